//! Replaces the textures of a glTF file by wavelet textures.
//!
//! `wavelet-tex encode model.glb` writes `model.glb.Texture0.wtex` and so on beside the file (an
//! image with a file of its own, `wall.png` or `wall.jpg`, becomes `wall.wtex`, and one in two roles `wall.wtex` and,
//! for example, `wall.normal.wtex`). A scene of the file whose root
//! has [`WaveletGltf`] is rendered with those: each material is replaced once all of its wavelet
//! textures have loaded, and the images of the file are dropped with the materials that used them.

use bevy::{
    asset::{AssetEvent, AssetId, AssetPath, AssetServer, Assets, Handle, LoadState},
    ecs::{
        component::Component,
        entity::Entity,
        hierarchy::ChildOf,
        message::MessageReader,
        query::Added,
        reflect::ReflectComponent,
        resource::Resource,
        system::{Commands, Query, Res, ResMut},
    },
    image::{Image, ImageAddressMode, ImageSampler},
    log::warn,
    pbr::{MeshMaterial3d, StandardMaterial},
    platform::collections::HashMap,
    reflect::{Reflect, std_traits::ReflectDefault},
};

use crate::{
    asset::WaveletTexture,
    codec::image::{ColorSpace, Content},
    file::EXTENSION,
    material::{Map, WaveletExtension, WaveletStandardMaterial},
    settings::{WaveletAddressMode, WaveletFilter},
};

/// Replaces the materials of all meshes below this entity by wavelet materials, as they are
/// spawned. Meshes of one material share its wavelet material.
///
/// A map keeps its image where it has no wavelet texture, or where the material cannot address it as its glTF sampler
/// says: differently in U and V, or not as the material's other maps. A warning names such maps.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component, Default, Clone)]
pub struct WaveletGltf {
    /// Filter of the wavelet textures. Default: [`WaveletFilter::Trilinear`].
    pub filter: WaveletFilter,
}

/// Marks a mesh that waits for the wavelet textures of its material.
#[derive(Component)]
pub(crate) struct Waiting {
    filter: WaveletFilter,
}

/// A material of a glTF file, and the filter that replaces its own.
type Key = (AssetId<StandardMaterial>, WaveletFilter);

/// What became of the materials.
#[derive(Resource, Default)]
pub(crate) struct Exchanges(HashMap<Key, Exchange>);

enum Exchange {
    /// The maps that are still loading or have loaded; their handles keep the textures.
    Loading(Vec<MapExchange>),
    /// The wavelet material, as long as a mesh has it.
    Done(AssetId<WaveletStandardMaterial>),
    /// No map has a wavelet texture.
    Kept,
}

/// Marks the meshes that were spawned below a [`WaveletGltf`].
pub(crate) fn find_meshes(
    mut commands: Commands,
    meshes: Query<Entity, Added<MeshMaterial3d<StandardMaterial>>>,
    parents: Query<&ChildOf>,
    roots: Query<&WaveletGltf>,
) {
    for mesh in &meshes {
        let own = roots.get(mesh).ok();
        let above = || parents.iter_ancestors(mesh).find_map(|e| roots.get(e).ok());
        if let Some(root) = own.or_else(above) {
            commands.entity(mesh).insert(Waiting {
                filter: root.filter,
            });
        }
    }
}

/// Forgets materials that have changed or are gone.
pub(crate) fn forget_materials(
    mut events: MessageReader<AssetEvent<StandardMaterial>>,
    mut exchanges: ResMut<Exchanges>,
) {
    for event in events.read() {
        if let AssetEvent::Modified { id } | AssetEvent::Removed { id } = event
            && !exchanges.0.is_empty()
        {
            exchanges.0.retain(|(material, _), _| material != id);
        }
    }
}

/// Replaces the materials whose wavelet textures have all loaded.
pub(crate) fn exchange_materials(
    mut commands: Commands,
    waiting: Query<(Entity, &MeshMaterial3d<StandardMaterial>, &Waiting)>,
    mut exchanges: ResMut<Exchanges>,
    server: Res<AssetServer>,
    standard: Res<Assets<StandardMaterial>>,
    images: Res<Assets<Image>>,
    textures: Res<Assets<WaveletTexture>>,
    mut wavelet: ResMut<Assets<WaveletStandardMaterial>>,
) {
    if waiting.is_empty() {
        return;
    }
    for (_, material, waiting) in &waiting {
        if let Some(base) = standard.get(material) {
            let key = (material.id(), waiting.filter);
            let begin = || Exchange::Loading(MapExchange::all(base, &server));
            exchanges.0.entry(key).or_insert_with(begin);
        }
    }
    // A new material lives by this until the meshes have it.
    let mut fresh = Vec::new();
    for ((id, filter), exchange) in &mut exchanges.0 {
        let Exchange::Loading(maps) = exchange else {
            continue;
        };
        for map in &mut *maps {
            map.go_on(&server, &images, &textures);
        }
        let Some(base) = standard
            .get(*id)
            .filter(|_| maps.iter().all(MapExchange::is_over))
        else {
            continue;
        };
        let path = server.get_path(*id);
        let name = path.map_or_else(String::new, |path| format!(" '{path}'"));
        *exchange = match exchanged(base, maps, *filter, &name) {
            Some(material) => {
                let handle = wavelet.add(material);
                let done = Exchange::Done(handle.id());
                fresh.push(handle);
                done
            }
            None => Exchange::Kept,
        };
    }
    for (mesh, material, waiting) in &waiting {
        let key = (material.id(), waiting.filter);
        match exchanges.0.get(&key) {
            Some(Exchange::Done(id)) => match wavelet.get_strong_handle(*id) {
                Some(material) => {
                    commands
                        .entity(mesh)
                        .remove::<(MeshMaterial3d<StandardMaterial>, Waiting)>()
                        .insert(MeshMaterial3d(material));
                }
                // All meshes that had it are gone: it is made again.
                None => drop(exchanges.0.remove(&key)),
            },
            Some(Exchange::Kept) => drop(commands.entity(mesh).remove::<Waiting>()),
            Some(Exchange::Loading(_)) | None => {}
        }
    }
}

/// Makes the wavelet material: its wavelet textures replace those maps of the base material that it can show. The
/// first that it can address decides how all are addressed. `None` where there is no such map.
fn exchanged(
    base: &StandardMaterial,
    maps: &[MapExchange],
    filter: WaveletFilter,
    name: &str,
) -> Option<WaveletStandardMaterial> {
    let address_mode = maps.iter().find_map(|map| match map.state {
        MapState::Loaded(_, address) => address,
        _ => None,
    });
    let mut base = base.clone();
    let mut extension = WaveletExtension {
        filter,
        address_mode: address_mode.unwrap_or_default(),
        ..WaveletExtension::default()
    };
    let mut kept = Vec::new();
    for map in maps {
        let reason = match &map.state {
            MapState::Loaded(texture, address) if address.is_some() && *address == address_mode => {
                *(map.image_of)(&mut base) = None;
                *extension.map_mut(map.map) = Some(texture.clone());
                continue;
            }
            MapState::Loaded(_, None) => "its sampler differs in U and V, or has a border",
            MapState::Loaded(..) => "its sampler is not that of the maps before it",
            MapState::Failed(error) => error,
            MapState::Loading(_) => "its wavelet texture is still loading",
        };
        kept.push(format!("{}: {reason}", map.map.name()));
    }
    if !kept.is_empty() {
        warn!(
            "the glTF material{name} keeps images in place of wavelet textures, which `wavelet-tex encode` makes of the \
             glTF file: {}",
            kept.join("; ")
        );
    }
    let has_texture = extension.textures().next().is_some();
    has_texture.then_some(WaveletStandardMaterial { base, extension })
}

type ImageOf = fn(&mut StandardMaterial) -> &mut Option<Handle<Image>>;

/// The maps of a glTF material, with the role by which `wavelet-tex` names the second texture of an image.
const MAPS: [(Map, &str, ImageOf); 5] = [
    (Map::BaseColor, "color", |m| &mut m.base_color_texture),
    (Map::Emissive, "color", |m| &mut m.emissive_texture),
    (Map::Normal, "normal", |m| &mut m.normal_map_texture),
    (Map::MetallicRoughness, "data", |m| {
        &mut m.metallic_roughness_texture
    }),
    (Map::Occlusion, "occlusion", |m| &mut m.occlusion_texture),
];

/// A map while its material is exchanged.
struct MapExchange {
    map: Map,
    role: &'static str,
    image_of: ImageOf,
    image: Handle<Image>,
    /// Whether the texture of the image's own name is that of another role.
    by_role: bool,
    state: MapState,
}

enum MapState {
    Loading(Handle<WaveletTexture>),
    /// The texture, and how its image was addressed, or `None` where the material cannot do the same.
    Loaded(Handle<WaveletTexture>, Option<WaveletAddressMode>),
    Failed(String),
}

impl MapExchange {
    /// Begins to load the textures of all maps of a material.
    fn all(material: &StandardMaterial, server: &AssetServer) -> Vec<Self> {
        let mut material = material.clone();
        let begin = |(map, role, image_of): (Map, &'static str, ImageOf)| {
            let image = image_of(&mut material).take()?;
            let texture = server.load(wavelet_path(image.path()?, None));
            Some(Self {
                map,
                role,
                image_of,
                image,
                by_role: false,
                state: MapState::Loading(texture),
            })
        };
        MAPS.into_iter().filter_map(begin).collect()
    }

    fn is_over(&self) -> bool {
        !matches!(self.state, MapState::Loading(_))
    }

    fn go_on(
        &mut self,
        server: &AssetServer,
        images: &Assets<Image>,
        textures: &Assets<WaveletTexture>,
    ) {
        let MapState::Loading(handle) = &self.state else {
            return;
        };
        if let LoadState::Failed(error) = server.load_state(handle) {
            self.state = MapState::Failed(error.to_string());
            return;
        }
        let Some(texture) = textures.get(handle) else {
            return;
        };
        let is_normal = texture.content == Content::Normal;
        let fits = match self.map {
            Map::Normal => is_normal,
            Map::BaseColor | Map::Emissive => !is_normal && texture.color_space == ColorSpace::Srgb,
            _ => !is_normal && texture.color_space == ColorSpace::Linear,
        };
        if !fits {
            let role = self.role;
            self.state = match self.image.path().filter(|_| !self.by_role) {
                Some(path) => MapState::Loading(server.load(wavelet_path(path, Some(role)))),
                None => MapState::Failed(format!(
                    "its wavelet texture is not encoded with the role `{role}`"
                )),
            };
            self.by_role = true;
            return;
        }
        let address = match images.get(&self.image) {
            Some(image) => address_mode(&image.sampler),
            // Nothing says otherwise.
            None if server.load_state(&self.image).is_failed() => Some(WaveletAddressMode::Repeat),
            None => return,
        };
        self.state = MapState::Loaded(handle.clone(), address);
    }
}

/// How a wavelet material addresses what this sampler does.
fn address_mode(sampler: &ImageSampler) -> Option<WaveletAddressMode> {
    let ImageSampler::Descriptor(sampler) = sampler else {
        // That of Bevy's images where nothing else is set.
        return Some(WaveletAddressMode::ClampToEdge);
    };
    match sampler.address_mode_u {
        _ if sampler.address_mode_u != sampler.address_mode_v => None,
        ImageAddressMode::Repeat => Some(WaveletAddressMode::Repeat),
        ImageAddressMode::ClampToEdge => Some(WaveletAddressMode::ClampToEdge),
        ImageAddressMode::MirrorRepeat => Some(WaveletAddressMode::MirrorRepeat),
        ImageAddressMode::ClampToBorder => None,
    }
}

/// Path of the wavelet texture of an image. For an image with a label (`model.glb#Texture0`) it is
/// beside the file that contains the image; for an image with a file of its own (`wall.png`) it is
/// that path with another extension. The second texture of an image has its role in its name.
fn wavelet_path(image: &AssetPath<'_>, role: Option<&str>) -> AssetPath<'static> {
    let extension = match role {
        Some(role) => format!("{role}.{EXTENSION}"),
        None => EXTENSION.into(),
    };
    let path = match image.label() {
        Some(label) => {
            let mut name = image.path().as_os_str().to_os_string();
            name.push(format!(".{label}.{extension}"));
            name.into()
        }
        None => image.path().with_extension(extension),
    };
    AssetPath::from(path).with_source(image.source().clone_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_that_the_tool_writes() {
        for (image, role, texture) in [
            ("a/model.glb#Texture0", None, "a/model.glb.Texture0.wtex"),
            (
                "a/model.glb#Texture1",
                Some("normal"),
                "a/model.glb.Texture1.normal.wtex",
            ),
            ("a/wall.png", None, "a/wall.wtex"),
            ("a/wall.v2.png", Some("data"), "a/wall.v2.data.wtex"),
            (
                "remote://m.gltf#Texture12",
                None,
                "remote://m.gltf.Texture12.wtex",
            ),
        ] {
            let found = wavelet_path(&AssetPath::parse(image), role);
            assert_eq!(found, AssetPath::parse(texture));
        }
    }
}
