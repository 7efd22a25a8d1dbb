//! Finds the materials that are filtered, and what they need: tags of their pipelines, mip levels and samplers of their
//! textures.
//!
//! Only what has changed is looked at, and what it concerns: materials are found from their images.

use std::{
    any::TypeId,
    collections::{HashMap, HashSet},
    hash::Hash,
    marker::PhantomData,
};

use bevy::{
    asset::{AssetEventSystems, UntypedAssetId},
    image::ImageSamplerDescriptor,
    pbr::{Material, MeshMaterial3d},
    prelude::*,
    render::{
        Extract, ExtractSchedule, Render, RenderApp,
        erased_render_asset::prepare_erased_assets,
        render_resource::TextureFormat,
        renderer::{RenderAdapter, RenderDevice},
    },
};
use bevy_frugal_hooks::{MaterialTags, ShaderPatches};

use super::{
    layout::{ImageShape, Images, MapLayout, MaterialTextures, maps},
    patches::Refused,
    pipeline::{EwaKey, TAG, is_llvmpipe, supported, tag_of, warn_of_anisotropy},
    settings::{AllMaterials, EwaOverrides},
};
use crate::{
    mips::{MipContent, NoMips, generator::MipSupport},
    report::{EwaReport, MipReport, TextureReport},
    settings::{EwaMethod, EwaSettings},
};

/// The steps of a frame, in this order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum FindSystems {
    Images,
    Materials,
    Textures,
    MarkMaterials,
}

/// The order of the systems that prepare textures and Bevy's, which prepare materials.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum PrepareSystems {
    BeforeMaterials,
    AfterMaterials,
}

/// Follows the images, whatever materials there are.
pub(super) struct FilteredMaterialsPlugin;

impl Plugin for FilteredMaterialsPlugin {
    fn build(&self, app: &mut App) {
        use FindSystems::{Images, MarkMaterials, Materials, Textures};
        app.register_type::<(AllMaterials, EwaOverrides)>()
            .register_type::<EwaReport>()
            .init_resource::<EwaReport>()
            .init_resource::<AllMaterials>()
            .init_resource::<EwaOverrides>()
            .init_resource::<FilteredMaterials>()
            .configure_sets(
                PostUpdate,
                (Images, Materials, Textures, MarkMaterials)
                    .chain()
                    .after(AssetEventSystems),
            )
            .add_systems(
                PostUpdate,
                (find_images.in_set(Images), find_textures.in_set(Textures)),
            );
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            render_app.add_systems(ExtractSchedule, tag_materials);
        }
    }

    fn finish(&self, app: &mut App) {
        let plugins = app.get_added_plugins::<ImagePlugin>();
        if let Some(plugin) = plugins.first() {
            let sampler = plugin.default_sampler.clone();
            let mut filtered = app.world_mut().resource_mut::<FilteredMaterials>();
            filtered.images.default_sampler = sampler;
        }
    }
}

/// Filters the textures of another type of material, which derives `Reflect`: one line for each type of the game,
/// beside its own `MaterialPlugin`.
///
/// - An `ExtendedMaterial` with a `StandardMaterial` as its base is filtered as that is, where the extension calls
///   Bevy's functions for the base's maps. Textures of the extension are as those of other materials:
/// - Textures of other materials get mip levels and anisotropy, whatever the method, as the plugin cannot change their
///   shaders. Their texels are averaged as [`MipContent::Values`].
///
/// [`EwaPlugin`](crate::EwaPlugin) adds those of `StandardMaterial` and of
/// [`EwaStandardMaterial`](crate::EwaStandardMaterial). The settings are those of
/// [`AllMaterials`].
pub struct EwaMaterialPlugin<M>(PhantomData<fn() -> M>);

impl<M> Default for EwaMaterialPlugin<M> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<M> Plugin for EwaMaterialPlugin<M>
where
    M: Material + Reflect,
    M::Data: PartialEq + Eq + Hash + Clone,
{
    fn build(&self, app: &mut App) {
        app.add_systems(
            PostUpdate,
            (
                find_materials::<M>.in_set(FindSystems::Materials),
                mark_materials::<M>.in_set(FindSystems::MarkMaterials),
            )
                .run_if(resource_exists::<Assets<M>>),
        );
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            let prepare = prepare_erased_assets::<MeshMaterial3d<M>>;
            render_app.configure_sets(
                Render,
                (
                    PrepareSystems::BeforeMaterials.before(prepare),
                    PrepareSystems::AfterMaterials.after(prepare),
                ),
            );
        }
    }
}

/// The materials that are not left to Bevy, and their textures.
#[derive(Resource, Default)]
pub(super) struct FilteredMaterials {
    images: Images,
    materials: HashMap<UntypedAssetId, Filtered>,
    users: HashMap<AssetId<Image>, HashSet<UntypedAssetId>>,
    textures: HashMap<AssetId<Image>, TextureRequest>,
    config: Option<(AllMaterials, Refused)>,
    /// What has changed in this frame.
    pub(super) changes: Changes,
}

#[derive(Default)]
pub(super) struct Changes {
    are_all_materials_stale: bool,
    /// Images that are others now, with true for those that were none before: no material shows these yet.
    images: HashMap<AssetId<Image>, bool>,
    overridden: HashSet<UntypedAssetId>,
    /// Images whose users changed.
    used: HashSet<AssetId<Image>>,
    /// Materials that have to be prepared again.
    stale: HashSet<UntypedAssetId>,
    /// Materials whose assets changed, so that they are prepared anyway.
    prepared: HashSet<UntypedAssetId>,
    /// Materials with another tag.
    tags: Vec<(UntypedAssetId, Option<u64>)>,
    /// Images with other needs; `None` for those that are Bevy's own again.
    pub textures: Vec<(AssetId<Image>, Option<TextureRequest>)>,
}

/// How a material is filtered.
#[derive(Clone, Debug, Default, PartialEq)]
struct Filtered {
    tag: Option<u64>,
    textures: Vec<FilteredTexture>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct FilteredTexture {
    pub image: AssetId<Image>,
    pub content: MipContent,
    /// The `anisotropy_clamp` of its sampler.
    pub anisotropy: u16,
    pub is_elliptical: bool,
}

/// The levels and the sampler that the renderer gives a texture.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TextureRequest {
    /// Levels to generate, the finest included; 1 for none.
    pub levels: u32,
    pub format: TextureFormat,
    pub content: MipContent,
    /// The sampler in place of the image's.
    pub sampler: Option<ImageSamplerDescriptor>,
    pub after_draws: bool,
}

impl Filtered {
    fn new(
        material: &MaterialTextures,
        settings: EwaSettings,
        refused: Refused,
        images: &Images,
    ) -> Self {
        let settings = supported(settings);
        let anisotropy = settings.texture_unit_anisotropy();
        let mut filtered = Self::default();
        if let Some(standard) = material.standard {
            let chosen = refused.filterable(settings.maps, standard);
            let layout = MapLayout::of(standard, chosen, images);
            let key = EwaKey::new(&settings, is_llvmpipe()).filter(|_| !layout.is_empty());
            filtered.tag = key.map(|key| tag_of((key, layout)));
            for map in maps(standard) {
                let is_elliptical = filtered.tag.is_some() && layout.contains(map.index);
                // Exact methods read single texels, for which anisotropy is of no use.
                let is_exact = is_elliptical && settings.method.is_exact();
                filtered.textures.push(FilteredTexture {
                    image: map.texture.id(),
                    content: map.content(standard),
                    anisotropy: if is_exact { 1 } else { anisotropy },
                    is_elliptical,
                });
            }
        }
        let anisotropy = match settings.method {
            EwaMethod::Anisotropic | EwaMethod::Hardware => anisotropy,
            _ => EwaSettings::with_method(EwaMethod::Anisotropic).texture_unit_anisotropy(),
        };
        let others = material.others.iter().map(|image| FilteredTexture {
            image: *image,
            content: MipContent::Values,
            anisotropy,
            is_elliptical: false,
        });
        filtered.textures.extend(others);
        filtered
    }
}

fn find_images(
    mut filtered: ResMut<FilteredMaterials>,
    all: Res<AllMaterials>,
    patches: Option<Res<ShaderPatches>>,
    mut overrides: ResMut<EwaOverrides>,
    images: Res<Assets<Image>>,
    mut events: MessageReader<AssetEvent<Image>>,
    device: Option<Res<RenderDevice>>,
    adapter: Option<Res<RenderAdapter>>,
) {
    let filtered = &mut *filtered;
    filtered.changes = Changes::default();
    let changes = &mut filtered.changes;
    let refused = patches.map_or_else(default, |patches| Refused::new(&patches));
    let config = Some((*all, refused));
    changes.are_all_materials_stale = std::mem::replace(&mut filtered.config, config) != config;
    let renderer = device.as_deref().zip(adapter.as_deref());
    let support = renderer.map(|(device, adapter)| MipSupport { device, adapter });
    let mut update = |id, overrides: &EwaOverrides| {
        let is_new = filtered.images.get(id).is_none();
        let support = support.as_ref();
        if filtered.images.update(id, &images, overrides, support) {
            changes.images.insert(id, is_new);
        }
    };
    for event in events.read() {
        if let AssetEvent::Added { id } | AssetEvent::Modified { id } | AssetEvent::Removed { id } =
            event
        {
            update(*id, &overrides);
        }
    }
    if overrides.changed_images.is_empty() && overrides.changed_materials.is_empty() {
        return;
    }
    let overrides = overrides.bypass_change_detection();
    for id in std::mem::take(&mut overrides.changed_images) {
        update(id, overrides);
    }
    changes.overridden = std::mem::take(&mut overrides.changed_materials);
}

impl FilteredMaterials {
    /// Finds how a material is filtered, and returns whether that has changed.
    fn update<M: Material + Reflect>(
        &mut self,
        id: AssetId<M>,
        materials: &Assets<M>,
        all: &AllMaterials,
        overrides: &EwaOverrides,
    ) -> bool {
        let refused = self.config.map(|(_, refused)| refused).unwrap_or_default();
        let material = materials.get(id);
        let id = id.into();
        let filtered = material.and_then(|material| {
            let material = MaterialTextures::of(material.as_partial_reflect());
            let own = material.extension.map(|extension| extension.settings);
            let settings = overrides.material(id).unwrap_or(own.or(all.0))?;
            Some(Filtered::new(&material, settings, refused, &self.images))
        });
        let previous = self.materials.get(&id);
        if previous == filtered.as_ref() {
            return false;
        }
        let tag = filtered.as_ref().and_then(|filtered| filtered.tag);
        if previous.and_then(|previous| previous.tag) != tag {
            self.changes.tags.push((id, tag));
        }
        for texture in previous.into_iter().flat_map(|previous| &previous.textures) {
            self.changes.used.insert(texture.image);
            if let Some(users) = self.users.get_mut(&texture.image) {
                users.remove(&id);
            }
        }
        for texture in filtered.iter().flat_map(|filtered| &filtered.textures) {
            self.changes.used.insert(texture.image);
            self.users.entry(texture.image).or_default().insert(id);
        }
        match filtered {
            Some(filtered) => self.materials.insert(id, filtered),
            None => self.materials.remove(&id),
        };
        true
    }

    /// Whether a material shows an image that came in this frame, so that it was not prepared before.
    fn is_awaiting(&self, id: UntypedAssetId) -> bool {
        let textures = self.materials.get(&id).map(|material| &material.textures);
        let mut textures = textures.into_iter().flatten();
        textures.any(|texture| self.changes.images.get(&texture.image) == Some(&true))
    }

    /// What the materials that show an image want of its texture, and what it got.
    fn texture(
        &self,
        id: AssetId<Image>,
        image: &ImageShape,
    ) -> Option<(TextureRequest, TextureReport)> {
        let users = self.users.get(&id)?;
        let users = users.iter().filter_map(|user| self.materials.get(user));
        let uses = users.flat_map(|user| user.textures.iter().filter(|used| used.image == id));
        let used = uses.copied().reduce(|a, b| FilteredTexture {
            image: id,
            content: stricter(a.content, b.content),
            anisotropy: a.anisotropy.max(b.anisotropy),
            is_elliptical: a.is_elliptical || b.is_elliptical,
        })?;
        let sampler = image.with_anisotropy(used.anisotropy);
        if sampler.is_some() {
            warn_of_anisotropy();
        }
        let report = TextureReport {
            mips: image.mips,
            anisotropy: sampler.as_ref().unwrap_or(&image.sampler).anisotropy_clamp,
            is_elliptical: used.is_elliptical,
        };
        let texture = TextureRequest {
            levels: match image.mips {
                MipReport::Generated(levels) => levels,
                MipReport::Own(_) | MipReport::Without(_) => 1,
            },
            format: image.mip_format,
            content: used.content,
            sampler,
            after_draws: image.after_draws,
        };
        Some((texture, report))
    }
}

/// Looks at the materials that have changed, or whose images or settings have.
fn find_materials<M: Material + Reflect>(
    mut filtered: ResMut<FilteredMaterials>,
    all: Res<AllMaterials>,
    overrides: Res<EwaOverrides>,
    materials: Res<Assets<M>>,
    mut events: MessageReader<AssetEvent<M>>,
) {
    let filtered = &mut *filtered;
    for event in events.read() {
        match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => {
                filtered.changes.prepared.insert((*id).into());
                filtered.update(*id, &materials, &all, &overrides);
            }
            AssetEvent::Removed { id } => {
                filtered.update(*id, &materials, &all, &overrides);
            }
            AssetEvent::Unused { .. } | AssetEvent::LoadedWithDependencies { .. } => {}
        }
    }
    let stale: Vec<AssetId<M>> = if filtered.changes.are_all_materials_stale {
        materials.ids().collect()
    } else {
        let users = filtered.changes.images.keys();
        let users = users.flat_map(|image| filtered.users.get(image).into_iter().flatten());
        let stale = users.chain(&filtered.changes.overridden);
        let of_this_type = stale.filter(|id| id.type_id() == TypeId::of::<M>());
        of_this_type.map(|id| id.typed_unchecked()).collect()
    };
    for id in stale {
        let is_changed = filtered.update(id, &materials, &all, &overrides);
        let id = UntypedAssetId::from(id);
        if is_changed && !filtered.is_awaiting(id) {
            filtered.changes.stale.insert(id);
        }
    }
}

/// Marks materials as modified, so that the renderer prepares them again.
fn mark_materials<M: Material>(filtered: Res<FilteredMaterials>, mut materials: ResMut<Assets<M>>) {
    let changes = &filtered.changes;
    for id in changes.stale.difference(&changes.prepared) {
        if id.type_id() == TypeId::of::<M>()
            && let Some(mut material) = materials.get_mut(id.typed_unchecked::<M>())
        {
            // Only a mutable reference marks the asset as modified.
            let _: &mut M = &mut material;
        }
    }
}

/// Finds what the textures need whose images or users have changed.
fn find_textures(mut filtered: ResMut<FilteredMaterials>, mut report: ResMut<EwaReport>) {
    let filtered = &mut *filtered;
    let mut used = std::mem::take(&mut filtered.changes.used);
    used.extend(filtered.changes.images.keys());
    for id in &used {
        let image = filtered.images.get(*id);
        let requested = image.and_then(|image| filtered.texture(*id, image));
        let (texture, reported) = requested.unzip();
        let reported = reported.or_else(|| {
            // Materials wait for it.
            let users = filtered.users.get(id);
            let is_awaited = users.is_some_and(|users| !users.is_empty());
            is_awaited.then_some(TextureReport {
                mips: MipReport::Without(NoMips::NotLoaded),
                anisotropy: 1,
                is_elliptical: false,
            })
        });
        if report.textures.get(id) != reported.as_ref() {
            match reported {
                Some(reported) => report.textures.insert(*id, reported),
                None => report.textures.remove(id),
            };
        }
        if filtered.users.get(id).is_some_and(HashSet::is_empty) {
            filtered.users.remove(id);
        }
        let previous = match texture.clone() {
            Some(texture) => filtered.textures.insert(*id, texture),
            None => filtered.textures.remove(id),
        };
        // A material keeps the views and samplers with which it was prepared. Bevy replaces the texture of an image
        // with another shape, and does not prepare the materials again that show it.
        let is_new = filtered.changes.images.get(id).copied();
        if is_new != Some(true) && (previous != texture || is_new.is_some()) {
            let users = filtered.users.get(id).into_iter().flatten();
            filtered.changes.stale.extend(users);
        }
        if previous != texture {
            filtered.changes.textures.push((*id, texture));
        }
    }
}

/// What a texture is taken for that materials show as different contents.
fn stricter(a: MipContent, b: MipContent) -> MipContent {
    let rank = |content| match content {
        MipContent::Values => 0.0,
        MipContent::Transparent => 1.0,
        MipContent::Mask { cutoff } => 2.0 + cutoff,
        MipContent::Normals => f32::INFINITY,
    };
    if rank(a) < rank(b) { b } else { a }
}

/// Writes the tags of the filtered materials, which their pipelines have in their keys.
fn tag_materials(filtered: Extract<Res<FilteredMaterials>>, mut tags: ResMut<MaterialTags>) {
    for (id, tag) in &filtered.changes.tags {
        tags.set_for_material(*id, TAG, *tag);
    }
}
