//! Cameras that Bevy draws in three small floats.

use bevy::{
    anti_alias::{fxaa::Fxaa, smaa::Smaa, taa::TemporalAntiAliasing},
    camera::{ClearColorConfig, Hdr},
    core_pipeline::{
        oit::OrderIndependentTransparencySettings,
        prepass::{DeferredPrepass, DepthPrepass},
        tonemapping::{DebandDither, Tonemapping},
    },
    ecs::system::EntityCommands,
    math::{Affine3A, UVec4},
    pbr::ScreenSpaceReflections,
    post_process::{bloom::Bloom, dof::DepthOfField},
    prelude::*,
    render::{
        Render, RenderApp, RenderSystems,
        render_resource::TextureFormat,
        sync_world::TemporaryRenderEntity,
        view::{ColorGrading, ExtractedView, Msaa, RetainedViewEntity},
    },
};
use bevy_frugal_lab::headless::LabTarget;
use bevy_ycocg_fb::{
    CameraState, FallbackReason as Reason, FrameBufferFormat, FrameBufferQuality, PackedFormat,
    YCoCgFrameBuffer, reference::rg11b10ufloat::dithered,
};
use image::RgbImage;

use super::{
    flat::{Flat, random_colors},
    scene::{Studio, clear_to, keep, lit_scene, psnr},
};
use crate::support::gpu;

#[test]
fn the_dial_names_the_formats() {
    use FrameBufferQuality as Quality;
    let unorm8 = FrameBufferFormat::Packed(PackedFormat::Unorm8);
    let small_floats = FrameBufferFormat::Rg11b10Ufloat;
    for (quality, hdr, expected) in [
        (Quality::Exact, true, vec![]),
        (Quality::Compact, true, vec![small_floats]),
        (Quality::Smallest, true, vec![unorm8, small_floats]),
        (Quality::Smallest, false, vec![unorm8]),
        (
            YCoCgFrameBuffer::default().into(),
            true,
            vec![PackedFormat::Float16.into()],
        ),
    ] {
        assert_eq!(quality.formats(hdr), expected, "{quality:?}");
    }
}

#[test]
fn the_shader_rounds_as_the_reference() {
    let _gpu = gpu();
    let (size, offset) = ([37, 23], [3, 2]);
    // All exponents that the format has, and more.
    let colors: Vec<_> = random_colors(size, 3)
        .into_iter()
        .enumerate()
        .map(|(i, color)| color.map(|channel| channel * 2f32.powi(i as i32 % 40 - 24)))
        .collect();
    let mut flat = Flat::new([40, 28], size, offset, &colors);
    let found = flat.colors(FrameBufferQuality::Compact, CameraState::Rg11b10Ufloat);
    for (i, (found, color)) in (0_u32..).zip(found.iter().zip(colors)) {
        let (x, y) = (offset[0] + i % size[0], offset[1] + i / size[0]);
        assert_eq!(*found, dithered(color, x, y), "{color:?} at {x} {y}");
    }
}

/// A dark gradient, whose steps in this format are wide: the mean of a block is that of the gradient.
#[test]
fn a_gradient_has_no_bands() {
    let _gpu = gpu();
    let size = [128, 32];
    let colors: Vec<_> = (0..size[0] * size[1])
        .map(|i| [0.02 + 0.00001 * (i % size[0]) as f32; 3])
        .collect();
    let mut flat = Flat::new(size, size, [0, 0], &colors);
    let found = flat.colors(FrameBufferQuality::Compact, CameraState::Rg11b10Ufloat);
    let nearest: Vec<_> = colors
        .iter()
        // All of these have steps of 2^-12 in red and green and of 2^-11 in blue.
        .map(|&[r, g, b]| {
            let round = |value: f32, step: f32| (value / step).round() * step;
            let step = 2f32.powi(r.log2().floor() as i32 - 6);
            [round(r, step), round(g, step), round(b, 2.0 * step)]
        })
        .collect();
    // Root mean square of the differences of means of 8 x 8 pixels, in red.
    let error = |picture: &[[f32; 3]]| {
        let blocks = (0..size[0] / 8).flat_map(|x| (0..size[1] / 8).map(move |y| (8 * x, 8 * y)));
        let squares = blocks.map(|(x, y)| {
            let pixels = (0..64).map(|i| ((y + i / 8) * size[0] + x + i % 8) as usize);
            let difference = pixels.map(|i| f64::from(picture[i][0] - colors[i][0]));
            (difference.sum::<f64>() / 64.0).powi(2)
        });
        (squares.sum::<f64>() / f64::from(size[0] / 8 * (size[1] / 8))).sqrt()
    };
    let (dithered, rounded) = (error(&found), error(&nearest));
    println!("{dithered:.2e} dithered, {rounded:.2e} to nearest");
    assert!(dithered < 0.1 * rounded);
}

/// Demands a PSNR of the camera as configured, with `Hdr` and without where that applies.
fn check(
    studio: &mut Studio,
    name: &str,
    msaa: Msaa,
    wanted: [Option<f64>; 2],
    configure: impl FnOnce(&mut EntityCommands),
) {
    studio.camera(configure);
    for (hdr, wanted) in [true, false].into_iter().zip(wanted) {
        let Some(wanted) = wanted else {
            continue;
        };
        let reference = studio.mode(hdr, msaa).plain();
        let picture = studio.rg11b10ufloat();
        keep(&format!("{name}_{hdr}_plain"), &reference);
        keep(&format!("{name}_{hdr}_rg11b10ufloat"), &picture);
        let found = psnr(&reference, &picture);
        println!("{name} {msaa:?} hdr {hdr}: {found:.2} dB");
        assert!(found >= wanted, "{name} hdr {hdr}: {found:.2} dB");
    }
}

#[test]
fn with_hdr_and_without_at_every_sample_count() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    for msaa in [Msaa::Off, Msaa::Sample4] {
        check(&mut studio, "lit", msaa, [Some(51.5), Some(54.5)], |_| {});
    }
}

#[test]
fn passes_of_bevy_that_packed_cameras_lack() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    let hdr_only = [Some(51.5), None];
    check(&mut studio, "oit", Msaa::Off, hdr_only, |camera| {
        camera.insert(OrderIndependentTransparencySettings::default());
    });
    studio.camera(|camera| {
        camera.remove::<(OrderIndependentTransparencySettings, DepthPrepass)>();
    });
    check(&mut studio, "deferred", Msaa::Off, hdr_only, |camera| {
        camera.insert((DepthPrepass, DeferredPrepass));
    });
    check(&mut studio, "reflections", Msaa::Off, hdr_only, |camera| {
        camera.insert(ScreenSpaceReflections::default());
    });
}

#[test]
fn effects_on_hdr() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    let hdr_only = [Some(48.0), None];
    check(&mut studio, "bloom", Msaa::Off, hdr_only, |camera| {
        camera.insert(Bloom::NATURAL);
    });
    studio.camera(|camera| {
        camera.remove::<Bloom>();
    });
    check(&mut studio, "depth_of_field", Msaa::Off, hdr_only, |c| {
        c.insert(DepthOfField {
            focal_distance: 3.0,
            aperture_f_stops: 0.05,
            ..default()
        });
    });
}

/// The history has Bevy's own format, whose alpha keeps the confidence: without it, the picture has 39.6 dB.
#[test]
fn temporal_anti_aliasing() {
    let _gpu = gpu();
    // In apps of their own, as the jitter depends on the number of frames that the app has drawn.
    let [reference, picture] = [None, Some(FrameBufferQuality::Compact)].map(|frame_buffer| {
        let mut studio = Studio::new(lit_scene);
        studio.mode(true, Msaa::Off).camera(|camera| {
            camera.insert(TemporalAntiAliasing::default());
            if let Some(frame_buffer) = frame_buffer {
                camera.insert(frame_buffer);
            }
        });
        studio.app.render_frames(60).expect("frames");
        studio.picture()
    });
    keep("taa_plain", &reference);
    keep("taa_rg11b10ufloat", &picture);
    let found = psnr(&reference, &picture);
    println!("{found:.2} dB");
    assert!(found > 45.0, "{found:.2} dB");
    let darker = mean_level(&reference) - mean_level(&picture);
    println!("{darker:.2} levels darker");
    assert!((0.0..1.8).contains(&darker), "{darker:.2} levels darker");
}

fn mean_level(picture: &RgbImage) -> f64 {
    let levels = picture.as_raw();
    levels.iter().map(|&level| f64::from(level)).sum::<f64>() / levels.len() as f64
}

#[test]
fn effects_after_tone_mapping() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    check(&mut studio, "fxaa", Msaa::Off, [Some(49.0); 2], |camera| {
        camera.insert(Fxaa::default());
    });
    studio.camera(|camera| {
        camera.remove::<Fxaa>();
    });
    check(&mut studio, "smaa", Msaa::Off, [Some(50.5); 2], |camera| {
        camera.insert(Smaa::default());
    });
}

#[test]
fn every_tone_mapping() {
    use Tonemapping as T;
    let _gpu = gpu();
    let mut studio = Studio::lit();
    for method in [
        T::None,
        T::Linear,
        T::Reinhard,
        T::AcesFitted,
        T::AgX,
        T::TonyMcMapface,
        T::BlenderFilmic,
        T::KhronosPbrNeutral,
    ] {
        let name = format!("{method:?}");
        check(
            &mut studio,
            &name,
            Msaa::Off,
            [Some(49.0), Some(54.5)],
            |camera| {
                camera.insert((method, DebandDither::Disabled));
            },
        );
    }
}

#[test]
fn a_user_interface_over_the_picture() {
    let _gpu = gpu();
    let mut studio = Studio::new(|app| {
        lit_scene(app);
        app.add_systems(Startup, |mut commands: Commands| {
            let size = Node {
                width: percent(40),
                height: percent(30),
                ..default()
            };
            commands.spawn((size, BackgroundColor(Color::srgb(1.0, 0.0, 0.6))));
        });
    });
    studio.camera(|camera| {
        camera.insert(IsDefaultUiCamera);
    });
    for hdr in [true, false] {
        let picture = studio.mode(hdr, Msaa::Sample4).rg11b10ufloat();
        // 153 is not one of the format's values.
        let [r, g, b] = picture.get_pixel(20, 10).0;
        assert!([r, g] == [255, 0] && b.abs_diff(153) <= 1, "hdr {hdr}: {b}");
    }
}

#[test]
fn transparency_transmission_and_a_background() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    let world = studio.app.world_mut();
    let mesh = world
        .resource_mut::<Assets<Mesh>>()
        .add(Sphere::new(0.5).mesh());
    for (x, alpha_mode, specular_transmission) in [
        (-0.5, AlphaMode::Blend, 0.0),
        (0.3, AlphaMode::Add, 0.0),
        (0.9, AlphaMode::Opaque, 0.9),
    ] {
        let material = StandardMaterial {
            base_color: Color::srgba(0.3, 0.6, 0.9, 0.5),
            alpha_mode,
            specular_transmission,
            thickness: 0.3,
            ..default()
        };
        let material = world
            .resource_mut::<Assets<StandardMaterial>>()
            .add(material);
        world.spawn((
            Mesh3d(mesh.clone()),
            MeshMaterial3d(material),
            Transform::from_xyz(x, 0.6, 1.0),
        ));
    }
    studio.app.run_until_ready(200).expect("ready");
    for msaa in [Msaa::Off, Msaa::Sample4] {
        check(&mut studio, "glass", msaa, [Some(50.0), Some(52.0)], |_| {});
    }
}

#[test]
fn what_cannot_be_drawn_so_is_named() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    let check = |studio: &mut Studio, reason: Reason| {
        let reference = studio.plain();
        studio.camera(|camera| {
            camera.insert(FrameBufferQuality::Compact);
        });
        assert!(studio.picture() == reference, "the picture changed");
        assert_eq!(studio.state(), Some(CameraState::Fallback(reason)));
    };
    studio.mode(true, Msaa::Off).camera(|camera| {
        clear_to(camera, Color::NONE.into());
    });
    check(&mut studio, Reason::TransparentBackground);
    studio.camera(|camera| {
        clear_to(camera, ClearColorConfig::Default);
    });

    let world = studio.app.world_mut();
    let target = world.resource::<LabTarget>().0.clone();
    let over = Camera {
        order: 1,
        clear_color: ClearColorConfig::None,
        ..default()
    };
    let second = world
        .spawn((
            Camera3d::default(),
            over,
            target,
            Hdr,
            Msaa::Off,
            FrameBufferQuality::Exact,
        ))
        .id();
    let why = "It has `Exact`.".into();
    check(&mut studio, Reason::ContinuedInAnotherFormat(why));
    studio.app.world_mut().despawn(second);
    studio.rg11b10ufloat();
}

/// As `bevy_egui` does, whose pipelines take their format from `Hdr` alone.
#[test]
fn a_plugin_that_draws_over_the_picture() {
    let _gpu = gpu();
    let mut studio = Studio::new(|app| {
        app.sub_app_mut(RenderApp).add_systems(
            Render,
            (|mut commands: Commands, cameras: Query<&ExtractedView>| {
                for view in &cameras {
                    let id = view.retained_view_entity;
                    if id.subview_index == 0 && id.auxiliary_entity.is_none() {
                        commands.spawn((
                            ExtractedView {
                                retained_view_entity: RetainedViewEntity::new(
                                    id.main_entity,
                                    None,
                                    77,
                                ),
                                clip_from_view: Mat4::IDENTITY,
                                world_from_view: GlobalTransform::from(Affine3A::IDENTITY),
                                clip_from_world: None,
                                target_format: TextureFormat::Rgba16Float,
                                viewport: UVec4::new(0, 0, 1, 1),
                                color_grading: ColorGrading::default(),
                                invert_culling: false,
                            },
                            TemporaryRenderEntity::default(),
                        ));
                    }
                }
            })
            .in_set(RenderSystems::ExtractCommands),
        );
        lit_scene(app);
    });
    studio.mode(true, Msaa::Off).camera(|camera| {
        camera.insert(FrameBufferQuality::Compact);
    });
    studio.picture();
    assert_eq!(
        studio.state(),
        Some(CameraState::Fallback(Reason::DrawnOver))
    );
}
