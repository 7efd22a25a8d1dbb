//! Replaces the textures of a glTF file by wavelet textures.
//!
//! `wavelet-tex encode model.glb` writes `model.glb.Texture0.wtex` and so on beside the file (an
//! image with a file of its own, `wall.png` or `wall.jpg`, becomes `wall.wtex`). A scene of the file whose root
//! has [`WaveletGltf`] is rendered with those: each material is replaced once all of its wavelet
//! textures have loaded, and the images of the file are dropped with the materials that used them.

use bevy::{
    asset::{AssetPath, AssetServer, Assets, Handle, LoadState},
    ecs::{
        component::Component,
        entity::Entity,
        hierarchy::ChildOf,
        query::Added,
        reflect::ReflectComponent,
        system::{Commands, Query, Res, ResMut},
    },
    image::Image,
    log::warn,
    pbr::{MeshMaterial3d, StandardMaterial},
    reflect::{Reflect, std_traits::ReflectDefault},
};

use crate::{
    asset::WaveletTexture,
    file::EXTENSION,
    material::{WaveletExtension, WaveletStandardMaterial},
    settings::WaveletFilter,
};

/// Replaces the materials of all meshes below this entity by wavelet materials, as they are
/// spawned.
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
    /// The wavelet material, made once the standard material has loaded. Its handles keep the
    /// textures loading.
    next: Option<Box<WaveletStandardMaterial>>,
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
                next: None,
            });
        }
    }
}

/// Replaces the materials whose wavelet textures have all loaded.
pub(crate) fn exchange_materials(
    mut commands: Commands,
    mut waiting: Query<(Entity, &MeshMaterial3d<StandardMaterial>, &mut Waiting)>,
    server: Res<AssetServer>,
    standard: Res<Assets<StandardMaterial>>,
    mut wavelet: ResMut<Assets<WaveletStandardMaterial>>,
) {
    for (mesh, material, mut waiting) in &mut waiting {
        let Some(base) = standard.get(material) else {
            continue;
        };
        let filter = waiting.filter;
        let exchange = || Box::new(exchanged(base, filter, &server));
        let next = waiting.next.get_or_insert_with(exchange);
        let states = || next.extension.textures().map(|t| server.load_state(t));
        let failed = states().find_map(|state| match state {
            LoadState::Failed(error) => Some(error),
            _ => None,
        });
        if let Some(error) = failed {
            warn!(
                "a glTF material keeps its own textures: {error} (run `wavelet-tex encode` on the \
                 glTF file to make its wavelet textures)"
            );
            commands.entity(mesh).remove::<Waiting>();
        } else if states().all(|state| state.is_loaded()) {
            let material = wavelet.add((**next).clone());
            commands
                .entity(mesh)
                .remove::<(MeshMaterial3d<StandardMaterial>, Waiting)>()
                .insert(MeshMaterial3d(material));
        }
    }
}

/// Makes the wavelet material: its wavelet textures replace the maps of the base material.
fn exchanged(
    material: &StandardMaterial,
    filter: WaveletFilter,
    server: &AssetServer,
) -> WaveletStandardMaterial {
    let mut base = material.clone();
    let take = |map: &mut Option<Handle<Image>>| {
        let path = map.as_ref()?.path()?;
        let texture: Handle<WaveletTexture> = server.load(wavelet_path(path));
        *map = None;
        Some(texture)
    };
    let extension = WaveletExtension {
        base_color: take(&mut base.base_color_texture),
        emissive: take(&mut base.emissive_texture),
        normal: take(&mut base.normal_map_texture),
        metallic_roughness: take(&mut base.metallic_roughness_texture),
        occlusion: take(&mut base.occlusion_texture),
        filter,
        ..WaveletExtension::default()
    };
    WaveletStandardMaterial { base, extension }
}

/// Path of the wavelet texture of an image. For an image with a label (`model.glb#Texture0`) it is
/// beside the file that contains the image; for an image with a file of its own (`wall.png`) it is
/// that path with another extension.
fn wavelet_path(image: &AssetPath<'_>) -> AssetPath<'static> {
    let path = match image.label() {
        Some(label) => {
            let mut name = image.path().as_os_str().to_os_string();
            name.push(format!(".{label}.{EXTENSION}"));
            name.into()
        }
        None => image.path().with_extension(EXTENSION),
    };
    AssetPath::from(path).with_source(image.source().clone_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_that_the_tool_writes() {
        for (image, texture) in [
            ("a/model.glb#Texture0", "a/model.glb.Texture0.wtex"),
            ("a/wall.png", "a/wall.wtex"),
            (
                "remote://m.gltf#Texture12",
                "remote://m.gltf.Texture12.wtex",
            ),
        ] {
            let found = wavelet_path(&AssetPath::parse(image));
            assert_eq!(found, AssetPath::parse(texture));
        }
    }
}
