//! A quad that shows one wavelet texture after the other, pixel by pixel, and what is expected of it: the codec's view of
//! it, and the filters in f64 over decoded levels.

use std::{collections::BTreeMap, sync::OnceLock, thread};

use bevy::{
    camera::Hdr,
    math::Affine2,
    prelude::*,
    render::renderer::{RenderDevice, RenderQueue},
};
pub use bevy_frugal_lab::content::{add_texture, wavelets};
use bevy_frugal_lab::{
    content,
    headless::{
        HeadlessApp, HeadlessSettings, LabTarget, Rgba32FImage, TargetFormat, pixel_camera,
    },
};
use bevy_wavelet_tex::{
    WaveletAddressMode, WaveletExtension, WaveletFilter, WaveletStandardMaterial, WaveletStorage,
    WaveletTexPlugin, WaveletTexture,
    codec::{
        blocks::BlockFormat,
        color::linear_from_srgb,
        decoder::{DecodedImage, decode_with},
        image::{ColorSpace, Content, WaveletImage},
        packing::Packing,
        rate::Rate,
        settings::EncodeSettings,
    },
    material::storage_on,
};
use image::RgbImage;
use wgpu::util::DeviceExt;

use crate::support::{
    Gpu,
    compute::{Binding, dispatch_on},
    gpu, skipped,
};

pub const MAX_FRAMES: u32 = 200;

/// One 8-bit step.
pub const STEP: f32 = 1.0 / 255.0;

/// A picture with all that a photograph has, at a size that no block divides.
pub fn picture() -> RgbImage {
    content::photo_like(93, 61, 7)
}

pub fn encoded(picture: &RgbImage, content: Content, color_space: ColorSpace) -> WaveletImage {
    encoded_with(picture, &wavelets(Rate::usual(content), color_space))
}

pub fn encoded_with(picture: &RgbImage, settings: &EncodeSettings) -> WaveletImage {
    content::encoded(picture, settings).expect("a good image")
}

/// Pixels in linear units, as they would be filtered.
pub fn linear(image: &WaveletImage, decoded: DecodedImage) -> ([u32; 2], Vec<[f32; 3]>) {
    let srgb = image.color_space == ColorSpace::Srgb;
    let linear = |p: [f32; 3]| if srgb { p.map(linear_from_srgb) } else { p };
    let pixels = decoded.pixels.into_iter().map(linear);
    (decoded.size, pixels.collect())
}

/// What a texture unit that filters with 8 bits, as lavapipe's does, may add: one level of what is
/// stored, in Co and Cg, of which R and B take half each.
pub fn chroma_rounding(image: &WaveletImage) -> f32 {
    let chroma = image.groups().nth(1).filter(|g| g.packing == Packing::Bc1);
    let extents = chroma.iter().flat_map(|g| &g.codings);
    0.5 * STEP * extents.map(|c| c.low_max - c.low_min).sum::<f32>()
}

/// Waits until an app may run; `None`, with a note, where wavelet textures cannot all be blocks.
pub fn gpu_with_all_planes() -> Option<Gpu> {
    static BINDS: OnceLock<bool> = OnceLock::new();
    let gpu = gpu();
    let binds = BINDS.get_or_init(|| {
        let app = HeadlessApp::new(HeadlessSettings::with_size(16, 16), |_| {});
        let app = app.expect("an adapter");
        storage_on(app.world().resource::<RenderDevice>()) == WaveletStorage::Blocks
    });
    if !binds {
        let thread = thread::current();
        let test = thread.name().unwrap_or("a test of wavelet textures");
        skipped(&format!(
            "{test}: the adapter lacks BC or binds too few textures for all planes"
        ));
        return None;
    }
    Some(gpu)
}

/// An app with wavelet textures.
pub fn app(settings: HeadlessSettings) -> HeadlessApp {
    HeadlessApp::new(settings, |app| {
        app.add_plugins(WaveletTexPlugin);
    })
    .expect("an adapter")
}

/// All of a texture, once.
pub const WHOLE: [Vec2; 2] = [Vec2::ZERO, Vec2::ONE];

/// An app whose camera sees nothing but a quad, in floats.
pub struct Viewer {
    pub app: HeadlessApp,
    quad: Entity,
    _gpu: Gpu,
}

impl Viewer {
    /// A target of `size` pixels, where the adapter takes textures of all planes.
    pub fn new(size: [u32; 2]) -> Option<Self> {
        let gpu = gpu_with_all_planes()?;
        Some(Self::with_settings(gpu, size, HeadlessSettings::default()))
    }

    pub fn with_settings(gpu: Gpu, size: [u32; 2], settings: HeadlessSettings) -> Self {
        let mut app = app(HeadlessSettings {
            width: size[0],
            height: size[1],
            format: TargetFormat::Float32,
            ..settings
        });
        let world = app.world_mut();
        world.insert_resource(ClearColor(Color::BLACK));
        let camera = pixel_camera(world.resource::<LabTarget>(), size);
        world.spawn((camera, Hdr));
        let mesh = world.add_asset(Rectangle::new(size[0] as f32, size[1] as f32));
        let quad = world.spawn(Mesh3d(mesh)).id();
        Self {
            app,
            quad,
            _gpu: gpu,
        }
    }

    /// The quad with a texture as base colour, unlit; uv runs from `origin` to `origin + extent`.
    pub fn show(
        &mut self,
        image: &WaveletImage,
        storage: WaveletStorage,
        extension: WaveletExtension,
        [origin, extent]: [Vec2; 2],
    ) -> Rgba32FImage {
        let texture = add_texture(self.app.world_mut(), image, storage);
        self.show_material(WaveletStandardMaterial {
            base: StandardMaterial {
                unlit: true,
                uv_transform: Affine2::from_scale_angle_translation(extent, 0.0, origin),
                alpha_mode: match image.content {
                    Content::ColorAlpha => AlphaMode::Blend,
                    _ => AlphaMode::Opaque,
                },
                ..default()
            },
            extension: WaveletExtension {
                base_color: Some(texture),
                ..extension
            },
        })
    }

    /// As [`Self::show`] with Bevy's default way to address an image.
    pub fn show_filtered(
        &mut self,
        image: &WaveletImage,
        storage: WaveletStorage,
        filter: WaveletFilter,
        view: [Vec2; 2],
    ) -> Rgba32FImage {
        let extension = WaveletExtension {
            filter,
            ..default()
        };
        self.show(image, storage, extension, view)
    }

    /// The same of the blocks of an image.
    pub fn show_blocks(
        &mut self,
        image: &WaveletImage,
        filter: WaveletFilter,
        view: [Vec2; 2],
    ) -> Rgba32FImage {
        self.show_filtered(image, WaveletStorage::Blocks, filter, view)
    }

    /// The quad with a texture that may still be loading, unlit, without a filter.
    pub fn show_texture(&mut self, texture: Handle<WaveletTexture>) -> Rgba32FImage {
        self.show_material(WaveletStandardMaterial {
            base: StandardMaterial {
                unlit: true,
                ..default()
            },
            extension: WaveletExtension {
                base_color: Some(texture),
                filter: WaveletFilter::Nearest,
                ..default()
            },
        })
    }

    /// The quad with a material.
    pub fn show_material(&mut self, material: WaveletStandardMaterial) -> Rgba32FImage {
        let world = self.app.world_mut();
        let material = MeshMaterial3d(world.add_asset::<WaveletStandardMaterial>(material));
        world.entity_mut(self.quad).insert(material);
        self.app.run_until_ready(MAX_FRAMES).expect("ready");
        self.app.capture_f32().expect("a picture")
    }

    /// The reference decoder's pixels of a level, from the texels that the driver hands a shader:
    /// how those are rounded is up to the driver, and four of them add up in one pixel.
    pub fn decoded(&self, image: &WaveletImage, level: u32) -> DecodedImage {
        decode_with(image, level, |format, blocks, size| {
            driver_texels(&self.app, format, blocks, size)
        })
    }
}

/// The texels that the driver decodes from blocks, as `decode_blocks` does.
pub fn driver_texels(
    app: &HeadlessApp,
    format: BlockFormat,
    blocks: &[u8],
    size: [u32; 2],
) -> Vec<[f32; 4]> {
    let padded = size.map(|s| s.next_multiple_of(4));
    let format = match format {
        BlockFormat::Bc1 => wgpu::TextureFormat::Bc1RgbaUnorm,
        BlockFormat::Bc3 => wgpu::TextureFormat::Bc3RgbaUnorm,
        BlockFormat::Bc4 => wgpu::TextureFormat::Bc4RUnorm,
        BlockFormat::Bc5 => wgpu::TextureFormat::Bc5RgUnorm,
        BlockFormat::Bc7 => wgpu::TextureFormat::Bc7RgbaUnorm,
    };
    let texels = texels(app, format, blocks, padded);
    let rows = texels.chunks_exact(padded[0] as usize);
    rows.take(size[1] as usize)
        .flat_map(|row| &row[..size[0] as usize])
        .copied()
        .collect()
}

/// The linear values that the driver has for the 256 values of sRGB, which lavapipe approximates.
pub fn driver_linear_from_srgb(app: &HeadlessApp) -> Vec<f32> {
    let bytes: Vec<u8> = (0..=255).flat_map(|v| [v; 4]).collect();
    let texels = texels(app, wgpu::TextureFormat::Rgba8UnormSrgb, &bytes, [16, 16]);
    texels.into_iter().map(|texel| texel[0]).collect()
}

/// Reads texels without filtering or arithmetic, and apart from the shaders under test.
const TEXELS: &str = "
@group(0) @binding(0) var blocks: texture_2d_array<f32>;
@group(1) @binding(0) var<storage, read_write> texels: array<vec4<f32>>;

@compute @workgroup_size(4, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let width = textureDimensions(blocks).x;
    texels[id.y * width + id.x] = textureLoad(blocks, id.xy, 0u, 0u);
}
";

fn texels(
    app: &HeadlessApp,
    format: wgpu::TextureFormat,
    bytes: &[u8],
    [width, height]: [u32; 2],
) -> Vec<[f32; 4]> {
    let device = app.world().resource::<RenderDevice>().wgpu_device();
    let queue = app.world().resource::<RenderQueue>();
    let descriptor = wgpu::TextureDescriptor {
        label: Some("raw_blocks"),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    };
    let order = wgpu::util::TextureDataOrder::LayerMajor;
    let texture = device.create_texture_with_data(queue, &descriptor, order, bytes);
    let view = texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..default()
    });
    let inputs: [&[Binding]; 2] = [&[Binding::Texture(&view)], &[]];
    let bytes = u64::from(width * height) * 16;
    let groups = [width / 4, height / 4];
    let texels = dispatch_on(device, queue, TEXELS, inputs, bytes, groups);
    bytemuck::pod_collect_to_vec(&texels)
}

/// How far a picture is from what is expected of it.
pub struct Difference {
    /// Of a channel, the largest.
    pub largest: f32,
    /// Where that is.
    pub at: [u32; 2],
    /// Pixels with a channel that is more than one 8-bit step off, in percent.
    pub percent_beyond_a_step: f32,
}

impl Difference {
    /// The largest, in 8-bit steps.
    pub fn steps(&self) -> f32 {
        self.largest / STEP
    }

    pub fn report(&self, name: &str) {
        println!(
            "{name}: {:.3} steps at {:?}, {:.2} % of pixels beyond 1",
            self.steps(),
            self.at,
            self.percent_beyond_a_step,
        );
    }

    /// Reports it, and demands that it is at most this.
    pub fn check(&self, name: &str, most: f32) {
        self.report(name);
        assert!(self.largest <= most, "{name}: {} steps", self.steps());
    }
}

pub fn difference(picture: &Rgba32FImage, expected: impl Fn(u32, u32) -> [f32; 3]) -> Difference {
    let mut difference = Difference {
        largest: 0.0,
        at: [0; 2],
        percent_beyond_a_step: 0.0,
    };
    let percent = 100.0 / picture.pixels.len() as f32;
    for y in 0..picture.height {
        for x in 0..picture.width {
            let actual = picture.pixels[(y * picture.width + x) as usize];
            let mut here = 0.0f32;
            for (a, e) in actual.iter().zip(expected(x, y)) {
                assert!(a.is_finite(), "pixel {x}, {y} is {a}");
                here = here.max((a - e).abs());
            }
            if here > STEP {
                difference.percent_beyond_a_step += percent;
            }
            if here > difference.largest {
                (difference.largest, difference.at) = (here, [x, y]);
            }
        }
    }
    difference
}

/// PSNR in dB of values in `[0, 1]`.
pub fn psnr_of_units(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    let mean = pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>() / (3 * a.len()) as f64;
    -10.0 * mean.log10()
}

/// Red, green and blue of a picture's pixels.
pub fn colors(picture: &Rgba32FImage) -> Vec<[f64; 3]> {
    let pixels = picture.pixels.iter();
    pixels.map(|p| [p[0], p[1], p[2]].map(f64::from)).collect()
}

/// A level in linear units.
pub struct Level {
    size: [u32; 2],
    pub pixels: Vec<[f32; 3]>,
}

/// The levels of an image, as `decode` decodes them.
pub fn levels(image: &WaveletImage, decode: impl Fn(u32) -> DecodedImage) -> Vec<Level> {
    let level = |level| Level::new(image, decode(level));
    (0..image.levels).map(level).collect()
}

impl Level {
    pub fn new(image: &WaveletImage, decoded: DecodedImage) -> Self {
        let (size, pixels) = linear(image, decoded);
        Self { size, pixels }
    }

    fn at(&self, position: [i64; 2], mode: WaveletAddressMode) -> [f64; 3] {
        let inside = |axis: usize| {
            let n = i64::from(self.size[axis]);
            let i = position[axis];
            let i = match mode {
                WaveletAddressMode::Repeat => i.rem_euclid(n),
                WaveletAddressMode::ClampToEdge => i.clamp(0, n - 1),
                WaveletAddressMode::MirrorRepeat => {
                    let i = i.rem_euclid(2 * n);
                    i.min(2 * n - 1 - i)
                }
            };
            i as usize
        };
        let pixel = self.pixels[inside(1) * self.size[0] as usize + inside(0)];
        pixel.map(f64::from)
    }

    /// The nearest pixel.
    pub fn nearest(&self, uv: Vec2, mode: WaveletAddressMode) -> [f64; 3] {
        let position = |axis: usize| (f64::from(uv[axis]) * f64::from(self.size[axis])).floor();
        self.at([position(0) as i64, position(1) as i64], mode)
    }

    /// The four nearest pixels, weighted.
    pub fn bilinear(&self, uv: Vec2, mode: WaveletAddressMode) -> [f64; 3] {
        let place = |axis: usize| {
            let centered = f64::from(uv[axis]) * f64::from(self.size[axis]) - 0.5;
            (centered.floor() as i64, centered - centered.floor())
        };
        let ((x, u), (y, v)) = (place(0), place(1));
        let at = |dx, dy| self.at([x + dx, y + dy], mode);
        let row = |dy| mix(at(0, dy), at(1, dy), u);
        mix(row(0), row(1), v)
    }
}

/// A level and the mips of it that are means of four pixels of the level before, without coding errors.
pub fn exact_mips(level: Level) -> Vec<Level> {
    let mut levels = vec![level];
    while let Some(last) = levels.last()
        && last.size.iter().all(|side| side % 2 == 0)
    {
        let size = last.size.map(|side| i64::from(side / 2));
        let positions = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [2 * x, 2 * y]));
        let mean = |[x, y]: [i64; 2]| {
            let at = |dx, dy| last.at([x + dx, y + dy], WaveletAddressMode::Repeat);
            let row = |dy| mix(at(0, dy), at(1, dy), 0.5);
            mix(row(0), row(1), 0.5).map(|value| value as f32)
        };
        let pixels = positions.map(mean).collect();
        let size = last.size.map(|side| side / 2);
        levels.push(Level { size, pixels });
    }
    levels
}

/// The trilinear filter.
pub fn trilinear(levels: &[Level], uv: Vec2, lod: f64, mode: WaveletAddressMode) -> [f64; 3] {
    let fine = lod.floor() as usize;
    let coarse = (fine + 1).min(levels.len() - 1);
    let of_level = |level: usize| levels[level].bilinear(uv, mode);
    mix(of_level(fine), of_level(coarse), lod.fract())
}

/// The anisotropic filter of `sampling.wesl`, where a pixel of the screen covers `extent` uv along their axes.
pub fn anisotropic(levels: &[Level], uv: Vec2, extent: Vec2, mode: WaveletAddressMode) -> [f64; 3] {
    const MAX_ANISOTROPY: f64 = 9.9;
    const SAMPLE_DENSITY: f64 = 1.2;
    const LONG_FOOTPRINT_BIAS: f64 = 0.45;
    let pixels = [0, 1].map(|axis| f64::from(extent[axis]) * f64::from(levels[0].size[axis]));
    let long = pixels[0].max(pixels[1]);
    let least = (long / MAX_ANISOTROPY).max(1.0);
    let short = pixels[0].min(pixels[1]).max(least);
    let finer = LONG_FOOTPRINT_BIAS * (1.0 - (short / long).powi(2)).clamp(0.0, 1.0);
    let width = short * (-finer).exp2();
    let lod = width.log2().clamp(0.0, (levels.len() - 1) as f64);
    let widths = (long / width).max(1.0);
    let samples = (SAMPLE_DENSITY * widths + 1.0 - SAMPLE_DENSITY).ceil() as u32;
    assert!(samples <= 16, "{samples} samples");
    let half = (1.0 - (width / long).powi(2)).max(0.0).sqrt() as f32;
    let axis = [Vec2::Y, Vec2::X][usize::from(pixels[0] >= pixels[1])];
    let (mut sum, mut weights) = ([0.0; 3], 0.0);
    for i in 0..samples {
        let along = f64::from(2 * i + 1) / f64::from(samples) - 1.0;
        let weight = 1.0 - along.abs();
        let at = uv + along as f32 * half * axis * extent;
        let sample = trilinear(levels, at, lod, mode);
        (0..3).for_each(|c| sum[c] += weight * sample[c]);
        weights += weight;
    }
    sum.map(|value| value / weights)
}

/// `a + (b - a) t`.
pub fn mix(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t)
}

/// A level filtered over a footprint of `extent` uv around `uv`, by `taps` x `taps` bilinear samples: with equal
/// weights, or with a tent over twice the footprint, as a texture unit's filter is. Every weight is a product of
/// one along x and one along y, so that each texel is read once.
pub fn supersampled(level: &Level, uv: Vec2, extent: Vec2, taps: u32, tent: bool) -> [f64; 3] {
    let weights = [0, 1].map(|axis| {
        let texels = f64::from(level.size[axis]);
        let centre = f64::from(uv[axis]) * texels - 0.5;
        weights_of_texels(centre, f64::from(extent[axis]) * texels, taps, tent)
    });
    let mut sum = [0.0; 3];
    for (y, weight_y) in &weights[1] {
        for (x, weight_x) in &weights[0] {
            let texel = level.at([*x, *y], WaveletAddressMode::Repeat);
            (0..3).for_each(|c| sum[c] += weight_x * weight_y * texel[c]);
        }
    }
    sum
}

/// The texels along one axis and their weights, one in all, where `taps` linear samples are spread over `extent`
/// texels around `centre`.
fn weights_of_texels(centre: f64, extent: f64, taps: u32, tent: bool) -> BTreeMap<i64, f64> {
    let mut weights = BTreeMap::new();
    for tap in 0..taps {
        let offset = (f64::from(tap) + 0.5) / f64::from(taps) - 0.5;
        let (offset, weight) = if tent {
            (2.0 * offset, 1.0 - 2.0 * offset.abs())
        } else {
            (offset, 1.0)
        };
        let position = centre + offset * extent;
        let (first, fraction) = (position.floor(), position - position.floor());
        *weights.entry(first as i64).or_insert(0.0) += weight * (1.0 - fraction);
        *weights.entry(first as i64 + 1).or_insert(0.0) += weight * fraction;
    }
    let total: f64 = weights.values().sum();
    weights.values_mut().for_each(|weight| *weight /= total);
    weights
}
