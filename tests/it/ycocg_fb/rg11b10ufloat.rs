//! Cameras that Bevy draws in three small floats.

use bevy::{
    camera::{ClearColorConfig, Hdr},
    math::{Affine3A, UVec4},
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

use super::{
    flat::{Flat, random_colors},
    scene::{Studio, clear_to, lit_scene},
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

#[test]
fn what_cannot_be_drawn_so_is_named() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    studio.mode(true, Msaa::Off).camera(|camera| {
        clear_to(camera, Color::NONE.into());
    });
    studio.check_fallback(FrameBufferQuality::Compact, Reason::TransparentBackground);
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
    let reason = Reason::ContinuedInAnotherFormat(why);
    studio.check_fallback(FrameBufferQuality::Compact, reason);
    studio.app.world_mut().despawn(second);
    studio.rg11b10ufloat();
}

/// As `bevy_egui` does, whose pipelines take their format from `Hdr` alone.
#[test]
fn a_plugin_that_draws_over_the_picture_keeps_bevys_format() {
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
    studio.mode(true, Msaa::Off);
    studio.quality(FrameBufferQuality::Compact);
    assert_eq!(
        studio.state(),
        Some(CameraState::Fallback(Reason::DrawnOver))
    );
}
