//! Every filter and address mode, magnified and minified, against the same in f64 over decoded mips; the mean of
//! stochastic filters and their noise with and without temporal anti-aliasing; and all of them in a shader of a user's own.

use bevy::{anti_alias::taa::TemporalAntiAliasing, prelude::*, shader::ShaderDefVal};
use bevy_frugal_lab::{content, headless::HeadlessSettings};
use bevy_wavelet_tex::{
    WaveletAddressMode, WaveletExtension, WaveletFilter, WaveletStorage,
    codec::{
        decoder::decode,
        image::{ColorSpace, WaveletImage},
        rate::Rate,
        settings::{EncodeSettings, Formats},
    },
};
use image::RgbImage;

use super::scene::{
    Level, STEP, Viewer, anisotropic, app, chroma_rounding, colors, difference, encoded_with,
    exact_mips, levels, mix, picture, psnr_of_units as psnr, supersampled, trilinear, wavelets,
};
use crate::support::{composer, drawn, gpu};

const TARGET: [u32; 2] = [64, 48];

/// Width and height of the target, in pixels.
const EXTENT: Vec2 = Vec2::new(TARGET[0] as f32, TARGET[1] as f32);

fn coded(picture: &RgbImage, rate: Rate, color_space: ColorSpace) -> WaveletImage {
    encoded_with(picture, &wavelets(rate, color_space))
}

/// What a filter has at the pixels of the target, row by row.
fn filtered(view: [Vec2; 2], filter: impl Fn(Vec2) -> [f64; 3]) -> Vec<[f64; 3]> {
    let positions = (0..TARGET[1]).flat_map(|y| (0..TARGET[0]).map(move |x| (x, y)));
    let pixels = positions.map(|(x, y)| filter(uv_at(x, y, view)));
    pixels.collect()
}

/// The centre of a target's pixel in uv.
fn uv_at(x: u32, y: u32, [origin, extent]: [Vec2; 2]) -> Vec2 {
    origin + (Vec2::new(x as f32, y as f32) + 0.5) / EXTENT * extent
}

/// Level of detail where `extent` uv cover the target.
fn level_of_detail(image: &WaveletImage, extent: Vec2) -> f64 {
    let pixels = |axis: usize| {
        f64::from(extent[axis]) * f64::from(image.size[axis]) / f64::from(TARGET[axis])
    };
    let lod = pixels(0).max(pixels(1)).log2();
    lod.clamp(0.0, f64::from(image.levels - 1))
}

fn expected(
    filter: WaveletFilter,
    levels: &[Level],
    uv: Vec2,
    lod: f64,
    mode: WaveletAddressMode,
) -> [f64; 3] {
    let fine = lod.floor() as usize;
    let coarse = (fine + 1).min(levels.len() - 1);
    let nearest_level = &levels[lod.round() as usize];
    match filter {
        WaveletFilter::Nearest => nearest_level.nearest(uv, mode),
        WaveletFilter::Bilinear => nearest_level.bilinear(uv, mode),
        WaveletFilter::NearestMipLinear => {
            let of_level = |level: usize| levels[level].nearest(uv, mode);
            mix(of_level(fine), of_level(coarse), lod.fract())
        }
        _ => trilinear(levels, uv, lod, mode),
    }
}

#[test]
fn every_filter_and_address_mode_is_that_of_the_decoded_image() {
    let Some(mut viewer) = Viewer::new(TARGET) else {
        return;
    };
    let settings = EncodeSettings {
        rate: Rate::Color8,
        formats: Formats::Plain,
        ..EncodeSettings::default()
    };
    let padded = encoded_with(&picture(), &settings);
    let plain = padded.plain();
    assert!(plain.is_some_and(|p| p.is_padded(padded.size)));
    let images = [
        ("gray2", coded(&picture(), Rate::Gray2, ColorSpace::Linear)),
        ("gray3", coded(&picture(), Rate::Gray3, ColorSpace::Srgb)),
        ("color3", coded(&picture(), Rate::Color3, ColorSpace::Srgb)),
        ("color5", coded(&picture(), Rate::Color5, ColorSpace::Srgb)),
        ("padded", padded),
    ];
    // Magnified across an edge, and minified to between two levels.
    let views = [
        [Vec2::new(-0.17, 0.63), Vec2::new(0.53, 0.61)],
        [Vec2::new(-0.3, -0.2), Vec2::new(1.9, 2.1)],
    ];
    for (name, image) in &drawn(2, images) {
        let levels = levels(image, |level| viewer.decoded(image, level));
        for (mode, filter, view) in [
            (WaveletAddressMode::Repeat, WaveletFilter::Nearest, 0),
            (WaveletAddressMode::MirrorRepeat, WaveletFilter::Bilinear, 0),
            (WaveletAddressMode::ClampToEdge, WaveletFilter::Bilinear, 1),
            (
                WaveletAddressMode::MirrorRepeat,
                WaveletFilter::NearestMipLinear,
                1,
            ),
            (WaveletAddressMode::ClampToEdge, WaveletFilter::Trilinear, 0),
            (WaveletAddressMode::Repeat, WaveletFilter::Trilinear, 1),
        ] {
            let view = views[view];
            let extension = WaveletExtension {
                filter,
                address_mode: mode,
                ..Default::default()
            };
            let shown = viewer.show(image, WaveletStorage::Blocks, extension, view);
            let lod = level_of_detail(image, view[1]);
            let nearest = [WaveletFilter::Nearest, WaveletFilter::NearestMipLinear];
            let nearest = nearest.contains(&filter);
            let borderline = std::cell::Cell::new(0);
            let difference = difference(&shown, |x, y| {
                let uv = uv_at(x, y, view);
                let value = |uv| expected(filter, &levels, uv, lod, mode).map(|v| v as f32);
                let expected = value(uv);
                // Between two pixels either may be the nearest.
                let beside = [-1.0, 1.0].map(|d| uv + Vec2::splat(d * 2e-5));
                let ambiguous = nearest && beside.iter().any(|uv| value(*uv) != expected);
                if ambiguous {
                    borderline.set(borderline.get() + 1);
                    let shown = shown.pixels[(y * TARGET[0] + x) as usize];
                    return [shown[0], shown[1], shown[2]];
                }
                expected
            });
            let borderline = borderline.get();
            let name = format!("{name} {filter:?} {mode:?} lod {lod:.2}");
            println!("{name}: {borderline} borderline");
            assert!(borderline < 200, "{name}: {borderline} of 3072");
            difference.check(&name, 2.0 * STEP + chroma_rounding(image));
        }
    }
}

/// Pixels of the texture of 256 x 256 for one of the target, in x and y, at which anisotropic filters are measured.
const FOOTPRINTS: [[f32; 2]; 3] = [[2.0, 8.0], [3.0, 6.0], [2.5, 20.0]];

fn view(pixels: [f32; 2]) -> [Vec2; 2] {
    [Vec2::new(0.013, 0.027), Vec2::from(pixels) * EXTENT / 256.0]
}

#[test]
fn anisotropic_minification_is_that_of_the_reference() {
    let Some(mut viewer) = Viewer::new(TARGET) else {
        return;
    };
    let picture = content::photo_like(256, 256, 5);
    for (rate, color_space) in [
        (Rate::Gray2, ColorSpace::Linear),
        (Rate::Color3, ColorSpace::Srgb),
    ] {
        let image = coded(&picture, rate, color_space);
        let levels = levels(&image, |level| viewer.decoded(&image, level));
        // The last is longer than the most samples reach.
        for pixels in FOOTPRINTS.into_iter().chain([[2.0, 60.0]]) {
            let view = view(pixels);
            let shown = viewer.show_blocks(&image, WaveletFilter::Anisotropic, view);
            let difference = difference(&shown, |x, y| {
                let mode = WaveletAddressMode::Repeat;
                let expected = anisotropic(&levels, uv_at(x, y, view), view[1] / EXTENT, mode);
                expected.map(|value| value as f32)
            });
            let name = format!("{} {pixels:?}", rate.name());
            difference.check(&name, 2.0 * STEP + chroma_rounding(&image));
        }
    }
}

#[test]
fn coordinates_that_jump_have_finite_values() {
    let Some(mut viewer) = Viewer::new(TARGET) else {
        return;
    };
    let image = coded(&picture(), Rate::Color3, ColorSpace::Srgb);
    for filter in [
        WaveletFilter::Trilinear,
        WaveletFilter::Anisotropic,
        WaveletFilter::Stochastic,
        WaveletFilter::StochasticQuad,
    ] {
        // The squares of these derivatives are infinite.
        let view = [Vec2::ZERO, Vec2::splat(1e30)];
        let shown = viewer.show_blocks(&image, filter, view);
        let values = shown.pixels.iter().flatten();
        let right = values.filter(|value| (0.0..=1.0).contains(*value)).count();
        assert_eq!(right, 4 * shown.pixels.len(), "{filter:?}");
        let mean = shown.pixels.iter().map(|p| p[1]).sum::<f32>() / shown.pixels.len() as f32;
        assert!(mean > 0.02, "{filter:?}: {mean}");
    }
}

/// What is left in the test after this one are the errors of the mips, which are coded each on its own.
#[test]
fn the_anisotropic_filter_of_mips_without_coding_errors_is_right() {
    let picture = content::photo_like(256, 256, 5);
    for (rate, color_space) in [
        (Rate::Gray2, ColorSpace::Linear),
        (Rate::Color2_25, ColorSpace::Srgb),
        (Rate::Color3, ColorSpace::Srgb),
        (Rate::Color5, ColorSpace::Srgb),
    ] {
        let image = coded(&picture, rate, color_space);
        let mut decoded = levels(&image, |level| decode(&image, level));
        let coarser = decoded.split_off(1);
        let exact = exact_mips(decoded.remove(0));
        for pixels in FOOTPRINTS {
            let view = view(pixels);
            let extent = view[1] / EXTENT;
            let tent = filtered(view, |uv| supersampled(&exact[0], uv, extent, 40, true));
            let mode = WaveletAddressMode::Repeat;
            let ours = filtered(view, |uv| anisotropic(&exact, uv, extent, mode));
            let ours = psnr(&ours, &tent);
            let mip = psnr_of_levels(&coarser[0], &exact[1]);
            let name = rate.name();
            println!("{name} {pixels:?}: {ours:.1} dB; mip 1 itself {mip:.1} dB");
            assert!(ours > 40.0, "{name} {pixels:?}: {ours} dB");
        }
    }
}

#[test]
fn anisotropic_minification_is_near_a_supersampled_picture() {
    let Some(mut viewer) = Viewer::new(TARGET) else {
        return;
    };
    let picture = content::photo_like(256, 256, 5);
    let mut missed = Vec::new();
    let rows = [
        (Rate::Gray2, ColorSpace::Linear),
        (Rate::Gray3, ColorSpace::Linear),
        (Rate::Color3, ColorSpace::Linear),
        (Rate::Gray2, ColorSpace::Srgb),
        (Rate::Color2_25, ColorSpace::Srgb),
        (Rate::Color3, ColorSpace::Srgb),
    ];
    for (rate, color_space) in drawn(1, rows) {
        let image = coded(&picture, rate, color_space);
        let levels = levels(&image, |level| viewer.decoded(&image, level));
        for pixels in FOOTPRINTS {
            let view = view(pixels);
            let mut show =
                |filter, storage| colors(&viewer.show_filtered(&image, storage, filter, view));
            let extent = view[1] / EXTENT;
            let [boxed, tent] = [false, true]
                .map(|tent| filtered(view, |uv| supersampled(&levels[0], uv, extent, 40, tent)));
            let ours = show(WaveletFilter::Anisotropic, WaveletStorage::Blocks);
            let native = show(WaveletFilter::Anisotropic, WaveletStorage::Decoded);
            let plain = show(WaveletFilter::Trilinear, WaveletStorage::Blocks);
            println!(
                "{} {pixels:?}: {:.1} dB to the texture unit's own filter; to a tent {:.1} dB \
                 (texture unit {:.1}, trilinear {:.1}), to a box {:.1} dB (texture unit {:.1})",
                rate.name(),
                psnr(&ours, &native),
                psnr(&ours, &tent),
                psnr(&native, &tent),
                psnr(&plain, &tent),
                psnr(&ours, &boxed),
                psnr(&native, &boxed),
            );
            // Just below what is measured; the texture unit's own filter of the decoded pixels has 31.3 to 37.4.
            let least = match rate {
                Rate::Gray2 => 38.9,
                Rate::Gray3 => 40.8,
                Rate::Color3 => 35.4,
                _ => 32.6,
            };
            let ours = psnr(&ours, &tent);
            if ours < least {
                let name = rate.name();
                missed.push(format!("{name} {pixels:?}: {ours:.1} of {least:.1} dB"));
            }
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}

fn psnr_of_levels(a: &Level, b: &Level) -> f64 {
    let pixels = |level: &Level| {
        let pixels = level.pixels.iter().map(|pixel| pixel.map(f64::from));
        pixels.collect::<Vec<_>>()
    };
    psnr(&pixels(a), &pixels(b))
}

#[test]
fn anisotropic_magnification_is_bilinear() {
    let Some(mut viewer) = Viewer::new(TARGET) else {
        return;
    };
    let picture = content::photo_like(64, 64, 5);
    let image = coded(&picture, Rate::Color3, ColorSpace::Srgb);
    let levels = levels(&image, |level| viewer.decoded(&image, level));
    let view = [Vec2::new(0.2, 0.1), Vec2::new(0.5, 0.4)];
    let shown = viewer.show_blocks(&image, WaveletFilter::Anisotropic, view);
    let difference = difference(&shown, |x, y| {
        let expected = levels[0].bilinear(uv_at(x, y, view), WaveletAddressMode::Repeat);
        expected.map(|v| v as f32)
    });
    difference.check("magnified", 2.0 * STEP + chroma_rounding(&image));
}

/// Frames whose mean is compared.
const FRAMES: usize = 64;

fn colored() -> WaveletImage {
    let picture = content::photo_like(256, 256, 5);
    coded(&picture, Rate::Color3, ColorSpace::Srgb)
}

/// A picture of the viewer's as it is next, in one frame.
fn next(viewer: &mut Viewer) -> Vec<[f64; 3]> {
    colors(&viewer.app.capture_f32().expect("a picture"))
}

/// The texture with so many of its pixels for one of the target.
fn show(
    viewer: &mut Viewer,
    image: &WaveletImage,
    filter: WaveletFilter,
    pixels: [f32; 2],
) -> Vec<[f64; 3]> {
    viewer.show_blocks(image, filter, view(pixels));
    next(viewer)
}

/// The pictures of the next frames.
fn frames(viewer: &mut Viewer, count: usize) -> Vec<Vec<[f64; 3]>> {
    let picture = |_| {
        viewer.app.render_frames(1).expect("a frame");
        next(viewer)
    };
    (0..count).map(picture).collect()
}

fn mean(pictures: &[Vec<[f64; 3]>]) -> Vec<[f64; 3]> {
    let mut sum = vec![[0.0; 3]; pictures[0].len()];
    for picture in pictures {
        for (sum, pixel) in sum.iter_mut().zip(picture) {
            (0..3).for_each(|c| sum[c] += pixel[c] / pictures.len() as f64);
        }
    }
    sum
}

/// Views by pixels of the texture for one of the target, in x and y.
const VIEWS: [(&str, [f32; 2]); 4] = [
    ("magnified", [0.4, 0.3]),
    ("minified", [2.7, 2.7]),
    ("grazing", [1.5, 6.0]),
    ("far", [2.5, 20.0]),
];

#[test]
fn the_mean_of_many_frames_is_the_exact_filter() {
    let Some(mut viewer) = Viewer::new(TARGET) else {
        return;
    };
    let image = colored();
    for (name, pixels) in drawn(2, VIEWS) {
        let exact = show(&mut viewer, &image, WaveletFilter::Anisotropic, pixels);
        for filter in [WaveletFilter::Stochastic, WaveletFilter::StochasticQuad] {
            show(&mut viewer, &image, filter, pixels);
            let frames = frames(&mut viewer, FRAMES);
            let one = psnr(&frames[0], &exact);
            let many = psnr(&mean(&frames), &exact);
            println!(
                "{name}, {filter:?}: one frame {one:.1} dB, the mean of {FRAMES} {many:.1} dB"
            );
            assert!(many > 40.0, "{name}, {filter:?}: {many} dB");
            // Independent frames would gain 18 dB, and the same frame again and again none.
            assert!(
                many > one + 10.0,
                "{name}, {filter:?}: {many} dB from {one} dB"
            );
        }
    }
}

/// Frames before the noise is measured: the history has forgotten how it began.
const WARM_UP: u32 = 48;

/// The noise of a filter: the mean square of what pixels of 16 frames differ from their mean, in dB
/// below white.
fn noise(
    viewer: &mut Viewer,
    image: &WaveletImage,
    filter: WaveletFilter,
    pixels: [f32; 2],
) -> f64 {
    show(viewer, image, filter, pixels);
    viewer.app.render_frames(WARM_UP).expect("frames");
    let frames = frames(viewer, 16);
    let mean = mean(&frames);
    let all: Vec<_> = frames.iter().flatten().copied().collect();
    psnr(&all, &mean.repeat(frames.len()))
}

#[test]
fn temporal_anti_aliasing_averages_the_noise() {
    let Some(mut viewer) = Viewer::new(TARGET) else {
        return;
    };
    let image = colored();
    let filters = [WaveletFilter::Stochastic, WaveletFilter::StochasticQuad];
    let rows = filters.map(|filter| VIEWS[..3].iter().map(move |view| (filter, *view)));
    let rows = drawn(1, rows.into_iter().flatten());
    let without: Vec<_> = rows
        .iter()
        .map(|(filter, (_, pixels))| noise(&mut viewer, &image, *filter, *pixels))
        .collect();
    let world = viewer.app.world_mut();
    let mut cameras = world.query_filtered::<Entity, With<Camera3d>>();
    let camera = cameras.single(world).expect("a camera");
    world
        .entity_mut(camera)
        .insert(TemporalAntiAliasing::default());
    for ((filter, (name, pixels)), without) in rows.into_iter().zip(without) {
        let trilinear = noise(&mut viewer, &image, WaveletFilter::Trilinear, pixels);
        let with = noise(&mut viewer, &image, filter, pixels);
        println!(
            "{name}, {filter:?}: noise {without:.1} dB below white, with temporal anti-aliasing {with:.1} dB (trilinear \
             {trilinear:.1} dB)"
        );
        assert!(with > without + 15.0, "{name}: {with} and {without} dB");
    }
}

const USER: &str = "
import bevy_wavelet_tex::material::sampling::sample;
import bevy_wavelet_tex::material::types::WaveletTexture;

@group(0) @binding(0) var<uniform> texture: WaveletTexture;
@group(0) @binding(1) var luma: texture_2d_array<f32>;
@group(0) @binding(2) var detail: texture_2d_array<f32>;
@group(0) @binding(3) var chroma: texture_2d_array<f32>;
@group(0) @binding(4) var linear_clamp: sampler;
@group(0) @binding(5) var decoded: sampler;

@fragment
fn fragment(@location(0) uv: vec2<f32>) -> @location(0) vec4<f32> {
    return sample(texture, luma, detail, chroma, linear_clamp, decoded, uv, 0.0);
}
";

#[test]
fn the_library_validates_in_a_shader_of_ones_own() {
    let _gpu = gpu();
    let mut app = app(HeadlessSettings::with_size(1, 1));
    let mut composer = composer(&mut app);
    for filter in [
        None,
        Some("WAVELET_FILTER_NEAREST"),
        Some("WAVELET_FILTER_NEAREST_MIP_LINEAR"),
        Some("WAVELET_FILTER_BILINEAR"),
        Some("WAVELET_FILTER_ANISOTROPIC"),
    ] {
        let defs: Vec<ShaderDefVal> = filter.into_iter().map(ShaderDefVal::from).collect();
        let valid = composer.compose_source(USER, &defs);
        assert!(valid.is_ok(), "{filter:?}: {}", valid.unwrap_err());
    }
}
