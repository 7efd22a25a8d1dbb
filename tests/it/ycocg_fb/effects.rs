//! What Bevy draws before, between and after, with packed cameras and with those in three small floats.

use bevy::{
    anti_alias::{fxaa::Fxaa, smaa::Smaa, taa::TemporalAntiAliasing},
    core_pipeline::{
        Skybox,
        oit::OrderIndependentTransparencySettings,
        prepass::{DeferredPrepass, DepthPrepass, MotionVectorPrepass, NormalPrepass},
        tonemapping::{DebandDither, Tonemapping},
    },
    gizmos::{config::GizmoConfigStore, gizmos::Gizmos},
    image::ToExtents,
    light::{FogVolume, VolumetricFog, VolumetricLight},
    pbr::{DistanceFog, FogFalloff, ScreenSpaceReflections},
    post_process::{bloom::Bloom, dof::DepthOfField},
    prelude::*,
    render::{
        occlusion_culling::OcclusionCulling,
        render_resource::{
            TextureDimension, TextureFormat, TextureViewDescriptor, TextureViewDimension,
        },
        view::{ColorGrading, ColorGradingGlobal, Msaa},
    },
};
use bevy::{asset::RenderAssetUsages, ecs::system::EntityCommands};

use bevy_ycocg_fb::FrameBufferQuality;
use image::RgbImage;

use super::{Studio, assert_like, clear_to, lit_scene, packing, spawn_mesh, with};
use crate::support::{drawn, gpu};

/// A camera that draws with an effect, and the PSNR in dB that it has to Bevy's own.
struct Effect {
    name: &'static str,
    msaa: &'static [Msaa],
    insert: fn(&mut EntityCommands),
    /// Packed, with `Hdr` and fused, to Bevy's picture with `Hdr`.
    packed: [Option<f64>; 2],
    /// In three small floats, with `Hdr` and without, to Bevy's in the same mode.
    small_floats: [Option<f64>; 2],
}

impl Effect {
    const NONE: Self = Self {
        name: "none",
        msaa: &[Msaa::Off],
        insert: |_| {},
        packed: [None; 2],
        small_floats: [None; 2],
    };

    fn check_in(&self, studio: &mut Studio) {
        studio.camera(self.insert);
        for &msaa in self.msaa {
            let reference = studio.mode(true, msaa).plain();
            let named = |format: &str, hdr| format!("{}, {format}, {msaa:?}, hdr {hdr}", self.name);
            for (hdr, least_db) in [true, false].into_iter().zip(self.packed) {
                if let Some(least_db) = least_db {
                    studio.mode(hdr, msaa);
                    studio.check(&named("packed", hdr), &reference, packing(), least_db);
                }
            }
            for (hdr, least_db) in [true, false].into_iter().zip(self.small_floats) {
                if let Some(least_db) = least_db {
                    let reference = studio.mode(hdr, msaa).plain();
                    let quality = FrameBufferQuality::Compact;
                    studio.check(&named("small floats", hdr), &reference, quality, least_db);
                }
            }
        }
    }
}

/// Each effect alone.
fn check_each(effects: &[Effect]) {
    let _gpu = gpu();
    for effect in effects {
        effect.check_in(&mut Studio::lit());
    }
}

const BOTH_SAMPLES: &[Msaa] = &[Msaa::Off, Msaa::Sample4];

#[test]
fn small_floats_are_near_bevys_picture() {
    check_each(&[Effect {
        msaa: BOTH_SAMPLES,
        small_floats: [Some(51.5), Some(54.5)],
        ..Effect::NONE
    }]);
}

#[test]
fn effects_on_hdr_are_near_bevys() {
    check_each(&[
        Effect {
            name: "bloom",
            insert: with::<Bloom>,
            packed: [Some(42.0), None],
            small_floats: [Some(48.0), None],
            ..Effect::NONE
        },
        Effect {
            name: "depth of field",
            insert: |camera| {
                camera.insert(DepthOfField {
                    focal_distance: 3.0,
                    aperture_f_stops: 0.05,
                    ..default()
                });
            },
            packed: [Some(42.0), None],
            small_floats: [Some(48.0), None],
            ..Effect::NONE
        },
    ]);
}

#[test]
fn passes_that_packed_cameras_lack_are_near_bevys_in_small_floats() {
    let small_floats = [Some(51.5), None];
    check_each(&[
        Effect {
            name: "order-independent transparency",
            insert: with::<OrderIndependentTransparencySettings>,
            small_floats,
            ..Effect::NONE
        },
        Effect {
            name: "deferred",
            insert: with::<(DepthPrepass, DeferredPrepass)>,
            small_floats,
            ..Effect::NONE
        },
        Effect {
            name: "reflections",
            insert: with::<ScreenSpaceReflections>,
            small_floats,
            ..Effect::NONE
        },
    ]);
}

/// In apps of their own, which have drawn the same number of frames: the jitter depends on it.
#[test]
fn temporal_anti_aliasing_is_near_bevys() {
    let _gpu = gpu();
    let frame_buffers = [None, Some(packing()), Some(FrameBufferQuality::Compact)];
    let [reference, packed, small_floats] = frame_buffers.map(|frame_buffer| {
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
    assert_like("taa, packed", &reference, &packed, 45.0);
    // The history has Bevy's own format, whose alpha keeps the confidence: without it, the picture has 39.6 dB.
    assert_like("taa, small floats", &reference, &small_floats, 45.0);
    let darker = mean_level(&reference) - mean_level(&small_floats);
    println!("{darker:.2} levels darker");
    assert!((0.0..1.8).contains(&darker), "{darker:.2} levels darker");
}

fn mean_level(picture: &RgbImage) -> f64 {
    let levels = picture.as_raw();
    levels.iter().map(|&level| f64::from(level)).sum::<f64>() / levels.len() as f64
}

#[test]
fn effects_after_tone_mapping_are_near_bevys() {
    check_each(&[
        Effect {
            name: "fxaa",
            insert: with::<Fxaa>,
            packed: [Some(42.0); 2],
            small_floats: [Some(49.0); 2],
            ..Effect::NONE
        },
        Effect {
            name: "smaa",
            insert: with::<Smaa>,
            packed: [Some(42.0); 2],
            small_floats: [Some(50.5); 2],
            ..Effect::NONE
        },
    ]);
}

#[test]
fn a_user_interface_over_the_picture_keeps_its_colours() {
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
        let small_floats = studio.rg11b10ufloat();
        // Drawn after the resolve: the same to the last bit.
        for picture in [&plain, &packed] {
            assert_eq!(picture.get_pixel(20, 10).0, [255, 0, 153], "hdr {hdr}");
        }
        // 153 is not one of the small floats.
        let [r, g, b] = small_floats.get_pixel(20, 10).0;
        assert!([r, g] == [255, 0] && b.abs_diff(153) <= 1, "hdr {hdr}: {b}");
    }
}

#[test]
fn every_tone_mapping_and_color_grading_is_near_bevys() {
    use Tonemapping as T;
    let _gpu = gpu();
    let mut studio = Studio::lit();
    let methods = [
        T::None,
        T::Linear,
        T::Reinhard,
        T::ReinhardLuminance,
        T::AcesFitted,
        T::AgX,
        T::SomewhatBoringDisplayTransform,
        T::TonyMcMapface,
        T::BlenderFilmic,
        T::KhronosPbrNeutral,
    ];
    for method in drawn(2, methods) {
        println!("{method:?}");
        studio.camera(|camera| {
            camera.insert((method, DebandDither::Disabled));
        });
        let is_packed = !matches!(method, T::Linear | T::TonyMcMapface);
        let is_small = !matches!(
            method,
            T::ReinhardLuminance | T::SomewhatBoringDisplayTransform
        );
        let effect = Effect {
            name: "tone mapping",
            packed: [is_packed.then_some(38.0); 2],
            small_floats: [is_small.then_some(49.0), is_small.then_some(54.5)],
            ..Effect::NONE
        };
        effect.check_in(&mut studio);
    }
    let grading = Effect {
        name: "grading",
        insert: |camera| {
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
        },
        packed: [Some(42.0); 2],
        ..Effect::NONE
    };
    grading.check_in(&mut studio);
}

#[test]
fn fog_is_near_bevys() {
    check_each(&[Effect {
        name: "fog",
        msaa: &[Msaa::Sample4],
        insert: |camera| {
            camera.insert(DistanceFog {
                color: Color::srgb(0.4, 0.5, 0.7),
                falloff: FogFalloff::Linear {
                    start: 2.0,
                    end: 6.0,
                },
                ..default()
            });
        },
        packed: [Some(38.0); 2],
        ..Effect::NONE
    }]);
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
    let volumetric = Effect {
        name: "volumetric fog",
        insert: with::<VolumetricFog>,
        packed: [Some(42.0), None],
        ..Effect::NONE
    };
    let _gpu = gpu();
    volumetric.check_in(&mut Studio::new(scene));
}

#[test]
fn prepasses_and_occlusion_culling_are_near_bevys() {
    check_each(&[
        Effect {
            name: "prepasses",
            msaa: BOTH_SAMPLES,
            insert: with::<(DepthPrepass, NormalPrepass, MotionVectorPrepass)>,
            packed: [Some(38.0); 2],
            ..Effect::NONE
        },
        Effect {
            name: "occlusion culling",
            msaa: BOTH_SAMPLES,
            insert: with::<(DepthPrepass, OcclusionCulling)>,
            packed: [Some(38.0); 2],
            ..Effect::NONE
        },
    ]);
}

/// Whatever the camera has been given.
const BACKGROUND: Effect = Effect {
    name: "background",
    msaa: BOTH_SAMPLES,
    packed: [Some(38.0); 2],
    ..Effect::NONE
};

#[test]
fn a_clear_color_of_any_chroma_is_near_bevys() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    for color in [
        Color::BLACK,
        Color::WHITE,
        Color::srgb(0.5, 0.5, 0.5),
        Color::srgb(1.0, 0.0, 0.0),
        Color::srgb(0.0, 0.3, 1.0),
        Color::LinearRgba(LinearRgba::rgb(8.0, 2.0, 0.5)),
    ] {
        studio.camera(|camera| clear_to(camera, color.into()));
        BACKGROUND.check_in(&mut studio);
    }
}

#[test]
fn a_skybox_is_near_bevys() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    let image = Some(studio.app.world_mut().add_asset(sky()));
    studio.camera(|camera| {
        camera.insert(Skybox {
            image,
            brightness: 3000.0,
            ..default()
        });
    });
    BACKGROUND.check_in(&mut studio);
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
        UVec3::new(size as u32, size as u32, 6).to_extents(),
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
    let gizmos = Effect {
        name: "gizmos",
        msaa: BOTH_SAMPLES,
        packed: [Some(34.0); 2],
        ..Effect::NONE
    };
    let _gpu = gpu();
    gizmos.check_in(&mut Studio::new(scene));
}

#[test]
fn transparency_and_transmission_in_small_floats_are_near_bevys() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
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
        let place = Transform::from_xyz(x, 0.6, 1.0);
        spawn_mesh(studio.app.world_mut(), Sphere::new(0.5), material, place);
    }
    studio.app.run_until_ready(200).expect("ready");
    let glass = Effect {
        name: "glass",
        msaa: BOTH_SAMPLES,
        small_floats: [Some(50.0), Some(52.0)],
        ..Effect::NONE
    };
    glass.check_in(&mut studio);
}
