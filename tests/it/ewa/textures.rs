//! Textures as games have them: from files, of 16 bits, with seams and borders.

use bevy::{
    asset::RenderAssetUsages,
    image::{
        ImageAddressMode, ImageLoaderSettings, ImageSampler, ImageSamplerDescriptor, ToExtents,
    },
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
    render::render_resource::{TextureDimension, TextureFormat},
};
use bevy_ewa::{EwaMethod, EwaPlugin, EwaSettings, MipReport};
use bevy_frugal_lab::metrics::max_error;
use image::{ImageFormat, RgbImage, RgbaImage};

use super::{Floor, all, checked, checkered, checks, colored, mips, sampler, texture, unlit};
use crate::support::{Folder, gpu, image_file, keep, psnr, skipped, wait_for};

fn filtering() -> Option<EwaPlugin> {
    all(EwaSettings::with_method(EwaMethod::Linear))
}

/// Waits for the mip levels of the floor's texture.
fn wait_for_mips(floor: &mut Floor) -> u32 {
    let material = &floor.material;
    wait_for(&mut floor.app, |app| {
        let materials = app.world().resource::<Assets<StandardMaterial>>();
        let texture = materials.get(material)?.base_color_texture.as_ref()?;
        match mips(app.world(), texture)? {
            MipReport::Generated(levels) => Some(levels),
            _ => None,
        }
    })
}

const GLTF: &str = r#"{
    "asset": { "version": "2.0" },
    "images": [{ "uri": "checks.png" }],
    "samplers": [{ "magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497 }],
    "textures": [{ "sampler": 0, "source": 0 }],
    "materials": [{ "pbrMetallicRoughness": {
        "baseColorTexture": { "index": 0 }, "metallicFactor": 0.0, "roughnessFactor": 0.5
    } }]
}"#;

/// A folder with `checks.png`, and `checks.gltf` with a material of it.
fn folder(name: &str) -> Folder {
    let texel = checks([250, 250, 240, 255], [20, 30, 60, 255]);
    let picture = RgbaImage::from_fn(64, 64, |x, y| image::Rgba(texel(x, y)));
    Folder::new(name)
        .with("checks.png", &image_file(picture, ImageFormat::Png))
        .with("checks.gltf", GLTF.as_bytes())
}

fn floor_in(folder: &Folder) -> Floor {
    let settings = folder.settings(96, 64);
    Floor::with_settings(settings, filtering(), |_| StandardMaterial::default())
}

/// Demands this PSNR in dB.
fn assert_like(name: &str, picture: &RgbImage, expected: &RgbImage, least_db: f64) {
    keep(name, picture);
    let psnr_db = psnr(picture, expected);
    println!("{name}: {psnr_db:.1} dB");
    assert!(psnr_db > least_db, "{name}: {psnr_db} dB");
}

/// A file without mips looks like the same texture made with them.
#[test]
fn a_png_file_is_filtered_as_a_texture_with_mips_is() {
    let _gpu = gpu();
    let folder = folder("png");
    let mut floor = floor_in(&folder);
    let world = floor.app.world();
    let loaded = world
        .load_builder()
        .with_settings(|settings: &mut ImageLoaderSettings| {
            settings.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
                address_mode_u: ImageAddressMode::Repeat,
                address_mode_v: ImageAddressMode::Repeat,
                ..ImageSamplerDescriptor::linear()
            });
        })
        .load("checks.png");
    floor.lay(|_| colored(loaded));
    assert_eq!(wait_for_mips(&mut floor), 7);
    let expected = Floor::new(filtering(), checkered(true)).picture();
    assert_like("png", &floor.picture(), &expected, 50.0);
}

#[test]
fn a_gltf_material_is_filtered_as_one_made_here_is() {
    let _gpu = gpu();
    let folder = folder("gltf");
    let mut floor = floor_in(&folder);
    let loaded: Handle<StandardMaterial> = floor.app.load("checks.gltf#Material0/std");
    floor
        .app
        .world_mut()
        .entity_mut(floor.floor)
        .insert(MeshMaterial3d(loaded.clone()));
    floor.material = loaded;
    floor.app.run_until_ready(500).expect("loaded");
    assert_eq!(wait_for_mips(&mut floor), 7);
    let picture = floor.picture();
    let materials = floor.app.world().resource::<Assets<StandardMaterial>>();
    let material = materials.get(&floor.material).expect("loaded").clone();
    let made_here = |images: &mut Assets<Image>| StandardMaterial {
        base_color_texture: checkered(true)(images).base_color_texture,
        ..material
    };
    let expected = Floor::new(filtering(), made_here).picture();
    assert_like("gltf", &picture, &expected, 50.0);
}

/// Checks as [`checkered`] has them, in linear light.
fn wide(format: TextureFormat, texel: impl Fn(f32) -> u16) -> Image {
    let checks = checks([255; 4], [0, 0, 0, 255]);
    let data = (0..64 * 64)
        .flat_map(|i| checks(i % 64, i / 64))
        .flat_map(|byte| texel(f32::from(byte) / 255.0).to_le_bytes());
    let mut image = Image::new(
        UVec2::splat(64).to_extents(),
        TextureDimension::D2,
        data.collect(),
        format,
        RenderAssetUsages::default(),
    );
    image.sampler = texture(false, TextureFormat::Rgba8Unorm, |_, _| [0; 4]).sampler;
    image
}

#[test]
fn textures_of_16_bits_get_mips_too() {
    let _gpu = gpu();
    let unlit = |image: Image| |images: &mut Assets<Image>| unlit(images.add(image));
    let black_and_white = checks([255; 4], [0, 0, 0, 255]);
    let eight = texture(true, TextureFormat::Rgba8UnormSrgb, black_and_white);
    let expected = Floor::new(filtering(), unlit(eight)).picture();
    let half = |value: f32| -> u16 { if value > 0.5 { 0x3c00 } else { 0 } };
    let unorm = |value: f32| (value * 65535.0) as u16;
    let norm = wgpu::Features::TEXTURE_FORMAT_16BIT_NORM;
    let any = wgpu::Features::empty();
    for (format, texel, feature) in [
        (TextureFormat::Rgba16Float, half as fn(f32) -> u16, any),
        (TextureFormat::Rgba16Unorm, unorm, norm),
    ] {
        let mut floor = Floor::new(filtering(), |_| StandardMaterial::default());
        if !floor.app.features().contains(feature) {
            skipped(&format!(
                "EWA of {format:?}: the adapter has no such textures"
            ));
            continue;
        }
        let image = wide(format, texel);
        floor.lay(unlit(image));
        assert_eq!(wait_for_mips(&mut floor), 7, "{format:?}");
        assert_like(&format!("{format:?}"), &floor.picture(), &expected, 45.0);
    }
}

/// A floor of strips, each of whose coordinates begin anew or go on.
fn strips(anew: bool) -> Mesh {
    let (mut positions, mut uvs, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..8 {
        let (left, right) = (i as f32 - 4.0, i as f32 - 3.0);
        let first = positions.len() as u32;
        positions.extend([
            [left, 0.0, -30.0],
            [left, 0.0, 2.0],
            [right, 0.0, 2.0],
            [right, 0.0, -30.0],
        ]);
        // Whole textures apart: the same texels.
        let u = if anew { 0.0 } else { 2.0 * left };
        uvs.extend([[u, -30.0], [u, 2.0], [u + 2.0, 2.0], [u + 2.0, -30.0]]);
        indices.extend([0, 1, 2, 0, 2, 3].map(|k| first + k));
    }
    Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::default(),
    )
    .with_inserted_attribute(
        Mesh::ATTRIBUTE_NORMAL,
        vec![[0.0, 1.0, 0.0]; positions.len()],
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
    .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs)
    .with_inserted_indices(Indices::U32(indices))
}

#[test]
fn seams_of_texture_coordinates_do_not_show() {
    let _gpu = gpu();
    let [whole, seams] = [false, true].map(|anew| {
        let mut floor = Floor::new(filtering(), checkered(true)).cleared();
        let world = floor.app.world_mut();
        let mesh = world.add_asset(strips(anew));
        world.entity_mut(floor.floor).insert(Mesh3d(mesh));
        floor.picture()
    });
    keep("whole", &whole);
    keep("seams", &seams);
    let found = max_error(&whole, &seams).expect("equal sizes");
    println!("{found} levels");
    assert!(found <= 2, "{found} levels");
}

/// A texture that is clamped keeps its border, however far away, and is not asked for.
#[test]
fn clamped_textures_are_not_repeated_at_large_coordinates() {
    let _gpu = gpu();
    let clamped = |mode| {
        move |images: &mut Assets<Image>| {
            let mut image = checked(true);
            sampler(&mut image).address_mode_u = mode;
            sampler(&mut image).address_mode_v = mode;
            unlit(images.add(image))
        }
    };
    let far = |floor: Floor| {
        let mut floor = floor.cleared();
        let mut mesh = strips(false);
        let uvs = [
            [100.0, 100.0],
            [100.0, 132.0],
            [102.0, 132.0],
            [102.0, 100.0],
        ];
        mesh.insert_attribute(Mesh::ATTRIBUTE_UV_0, uvs.repeat(8));
        let world = floor.app.world_mut();
        let mesh = world.add_asset(mesh);
        world.entity_mut(floor.floor).insert(Mesh3d(mesh));
        floor
    };
    for settings in [None, Some(EwaSettings::with_method(EwaMethod::Linear))] {
        let plugin = EwaPlugin {
            all_materials: settings,
        };
        let clamped_to_edge = clamped(ImageAddressMode::ClampToEdge);
        let mut floor = far(Floor::new(Some(plugin), clamped_to_edge));
        let edge = match settings {
            Some(_) => floor.picture(),
            None => floor.chosen(EwaSettings::with_method(EwaMethod::Linear)),
        };
        keep("clamped", &edge);
        // The last texel of the texture is white, and so is the floor, up to its mip levels.
        let below = edge.get_pixel(48, 60).0;
        assert!(below.iter().all(|c| *c > 220), "{settings:?}: {below:?}");
        assert!(steps(&edge) < 10, "{settings:?}: {}", steps(&edge));

        let repeating = clamped(ImageAddressMode::Repeat);
        let repeated = far(Floor::new(Some(plugin), repeating)).picture();
        assert!(steps(&repeated) > 40, "{}", steps(&repeated));
    }
}

/// The largest step from a pixel to its neighbour, where there is nothing but floor.
fn steps(picture: &RgbImage) -> u8 {
    let pixels = (40..64).flat_map(|y| (30..66).map(move |x| (x, y)));
    let step = |(x, y)| {
        let [a, b] = [x, x + 1].map(|x| picture.get_pixel(x, y).0[0]);
        a.abs_diff(b)
    };
    pixels.map(step).max().unwrap_or_default()
}

/// The holes of a mask are filtered in the shadow that it casts, too.
#[test]
fn shadows_of_masks_are_filtered() {
    let _gpu = gpu();
    let plain = |_: &mut Assets<Image>| StandardMaterial {
        base_color: Color::srgb(0.7, 0.7, 0.7),
        perceptual_roughness: 1.0,
        ..default()
    };
    let mut floor = Floor::new(Some(EwaPlugin::OPT_IN), plain);
    // Only its shadow is in the picture: the floor has no texture, so nothing else can change.
    let post = floor.post;
    let camera = floor.camera;
    let world = floor.app.world_mut();
    world.entity_mut(post).insert((
        Transform::from_xyz(0.0, 1.2, -1.6)
            .with_scale(Vec3::splat(4.0))
            .with_rotation(Quat::from_rotation_y(0.9)),
        bevy::camera::visibility::RenderLayers::layer(0),
        bevy::light::NotShadowReceiver,
    ));
    let below_it =
        Transform::from_xyz(0.0, 0.3, 0.0).looking_to(Vec3::new(0.1, -0.8, -1.0), Vec3::Y);
    world.entity_mut(camera).insert(below_it);
    let stock = floor.picture();
    let filtered = floor.all(Some(EwaSettings::with_method(EwaMethod::Linear)));
    keep("shadow_stock", &stock);
    keep("shadow_ewa", &filtered);
    let without = floor.cleared().picture();
    keep("shadow_none", &without);
    let shadow = psnr(&stock, &without);
    let changed = psnr(&stock, &filtered);
    println!("shadow {shadow:.1} dB, filtered {changed:.1} dB");
    assert!(shadow < 25.0, "there is a shadow: {shadow} dB");
    assert!(stock != filtered, "it is filtered");
    assert!(
        changed > shadow + 3.0,
        "it is the same shadow: {changed} dB"
    );
}
