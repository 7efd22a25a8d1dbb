//! Which materials and which textures replace those of a glTF file.

use bevy::{
    asset::AssetServer,
    image::{ImageAddressMode, ImageLoaderSettings, ImageSampler, ImageSamplerDescriptor},
    platform::collections::HashSet,
    prelude::*,
};
use bevy_frugal_lab::content;
use bevy_wavelet_tex::{
    WaveletAddressMode, WaveletExtension, WaveletGltf, WaveletStandardMaterial, WaveletTexture,
    codec::image::{ColorSpace, Content},
    file,
};
use image::{DynamicImage, ImageFormat};

use super::{loading::Folder, scene::encoded, viewer::Viewer};
use crate::support::{gpu, logs::warned_of};

const SIZE: [u32; 2] = [16, 16];

fn png() -> Vec<u8> {
    let mut png = std::io::Cursor::new(Vec::new());
    DynamicImage::from(content::photo_like(16, 16, 3))
        .write_to(&mut png, ImageFormat::Png)
        .expect("a PNG");
    png.into_inner()
}

fn wtex(content: Content, color_space: ColorSpace) -> Vec<u8> {
    let picture = match content {
        Content::Normal => content::bricks(16, 16, 3).normal,
        _ => content::photo_like(16, 16, 3),
    };
    file::write(&encoded(&picture, content, color_space))
}

/// Loads an image as a glTF file does, whose sampler addresses U and V like this.
fn load(world: &World, path: &str, [u, v]: [ImageAddressMode; 2]) -> Handle<Image> {
    let sampler = ImageSamplerDescriptor {
        address_mode_u: u,
        address_mode_v: v,
        ..default()
    };
    let server = world.resource::<AssetServer>();
    let settings = move |settings: &mut ImageLoaderSettings| {
        settings.sampler = ImageSampler::Descriptor(sampler.clone());
    };
    server
        .load_builder()
        .with_settings(settings)
        .load(path.to_string())
}

/// Spawns a mesh with a material below a root of a glTF scene.
fn spawn(world: &mut World, material: &Handle<StandardMaterial>) -> Entity {
    let mesh = world
        .resource_mut::<Assets<Mesh>>()
        .add(Rectangle::default());
    let root = (WaveletGltf::default(), Transform::default());
    let root = world.spawn((root, Visibility::default())).id();
    let mesh = (Mesh3d(mesh), MeshMaterial3d(material.clone()));
    world.spawn((mesh, ChildOf(root))).id()
}

fn add(world: &mut World, material: StandardMaterial) -> Handle<StandardMaterial> {
    world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(material)
}

/// Runs until a mesh has its wavelet material, which is returned.
fn exchanged(viewer: &mut Viewer, mesh: Entity) -> Handle<WaveletStandardMaterial> {
    for _ in 0..500 {
        viewer.app.render_frames(1).expect("frames");
        let world = viewer.app.world();
        let material = world.get::<MeshMaterial3d<WaveletStandardMaterial>>(mesh);
        if let Some(material) = material {
            assert!(
                world
                    .get::<MeshMaterial3d<StandardMaterial>>(mesh)
                    .is_none()
            );
            return material.0.clone();
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    panic!("no wavelet material");
}

fn material<'a>(
    viewer: &'a Viewer,
    handle: &Handle<WaveletStandardMaterial>,
) -> &'a WaveletStandardMaterial {
    let materials = viewer
        .app
        .world()
        .resource::<Assets<WaveletStandardMaterial>>();
    materials.get(handle).expect("a material")
}

fn path(texture: &Option<Handle<WaveletTexture>>) -> Option<String> {
    Some(texture.as_ref()?.path()?.to_string())
}

const REPEAT: [ImageAddressMode; 2] = [ImageAddressMode::Repeat; 2];
const CLAMP: [ImageAddressMode; 2] = [ImageAddressMode::ClampToEdge; 2];

#[test]
fn meshes_of_one_material_share_its_wavelet_material() {
    let _gpu = gpu();
    let folder = Folder::new("share")
        .with("wall.png", &png())
        .with("wall.wtex", &wtex(Content::Color, ColorSpace::Srgb));
    let mut viewer = Viewer::with_settings(SIZE, folder.settings());
    let world = viewer.app.world_mut();
    let image = load(world, "wall.png", REPEAT);
    let standard = StandardMaterial {
        base_color_texture: Some(image),
        ..default()
    };
    let standard = add(world, standard);
    let mut meshes: Vec<Entity> = (0..40).map(|_| spawn(world, &standard)).collect();
    let first = exchanged(&mut viewer, meshes[0]);
    let extension = &material(&viewer, &first).extension;
    assert_eq!(extension.address_mode, WaveletAddressMode::Repeat);
    // Those that come later have it, too.
    let later = spawn(viewer.app.world_mut(), &standard);
    exchanged(&mut viewer, later);
    meshes.push(later);
    let world = viewer.app.world();
    let handle = |mesh: &Entity| world.get::<MeshMaterial3d<WaveletStandardMaterial>>(*mesh);
    let handles = meshes
        .iter()
        .map(|mesh| handle(mesh).expect("exchanged").id());
    let handles: HashSet<_> = handles.collect();
    assert_eq!(handles.into_iter().collect::<Vec<_>>(), [first.id()]);
    // It lives no longer than its meshes.
    drop(first);
    let world = viewer.app.world_mut();
    for mesh in meshes {
        world.despawn(mesh);
    }
    viewer.app.render_frames(3).expect("frames");
    let world = viewer.app.world_mut();
    assert_eq!(world.resource::<Assets<WaveletStandardMaterial>>().len(), 0);
    let again = spawn(world, &standard);
    exchanged(&mut viewer, again);
}

#[test]
fn an_image_in_two_roles_has_both_textures() {
    let _gpu = gpu();
    let folder = Folder::new("roles")
        .with("wall.png", &png())
        .with("wall.wtex", &wtex(Content::Color, ColorSpace::Srgb))
        .with(
            "wall.normal.wtex",
            &wtex(Content::Normal, ColorSpace::Linear),
        )
        .with("wall.data.wtex", &wtex(Content::Color, ColorSpace::Linear));
    let mut viewer = Viewer::with_settings(SIZE, folder.settings());
    let world = viewer.app.world_mut();
    let image = load(world, "wall.png", REPEAT);
    let standard = StandardMaterial {
        base_color_texture: Some(image.clone()),
        normal_map_texture: Some(image.clone()),
        metallic_roughness_texture: Some(image),
        ..default()
    };
    let standard = add(world, standard);
    let mesh = spawn(world, &standard);
    let exchanged = exchanged(&mut viewer, mesh);
    let WaveletExtension {
        base_color,
        normal,
        metallic_roughness,
        ..
    } = &material(&viewer, &exchanged).extension;
    assert_eq!(path(base_color).as_deref(), Some("wall.wtex"));
    assert_eq!(path(normal).as_deref(), Some("wall.normal.wtex"));
    assert_eq!(path(metallic_roughness).as_deref(), Some("wall.data.wtex"));
}

#[test]
fn maps_that_the_material_cannot_address_keep_their_images() {
    let _gpu = gpu();
    let color = wtex(Content::Color, ColorSpace::Srgb);
    let data = wtex(Content::Color, ColorSpace::Linear);
    let folder = Folder::new("samplers")
        .with("a.png", &png())
        .with("a.wtex", &color)
        .with("b.png", &png())
        .with("b.wtex", &color)
        .with("c.png", &png())
        .with("c.wtex", &data)
        .with("d.png", &png())
        .with("e.png", &png())
        .with("e.wtex", &data);
    let mut viewer = Viewer::with_settings(SIZE, folder.settings());
    let world = viewer.app.world_mut();
    let mixed = [ImageAddressMode::ClampToEdge, ImageAddressMode::Repeat];
    let standard = StandardMaterial {
        base_color_texture: Some(load(world, "a.png", CLAMP)),
        emissive_texture: Some(load(world, "b.png", REPEAT)),
        metallic_roughness_texture: Some(load(world, "c.png", mixed)),
        // It has no wavelet texture.
        normal_map_texture: Some(load(world, "d.png", CLAMP)),
        occlusion_texture: Some(load(world, "e.png", CLAMP)),
        ..default()
    };
    let standard = add(world, standard);
    let mesh = spawn(world, &standard);
    let exchanged = exchanged(&mut viewer, mesh);
    let WaveletStandardMaterial { base, extension } = material(&viewer, &exchanged);
    assert_eq!(extension.address_mode, WaveletAddressMode::ClampToEdge);
    assert_eq!(path(&extension.base_color).as_deref(), Some("a.wtex"));
    assert_eq!(path(&extension.occlusion).as_deref(), Some("e.wtex"));
    assert!(base.base_color_texture.is_none() && base.occlusion_texture.is_none());
    assert!(extension.emissive.is_none() && base.emissive_texture.is_some());
    assert!(extension.metallic_roughness.is_none());
    assert!(base.metallic_roughness_texture.is_some());
    assert!(extension.normal.is_none() && base.normal_map_texture.is_some());
    for reason in [
        "emissive colour: its sampler is not that of the maps before it",
        "metallic and roughness: its sampler differs in U and V",
        "d.wtex",
    ] {
        assert!(warned_of(reason), "{reason}");
    }
}
