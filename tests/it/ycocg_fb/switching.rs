//! The component comes and goes.

use bevy::{
    prelude::*,
    render::{RenderApp, render_resource::PipelineCache, renderer::RenderDevice, view::Msaa},
};
use bevy_ycocg_fb::{FrameBufferQuality, PackedFormat, YCoCgFrameBuffer};

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
