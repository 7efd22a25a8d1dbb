//! What Bevy's own materials do in a scene, wavelet materials do alike.

use bevy::{
    core_pipeline::oit::OrderIndependentTransparencySettings,
    light::{ClusteredDecal, GlobalAmbientLight},
    mesh::UvChannel,
    pbr::{ParallaxMappingMethod, ScreenSpaceAmbientOcclusion},
    prelude::*,
    render::render_resource::TextureFormat,
};
use bevy_frugal_lab::content;
use bevy_wavelet_tex::codec::image::{ColorSpace, Content, WaveletImage};
use image::{DynamicImage, Rgb, RgbImage};

use super::{
    scene::gpu_with_all_planes,
    twin::{Maps, Path, Twin, add_image, differences, rectangle, square, without_mips},
};
use crate::support::{drawn, psnr, skipped, warned_of};

const TEXELS: u32 = 64;

/// Occlusion, roughness and metallic that have nothing in common.
fn orm() -> WaveletImage {
    let [r, g, b] = [5, 6, 7].map(|seed| content::photo_like(TEXELS, TEXELS, seed));
    let picture = RgbImage::from_fn(TEXELS, TEXELS, |x, y| {
        let [r, g, b] = [&r, &g, &b].map(|p| p.get_pixel(x, y)[1]);
        Rgb([r, g / 2 + 120, b])
    });
    without_mips(&picture, Content::Color, ColorSpace::Linear)
}

/// As bright as a white wall of 0.5 on the screen.
const AMBIENT: f32 = 600.0;

/// A square under a light.
fn lit(world: &mut World, _: Entity) -> Vec<Entity> {
    world.spawn((
        DirectionalLight {
            illuminance: 3000.0,
            ..default()
        },
        Transform::from_xyz(1.5, 1.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    vec![square(world)]
}

fn rough(_: &mut World) -> StandardMaterial {
    StandardMaterial {
        perceptual_roughness: 1.0,
        ..default()
    }
}

/// A rough square in the light, with these maps.
fn lit_twin(path: Path, maps: Maps) -> Twin<'static> {
    Twin {
        path,
        maps,
        base: &rough,
        ambient: AMBIENT,
        scene: &lit,
    }
}

fn colored() -> Maps {
    let picture = content::photo_like(TEXELS, TEXELS, 3);
    Maps {
        base_color: Some(without_mips(&picture, Content::Color, ColorSpace::Srgb)),
        ..default()
    }
}

/// Compares the pictures of a twin, of which the wavelet one has to differ from that without maps.
fn assert_alike(name: &str, twin: &Twin, largest: u8) {
    let [wavelet, decoded] = twin.pictures();
    let bare = Twin {
        maps: Maps::default(),
        ..twin.clone()
    };
    let (worst, mean) = differences(&wavelet, &decoded);
    let (_, effect) = differences(&wavelet, &bare.wavelet());
    println!("{name}: {worst} levels at most, {mean:.3} in the mean; {effect:.1} from no maps");
    assert!(worst <= largest, "{name}: {worst} levels of 255");
    assert!(mean < 0.6, "{name}: {mean} levels in the mean");
    assert!(effect > 2.0, "{name}: the maps are not seen");
}

#[test]
fn occlusion_roughness_and_metallic_of_colour_are_its_channels() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let base = |_: &mut World| StandardMaterial {
        perceptual_roughness: 1.0,
        metallic: 1.0,
        ..default()
    };
    let both = Maps {
        metallic_roughness: Some(orm()),
        occlusion: Some(orm()),
        ..default()
    };
    let shared = Maps {
        occlusion: None,
        is_shared: true,
        ..both.clone()
    };
    let occlusion = Maps {
        metallic_roughness: None,
        ..both.clone()
    };
    let cases = [
        ("one texture", shared),
        ("two", both),
        ("occlusion alone", occlusion),
    ];
    let paths = [Path::Forward, Path::Prepass, Path::Deferred];
    let rows = cases
        .into_iter()
        .flat_map(|(name, maps)| paths.map(|path| (name, maps.clone(), path)));
    for (name, maps, path) in drawn(3, rows) {
        let twin = Twin {
            base: &base,
            ..lit_twin(path, maps)
        };
        assert_alike(&format!("{name}, {path:?}"), &twin, 3);
    }
}

#[test]
fn a_mask_of_colour_is_its_red_channel() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let base = |_: &mut World| StandardMaterial {
        alpha_mode: AlphaMode::Blend,
        perceptual_roughness: 1.0,
        ..default()
    };
    let mask = Maps {
        mask: Some(orm()),
        ..default()
    };
    let twin = Twin {
        base: &base,
        ..lit_twin(Path::Forward, mask)
    };
    assert_alike("mask", &twin, 3);
}

#[test]
fn maps_on_the_second_uv_set_take_it() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let scene = |world: &mut World, camera: Entity| {
        let entities = lit(world, camera);
        let id = world.get::<Mesh3d>(entities[0]).expect("a mesh").id();
        let mut meshes = world.resource_mut::<Assets<Mesh>>();
        let mut mesh = meshes.get_mut(id).expect("its mesh");
        let second = [[0.8, 0.1], [0.1, 0.3], [0.2, 0.9], [0.9, 0.7]];
        mesh.insert_attribute(Mesh::ATTRIBUTE_UV_1, second.to_vec());
        entities
    };
    // The two maps of one texture have different sets.
    let base = |_: &mut World| StandardMaterial {
        base_color_channel: UvChannel::Uv1,
        metallic_roughness_channel: UvChannel::Uv1,
        perceptual_roughness: 1.0,
        metallic: 1.0,
        ..default()
    };
    for path in [Path::Forward, Path::Deferred] {
        let maps = Maps {
            metallic_roughness: Some(orm()),
            is_shared: true,
            ..colored()
        };
        let twin = Twin {
            base: &base,
            scene: &scene,
            ..lit_twin(path, maps)
        };
        // A G-buffer rounds each of three maps once more.
        let largest = 3 + u8::from(path == Path::Deferred);
        assert_alike(&format!("second set, {path:?}"), &twin, largest);
    }
}

/// Boxes on a floor, seen from above, without a lamp.
fn corner(world: &mut World, camera: Entity) -> Vec<Entity> {
    world.entity_mut(camera).insert((
        ScreenSpaceAmbientOcclusion::default(),
        Transform::from_xyz(0.0, 1.6, 2.4).looking_at(Vec3::new(0.0, 0.2, 0.0), Vec3::Y),
    ));
    let mut meshes = world.resource_mut::<Assets<Mesh>>();
    let [floor, cube] = [
        meshes.add(Plane3d::default().mesh().size(6.0, 6.0)),
        meshes.add(Cuboid::from_length(0.7)),
    ];
    let mut spawn = |mesh: &Handle<Mesh>, x: f32, y: f32| {
        let at = Transform::from_xyz(x, y, 0.0);
        world.spawn((Mesh3d(mesh.clone()), at)).id()
    };
    vec![
        spawn(&floor, 0.0, 0.0),
        spawn(&cube, -0.42, 0.35),
        spawn(&cube, 0.42, 0.35),
    ]
}

#[test]
fn screen_space_occlusion_is_that_of_the_colour_with_its_maps_in_every_path() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    // Dark, so that little light is reflected once more. The map has one colour, whose rounding both paths share.
    let picture = RgbImage::from_pixel(TEXELS, TEXELS, Rgb([124, 110, 96]));
    let dark = without_mips(&picture, Content::Color, ColorSpace::Srgb);
    let base = |_: &mut World| StandardMaterial {
        perceptual_roughness: 0.8,
        ..default()
    };
    let pictures = [Path::Forward, Path::Deferred].map(|path| {
        let dark = Maps {
            base_color: Some(dark.clone()),
            ..default()
        };
        let twin = Twin {
            base: &base,
            scene: &corner,
            ..lit_twin(path, dark)
        };
        assert_alike(&format!("occlusion, {path:?}"), &twin, 1);
        twin.wavelet()
    });
    let (worst, mean) = differences(&pictures[0], &pictures[1]);
    println!("forward to deferred: {worst} levels at most, {mean:.3} in the mean");
    assert!(worst <= 1, "forward to deferred: {worst} levels of 255");
}

#[test]
fn transparent_materials_are_sorted_by_pixel_where_the_camera_does() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    // Two squares that go through each other.
    let scene = |world: &mut World, camera: Entity| {
        world
            .entity_mut(camera)
            .insert(OrderIndependentTransparencySettings::default());
        let squares = [lit(world, camera)[0], square(world)];
        for (square, angle) in squares.into_iter().zip([0.7, -0.7]) {
            let turned = Transform::from_rotation(Quat::from_rotation_y(angle));
            world.entity_mut(square).insert(turned);
        }
        squares.to_vec()
    };
    for alpha_mode in [AlphaMode::Blend, AlphaMode::Premultiplied, AlphaMode::Add] {
        let base = |_: &mut World| StandardMaterial {
            base_color: Color::srgba(1.0, 1.0, 1.0, 0.6),
            alpha_mode,
            cull_mode: None,
            double_sided: true,
            ..default()
        };
        let twin = Twin {
            base: &base,
            scene: &scene,
            ..lit_twin(Path::Forward, colored())
        };
        assert_alike(&format!("{alpha_mode:?}"), &twin, 4);
    }
}

#[test]
fn alpha_to_coverage_is_as_sharp_as_bevys() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    // A slope over a third of the square, whose edge is a line where alpha crosses the cutoff.
    let slope = |x: u32, y: u32| (x * 10 + y * 3).saturating_sub(300).min(255) as u8;
    let picture = RgbImage::from_fn(TEXELS, TEXELS, |x, y| Rgb([slope(x, y); 3]));
    let scene = |world: &mut World, camera: Entity| {
        world.entity_mut(camera).insert(Msaa::Sample4);
        lit(world, camera)
    };
    let base = |_: &mut World| StandardMaterial {
        alpha_mode: AlphaMode::AlphaToCoverage,
        perceptual_roughness: 1.0,
        ..default()
    };
    let mask = Maps {
        mask: Some(without_mips(&picture, Content::Gray, ColorSpace::Linear)),
        ..default()
    };
    let twin = Twin {
        base: &base,
        scene: &scene,
        ..lit_twin(Path::Forward, mask)
    };
    let [wavelet, decoded] = twin.pictures();
    // Where the alphas of both are a rounding apart, a pixel can have a sample more.
    let apart = |a: &RgbImage, b: &RgbImage| {
        let pairs = a.pixels().zip(b.pixels());
        pairs.filter(|(a, b)| a[1].abs_diff(b[1]) > 4).count()
    };
    let off = apart(&wavelet, &decoded);
    let all = wavelet.pixels().len();
    let lit = apart(
        &wavelet,
        &RgbImage::from_pixel(96, 96, *wavelet.get_pixel(0, 0)),
    );
    println!("{off} of {all} pixels are apart, {lit} are not the background");
    assert!(off <= 30, "{off} of {all} pixels");
    assert!(
        lit > all / 4 && lit < all - all / 4,
        "{lit} of {all} pixels"
    );
}

#[test]
fn a_depth_map_moves_wavelet_maps() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let scene = |world: &mut World, camera: Entity| {
        let eye = Transform::from_xyz(1.7, 0.4, 1.7);
        let eye = eye.looking_at(Vec3::ZERO, Vec3::Y);
        world.entity_mut(camera).insert(eye);
        lit(world, camera)
    };
    let methods = [
        ("occlusion", ParallaxMappingMethod::Occlusion),
        ("relief", ParallaxMappingMethod::Relief { max_steps: 5 }),
    ];
    for (name, parallax_mapping_method) in drawn(1, methods) {
        let base = |world: &mut World| {
            // Slopes without edges, at which a rounding would decide.
            let depth = (0..16 * 16).map(|i| [100 + (i % 16) * 6 + (i / 16) * 3; 4]);
            let texels = depth.map(|texel| texel.map(|v: i32| v as u8)).collect();
            StandardMaterial {
                depth_map: Some(add_image(world, [16; 2], texels, TextureFormat::Rgba8Unorm)),
                parallax_depth_scale: 0.15,
                parallax_mapping_method,
                ..rough(world)
            }
        };
        for path in [Path::Forward, Path::Deferred] {
            let twin = Twin {
                base: &base,
                scene: &scene,
                ..lit_twin(path, colored())
            };
            assert_alike(&format!("{name}, {path:?}"), &twin, 4);
            let without = Twin {
                base: &rough,
                ..twin.clone()
            };
            let (_, moved) = differences(&twin.wavelet(), &without.wavelet());
            assert!(
                moved > 2.0,
                "{name}, {path:?}: {moved} levels from a flat square"
            );
        }
    }
}

#[test]
fn clustered_decals_lie_on_wavelet_materials() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let scene = |world: &mut World, camera: Entity| {
        let red = vec![[255, 0, 0, 255]; 16];
        let red = add_image(world, [4; 2], red, TextureFormat::Rgba8UnormSrgb);
        world.spawn((
            ClusteredDecal {
                base_color_texture: Some(red),
                ..default()
            },
            Transform::from_scale(Vec3::splat(0.8)),
        ));
        lit(world, camera)
    };
    for path in [Path::Forward, Path::Deferred] {
        let twin = Twin {
            scene: &scene,
            ..lit_twin(path, colored())
        };
        assert_alike(&format!("decal, {path:?}"), &twin, 3);
        let without = Twin {
            scene: &lit,
            ..twin.clone()
        };
        if differences(&twin.decoded(), &without.decoded()).1 < 1.0 {
            skipped("clustered decals: this Bevy, or the device, has none");
        }
    }
}

#[test]
fn a_texture_of_another_kind_is_left_out_and_named() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let normals = content::bricks(TEXELS, TEXELS, 3).normal;
    let maps = Maps {
        occlusion: Some(without_mips(&normals, Content::Normal, ColorSpace::Linear)),
        ..colored()
    };
    let twin = lit_twin(Path::Forward, maps);
    let without = lit_twin(Path::Forward, colored());
    assert_eq!(differences(&twin.wavelet(), &without.wavelet()).0, 0);
    assert!(warned_of("a material goes without its map of occlusion"));
}

/// A lit, masked square that throws its shadow on a wall.
fn before_a_wall(world: &mut World, _: Entity) -> Vec<Entity> {
    world.spawn((
        DirectionalLight {
            // So that nothing is clipped, with the light that the material emits.
            illuminance: 1500.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(1.5, 1.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    let wall = world.add_asset(Rectangle::new(6.0, 6.0));
    let gray = world.add_asset::<StandardMaterial>(Color::srgb(0.6, 0.6, 0.6));
    world.spawn((
        Mesh3d(wall),
        MeshMaterial3d(gray),
        Transform::from_xyz(0.0, 0.0, -0.4),
    ));
    vec![rectangle(world, 1.6)]
}

fn leaf(_: &mut World) -> StandardMaterial {
    StandardMaterial {
        alpha_mode: AlphaMode::Mask(0.5),
        perceptual_roughness: 0.9,
        metallic: 0.8,
        emissive: LinearRgba::rgb(0.3, 0.3, 0.3),
        ..default()
    }
}

fn leaf_twin(path: Path, maps: Maps) -> Twin<'static> {
    Twin {
        path,
        maps,
        base: &leaf,
        ambient: GlobalAmbientLight::default().brightness,
        scene: &before_a_wall,
    }
}

fn all_maps() -> Maps {
    let foliage = content::foliage(TEXELS, TEXELS, 3);
    let mask = DynamicImage::ImageLuma8(foliage.mask).to_rgb8();
    let photo = |seed, content, color_space| {
        let picture = content::photo_like(TEXELS, TEXELS, seed);
        Some(without_mips(&picture, content, color_space))
    };
    let map = |picture, content, color_space| Some(without_mips(picture, content, color_space));
    Maps {
        base_color: map(&foliage.color, Content::Color, ColorSpace::Srgb),
        normal: map(&foliage.normal, Content::Normal, ColorSpace::Linear),
        mask: map(&mask, Content::Gray, ColorSpace::Linear),
        emissive: photo(4, Content::Color, ColorSpace::Srgb),
        metallic_roughness: photo(5, Content::Color, ColorSpace::Linear),
        occlusion: photo(6, Content::Gray, ColorSpace::Linear),
        is_shared: false,
    }
}

/// Each map alone is a pipeline of its own, is seen, and looks as its decoded image does.
#[test]
fn every_map_alone_is_seen() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let all = all_maps();
    let bare = leaf_twin(Path::Forward, Maps::default()).wavelet();
    let maps: [(&str, fn(&mut Maps) -> &mut Option<WaveletImage>); 5] = [
        ("base color", |maps| &mut maps.base_color),
        ("emissive", |maps| &mut maps.emissive),
        ("normal", |maps| &mut maps.normal),
        ("metallic-roughness", |maps| &mut maps.metallic_roughness),
        ("occlusion", |maps| &mut maps.occlusion),
    ];
    for (name, map) in maps {
        let mut maps = Maps::default();
        *map(&mut maps) = map(&mut all.clone()).take();
        let [wavelet, decoded] = leaf_twin(Path::Forward, maps).pictures();
        let (seen, right) = (psnr(&bare, &wavelet), psnr(&decoded, &wavelet));
        println!("{name}: {right:.1} dB, {seen:.1} dB from no map");
        assert!(seen < right - 6.0, "{name} is not seen");
    }
}

#[test]
fn all_maps_look_as_their_decoded_images_in_every_path() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let maps = all_maps();
    for path in drawn(2, [Path::Forward, Path::Prepass, Path::Deferred]) {
        let [wavelet, decoded] = leaf_twin(path, maps.clone()).pictures();
        let bare = leaf_twin(path, Maps::default()).decoded();
        let effect = psnr(&bare, &wavelet);
        let (flips, psnr_db) = apart_from_flips(&decoded, &wavelet);
        println!("{path:?}: {psnr_db:.1} dB, {flips} flips, {effect:.1} dB against no maps");
        assert!(flips <= 12, "{path:?}: {flips} pixels");
        assert!(psnr_db > 50.0, "{path:?}: {psnr_db} dB");
        assert!(effect < 25.0, "{path:?}: the maps are not seen");
    }
}

/// Pixels at the edges of the mask that fall to the other side of the cutoff, and the PSNR in dB of
/// all others.
fn apart_from_flips(a: &RgbImage, b: &RgbImage) -> (u32, f64) {
    let (mut flips, mut sum, mut count) = (0, 0.0, 0.0);
    for (a, b) in a.pixels().zip(b.pixels()) {
        let differences = [0, 1, 2].map(|c: usize| f64::from(a[c].abs_diff(b[c])));
        if differences.iter().any(|d| *d > 24.0) {
            flips += 1;
        } else {
            sum += differences.map(|d| d * d).iter().sum::<f64>();
            count += 3.0;
        }
    }
    (flips, 10.0 * (255.0 * 255.0 * count / sum).log10())
}
