//! Pictures while pipelines compile in the background, as they do in a game.

use bevy::{
    light::NotShadowCaster,
    prelude::*,
    render::{
        RenderApp,
        render_resource::{CachedPipelineState, PipelineCache},
    },
};
use bevy_frugal_lab::headless::HeadlessSettings;
use bevy_ycocg_fb::FrameBufferQuality;
use image::RgbImage;

use super::scene::{Studio, lit_scene, packing};
use crate::support::{gpu, keep, psnr};

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
    let material = world.add_asset::<StandardMaterial>(material);
    let mesh = world.add_asset(Rectangle::new(0.6, 0.6));
    let place = Transform::from_xyz(0.0, 0.9, 1.0);
    // Its shadow would come before it, as the pipelines of shadows are ready.
    world.spawn((
        Mesh3d(mesh),
        MeshMaterial3d(material),
        place,
        NotShadowCaster,
    ));
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
        let to_quality = |studio: &mut Studio| {
            studio.camera(|camera| {
                camera.insert(quality);
            });
        };
        let named = |what: &str| format!("{name}, {what}");
        let small = change(&named("on"), &mut studio, &plain, to_quality);
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
        change(&named("off"), &mut studio, &with_shader, |studio| {
            studio.camera(|camera| {
                camera.remove::<FrameBufferQuality>();
            });
        });
    }
}
