//! The component comes and goes, also while pipelines compile in the background, as they do in a game.

use bevy::{
    light::NotShadowCaster,
    prelude::*,
    render::{
        RenderApp,
        render_resource::{CachedPipelineState, PipelineCache},
        renderer::RenderDevice,
        view::Msaa,
    },
};
use bevy_frugal_lab::headless::HeadlessSettings;
use bevy_ycocg_fb::{
    CameraState, DefaultFrameBufferQuality, FrameBufferChanged, FrameBufferQuality, PackedFormat,
    YCoCgFrameBuffer,
};
use image::RgbImage;

use super::{Studio, lit_scene, packing, spawn_mesh};
use crate::support::{gpu, keep, psnr};

#[test]
fn the_ordinary_picture_is_back_on_the_next_frame() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    for msaa in [Msaa::Off, Msaa::Sample4] {
        for hdr in [true, false] {
            let reference = studio.mode(hdr, msaa).plain();
            let packed = studio.packed(packing());
            assert!(packed != reference);
            studio.set_quality(studio.camera, None);
            studio.app.render_frames(1).expect("a frame");
            let after = studio.app.capture_rgb8().expect("a picture");
            assert!(after == reference, "{msaa:?} hdr {hdr}");
            assert!(studio.packed(packing()) == packed);
        }
    }
}

#[test]
#[ignore = "long: a thousand frames"]
fn a_thousand_switches_leave_nothing_behind() {
    let _gpu = gpu();
    let mut studio = Studio::with_size(16, 16, lit_scene);
    studio.mode(true, Msaa::Sample4);
    let mut after = Vec::new();
    for switch in 0..1000 {
        let format = [PackedFormat::Float16, PackedFormat::Float32][switch / 2 % 2];
        let quality = FrameBufferQuality::from(YCoCgFrameBuffer::with_format(format));
        studio.set_quality(studio.camera, (switch % 2 == 0).then_some(quality));
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
    assert!(studio.plain() == compact);
    let world = studio.app.world_mut();
    world.remove_resource::<DefaultFrameBufferQuality>();
    assert!(studio.picture() == plain);
    assert_eq!(studio.report(), None);
}

#[test]
fn a_message_says_when_a_camera_changes() {
    let _gpu = gpu();
    let mut studio = Studio::with_size(64, 48, lit_scene);
    studio.mode(true, Msaa::Off).plain();
    let messages = studio.app.world().resource::<Messages<_>>();
    let mut reader = messages.get_cursor_current();
    let mut told: Vec<FrameBufferChanged> = Vec::new();
    let [compact, exact] = [FrameBufferQuality::Compact, FrameBufferQuality::Exact];
    for quality in [compact, exact, packing()] {
        studio.set_quality(studio.camera, Some(quality));
        for _ in 0..4 {
            studio.app.render_frames(1).expect("a frame");
            let messages = studio.app.world().resource::<Messages<_>>();
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

/// The least PSNR of a picture and the one that it is meant to be; without a mesh it is half of it.
const SAME: f64 = 38.0;

/// Frames in a row without a pipeline that compiles, after which none will.
const QUIET_FRAMES: u32 = 5;

/// The frames until all pipelines are ready, a few frames after a change at the earliest.
fn frames_until_ready(studio: &mut Studio) -> Vec<RgbImage> {
    let mut frames = Vec::new();
    let mut quiet = 0;
    while quiet < QUIET_FRAMES {
        assert!(frames.len() < 5000, "pipelines that never are ready");
        studio.app.render_frames(1).expect("a frame");
        frames.push(studio.app.capture_rgb8().expect("a picture"));
        let world = studio.app.app_mut().sub_app(RenderApp).world();
        let compiles = world
            .resource::<PipelineCache>()
            .pipelines()
            .any(|pipeline| {
                matches!(
                    pipeline.state,
                    CachedPipelineState::Queued | CachedPipelineState::Creating(_)
                )
            });
        quiet = if compiles { 0 } else { quiet + 1 };
    }
    frames
}

/// Asserts that each of the frames shows what was there before or what is there now.
fn assert_no_flash(name: &str, frames: &[RgbImage], before: &RgbImage) {
    let now = frames.last().expect("frames");
    let is_like = |picture: &RgbImage, frame: &RgbImage| psnr(picture, frame) >= SAME;
    for (number, frame) in frames.iter().enumerate() {
        if !is_like(before, frame) && !is_like(now, frame) {
            keep(&format!("flash {name}"), frame);
            let (before, now) = (psnr(before, frame), psnr(now, frame));
            panic!(
                "{name}: frame {number} of {} is {before:.1} dB from the one before the change, and {now:.1} dB \
                 from the last one",
                frames.len()
            );
        }
    }
    println!("{name}: {} frames until all was ready", frames.len());
}

/// Changes something, and demands that no frame shows anything but before and after; the picture after it.
fn change(
    name: &str,
    studio: &mut Studio,
    before: &RgbImage,
    change: impl FnOnce(&mut Studio),
) -> RgbImage {
    change(studio);
    let frames = frames_until_ready(studio);
    assert_no_flash(name, &frames, before);
    frames.last().expect("frames").clone()
}

/// A mesh in front of the scene of a material that was not there before.
fn spawn_in_front(studio: &mut Studio, material: StandardMaterial) {
    let world = studio.app.world_mut();
    let place = Transform::from_xyz(0.0, 0.9, 1.0);
    let mesh = spawn_mesh(world, Rectangle::new(0.6, 0.6), material, place);
    // Its shadow would come before it, as the pipelines of shadows are ready.
    world.entity_mut(mesh).insert(NotShadowCaster);
}

#[test]
fn nothing_vanishes_while_pipelines_compile() {
    let _gpu = gpu();
    for (name, quality) in [
        ("compact", FrameBufferQuality::Compact),
        ("packed", packing()),
    ] {
        let settings = HeadlessSettings {
            compiles_in_background: true,
            ..HeadlessSettings::with_size(128, 96)
        };
        let mut studio = Studio::with_settings(settings, lit_scene);
        let plain = frames_until_ready(&mut studio).pop().expect("frames");
        let set = |quality| move |studio: &mut Studio| studio.set_quality(studio.camera, quality);
        let named = |what: &str| format!("{name}, {what}");
        let small = change(&named("on"), &mut studio, &plain, set(Some(quality)));
        assert!(small != plain);
        let with_particle = change(&named("particle"), &mut studio, &small, |studio| {
            let glow = StandardMaterial {
                base_color: Color::srgb(0.9, 0.9, 0.2),
                alpha_mode: AlphaMode::Add,
                unlit: true,
                ..default()
            };
            spawn_in_front(studio, glow);
        });
        assert!(psnr(&with_particle, &small) < SAME);
        let with_shader = change(&named("shader"), &mut studio, &with_particle, |studio| {
            let masked = StandardMaterial {
                base_color: Color::srgb(0.1, 0.9, 0.9),
                alpha_mode: AlphaMode::Mask(0.5),
                clearcoat: 1.0,
                ..default()
            };
            spawn_in_front(studio, masked);
        });
        assert!(psnr(&with_shader, &with_particle) < SAME);
        change(&named("off"), &mut studio, &with_shader, set(None));
    }
}
