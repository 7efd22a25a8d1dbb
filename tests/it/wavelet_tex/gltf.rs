//! Which materials and which textures replace those of a glTF file, and what is seen then.

use bevy::{
    gltf::GltfAssetLabel,
    image::{ImageAddressMode, ImageLoaderSettings, ImageSampler, ImageSamplerDescriptor},
    prelude::*,
    world_serialization::WorldAssetRoot,
};
use bevy_frugal_lab::{content, headless::HeadlessApp};
use bevy_wavelet_tex::{
    WaveletAddressMode, WaveletExtension, WaveletFilter, WaveletGltf, WaveletStandardMaterial,
    WaveletTexture,
    codec::image::{ColorSpace, Content, WaveletImage},
    file,
};
use image::{ImageFormat, RgbImage};

use super::scene::{
    STEP, Viewer, app, chroma_rounding, difference, encoded, gpu_with_all_planes, linear,
};
use crate::support::{Folder, gpu, image_file, wait_for, warned_of};

const SIZE: [u32; 2] = [64, 48];

fn pictures() -> [RgbImage; 2] {
    [3, 9].map(|seed| content::photo_like(SIZE[0], SIZE[1], seed))
}

fn png(picture: &RgbImage) -> Vec<u8> {
    image_file(picture.clone(), ImageFormat::Png)
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
    let settings = move |settings: &mut ImageLoaderSettings| {
        settings.sampler = ImageSampler::Descriptor(sampler.clone());
    };
    world
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

type Standard = MeshMaterial3d<StandardMaterial>;
type Wavelet = MeshMaterial3d<WaveletStandardMaterial>;

/// Runs until a mesh has its wavelet material in place of the other.
fn exchanged(app: &mut HeadlessApp, mesh: Entity) -> Handle<WaveletStandardMaterial> {
    wait_for(app, |app| {
        let mesh = app.world().entity(mesh);
        let material = mesh.get::<Wavelet>()?.0.clone();
        assert!(!mesh.contains::<Standard>());
        Some(material)
    })
}

fn material<'a>(
    app: &'a HeadlessApp,
    handle: &Handle<WaveletStandardMaterial>,
) -> &'a WaveletStandardMaterial {
    let materials = app.world().resource::<Assets<WaveletStandardMaterial>>();
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
        .with("wall.png", &png(&pictures()[0]))
        .with("wall.wtex", &wtex(Content::Color, ColorSpace::Srgb));
    let mut app = app(folder.settings(16, 16));
    let world = app.world_mut();
    let image = load(world, "wall.png", REPEAT);
    let standard = StandardMaterial {
        base_color_texture: Some(image),
        ..default()
    };
    let standard = world.add_asset::<StandardMaterial>(standard);
    let mut meshes: Vec<Entity> = (0..40).map(|_| spawn(world, &standard)).collect();
    let first = exchanged(&mut app, meshes[0]);
    let extension = &material(&app, &first).extension;
    assert_eq!(extension.address_mode, WaveletAddressMode::Repeat);
    // Those that come later have it, too.
    let later = spawn(app.world_mut(), &standard);
    exchanged(&mut app, later);
    meshes.push(later);
    let world = app.world();
    for mesh in &meshes {
        let handle = world.get::<Wavelet>(*mesh).expect("exchanged");
        assert_eq!(handle.id(), first.id());
    }
    // It lives no longer than its meshes.
    drop(first);
    let world = app.world_mut();
    for mesh in meshes {
        world.despawn(mesh);
    }
    app.render_frames(3).expect("frames");
    let world = app.world_mut();
    assert_eq!(world.resource::<Assets<WaveletStandardMaterial>>().len(), 0);
    let again = spawn(world, &standard);
    exchanged(&mut app, again);
}

#[test]
fn an_image_in_two_roles_has_both_textures() {
    let _gpu = gpu();
    let folder = Folder::new("roles")
        .with("wall.png", &png(&pictures()[0]))
        .with("wall.wtex", &wtex(Content::Color, ColorSpace::Srgb))
        .with(
            "wall.normal.wtex",
            &wtex(Content::Normal, ColorSpace::Linear),
        )
        .with("wall.data.wtex", &wtex(Content::Color, ColorSpace::Linear));
    let mut app = app(folder.settings(16, 16));
    let world = app.world_mut();
    let image = load(world, "wall.png", REPEAT);
    let standard = StandardMaterial {
        base_color_texture: Some(image.clone()),
        normal_map_texture: Some(image.clone()),
        metallic_roughness_texture: Some(image),
        ..default()
    };
    let standard = world.add_asset::<StandardMaterial>(standard);
    let mesh = spawn(world, &standard);
    let exchanged = exchanged(&mut app, mesh);
    let WaveletExtension {
        base_color,
        normal,
        metallic_roughness,
        ..
    } = &material(&app, &exchanged).extension;
    assert_eq!(path(base_color).as_deref(), Some("wall.wtex"));
    assert_eq!(path(normal).as_deref(), Some("wall.normal.wtex"));
    assert_eq!(path(metallic_roughness).as_deref(), Some("wall.data.wtex"));
}

#[test]
fn maps_that_the_material_cannot_address_keep_their_images() {
    let _gpu = gpu();
    let color = wtex(Content::Color, ColorSpace::Srgb);
    let data = wtex(Content::Color, ColorSpace::Linear);
    let mut folder = Folder::new("samplers")
        .with("a.wtex", &color)
        .with("b.wtex", &color)
        .with("c.wtex", &data)
        .with("e.wtex", &data);
    for name in ["a.png", "b.png", "c.png", "d.png", "e.png"] {
        folder = folder.with(name, &png(&pictures()[0]));
    }
    let mut app = app(folder.settings(16, 16));
    let world = app.world_mut();
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
    let standard = world.add_asset::<StandardMaterial>(standard);
    let mesh = spawn(world, &standard);
    let exchanged = exchanged(&mut app, mesh);
    let WaveletStandardMaterial { base, extension } = material(&app, &exchanged);
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

/// A binary glTF file: an unlit quad of `SIZE` units around the origin with a picture on it.
fn glb(picture: RgbImage) -> Vec<u8> {
    let [x, y] = SIZE.map(|s| s as f32 / 2.0);
    let positions = [[-x, y, 0.0], [x, y, 0.0], [-x, -y, 0.0], [x, -y, 0.0]];
    let uvs = [[0.0f32, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    let indices = [0u32, 2, 1, 1, 2, 3];
    let png = image_file(picture, ImageFormat::Png);
    let parts: [&[u8]; 4] = [
        bytemuck::cast_slice(&positions),
        bytemuck::cast_slice(&uvs),
        bytemuck::cast_slice(&indices),
        &png,
    ];
    let mut views = Vec::new();
    let mut binary = Vec::new();
    for part in parts {
        views.push(serde_json::json!({
            "buffer": 0, "byteOffset": binary.len(), "byteLength": part.len()
        }));
        binary.extend(part);
        binary.resize(binary.len().next_multiple_of(4), 0);
    }
    let json = serde_json::json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_materials_unlit"],
        "buffers": [{"byteLength": binary.len()}],
        "bufferViews": views,
        "accessors": [
            {
                "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                "min": positions[2], "max": positions[1],
            },
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5125, "count": 6, "type": "SCALAR"},
        ],
        "images": [{"bufferView": 3, "mimeType": "image/png"}],
        "textures": [{"source": 0}],
        "materials": [{
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
            "extensions": {"KHR_materials_unlit": {}},
        }],
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0,
        }]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    });
    let mut json = json.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = 12 + 8 + json.len() + 8 + binary.len();
    let mut glb = b"glTF".to_vec();
    glb.extend([2, length as u32].map(u32::to_le_bytes).as_flattened());
    for (kind, bytes) in [(b"JSON", &json), (b"BIN\0", &binary)] {
        glb.extend((bytes.len() as u32).to_le_bytes());
        glb.extend(kind);
        glb.extend(bytes);
    }
    glb
}

/// Whether the quad of a viewer is that texture, unlit and pixel by pixel.
fn shows(viewer: &mut Viewer, image: &WaveletImage) -> bool {
    viewer.app.run_until_ready(200).expect("ready");
    let shown = viewer.app.capture_f32().expect("a picture");
    let (_, pixels) = linear(image, viewer.decoded(image, 0));
    let difference = difference(&shown, |x, y| pixels[(y * SIZE[0] + x) as usize]);
    println!("{} steps at {:?}", difference.steps(), difference.at);
    difference.largest <= 2.0 * STEP + chroma_rounding(image)
}

const NEAREST: WaveletGltf = WaveletGltf {
    filter: WaveletFilter::Nearest,
};

#[test]
fn an_image_inside_a_gltf_file_is_shown_as_its_wavelet_texture() {
    let Some(gpu) = gpu_with_all_planes() else {
        return;
    };
    // Another picture than the one inside, so that one sees which is shown.
    let [inside, other] = pictures();
    let image = encoded(&other, Content::Color, ColorSpace::Srgb);
    let folder = Folder::new("glb")
        .with("model.glb", &glb(inside))
        .with("model.glb.Texture0.wtex", &file::write(&image));
    let mut viewer = Viewer::with_settings(gpu, SIZE, folder.settings(16, 16));
    let world = viewer.app.world_mut();
    let scene = world.load_asset(GltfAssetLabel::Scene(0).from_asset("model.glb"));
    let in_front = Transform::from_xyz(0.0, 0.0, 1.0);
    world.spawn((WorldAssetRoot(scene), NEAREST, in_front));
    let exchanged = wait_for(&mut viewer.app, |app| {
        let world = app.world_mut();
        let count = world.query::<&Wavelet>().iter(world).count();
        (count > 0).then_some(count)
    });
    assert_eq!(exchanged, 1);
    assert!(shows(&mut viewer, &image));
    // The image inside the file went with the material that used it.
    let world = viewer.app.world_mut();
    assert_eq!(world.query::<&Standard>().iter(world).count(), 0);
}

#[test]
fn a_gltf_scene_takes_the_textures_beside_its_images() {
    let Some(gpu) = gpu_with_all_planes() else {
        return;
    };
    let [original, other] = pictures();
    // Another picture, so that one sees which is shown.
    let image = encoded(&other, Content::Color, ColorSpace::Srgb);
    let folder = Folder::new("gltf")
        .with("wall.png", &png(&original))
        .with("wall.wtex", &file::write(&image))
        .with("bare.png", &png(&original));
    let mut viewer = Viewer::with_settings(gpu, SIZE, folder.settings(16, 16));
    let mut spawn = |picture: &str, x: f32| {
        let material = StandardMaterial {
            base_color_texture: Some(viewer.app.load(picture)),
            unlit: true,
            ..default()
        };
        let world = viewer.app.world_mut();
        let material = world.add_asset::<StandardMaterial>(material);
        let mesh = world.add_asset(Rectangle::new(SIZE[0] as f32, SIZE[1] as f32));
        let place = (Transform::from_xyz(x, 0.0, 1.0), Visibility::default());
        let root = world.spawn((NEAREST, place)).id();
        let place = (Transform::default(), Visibility::default());
        let middle = world.spawn((place, ChildOf(root))).id();
        let mesh = (Mesh3d(mesh), MeshMaterial3d(material));
        world.spawn((mesh, ChildOf(middle))).id()
    };
    let with = spawn("wall.png", 0.0);
    let without = spawn("bare.png", 1000.0);
    exchanged(&mut viewer.app, with);
    assert!(shows(&mut viewer, &image));
    // What has no wavelet texture stays as it is.
    let bare = viewer.app.world().entity(without);
    assert!(bare.contains::<Standard>() && !bare.contains::<Wavelet>());
}
