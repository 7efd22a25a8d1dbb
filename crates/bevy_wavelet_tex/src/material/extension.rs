//! The material extension, which is the API for games, and what keeps up to date in materials what their pipelines are
//! specialised by: the forms of textures, and whether the scene has decals.

use bevy::{
    asset::{Asset, AssetEvent, AssetId, AssetPath, Assets, Handle, embedded_path},
    ecs::{
        message::MessageReader,
        query::With,
        resource::Resource,
        system::{Local, Query, Res, ResMut},
    },
    light::ClusteredDecal,
    log::warn,
    mesh::{MeshVertexBufferLayoutRef, UvChannel},
    pbr::{
        ExtendedMaterial, MaterialExtension, MaterialExtensionKey, MaterialExtensionPipeline,
        StandardMaterial,
    },
    reflect::{Reflect, std_traits::ReflectDefault},
    render::render_resource::{RenderPipelineDescriptor, SpecializedMeshPipelineError},
    shader::{ShaderDefVal, ShaderRef},
};
use bevy_frugal_hooks::{MapImage, MapImages, MaterialImages};

use super::uniform::{self, TextureForm};
use crate::{
    asset::WaveletTexture,
    codec::image::Content,
    settings::{WaveletAddressMode, WaveletFilter},
};

/// A `StandardMaterial` whose maps are wavelet textures.
pub type WaveletStandardMaterial = ExtendedMaterial<StandardMaterial, WaveletExtension>;

/// The wavelet textures of a material. A map that is `None` costs nothing in the shader.
///
/// The textures use the UV sets that the material has for its own maps (`base_color_channel`, which is also that of the
/// mask, and so on), its `uv_transform` and its `depth_map`. The `StandardMaterial` keeps all of its own fields, so leave
/// its textures of the same maps empty.
#[derive(Asset, Clone, Debug, Default, Reflect)]
#[reflect(Default, Clone, Debug)]
pub struct WaveletExtension {
    /// Multiplies the base colour, and its alpha where the texture has one. Gray or colour.
    pub base_color: Option<Handle<WaveletTexture>>,
    /// Multiplies the emissive colour, which is black by default. Gray or colour.
    pub emissive: Option<Handle<WaveletTexture>>,
    /// Normal map in tangent space, with +Y up. The mesh needs tangents.
    pub normal: Option<Handle<WaveletTexture>>,
    /// Multiplies roughness by G and metallic by B, as in glTF. Colour, linear.
    pub metallic_roughness: Option<Handle<WaveletTexture>>,
    /// Fraction of the indirect light that is not occluded, in R. Gray or colour, linear. Where it is the texture of
    /// `metallic_roughness` with the same UV set, the shader samples that one once.
    pub occlusion: Option<Handle<WaveletTexture>>,
    /// Multiplies the base colour's alpha by R; for `AlphaMode::Mask` and blending. Gray or colour, linear.
    pub mask: Option<Handle<WaveletTexture>>,
    /// Filter of all textures of the material. Default: [`WaveletFilter::Trilinear`].
    pub filter: WaveletFilter,
    /// How coordinates outside of `[0, 1]` are addressed. Default: [`WaveletAddressMode::Repeat`].
    pub address_mode: WaveletAddressMode,
    /// What the plugin knows of the textures once they are loaded.
    #[doc(hidden)]
    #[reflect(ignore)]
    pub forms: WaveletForms,
}

/// What the shader is specialised by beside the settings of the extension.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WaveletForms {
    /// The form of each map's texture, in the order of `Map::ALL`.
    maps: [TextureForm; 6],
    features: MaterialFeatures,
}

/// What a material needs of the shader apart from its maps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
struct MaterialFeatures {
    /// The texture of metallic and roughness has occlusion, too.
    shared_occlusion: bool,
    /// A depth map moves the coordinates.
    parallax: bool,
    /// The scene has clustered decals.
    decals: bool,
}

impl WaveletForms {
    pub(super) fn of(&self, map: Map) -> TextureForm {
        self.maps[map as usize]
    }
}

/// The key that a pipeline of the extension is specialised by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct WaveletKey {
    /// The bits of each map's form, in the order of [`Map::ALL`]; `None` where there is no map.
    maps: [Option<u32>; 6],
    features: MaterialFeatures,
    filter: WaveletFilter,
}

/// A map of the material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Map {
    BaseColor,
    Emissive,
    Normal,
    MetallicRoughness,
    Occlusion,
    Mask,
}

impl Map {
    pub(super) const ALL: [Self; 6] = [
        Self::BaseColor,
        Self::Emissive,
        Self::Normal,
        Self::MetallicRoughness,
        Self::Occlusion,
        Self::Mask,
    ];

    fn shader_def(self) -> &'static str {
        match self {
            Self::BaseColor => "WAVELET_BASE_COLOR",
            Self::Emissive => "WAVELET_EMISSIVE",
            Self::Normal => "WAVELET_NORMAL",
            Self::MetallicRoughness => "WAVELET_METALLIC_ROUGHNESS",
            Self::Occlusion => "WAVELET_OCCLUSION",
            Self::Mask => "WAVELET_MASK",
        }
    }

    /// What the map is for, in messages.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::BaseColor => "base colour",
            Self::Emissive => "emissive colour",
            Self::Normal => "normals",
            Self::MetallicRoughness => "metallic and roughness",
            Self::Occlusion => "occlusion",
            Self::Mask => "mask",
        }
    }

    /// Whether textures of a content can be the map: as a colour, normals are shown as they are.
    fn takes(self, content: Content) -> bool {
        match self {
            Self::BaseColor | Self::Emissive => true,
            Self::Normal => content == Content::Normal,
            _ => content != Content::Normal,
        }
    }
}

impl WaveletExtension {
    pub(super) fn map(&self, map: Map) -> Option<&Handle<WaveletTexture>> {
        match map {
            Map::BaseColor => self.base_color.as_ref(),
            Map::Emissive => self.emissive.as_ref(),
            Map::Normal => self.normal.as_ref(),
            Map::MetallicRoughness => self.metallic_roughness.as_ref(),
            Map::Occlusion => self.occlusion.as_ref(),
            Map::Mask => self.mask.as_ref(),
        }
    }

    pub(crate) fn map_mut(&mut self, map: Map) -> &mut Option<Handle<WaveletTexture>> {
        match map {
            Map::BaseColor => &mut self.base_color,
            Map::Emissive => &mut self.emissive,
            Map::Normal => &mut self.normal,
            Map::MetallicRoughness => &mut self.metallic_roughness,
            Map::Occlusion => &mut self.occlusion,
            Map::Mask => &mut self.mask,
        }
    }

    /// Iterates over the textures that are in use.
    pub fn textures(&self) -> impl Iterator<Item = &Handle<WaveletTexture>> {
        Map::ALL.into_iter().filter_map(|map| self.map(map))
    }

    /// The texture of a map that has bindings of its own.
    pub(super) fn bound(&self, map: Map) -> Option<&Handle<WaveletTexture>> {
        self.map(map)
            .filter(|_| self.forms.of(map) != TextureForm::UNBOUND)
    }

    /// Looks up what the shader is specialised by. A texture that has not been loaded has no form yet.
    pub(super) fn update_forms(
        &mut self,
        base: &StandardMaterial,
        textures: &Assets<WaveletTexture>,
        decals: bool,
    ) {
        let shared_occlusion = self.occlusion.is_some()
            && self.occlusion == self.metallic_roughness
            && base.occlusion_channel == base.metallic_roughness_channel;
        let form = |map: Map| {
            let Some((handle, texture)) = self.map(map).and_then(|h| Some((h, textures.get(h)?)))
            else {
                return TextureForm::default();
            };
            if !map.takes(texture.content) {
                if self.forms.of(map) != TextureForm::UNBOUND {
                    let path = handle.path().map(|path| format!(" '{path}'"));
                    let path = path.unwrap_or_default();
                    warn!(
                        "a material goes without its map of {}: the wavelet texture{path} has the content `{}` \
                         (encode it with the role of that map, `wavelet-tex encode --role`)",
                        map.name(),
                        texture.content.name(),
                    );
                }
                return TextureForm::UNBOUND;
            }
            if map == Map::Occlusion && shared_occlusion {
                return TextureForm::UNBOUND;
            }
            TextureForm::new(texture)
        };
        self.forms = WaveletForms {
            maps: Map::ALL.map(form),
            features: MaterialFeatures {
                shared_occlusion,
                parallax: base.depth_map.is_some(),
                decals,
            },
        };
    }

    /// The previews of the maps that are loaded.
    pub(super) fn previews(
        &self,
        base: &StandardMaterial,
        textures: &Assets<WaveletTexture>,
    ) -> MapImages {
        let preview = |map: Map, channel: &UvChannel| {
            let texture = textures.get(self.map(map)?)?;
            texture.preview.as_ref().map(|preview| MapImage {
                image: preview.id(),
                channel: channel.clone(),
            })
        };
        MapImages {
            base_color: preview(Map::BaseColor, &base.base_color_channel),
            emissive: preview(Map::Emissive, &base.emissive_channel),
            metallic_roughness: preview(Map::MetallicRoughness, &base.metallic_roughness_channel),
        }
    }

    pub(super) fn key(&self) -> WaveletKey {
        let form = |map| self.forms.of(map).bits(self.address_mode);
        WaveletKey {
            maps: Map::ALL.map(|map| self.bound(map).map(|_| form(map))),
            features: self.forms.features,
            filter: self.filter,
        }
    }
}

impl WaveletKey {
    fn shader_defs(self) -> impl Iterator<Item = ShaderDefVal> {
        let maps = Map::ALL.into_iter().zip(self.maps);
        let maps = maps.filter_map(|(map, form)| Some((map.shader_def(), form?)));
        let maps = maps.flat_map(|(name, form)| {
            let planes = uniform::has_planes(form).then(|| format!("{name}_PLANES").into());
            let form = ShaderDefVal::UInt(format!("{name}_FORM").into(), form);
            [Some(name.into()), Some(form), planes]
        });
        let maps = maps.flatten();
        let filter = match self.filter {
            WaveletFilter::Nearest => Some("WAVELET_FILTER_NEAREST"),
            WaveletFilter::NearestMipLinear => Some("WAVELET_FILTER_NEAREST_MIP_LINEAR"),
            WaveletFilter::Bilinear => Some("WAVELET_FILTER_BILINEAR"),
            WaveletFilter::Stochastic => Some("WAVELET_FILTER_STOCHASTIC"),
            WaveletFilter::StochasticQuad => Some("WAVELET_FILTER_STOCHASTIC_QUAD"),
            WaveletFilter::Trilinear => None,
            WaveletFilter::Anisotropic => Some("WAVELET_FILTER_ANISOTROPIC"),
        };
        let features = [
            (self.features.shared_occlusion, "WAVELET_SHARED_OCCLUSION"),
            (self.features.parallax, "WAVELET_PARALLAX"),
            (self.features.decals, "WAVELET_DECALS"),
        ];
        let features = features.into_iter();
        let features = features.filter_map(|(is_used, name)| is_used.then_some(name));
        maps.chain(features.chain(filter).map(Into::into))
    }
}

const FORWARD_SHADER: &str = "forward.wesl";

impl MaterialExtension for WaveletExtension {
    fn fragment_shader() -> ShaderRef {
        embedded_shader(FORWARD_SHADER)
    }

    fn deferred_fragment_shader() -> ShaderRef {
        embedded_shader(FORWARD_SHADER)
    }

    fn prepass_fragment_shader() -> ShaderRef {
        embedded_shader("prepass.wesl")
    }

    fn specialize(
        _pipeline: &MaterialExtensionPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        _layout: &MeshVertexBufferLayoutRef,
        key: MaterialExtensionKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        if let Some(fragment) = &mut descriptor.fragment {
            fragment
                .shader_defs
                .extend(key.bind_group_data.shader_defs());
        }
        Ok(())
    }
}

fn embedded_shader(name: &str) -> ShaderRef {
    let path = embedded_path!("").join(name);
    ShaderRef::Path(AssetPath::from(path).with_source("embedded"))
}

/// Whether the scene has had clustered decals, for which materials have code from then on.
#[derive(Resource, Default)]
pub(crate) struct Decals(bool);

/// Marks all materials as changed when the first clustered decal comes.
pub(crate) fn find_decals(
    mut found: ResMut<Decals>,
    decals: Query<(), With<ClusteredDecal>>,
    mut materials: ResMut<Assets<WaveletStandardMaterial>>,
) {
    if !found.0 && !decals.is_empty() {
        found.0 = true;
        materials.iter_mut().for_each(drop);
    }
}

/// Marks materials as changed when one of their textures is loaded or changed, so that they are bound
/// again: in that frame and in the next, since a frame can prepare a material before its texture.
pub(crate) fn rebind_materials(
    mut events: MessageReader<AssetEvent<WaveletTexture>>,
    mut again: Local<Vec<AssetId<WaveletStandardMaterial>>>,
    mut materials: ResMut<Assets<WaveletStandardMaterial>>,
) {
    let mut due = std::mem::take(&mut *again);
    let changed = events.read().filter_map(|event| match event {
        AssetEvent::Added { id } | AssetEvent::Modified { id } => Some(*id),
        _ => None,
    });
    let changed: Vec<AssetId<WaveletTexture>> = changed.collect();
    if !changed.is_empty() {
        for (id, material) in materials.iter() {
            let mut textures = material.extension.textures();
            if textures.any(|texture| changed.contains(&texture.id())) {
                again.push(id);
            }
        }
    }
    due.extend(&*again);
    for id in due {
        // Only access through `DerefMut` marks the material as changed.
        if let Some(mut material) = materials.get_mut(id) {
            let _: &mut WaveletStandardMaterial = &mut material;
        }
    }
}

/// Writes the forms of their textures into the materials that are new or changed, after their events
/// and before they are extracted; and their images, where a plugin reads them.
pub(crate) fn write_forms(
    mut events: MessageReader<AssetEvent<WaveletStandardMaterial>>,
    textures: Res<Assets<WaveletTexture>>,
    decals: Res<Decals>,
    mut materials: ResMut<Assets<WaveletStandardMaterial>>,
    mut images: Option<ResMut<MaterialImages>>,
) {
    for event in events.read() {
        match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => {
                let Some(material) = materials.get_mut_untracked(*id) else {
                    continue;
                };
                let WaveletStandardMaterial { base, extension } = &mut *material;
                extension.update_forms(base, &textures, decals.0);
                if let Some(images) = &mut images {
                    let previews = extension.previews(base, &textures);
                    images.0.insert(id.untyped(), previews);
                }
            }
            AssetEvent::Removed { id } => {
                if let Some(images) = &mut images {
                    images.0.remove(&id.untyped());
                }
            }
            _ => {}
        }
    }
}
