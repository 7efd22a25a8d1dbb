//! The component comes and goes.

use bevy::{
    prelude::*,
    render::{RenderApp, render_resource::PipelineCache, renderer::RenderDevice, view::Msaa},
};
use bevy_ycocg_fb::{
    CameraState, DefaultFrameBufferQuality, FrameBufferChanged, FrameBufferQuality,
    FrameBufferReport, PackedFormat, YCoCgFrameBuffer,
};

use super::scene::{Studio, lit_scene, packing};
use crate::support::gpu;

#[test]
fn the_ordinary_picture_is_back_on_the_next_frame() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    for msaa in [Msaa::Off, Msaa::Sample4] {
        for hdr in [true, false] {
            let reference = studio.mode(hdr, msaa).plain();
            let packed = studio.packed(packing());
            assert!(packed != reference);
            studio.camera(|camera| {
                camera.remove::<FrameBufferQuality>();
            });
            studio.app.render_frames(1).expect("a frame");
            let after = studio.app.capture_rgb8().expect("a picture");
            assert!(after == reference, "{msaa:?} hdr {hdr}");
            assert!(studio.packed(packing()) == packed);
        }
    }
}

#[test]
fn a_thousand_switches_leave_nothing_behind() {
    let _gpu = gpu();
    let mut studio = Studio::with_size(16, 16, lit_scene);
    studio.mode(true, Msaa::Sample4);
    let mut after = Vec::new();
    for switch in 0..1000 {
        studio.camera(|camera| {
            if switch % 2 == 0 {
                let format = [PackedFormat::Float16, PackedFormat::Float32][switch / 2 % 2];
                let settings = YCoCgFrameBuffer::with_format(format);
                camera.insert(FrameBufferQuality::from(settings));
            } else {
                camera.remove::<FrameBufferQuality>();
            }
        });
        studio.app.render_frames(1).expect("a frame");
        if switch == 99 || switch == 999 {
            // Bevy lets go of textures a few frames after their last use.
            studio.app.render_frames(10).expect("frames");
            after.push(resources(&mut studio));
        }
    }
    println!("pipelines, bytes on the GPU: {after:?}");
    assert_eq!(after[0].0, after[1].0);
    assert!(after[1].1 <= after[0].1 + 4096);
}

/// Pipelines, and bytes allocated on the GPU.
fn resources(studio: &mut Studio) -> (usize, u64) {
    let world = studio.app.app_mut().sub_app(RenderApp).world();
    let device = world.resource::<RenderDevice>().wgpu_device();
    let report = device.generate_allocator_report();
    (
        world.resource::<PipelineCache>().pipelines().count(),
        report.map_or(0, |report| report.total_allocated_bytes),
    )
}

#[test]
fn an_app_without_such_a_camera_has_nothing_more() {
    let _gpu = gpu();
    let mut studio = Studio::with_size(16, 16, lit_scene);
    studio.mode(true, Msaa::Sample4).plain();
    let world = studio.app.app_mut().sub_app(RenderApp).world();
    for pipeline in world.resource::<PipelineCache>().pipelines() {
        let label = format!("{:?}", pipeline.descriptor);
        assert!(!label.contains("packed_ycocg"), "{label}");
        assert!(!label.contains("YCOCG_FB_PACK"), "{label}");
    }
}

#[test]
fn cameras_without_a_quality_have_that_of_the_app() {
    let _gpu = gpu();
    let mut studio = Studio::with_size(64, 48, lit_scene);
    studio.mode(true, Msaa::Off);
    let plain = studio.plain();
    let compact = studio.quality(FrameBufferQuality::Compact);
    studio.plain();
    assert_eq!(studio.report(), None);
    let default = DefaultFrameBufferQuality(FrameBufferQuality::Compact);
    studio.app.world_mut().insert_resource(default);
    assert!(studio.picture() == compact);
    assert_eq!(studio.state(), Some(CameraState::Rg11b10Ufloat));
    // A camera's own is preferred.
    assert!(studio.quality(FrameBufferQuality::Exact) == plain);
    assert_eq!(studio.state(), Some(CameraState::Exact));
    studio.camera(|camera| {
        camera.remove::<FrameBufferQuality>();
    });
    assert!(studio.picture() == compact);
    let world = studio.app.world_mut();
    world.remove_resource::<DefaultFrameBufferQuality>();
    assert!(studio.picture() == plain);
    let camera = studio.camera;
    assert_eq!(studio.app.world().get::<FrameBufferReport>(camera), None);
}

#[test]
fn a_message_says_when_a_camera_changes() {
    let _gpu = gpu();
    let mut studio = Studio::with_size(64, 48, lit_scene);
    studio.mode(true, Msaa::Off).plain();
    let mut reader = studio
        .app
        .world()
        .resource::<Messages<FrameBufferChanged>>()
        .get_cursor_current();
    let mut told = Vec::new();
    let qualities = [
        FrameBufferQuality::Compact,
        FrameBufferQuality::Exact,
        packing(),
    ];
    for quality in qualities {
        studio.camera(|camera| {
            camera.insert(quality);
        });
        for _ in 0..4 {
            studio.app.render_frames(1).expect("a frame");
            let messages = studio
                .app
                .world()
                .resource::<Messages<FrameBufferChanged>>();
            told.extend(reader.read(messages).cloned());
        }
    }
    let states: Vec<_> = told.iter().map(|message| message.state.clone()).collect();
    let packed = CameraState::Packed(PackedFormat::default());
    assert_eq!(
        states,
        [CameraState::Rg11b10Ufloat, CameraState::Exact, packed]
    );
    assert!(told.iter().all(|message| message.camera == studio.camera));
}
