//! The shaders compute what the reference computes, also at the edges of the domain: no value from a material may spread or
//! be anything but a colour.
//!
//! Given colours go pixel by pixel through a camera. They are such that all packed values are exact in 16 bits, so that
//! what remains is the rounding of 32-bit arithmetic and of Bevy's 16-bit main texture.

use bevy::{
    asset::RenderAssetUsages,
    camera::{Hdr, Viewport, visibility::RenderLayers},
    image::{ImageSampler, ToExtents},
    prelude::*,
    render::{
        render_resource::{TextureDimension, TextureFormat},
        view::Msaa,
    },
};
use bevy_frugal_lab::headless::{
    HeadlessApp, HeadlessSettings, LabTarget, TargetFormat, pixel_camera,
};
use bevy_ycocg_fb::{
    CameraState, FrameBufferQuality, FrameBufferReport, MsaaResolve, PackedFormat, Reconstruction,
    YCoCgFrameBuffer, YCoCgFrameBufferPlugin,
    reference::{PackedImage, rg11b10ufloat::dithered},
};

use crate::support::{drawn, gpu};

/// Cameras that see one unlit quad each, scene-linear.
struct Flat {
    app: HeadlessApp,
    target: [u32; 2],
    size: [u32; 2],
    offset: [u32; 2],
    cameras: Vec<Entity>,
    material: Handle<StandardMaterial>,
}

impl Flat {
    /// A camera that fills the viewport of `size` pixels at `offset` of its target with `colors`.
    fn new(target: [u32; 2], size: [u32; 2], offset: [u32; 2], colors: &[[f32; 3]]) -> Self {
        let settings = HeadlessSettings {
            format: TargetFormat::Float32,
            ..HeadlessSettings::with_size(target[0], target[1])
        };
        let app = HeadlessApp::new(settings, |app| {
            app.add_plugins(YCoCgFrameBufferPlugin);
        });
        let mut flat = Self {
            app: app.expect("a headless app"),
            target,
            size,
            offset,
            cameras: Vec::new(),
            material: Handle::default(),
        };
        flat.add_camera(size, offset, colors);
        flat.app.run_until_ready(200).expect("it is ready");
        flat
    }

    /// Adds a camera beside the others; [`packed`](Self::packed) gives the picture of the first.
    fn add_camera(&mut self, size: [u32; 2], offset: [u32; 2], colors: &[[f32; 3]]) {
        let world = self.app.world_mut();
        let image = world.add_asset(float_image(size, colors));
        let mesh = world.add_asset(Rectangle::new(size[0] as f32, size[1] as f32));
        let material = world.add_asset::<StandardMaterial>(StandardMaterial {
            base_color_texture: Some(image),
            unlit: true,
            ..default()
        });
        let layer = RenderLayers::layer(self.cameras.len() + 1);
        world.spawn((
            Mesh3d(mesh),
            MeshMaterial3d(material.clone()),
            layer.clone(),
        ));
        let camera = Camera {
            order: self.cameras.len() as isize,
            viewport: Some(Viewport {
                physical_position: offset.into(),
                physical_size: size.into(),
                ..default()
            }),
            ..default()
        };
        let view = pixel_camera(world.resource::<LabTarget>(), size);
        let camera = world.spawn(view).insert((camera, Hdr, layer)).id();
        if self.cameras.is_empty() {
            self.material = material;
        }
        self.cameras.push(camera);
    }

    /// Puts `count` more quads of the same colours before the first.
    fn stack(&mut self, count: usize, alpha_mode: AlphaMode) {
        let [width, height] = self.size;
        let world = self.app.world_mut();
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        let material = StandardMaterial {
            alpha_mode,
            ..materials.get(&self.material).expect("the material").clone()
        };
        let material = materials.add(material);
        let mesh = world.add_asset(Rectangle::new(width as f32, height as f32));
        for i in 0..count {
            world.spawn((
                Mesh3d(mesh.clone()),
                MeshMaterial3d(material.clone()),
                Transform::from_xyz(0.0, 0.0, 1.0 + i as f32),
                RenderLayers::layer(1),
            ));
        }
    }

    /// Samples a pixel, of all cameras.
    fn set_msaa(&mut self, msaa: Msaa) {
        for &camera in &self.cameras {
            self.app.world_mut().entity_mut(camera).insert(msaa);
        }
    }

    /// What the first camera makes of its colours, all of them packed.
    fn packed(&mut self, settings: YCoCgFrameBuffer) -> Vec<[f32; 3]> {
        self.colors(settings.into(), CameraState::Packed(settings.format))
    }

    /// What the first camera makes of its colours, all of them in this state.
    fn colors(&mut self, quality: FrameBufferQuality, expected: CameraState) -> Vec<[f32; 3]> {
        for &camera in &self.cameras {
            self.app.world_mut().entity_mut(camera).insert(quality);
        }
        self.app.render_frames(3).expect("three frames");
        for &camera in &self.cameras {
            let report = self.app.world().get::<FrameBufferReport>(camera);
            assert_eq!(report.map(|report| &report.state), Some(&expected));
        }
        let picture = self.app.capture_f32().expect("a picture");
        let [width, height] = self.size;
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        pixels
            .map(|(x, y)| {
                let index = (self.offset[1] + y) * self.target[0] + self.offset[0] + x;
                let [r, g, b, _] = picture.pixels[index as usize];
                [r, g, b]
            })
            .collect()
    }
}

fn float_image(size: [u32; 2], colors: &[[f32; 3]]) -> Image {
    let texels = colors
        .iter()
        .flat_map(|&[r, g, b]| [r, g, b, 1.0])
        .flat_map(f32::to_le_bytes);
    let mut image = Image::new(
        UVec2::from(size).to_extents(),
        TextureDimension::D2,
        texels.collect(),
        TextureFormat::Rgba32Float,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.sampler = ImageSampler::nearest();
    image
}

/// Multiples of 1/64 up to 4: their luminance and chrominance are exact in 16-bit floats.
fn random_colors(size: [u32; 2], seed: u64) -> Vec<[f32; 3]> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) % 257
    };
    (0..size[0] * size[1])
        .map(|_| [random(), random(), random()].map(|n| n as f32 / 64.0))
        .collect()
}

const ALL: [Reconstruction; 6] = [
    Reconstruction::Nearest,
    Reconstruction::Bilinear,
    Reconstruction::EdgeDirected,
    Reconstruction::Guided,
    Reconstruction::Wide,
    Reconstruction::Quad,
];

/// The step of a 16-bit float, to either side of which a target may round, and some arithmetic.
const STEP: f32 = 1.1 / 1024.0;

/// The largest difference relative to the larger of the value and `floor`.
fn largest_difference(actual: &[[f32; 3]], expected: &[[f32; 3]], floor: f32) -> f32 {
    assert_eq!(actual.len(), expected.len());
    let pairs = actual.iter().flatten().zip(expected.iter().flatten());
    pairs.fold(0.0, |largest, (actual, expected)| {
        assert!(actual.is_finite(), "{actual} instead of {expected}");
        largest.max((actual - expected).abs() / expected.abs().max(floor))
    })
}

#[test]
fn every_filter_at_every_size_and_offset_is_that_of_the_reference() {
    let _gpu = gpu();
    let rows = [
        ([37, 23], [0, 0]),
        ([36, 22], [1, 0]),
        ([31, 21], [3, 5]),
        ([30, 20], [2, 7]),
        ([1, 23], [0, 0]),
        ([1, 22], [1, 1]),
        ([37, 1], [0, 0]),
        ([36, 1], [0, 1]),
        ([2, 2], [5, 4]),
        ([1, 1], [0, 0]),
        ([1, 1], [2, 3]),
    ];
    for (size, offset) in drawn(3, rows) {
        let colors = random_colors(size, 5);
        let mut flat = Flat::new([40, 28], size, offset, &colors);
        for format in [PackedFormat::Float16, PackedFormat::Float32] {
            let image = PackedImage::pack(&colors, size, offset, format);
            for reconstruction in ALL {
                let actual = flat.packed(YCoCgFrameBuffer {
                    reconstruction,
                    ..YCoCgFrameBuffer::with_format(format)
                });
                let expected = image.unpack(reconstruction);
                let difference = largest_difference(&actual, &expected, 0.05);
                assert!(
                    difference < STEP,
                    "{size:?} at {offset:?} {format:?} {reconstruction:?}: {difference}"
                );
            }
        }
    }
}

#[test]
fn a_neighbouring_viewport_changes_nothing() {
    // A neighbour in the next viewport is none: beside another picture the result is the same.
    let _gpu = gpu();
    let size = [20, 16];
    let colors = random_colors(size, 9);
    let mut alone = Flat::new([20, 16], size, [0, 0], &colors);
    let mut beside = Flat::new([40, 16], size, [20, 0], &colors);
    let bright = vec![[4.0, 0.0, 0.0]; 20 * 16];
    beside.add_camera(size, [0, 0], &bright);
    for reconstruction in ALL {
        let settings = YCoCgFrameBuffer {
            reconstruction,
            ..default()
        };
        assert!(
            alone.packed(settings) == beside.packed(settings),
            "{reconstruction:?}"
        );
    }
}

const BAD: [[f32; 3]; 10] = [
    [f32::NAN; 3],
    [f32::NAN, 1.0, 2.0],
    [f32::INFINITY; 3],
    [f32::INFINITY, 0.0, 1.0],
    [f32::NEG_INFINITY, 1.0, 1.0],
    [65504.0; 3],
    [65504.0, 0.0, 0.0],
    [1e30, 1.0, 0.0],
    [1e-7, 0.0, 2e-7],
    [-3.0, 0.5, 0.5],
];

#[test]
fn one_bad_pixel_is_one_bad_pixel() {
    let _gpu = gpu();
    let size = [24, 20];
    for (i, bad) in drawn(3, BAD.into_iter().enumerate()) {
        let mut colors = random_colors(size, 3);
        // Both parities.
        for (x, y) in [(7, 6), (15, 13)] {
            colors[y * size[0] as usize + x] = bad;
        }
        let mut flat = Flat::new(size, size, [0, 0], &colors);
        for format in [PackedFormat::Float16, PackedFormat::Float32] {
            for reconstruction in [
                Reconstruction::Guided,
                Reconstruction::Wide,
                Reconstruction::EdgeDirected,
            ] {
                let actual = flat.packed(YCoCgFrameBuffer {
                    format,
                    reconstruction,
                    ..default()
                });
                let image = PackedImage::pack(&colors, size, [0, 0], format);
                let expected = image.unpack(reconstruction);
                let difference = largest_difference_of_pixels(&actual, &expected);
                // 1e-7 is two steps of a 16-bit float, and which of them is up to the driver.
                let subnormal = bad[0] == 1e-7 && format == PackedFormat::Float16;
                let allowed = if subnormal { 0.02 } else { STEP };
                assert!(
                    difference < allowed,
                    "{i} {format:?} {reconstruction:?}: {difference}"
                );
                assert!(actual.iter().flatten().all(|c| (0.0..=65504.0).contains(c)));
                // Two pixels away nothing has changed.
                let clean = PackedImage::pack(&random_colors(size, 3), size, [0, 0], format)
                    .unpack(reconstruction);
                for (index, (actual, clean)) in actual.iter().zip(&clean).enumerate() {
                    let (x, y) = (index as i32 % 24, index as i32 / 24);
                    let is_near = |(bx, by): (i32, i32)| (x - bx).abs().max((y - by).abs()) <= 1;
                    if ![(7, 6), (15, 13)].into_iter().any(is_near) {
                        assert!(largest_difference(&[*actual], &[*clean], 0.05) < STEP);
                    }
                }
            }
        }
    }
}

#[test]
fn stacking_light_until_it_overflows_is_as_bright_as_can_be() {
    let _gpu = gpu();
    let size = [16, 12];
    let colors = vec![[60000.0, 30000.0, 10000.0]; 16 * 12];
    let mut flat = Flat::new(size, size, [0, 0], &colors);
    flat.stack(7, AlphaMode::Add);
    for msaa in [Msaa::Off, Msaa::Sample4] {
        flat.set_msaa(msaa);
        for format in [PackedFormat::Float16, PackedFormat::Float32] {
            for msaa_resolve in [MsaaResolve::Box, MsaaResolve::ToneMapWeighted] {
                let actual = flat.packed(YCoCgFrameBuffer {
                    format,
                    msaa_resolve,
                    ..default()
                });
                for pixel in actual {
                    assert!(
                        pixel.iter().all(|c| c.is_finite() && *c >= 0.0),
                        "{pixel:?}"
                    );
                    assert!(pixel[0] == 65504.0, "{format:?} {msaa:?}: {pixel:?}");
                }
            }
        }
    }
}

/// Relative to the brightest channel of each pixel: what is stored is rounded before channels of
/// very different size are told apart again.
fn largest_difference_of_pixels(actual: &[[f32; 3]], expected: &[[f32; 3]]) -> f32 {
    let pairs = actual.iter().zip(expected);
    pairs.fold(0.0, |largest: f32, (actual, expected)| {
        let brightest = expected.iter().copied().fold(0.05, f32::max);
        largest.max(largest_difference(&[*actual], &[*expected], brightest))
    })
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
