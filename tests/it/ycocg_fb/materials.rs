//! Every kind of material, seen by a packed camera.

use bevy::{
    asset::uuid_handle,
    light::NotShadowCaster,
    pbr::{ExtendedMaterial, Material, MaterialExtension, MaterialPlugin, ScreenSpaceTransmission},
    prelude::*,
    reflect::TypePath,
    render::{render_resource::AsBindGroup, view::Msaa},
    shader::ShaderRef,
};
use bevy_ycocg_fb::{CameraState, FallbackReason};
use image::RgbImage;

use super::{Studio, lit_scene, packing, spawn_mesh};
use crate::support::{drawn, gpu, keep, psnr};

/// The front of all: a tilted quad of some material before the lit scene.
fn with_quad<M: Material>(app: &mut App, material: impl Fn() -> M + Send + Sync + 'static) {
    lit_scene(app);
    app.add_systems(Startup, move |world: &mut World| {
        let place = Transform::from_xyz(0.2, 0.7, 1.1).with_rotation(Quat::from_rotation_y(0.3));
        spawn_mesh(world, Rectangle::new(1.6, 0.9), material(), place);
    });
}

fn standard(alpha_mode: AlphaMode, unlit: bool) -> StandardMaterial {
    StandardMaterial {
        base_color: Color::srgba(0.9, 0.5, 0.2, 0.6),
        alpha_mode,
        unlit,
        ..default()
    }
}

/// Renders with `Hdr`, without samples and with four, and demands a PSNR.
fn check(name: &str, least_db: [f64; 2], scene: impl FnOnce(&mut App)) {
    let _gpu = gpu();
    let mut studio = Studio::new(scene);
    for (msaa, least) in [Msaa::Off, Msaa::Sample4].into_iter().zip(least_db) {
        let reference = studio.mode(true, msaa).plain();
        studio.check(&format!("{name}, {msaa:?}"), &reference, packing(), least);
    }
}

#[test]
fn every_alpha_mode_lit() {
    let modes = [
        AlphaMode::Opaque,
        AlphaMode::Mask(0.5),
        AlphaMode::Blend,
        AlphaMode::Premultiplied,
        AlphaMode::Add,
    ];
    for mode in drawn(2, modes) {
        check(&format!("{mode:?}"), [42.0, 38.0], |app| {
            with_quad(app, move || standard(mode, false));
        });
    }
}

/// Mean over blocks of 8 x 8 pixels, in levels of 255.
fn block_means(picture: &RgbImage) -> Vec<f32> {
    let columns = picture.width() / 8;
    let mut sums = vec![0.0; (3 * columns * (picture.height() / 8)) as usize];
    for (x, y, pixel) in picture.enumerate_pixels() {
        let block = 3 * (y / 8 * columns + x / 8);
        for (channel, level) in pixel.0.iter().enumerate() {
            sums[block as usize + channel] += f32::from(*level) / 64.0;
        }
    }
    sums
}

/// Root of the mean squared difference of blocks, in levels of 255.
fn block_error(a: &RgbImage, b: &RgbImage) -> f32 {
    let pairs = block_means(a).into_iter().zip(block_means(b));
    let squares: Vec<f32> = pairs.map(|(a, b)| (a - b).powi(2)).collect();
    (squares.iter().sum::<f32>() / squares.len() as f32).sqrt()
}

/// Samples are covered as alpha says, in the mean of some pixels, and no hue shifts, however the driver
/// dithers coverage.
#[test]
fn alpha_to_coverage_is_blending_in_the_mean() {
    let _gpu = gpu();
    let quads = |mode: AlphaMode| {
        move |app: &mut App| {
            lit_scene(app);
            app.add_systems(Startup, move |world: &mut World| {
                for (i, alpha) in [0.1, 0.35, 0.6, 0.9].into_iter().enumerate() {
                    let mut material = standard(mode, false);
                    material.base_color.set_alpha(alpha);
                    let place = Transform::from_xyz(0.6 * i as f32 - 0.9, 0.7, 1.1);
                    spawn_mesh(world, Rectangle::new(0.55, 1.4), material, place);
                }
            });
        }
    };
    let blended = Studio::new(quads(AlphaMode::Blend))
        .mode(true, Msaa::Sample4)
        .plain();
    let mut studio = Studio::new(quads(AlphaMode::AlphaToCoverage));
    let plain = studio.mode(true, Msaa::Sample4).plain();
    keep("coverage_blended", &blended);
    keep("coverage_plain", &plain);
    for hdr in [true, false] {
        let packed = studio.mode(hdr, Msaa::Sample4);
        let packed = packed.packed(packing());
        keep(&format!("coverage_packed_{hdr}"), &packed);
        let [ours, bevys] = [&packed, &plain].map(|picture| block_error(picture, &blended));
        println!("hdr {hdr}: {ours:.2} levels from blending, Bevy's own {bevys:.2}");
        assert!(ours < 1.8, "hdr {hdr}: {ours} levels");
    }
}

#[test]
fn unlit_materials_are_packed_too() {
    for mode in [AlphaMode::Opaque, AlphaMode::Blend] {
        check(&format!("unlit, {mode:?}"), [42.0, 38.0], |app| {
            with_quad(app, move || standard(mode, true));
        });
    }
}

#[test]
fn multiply_is_exact_for_gray_and_keeps_the_luminance_otherwise() {
    let gray = StandardMaterial {
        base_color: Color::srgba(0.6, 0.6, 0.6, 0.8),
        alpha_mode: AlphaMode::Multiply,
        unlit: true,
        ..default()
    };
    check("multiply_gray", [42.0, 38.0], |app| {
        with_quad(app, move || gray.clone());
    });
    // The colour of the filter is lost: far from the picture, but still a filter.
    check("multiply_orange", [25.0, 25.0], |app| {
        with_quad(app, || standard(AlphaMode::Multiply, true));
    });
}

#[test]
fn transmissive_materials_see_the_packed_background() {
    check("transmissive", [40.0, 36.0], |app| {
        app.register_required_components::<Camera3d, ScreenSpaceTransmission>();
        with_quad(app, || StandardMaterial {
            base_color: Color::srgb(0.7, 0.9, 0.8),
            specular_transmission: 0.9,
            thickness: 0.2,
            ior: 1.3,
            perceptual_roughness: 0.1,
            ..default()
        });
    });
}

/// Tints what `StandardMaterial` gives, as a user's extension would.
#[derive(Asset, AsBindGroup, TypePath, Clone, Default)]
struct Tinted {}

impl MaterialExtension for Tinted {
    fn fragment_shader() -> ShaderRef {
        "shaders/tinted.wesl".into()
    }
}

#[test]
fn extended_materials_need_no_change() {
    check("extended", [42.0, 38.0], |app| {
        app.add_plugins(MaterialPlugin::<ExtendedMaterial<StandardMaterial, Tinted>>::default());
        with_quad(app, || ExtendedMaterial {
            base: standard(AlphaMode::Opaque, false),
            extension: Tinted::default(),
        });
    });
}

/// A material of its own that ends in the pack function.
#[derive(Asset, AsBindGroup, TypePath, Clone, Default)]
struct Packing {}

impl Material for Packing {
    fn fragment_shader() -> ShaderRef {
        "shaders/packing.wesl".into()
    }
}

#[test]
fn a_custom_material_packs_by_the_importable_function() {
    check("custom", [42.0, 38.0], |app| {
        app.add_plugins(MaterialPlugin::<Packing>::default());
        with_quad(app, Packing::default);
    });
}

/// A material whose shader comes late, as a file from a slow disk does.
#[derive(Asset, AsBindGroup, TypePath, Clone, Default)]
struct Late {}

const LATE: Handle<Shader> = uuid_handle!("6f4e1c52-9a10-4c3b-8a77-0d3f5b6f2a91");

impl Material for Late {
    fn fragment_shader() -> ShaderRef {
        ShaderRef::Handle(LATE)
    }
}

#[test]
fn a_shader_that_is_loading_is_no_reason_to_fall_back() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    let before = studio.mode(true, Msaa::Off).packed(packing());
    let mut late = Studio::new(|app| {
        app.add_plugins(MaterialPlugin::<Late>::default());
        lit_scene(app);
    });
    late.mode(true, Msaa::Off).packed(packing());
    let world = late.app.world_mut();
    let place = Transform::from_xyz(0.2, 0.7, 1.1);
    let quad = spawn_mesh(world, Rectangle::new(1.6, 0.9), Late::default(), place);
    world.entity_mut(quad).insert(NotShadowCaster);
    let is_packed = |late: &Studio| {
        let state = late.state();
        assert!(matches!(state, Some(CameraState::Packed(_))), "{state:?}");
    };
    for _ in 0..5 {
        late.app.render_frames(1).expect("a frame");
        is_packed(&late);
    }
    let source = include_str!("shaders/packing.wesl");
    let shader = Shader::from_wesl(source, "shaders/late.wesl");
    let mut shaders = late.app.world_mut().resource_mut::<Assets<Shader>>();
    shaders.insert(&LATE, shader).expect("a new shader");
    let with_mesh = late.picture();
    is_packed(&late);
    assert!(psnr(&before, &with_mesh) < 30.0);
}

/// A material that knows nothing of packing nor of Bevy's lighting.
#[derive(Asset, AsBindGroup, TypePath, Clone, Default)]
struct Raw {}

impl Material for Raw {
    fn fragment_shader() -> ShaderRef {
        "shaders/raw.wesl".into()
    }
}

#[test]
fn a_material_that_does_not_pack_is_named_and_the_camera_draws_as_bevy_does() {
    let _gpu = gpu();
    let mut studio = Studio::new(|app| {
        app.add_plugins(MaterialPlugin::<Raw>::default());
        with_quad(app, Raw::default);
    });
    let reference = studio.mode(true, Msaa::Off).plain();
    let picture = studio.quality(packing());
    let Some(CameraState::Fallback(FallbackReason::UnpackedPipeline(name))) = studio.state() else {
        panic!("{:?}", studio.state());
    };
    assert!(name.contains("shaders/raw.wesl"), "{name}");
    assert!(picture == reference, "the picture changed");
}
