//! Light accumulated in one target and in two, on the GPU and on the CPU.

use bevy::{
    camera::Viewport,
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    prelude::*,
};
use bevy_frugal_lab::{
    headless::{HeadlessApp, LabTarget},
    metrics::compare,
    runner::{MemoryFigures, Scene},
    scenes::deferred_accumulation::{
        DeferredAccumulation, LIGHT_DISTANCE, LightAccumulation, LightAccumulationPlugin,
        reference::{Eye, render},
        sources,
    },
};

use crate::{
    scenes,
    support::{float_settings, gpu},
};

const SIZE: [u32; 2] = [161, 119];
const MAX_FRAMES: u32 = 100;

/// A scene-linear picture of a viewport.
struct Picture {
    eye: Eye,
    pixels: Vec<[f32; 3]>,
}

/// The picture of a camera whose viewport begins at `offset`.
fn picture(way: LightAccumulation, offset: UVec2) -> Picture {
    let settings = float_settings(SIZE[0], SIZE[1]);
    let size = UVec2::from(SIZE) - offset;
    let mut app = HeadlessApp::new(settings, |app| {
        app.add_plugins(LightAccumulationPlugin)
            .insert_resource(ClearColor(Color::BLACK))
            .insert_resource(sources(LIGHT_DISTANCE));
        let target = app.world().resource::<LabTarget>().0.clone();
        app.world_mut().spawn((
            Camera3d::default(),
            Camera {
                viewport: Some(Viewport {
                    physical_position: offset,
                    physical_size: size,
                    ..default()
                }),
                ..default()
            },
            target,
            way,
            Msaa::Off,
            Tonemapping::None,
            DebandDither::Disabled,
            DeferredAccumulation.view(),
        ));
    })
    .expect("an adapter");
    app.run_until_ready(MAX_FRAMES).expect("ready");
    let image = app.capture_f32().expect("a picture");
    let world = app.world_mut();
    let mut cameras = world.query::<(&Camera, &GlobalTransform)>();
    let (camera, pose) = cameras.single(world).expect("one camera");
    let rows = (offset.y..SIZE[1]).flat_map(|y| (offset.x..SIZE[0]).map(move |x| (x, y)));
    let pixels = rows.map(|(x, y)| {
        let [r, g, b, _] = image.pixels[(y * SIZE[0] + x) as usize];
        [r, g, b]
    });
    Picture {
        eye: Eye {
            position: pose.translation(),
            world_from_clip: pose.to_matrix() * camera.clip_from_view().inverse(),
            size,
        },
        pixels: pixels.collect(),
    }
}

/// Root of the mean squared difference of the channels, and the largest.
fn difference(a: &[[f32; 3]], b: &[[f32; 3]]) -> (f32, f32) {
    assert_eq!(a.len(), b.len());
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    let differences = pairs.map(|(a, b)| (a - b).abs());
    let (sum, largest) = differences.fold((0.0, 0.0f32), |(sum, largest), d| {
        (sum + d * d, largest.max(d))
    });
    ((sum / (3 * a.len()) as f32).sqrt(), largest)
}

fn pictures() -> [Vec<[f32; 3]>; 3] {
    LightAccumulation::ALL.map(|way| picture(way, UVec2::ZERO).pixels)
}

#[test]
fn one_target_is_nearly_as_good_as_two() {
    let _gpu = gpu();
    let [exact, packed, shortcut] = pictures();
    let brightest = exact.iter().flatten().copied().fold(0.0, f32::max);
    assert!(brightest > 1.0, "{brightest}");
    let (packed, _) = difference(&exact, &packed);
    let (shortcut, largest) = difference(&exact, &shortcut);
    assert!(largest > 0.2, "the highlights lose no colour: {largest}");
    assert!(packed < 0.002, "{packed}");
    assert!(packed < 0.03 * shortcut, "{packed} and {shortcut}");
}

/// Where a channel exceeds the other most: a highlight.
#[test]
fn packed_highlights_keep_their_colours() {
    let _gpu = gpu();
    let [exact, packed, shortcut] = pictures();
    let peak = |channel: usize| {
        let excess = |i: &usize| exact[*i][channel] - exact[*i][1 - channel];
        let indices = 0..exact.len();
        indices.max_by(|a, b| excess(a).total_cmp(&excess(b)))
    };
    for channel in [0, 1] {
        let peak = peak(channel).expect("pixels");
        let purity = |p: [f32; 3]| p[channel] / (p[0] + p[1]);
        let [exact, packed, shortcut] = [&exact, &packed, &shortcut].map(|p| purity(p[peak]));
        assert!((exact - packed).abs() < 0.001, "{exact} and {packed}");
        assert!(exact - shortcut > 0.1, "{exact} and {shortcut}");
    }
}

/// Of viewports at odd offsets too: the checkerboard is that of the target.
#[test]
fn the_shaders_are_the_reference() {
    let _gpu = gpu();
    for way in LightAccumulation::ALL {
        let gpu = picture(way, UVec2::ZERO);
        let cpu = render(&gpu.eye, &sources(LIGHT_DISTANCE).0, way);
        let (mean, _) = difference(&gpu.pixels, &cpu);
        // A pixel at the outline can fall to the other side.
        let off =
            gpu.pixels.iter().zip(&cpu).filter(|(a, b)| {
                (0..3).any(|c| (a[c] - b[c]).abs() > 0.01 * a[c].max(b[c]) + 0.002)
            });
        let off = off.count();
        assert!(off * 500 < cpu.len(), "{way:?}: {off} pixels differ");
        assert!(mean < 0.001, "{way:?}: {mean}");
    }
}

#[test]
fn a_viewport_at_an_odd_offset_is_unpacked_with_its_own_parity() {
    let _gpu = gpu();
    let offset = UVec2::new(21, 12);
    let [exact, packed] = [LightAccumulation::Exact, LightAccumulation::Packed]
        .map(|way| picture(way, offset).pixels);
    let (packed, _) = difference(&exact, &packed);
    assert!(packed < 0.002, "{packed}");
}

/// As the example's window shows it: exact on the left, the method of the setting on the right.
#[test]
fn the_sides_of_the_split_line_are_accumulated_their_own_way() {
    let _gpu = gpu();
    let set = ["method=specular_luminance"];
    let mut app = scenes::app(&DeferredAccumulation, SIZE, &set);
    let [before, after] = scenes::sides(&mut app);
    let both = scenes::picture(&mut app, 0.5);
    let expected = scenes::joined([&before, &after], SIZE[0].div_ceil(2));
    let error = compare(&expected, &both).expect("one size");
    // The outline of the ball can round differently in a part of the picture.
    assert!(error.mse < 1.0, "{error:?}");
    let different = compare(&before, &after).expect("one size");
    assert!(different.mse > 5.0, "{different:?}");
    let memory = &app.world().resource::<MemoryFigures>().0;
    let pixels = u64::from(SIZE[0] * SIZE[1]);
    assert_eq!(memory["accumulated light before"], 16 * pixels);
    assert_eq!(memory["accumulated light after"], 8 * pixels);
}
