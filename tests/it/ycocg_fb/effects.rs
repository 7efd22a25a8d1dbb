//! What Bevy draws before, between and after.

use bevy::{
    anti_alias::{fxaa::Fxaa, smaa::Smaa, taa::TemporalAntiAliasing},
    core_pipeline::{
        Skybox,
        prepass::{DepthPrepass, MotionVectorPrepass, NormalPrepass},
        tonemapping::{DebandDither, Tonemapping},
    },
    gizmos::{config::GizmoConfigStore, gizmos::Gizmos},
    light::{FogVolume, VolumetricFog, VolumetricLight},
    pbr::{DistanceFog, FogFalloff},
    post_process::{bloom::Bloom, dof::DepthOfField},
    prelude::*,
    render::{
        occlusion_culling::OcclusionCulling,
        render_resource::{
            Extent3d, TextureDimension, TextureFormat, TextureViewDescriptor, TextureViewDimension,
        },
        view::{ColorGrading, ColorGradingGlobal, Msaa},
    },
};
use bevy::{asset::RenderAssetUsages, ecs::system::EntityCommands};

use super::scene::{Studio, clear_to, keep, lit_scene, packing, psnr};
use crate::support::gpu;

/// Configures the camera and demands a PSNR for each of `Hdr` and fused, where they apply.
fn check(
    name: &str,
    msaa: Msaa,
    [hdr_db, fused_db]: [Option<f64>; 2],
    studio: impl FnOnce() -> Studio,
    configure: impl FnOnce(&mut EntityCommands),
) {
    let _gpu = gpu();
    check_in(&mut studio(), name, msaa, [hdr_db, fused_db], configure);
}

/// As [`check`], in a scene that is there already.
fn check_in(
    studio: &mut Studio,
    name: &str,
    msaa: Msaa,
    [hdr_db, fused_db]: [Option<f64>; 2],
    configure: impl FnOnce(&mut EntityCommands),
) {
    studio.camera(configure);
    let reference = studio.mode(true, msaa).plain();
    keep(&format!("{name}_plain"), &reference);
    for (hdr, wanted) in [(true, hdr_db), (false, fused_db)] {
        let Some(wanted) = wanted else {
            continue;
        };
        let packed = studio.mode(hdr, msaa).packed(packing());
        keep(&format!("{name}_packed_{hdr}"), &packed);
        let found = psnr(&reference, &packed);
        println!("{name} hdr {hdr}: {found:.2} dB");
        assert!(found >= wanted, "{name} hdr {hdr}: {found:.2} dB");
    }
}

const BOTH: [Option<f64>; 2] = [Some(42.0), Some(42.0)];
const HDR_ONLY: [Option<f64>; 2] = [Some(42.0), None];

#[test]
fn effects_that_need_hdr() {
    check("bloom", Msaa::Off, HDR_ONLY, Studio::lit, |camera| {
        camera.insert(Bloom::NATURAL);
    });
    check(
        "depth_of_field",
        Msaa::Off,
        HDR_ONLY,
        Studio::lit,
        |camera| {
            camera.insert(DepthOfField {
                focal_distance: 3.0,
                aperture_f_stops: 0.05,
                ..default()
            });
        },
    );
}

/// In apps of their own, which have drawn the same number of frames: the jitter depends on it.
#[test]
fn temporal_anti_aliasing() {
    let _gpu = gpu();
    let frame_buffers = [None, Some(packing())];
    let [reference, picture] = frame_buffers.map(|frame_buffer| {
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
    keep("taa_packed", &picture);
    let found = psnr(&reference, &picture);
    println!("{found:.2} dB");
    assert!(found > 45.0, "{found:.2} dB");
}

#[test]
fn effects_after_tone_mapping() {
    check("fxaa", Msaa::Off, BOTH, Studio::lit, |camera| {
        camera.insert(Fxaa::default());
    });
    check("smaa", Msaa::Off, BOTH, Studio::lit, |camera| {
        camera.insert(Smaa::default());
    });
}

#[test]
fn a_user_interface_over_the_picture() {
    let scene = |app: &mut App| {
        lit_scene(app);
        app.add_systems(Startup, |mut commands: Commands| {
            commands.spawn((
                Node {
                    width: percent(40),
                    height: percent(30),
                    ..default()
                },
                BackgroundColor(Color::srgb(1.0, 0.0, 0.6)),
            ));
        });
    };
    let _gpu = gpu();
    let mut studio = Studio::new(scene);
    studio.camera(|camera| {
        camera.insert(IsDefaultUiCamera);
    });
    for hdr in [true, false] {
        let plain = studio.mode(hdr, Msaa::Sample4).plain();
        let packed = studio.packed(packing());
        // Drawn after the resolve: the same to the last bit.
        for picture in [&plain, &packed] {
            assert_eq!(picture.get_pixel(20, 10).0, [255, 0, 153], "hdr {hdr}");
        }
    }
}

#[test]
fn every_tone_mapping_and_color_grading() {
    use Tonemapping as T;
    let _gpu = gpu();
    let mut studio = Studio::lit();
    for method in [
        T::None,
        T::Reinhard,
        T::ReinhardLuminance,
        T::AcesFitted,
        T::AgX,
        T::SomewhatBoringDisplayTransform,
        T::BlenderFilmic,
        T::KhronosPbrNeutral,
    ] {
        check_in(
            &mut studio,
            &format!("{method:?}"),
            Msaa::Off,
            [Some(38.0); 2],
            |camera| {
                camera.insert((method, DebandDither::Disabled));
            },
        );
    }
    check_in(&mut studio, "grading", Msaa::Off, BOTH, |camera| {
        camera.insert(Tonemapping::default()).insert(ColorGrading {
            global: ColorGradingGlobal {
                exposure: 0.5,
                temperature: 0.1,
                hue: 0.2,
                post_saturation: 1.2,
                ..default()
            },
            ..default()
        });
    });
}

#[test]
fn fog() {
    check(
        "fog",
        Msaa::Sample4,
        [Some(38.0); 2],
        Studio::lit,
        |camera| {
            camera.insert(DistanceFog {
                color: Color::srgb(0.4, 0.5, 0.7),
                falloff: FogFalloff::Linear {
                    start: 2.0,
                    end: 6.0,
                },
                ..default()
            });
        },
    );
    let scene = |app: &mut App| {
        lit_scene(app);
        app.add_systems(
            PostStartup,
            |mut commands: Commands, sun: Single<Entity, With<DirectionalLight>>| {
                commands.entity(*sun).insert(VolumetricLight);
                commands.spawn((
                    FogVolume::default(),
                    Transform::from_scale(Vec3::splat(5.0)),
                ));
            },
        );
    };
    check(
        "volumetric_fog",
        Msaa::Off,
        HDR_ONLY,
        || Studio::new(scene),
        |camera| {
            camera.insert(VolumetricFog::default());
        },
    );
}

#[test]
fn prepasses_and_occlusion_culling() {
    for msaa in [Msaa::Off, Msaa::Sample4] {
        check("prepasses", msaa, [Some(38.0); 2], Studio::lit, |camera| {
            camera.insert((DepthPrepass, NormalPrepass, MotionVectorPrepass));
        });
        check(
            "occlusion_culling",
            msaa,
            [Some(38.0); 2],
            Studio::lit,
            |camera| {
                camera.insert((DepthPrepass, OcclusionCulling));
            },
        );
    }
}

#[test]
fn a_clear_color_of_any_chroma() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    let colors = [
        Color::BLACK,
        Color::WHITE,
        Color::srgb(0.5, 0.5, 0.5),
        Color::srgb(1.0, 0.0, 0.0),
        Color::srgb(0.0, 0.3, 1.0),
        Color::LinearRgba(LinearRgba::rgb(8.0, 2.0, 0.5)),
    ];
    for color in colors {
        for msaa in [Msaa::Off, Msaa::Sample4] {
            check_in(&mut studio, "clear", msaa, [Some(38.0); 2], |camera| {
                clear_to(camera, color.into());
            });
        }
    }
}

#[test]
fn a_skybox() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    let image = studio
        .app
        .world_mut()
        .resource_mut::<Assets<Image>>()
        .add(sky());
    for msaa in [Msaa::Off, Msaa::Sample4] {
        studio.camera(|camera| {
            camera.insert(Skybox {
                image: Some(image.clone()),
                brightness: 3000.0,
                ..default()
            });
        });
        let reference = studio.mode(true, msaa).plain();
        keep("skybox_plain", &reference);
        for hdr in [true, false] {
            let packed = studio.mode(hdr, msaa).packed(packing());
            keep("skybox_packed", &packed);
            let found = psnr(&reference, &packed);
            println!("skybox {msaa:?} hdr {hdr}: {found:.2} dB");
            assert!(found >= 38.0, "{found:.2} dB");
        }
    }
}

/// A cube map of six colours, each with a gradient.
fn sky() -> Image {
    let size = 16_usize;
    let faces = [
        [1.0, 0.5, 0.2],
        [0.3, 0.5, 1.0],
        [0.2, 0.4, 0.9],
        [0.4, 0.3, 0.2],
        [0.9, 0.8, 0.4],
        [0.5, 0.7, 0.9],
    ];
    let texels = faces.iter().flat_map(|face| {
        (0..size * size).flat_map(move |i| {
            let shade = 0.5 + 0.5 * (i / size) as f32 / size as f32;
            let [r, g, b] = face.map(|c: f32| (c * shade * 255.0) as u8);
            [r, g, b, 255]
        })
    });
    let mut image = Image::new(
        Extent3d {
            width: size as u32,
            height: size as u32,
            depth_or_array_layers: 6,
        },
        TextureDimension::D2,
        texels.collect(),
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.texture_view_descriptor = Some(TextureViewDescriptor {
        dimension: Some(TextureViewDimension::Cube),
        ..default()
    });
    image
}

#[test]
fn gizmos_are_drawn_in_their_colors() {
    let scene = |app: &mut App| {
        lit_scene(app);
        app.add_systems(Update, |mut gizmos: Gizmos| {
            gizmos.sphere(
                Isometry3d::from_xyz(0.0, 0.7, 0.6),
                0.6,
                Color::srgb(1.0, 0.9, 0.1),
            );
            gizmos.arrow(
                Vec3::new(-1.5, 0.1, 1.0),
                Vec3::new(1.5, 0.9, 0.5),
                Color::srgb(0.1, 1.0, 1.0),
            );
        })
        .add_systems(Startup, |mut store: ResMut<GizmoConfigStore>| {
            let (config, _) = store.config_mut::<DefaultGizmoConfigGroup>();
            config.line.width = 3.0;
            config.line.joints = GizmoLineJoint::Bevel;
        });
    };
    for msaa in [Msaa::Off, Msaa::Sample4] {
        check(
            "gizmos",
            msaa,
            [Some(34.0); 2],
            || Studio::new(scene),
            |_| {},
        );
    }
}
