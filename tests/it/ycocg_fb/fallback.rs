//! What cannot be packed: the picture is Bevy's own and the reason is given.

use std::sync::atomic::{AtomicBool, Ordering};

use bevy::{
    camera::{
        ClearColorConfig, CompositingSpace, Hdr, ImageRenderTarget, MainPassResolutionOverride,
        RenderTarget,
    },
    core_pipeline::{
        oit::OrderIndependentTransparencySettings,
        prepass::{DeferredPrepass, DepthPrepass},
    },
    ecs::system::EntityCommands,
    light::atmosphere::{Atmosphere, ScatteringMedium},
    pbr::{
        AtmosphereSettings, ScreenSpaceReflections,
        wireframe::{Wireframe, WireframePlugin},
    },
    prelude::*,
    render::{
        ExtractSchedule, RenderApp,
        render_resource::TextureFormat,
        view::{ExtractedView, Msaa},
    },
};
use bevy_frugal_lab::headless::LabTarget;
use bevy_ycocg_fb::{
    CameraState, FallbackReason as Reason, FrameBufferQuality, FrameBufferReport, PackedFormat,
    YCoCgFrameBuffer,
};

use super::scene::{Studio, clear_to, lit_scene, packing};
use crate::support::{gpu, skipped};

/// The configured camera draws the same with and without the component, for this reason.
fn check(
    studio: &mut Studio,
    quality: FrameBufferQuality,
    reason: Reason,
    configure: impl FnOnce(&mut EntityCommands),
    undress: impl FnOnce(&mut EntityCommands),
) {
    studio.camera(configure);
    let reference = studio.plain();
    studio.camera(|camera| {
        camera.insert(quality);
    });
    let picture = studio.picture();
    // Without a clear colour each frame is drawn over the last.
    if reason != Reason::NoClear {
        assert!(picture == reference, "the picture changed: {reason}");
    }
    assert_eq!(studio.state(), Some(CameraState::Fallback(reason)));
    // The obstacle gone, it packs.
    studio.camera(undress);
    studio.packed(packing());
}

#[test]
fn each_obstacle_is_named() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    studio.mode(true, Msaa::Off);
    check(
        &mut studio,
        packing(),
        Reason::DeferredPrepass,
        |camera| {
            camera.insert((DepthPrepass, DeferredPrepass));
        },
        |camera| {
            camera.remove::<(DepthPrepass, DeferredPrepass)>();
        },
    );
    check(
        &mut studio,
        packing(),
        Reason::NoClear,
        |camera| {
            clear_to(camera, ClearColorConfig::None);
        },
        |camera| {
            clear_to(camera, ClearColorConfig::Default);
        },
    );
    check(
        &mut studio,
        packing(),
        Reason::TransparentBackground,
        |camera| {
            clear_to(camera, Color::NONE.into());
        },
        |camera| {
            clear_to(camera, ClearColorConfig::Default);
        },
    );
    check(
        &mut studio,
        YCoCgFrameBuffer::with_format(PackedFormat::Unorm8).into(),
        Reason::Unorm8WithHdr,
        |_| {},
        |_| {},
    );
}

#[test]
fn a_compositing_space_is_linear_for_3d_cameras() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    studio.mode(true, Msaa::Off);
    let linear = studio.packed(packing());
    studio.camera(|camera| {
        camera.insert(CompositingSpace::Oklab);
    });
    assert!(studio.packed(packing()) == linear);
}

#[test]
fn wireframes() {
    let _gpu = gpu();
    let mut studio = Studio::new(|app| {
        app.add_plugins(WireframePlugin::default());
        lit_scene(app);
    });
    studio.mode(true, Msaa::Off);
    let world = studio.app.world_mut();
    let mesh = world
        .query_filtered::<Entity, With<Mesh3d>>()
        .iter(world)
        .next()
        .expect("a mesh");
    world.entity_mut(mesh).insert(Wireframe);
    let reference = studio.plain();
    studio.camera(|camera| {
        camera.insert(packing());
    });
    assert!(studio.picture() == reference, "the picture changed");
    assert_eq!(
        studio.state(),
        Some(CameraState::Fallback(Reason::Wireframes))
    );
    studio
        .app
        .world_mut()
        .entity_mut(mesh)
        .remove::<Wireframe>();
    studio.packed(packing());
}

/// Checks a component of Bevy that uses the main pass; prepasses that it requires go with it.
fn check_component<C: Component + Default>(studio: &mut Studio, reason: Reason) {
    studio.mode(true, Msaa::Off);
    check(
        studio,
        packing(),
        reason,
        |camera| {
            camera.insert(C::default());
        },
        |camera| {
            camera.remove::<(C, DepthPrepass, DeferredPrepass)>();
        },
    );
}

#[test]
fn screen_space_reflections() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    check_component::<ScreenSpaceReflections>(&mut studio, Reason::ScreenSpaceReflections);
}

#[test]
fn order_independent_transparency() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    let reason = Reason::OrderIndependentTransparency;
    check_component::<OrderIndependentTransparencySettings>(&mut studio, reason);
}

#[test]
fn an_atmosphere() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    if studio.app.adapter().driver.contains("Mesa 22.") {
        skipped("frame buffer and Bevy's atmosphere: this software driver ends the process");
        return;
    }
    let world = studio.app.world_mut();
    let medium = ScatteringMedium::default();
    let medium = world.resource_mut::<Assets<ScatteringMedium>>().add(medium);
    world.spawn(Atmosphere::earth(medium));
    check_component::<AtmosphereSettings>(&mut studio, Reason::Atmosphere);
}

#[test]
fn a_main_pass_smaller_than_its_target() {
    static SMALLER: AtomicBool = AtomicBool::new(false);
    let _gpu = gpu();
    let mut studio = Studio::new(|app| {
        let override_resolution =
            |mut commands: Commands, views: Query<Entity, With<ExtractedView>>| {
                for view in &views {
                    let mut view = commands.entity(view);
                    if SMALLER.load(Ordering::Relaxed) {
                        view.insert(MainPassResolutionOverride(UVec2::new(64, 48)));
                    } else {
                        view.remove::<MainPassResolutionOverride>();
                    }
                }
            };
        app.sub_app_mut(RenderApp)
            .add_systems(ExtractSchedule, override_resolution);
        lit_scene(app);
    });
    studio.mode(true, Msaa::Off);
    check(
        &mut studio,
        packing(),
        Reason::ResolutionOverride,
        |_| SMALLER.store(true, Ordering::Relaxed),
        |_| SMALLER.store(false, Ordering::Relaxed),
    );
}

#[test]
fn a_picture_that_another_camera_continues() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    studio.mode(true, Msaa::Sample4);
    let world = studio.app.world_mut();
    let target = world.resource::<LabTarget>().0.clone();
    let second = world
        .spawn((
            Camera3d::default(),
            Camera {
                order: 1,
                clear_color: ClearColorConfig::None,
                ..default()
            },
            target,
            Hdr,
            Msaa::Sample4,
            Transform::from_xyz(2.5, 1.4, 1.0).looking_at(Vec3::ZERO, Vec3::Y),
        ))
        .id();
    let reference = studio.plain();
    studio.camera(|camera| {
        camera.insert(packing());
    });
    assert!(studio.picture() == reference, "the picture changed");
    assert_eq!(
        studio.state(),
        Some(CameraState::Fallback(Reason::ContinuedByMultisampled))
    );
    studio.app.world_mut().despawn(second);
    studio.packed(packing());
}

#[test]
fn a_camera_of_two_dimensions() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    let world = studio.app.world_mut();
    let image = Image::new_target_texture(16, 16, TextureFormat::Rgba8UnormSrgb, None);
    let image = world.resource_mut::<Assets<Image>>().add(image);
    let flat = world
        .spawn((
            Camera2d,
            RenderTarget::Image(ImageRenderTarget::from(image)),
            packing(),
        ))
        .id();
    studio.picture();
    let report = studio.app.world().get::<FrameBufferReport>(flat);
    let state = report.map(|report| report.state.clone());
    assert_eq!(state, Some(CameraState::Fallback(Reason::Not3d)));
}
