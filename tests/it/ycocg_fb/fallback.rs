//! What cannot be packed: the picture is Bevy's own and the reason is given.

use bevy::{
    camera::{ClearColorConfig, CompositingSpace},
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass},
    ecs::system::EntityCommands,
    pbr::wireframe::{Wireframe, WireframePlugin},
    prelude::*,
    render::view::Msaa,
};
use bevy_ycocg_fb::{CameraState, FallbackReason as Reason, PackedFormat, YCoCgFrameBuffer};

use super::scene::{Studio, clear_to, lit_scene};
use crate::support::gpu;

/// The dressed camera draws the same with and without the component, for this reason.
fn check(
    studio: &mut Studio,
    settings: YCoCgFrameBuffer,
    reason: Reason,
    dress: impl FnOnce(&mut EntityCommands),
    undress: impl FnOnce(&mut EntityCommands),
) {
    studio.camera(dress);
    let reference = studio.plain();
    studio.camera(|camera| {
        camera.insert(settings);
    });
    let picture = studio.picture();
    // Without a clear colour each frame is drawn over the last.
    if reason != Reason::NoClear {
        assert!(picture == reference, "the picture changed: {reason}");
    }
    assert_eq!(studio.state(), Some(CameraState::Fallback(reason)));
    // The obstacle gone, it packs.
    studio.camera(undress);
    studio.packed(YCoCgFrameBuffer::default());
}

#[test]
fn each_obstacle_is_named() {
    let _gpu = gpu();
    let mut studio = Studio::new(lit_scene);
    let packing = YCoCgFrameBuffer::default();
    studio.mode(true, Msaa::Off);
    check(
        &mut studio,
        packing,
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
        packing,
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
        packing,
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
        YCoCgFrameBuffer {
            format: PackedFormat::Unorm8,
            ..packing
        },
        Reason::Unorm8WithHdr,
        |_| {},
        |_| {},
    );
}

#[test]
fn a_compositing_space_is_linear_for_3d_cameras() {
    let _gpu = gpu();
    let mut studio = Studio::new(lit_scene);
    studio.mode(true, Msaa::Off);
    let linear = studio.packed(YCoCgFrameBuffer::default());
    studio.camera(|camera| {
        camera.insert(CompositingSpace::Oklab);
    });
    assert!(studio.packed(YCoCgFrameBuffer::default()) == linear);
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
        camera.insert(YCoCgFrameBuffer::default());
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
    studio.packed(YCoCgFrameBuffer::default());
}
