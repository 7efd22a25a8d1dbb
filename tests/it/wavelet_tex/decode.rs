//! The shader decodes as the reference does, then filters: textures of every content, rate, method and format.
//!
//! How interpolated values of BC3 are rounded is left to the driver, so there are images whose texels are the same in
//! every decoder. Lavapipe, for one, makes the end points `a` and `b` bytes (bits repeated) and step `w` of `n`
//! between them `a + ((b - a) * (255 * w / n) >> 8)` in integers: up to 1.7 levels off.

use std::collections::BTreeSet;

use bevy::math::{UVec2, Vec2};
use bevy_frugal_lab::{
    content,
    headless::{HeadlessSettings, Rgba32FImage},
};
use bevy_wavelet_tex::{
    WaveletAddressMode, WaveletExtension, WaveletFilter, WaveletStorage,
    codec::{
        axes::ColorAxes,
        blocks::{BlockFormat, decode_bc3},
        color::srgb_from_linear,
        decoder::{DecodedImage, decode},
        encoder::encode,
        haar::Transform,
        image::{ColorSpace, Content, Payload, PlaneGroup, WaveletImage, WaveletPlanes},
        packing::Packing,
        quantizer::PlaneCoding,
        rate::Rate,
        settings::{EncodeSettings, Formats, Method},
        source::{Pixels, Source},
    },
};
use image::{Rgb, RgbImage};

use super::scene::{
    Difference, Level, STEP, Viewer, WHOLE, app, chroma_rounding, difference, driver_texels,
    encoded, encoded_with, levels, linear, picture,
};
use crate::support::{drawn, gpu};

fn contents() -> [WaveletImage; 3] {
    [
        encoded(&picture(), Content::Gray, ColorSpace::Linear),
        encoded(&picture(), Content::Gray, ColorSpace::Srgb),
        encoded(&picture(), Content::Color, ColorSpace::Srgb),
    ]
}

/// In steps of the 8-bit picture that a display shows.
fn encoded_difference(
    image: &WaveletImage,
    mut shown: Rgba32FImage,
    decoded: &DecodedImage,
) -> Difference {
    if image.color_space == ColorSpace::Srgb {
        let encode = |v: &mut f32| *v = srgb_from_linear(v.max(0.0));
        shown.pixels.iter_mut().flatten().for_each(encode);
    }
    difference(&shown, |x, y| {
        decoded.pixels[(y * decoded.size[0] + x) as usize]
    })
}

fn report(name: &str, image: &WaveletImage, difference: &Difference) {
    difference.report(&format!(
        "{:?} {:?}, {name}",
        image.content, image.color_space
    ));
}

/// Reports a difference, and demands that it is at most this.
fn check(name: &str, image: &WaveletImage, difference: &Difference, most: f32) {
    let name = format!("{:?} {:?}, {name}", image.content, image.color_space);
    difference.check(&name, most);
}

#[test]
fn nearest_equals_the_reference_decoder_within_one_step_at_every_pixel() {
    let Some(mut viewer) = Viewer::new([93, 61]) else {
        return;
    };
    for image in contents() {
        let blocks = viewer.show_blocks(&image, WaveletFilter::Nearest, WHOLE);
        let exact = decode(&image, 0);
        let to_exact = encoded_difference(&image, blocks.clone(), &exact);
        report("blocks, against exact texels", &image, &to_exact);
        let to_drivers = encoded_difference(&image, blocks, &viewer.decoded(&image, 0));
        let most = STEP + chroma_rounding(&image);
        check("blocks, the driver's texels", &image, &to_drivers, most);

        let (storage, filter) = (WaveletStorage::Decoded, WaveletFilter::Nearest);
        let decoded = viewer.show_filtered(&image, storage, filter, WHOLE);
        let decoded = encoded_difference(&image, decoded, &exact);
        check("decoded", &image, &decoded, STEP);
    }
}

#[test]
fn blocks_that_no_driver_rounds_are_within_one_step_of_the_reference_at_every_pixel() {
    let images = exact_images();
    let Some(mut viewer) = Viewer::new(images[0].size) else {
        return;
    };
    for image in images {
        let shown = viewer.show_blocks(&image, WaveletFilter::Nearest, WHOLE);
        let difference = encoded_difference(&image, shown, &decode(&image, 0));
        check("blocks without rounding", &image, &difference, STEP);
    }
}

#[test]
fn bilinear_equals_filtering_the_decoded_image_in_linear_light() {
    // Magnified by 1.7, with a part of the next repetition in view.
    let uv_max = 1.3;
    let target = [93.0, 61.0].map(|s| (s * uv_max * 1.7) as u32);
    let Some(mut viewer) = Viewer::new(target) else {
        return;
    };
    for image in contents() {
        let view = [Vec2::ZERO, Vec2::splat(uv_max)];
        let shown = viewer.show_blocks(&image, WaveletFilter::Bilinear, view);
        let to_filtered = |decoded: DecodedImage| {
            let level = Level::new(&image, decoded);
            difference(&shown, |x, y| {
                let uv = [(x, target[0]), (y, target[1])]
                    .map(|(pixel, pixels)| (pixel as f32 + 0.5) / pixels as f32 * uv_max);
                let filtered = level.bilinear(uv.into(), WaveletAddressMode::Repeat);
                filtered.map(|v| v as f32)
            })
        };
        let to_exact = to_filtered(decode(&image, 0));
        report("bilinear, against exact texels", &image, &to_exact);
        let to_drivers = to_filtered(viewer.decoded(&image, 0));
        let name = "bilinear, the driver's texels";
        check(name, &image, &to_drivers, 2.0 * STEP);
    }
}

#[test]
fn minification_reads_the_mip_that_the_encoder_stored() {
    // Half the width in x, 46 pixels for 93 texels: level 1 is 46 pixels wide.
    let Some(mut viewer) = Viewer::new([46, 30]) else {
        return;
    };
    let image = encoded(&picture(), Content::Color, ColorSpace::Srgb);
    let (size, pixels) = linear(&image, viewer.decoded(&image, 1));
    assert_eq!(size, [46, 30]);
    // 93 / 46 is a little more than 2: trilinear mixes some of level 2 in.
    for (filter, most) in [
        (WaveletFilter::Bilinear, 2.0 * STEP),
        (WaveletFilter::Trilinear, 8.0 * STEP),
    ] {
        let shown = viewer.show_blocks(&image, filter, WHOLE);
        let expected = |x, y| pixels[(y * size[0] + x) as usize];
        let difference = difference(&shown, expected);
        check(&format!("{filter:?} minified"), &image, &difference, most);
    }
}

/// Textures of all these rates and methods, with names.
fn textures(
    size: [u32; 2],
    rates: impl Iterator<Item = Rate>,
    methods: &[Method],
    formats: Formats,
) -> Vec<(String, WaveletImage)> {
    let picture = content::photo_like(size[0], size[1], 7);
    let normals = content::bricks(size[0], size[1], 3).normal;
    let mut textures = Vec::new();
    for rate in rates {
        for (&method, alpha) in methods.iter().flat_map(|m| [(m, false), (m, true)]) {
            let content = rate.content(alpha);
            if alpha && content != Content::ColorAlpha {
                continue;
            }
            let settings = EncodeSettings {
                rate,
                alpha,
                method,
                mips: false,
                formats,
                ..EncodeSettings::default()
            };
            let source = match content {
                Content::Normal => &normals,
                _ => &picture,
            };
            let image = encoded_with_alpha(source, &settings);
            let storage = image.storage_name();
            let name = format!("{} {method:?}, alpha {alpha}, {storage}", rate.name());
            textures.push((name, image));
        }
    }
    textures
}

/// With an alpha channel that has edges and slopes.
fn encoded_with_alpha(picture: &RgbImage, settings: &EncodeSettings) -> WaveletImage {
    let with_alpha = |(x, y, p): (u32, u32, &Rgb<u8>)| {
        let alpha = match (x / 16 + y / 16) % 2 {
            0 => 255,
            _ => (x * 2 + y) % 256,
        };
        [p[0], p[1], p[2], alpha as u8]
    };
    let pixels: Vec<[u8; 4]> = picture.enumerate_pixels().map(with_alpha).collect();
    let source = Source::new(picture.dimensions().into(), Pixels::Rgba8(&pixels));
    encode(&source, settings, &|_, _| {}).expect("a good image")
}

/// Wavelets of 93 x 61 pixels in every way to store them.
pub fn wavelet_textures() -> Vec<(String, WaveletImage)> {
    let rates = Rate::ALL.into_iter().filter(|rate| rate.wavelet() == *rate);
    let methods = [Method::Best, Method::OneFetch, Method::Thesis];
    textures([93, 61], rates, &methods, Formats::Wavelet)
}

/// The largest difference in steps of an 8-bit picture from the driver's texels, decoded.
fn worst_steps(image: &WaveletImage, shown: &Rgba32FImage, viewer: &Viewer) -> f32 {
    let decoded = viewer.decoded(image, 0);
    let mut worst = 0.0f32;
    for (i, shown) in shown.pixels.iter().enumerate() {
        // The target holds colour times alpha.
        let alpha = decoded.alpha.as_ref().map_or(1.0, |a| a[i]);
        for (shown, expected) in shown.iter().zip(decoded.pixels[i]) {
            let value = match image.content {
                Content::Normal => *shown,
                _ if alpha < 0.25 => continue,
                _ => srgb_from_linear((shown / alpha).max(0.0)),
            };
            // Nothing shows a negative colour.
            let expected = match image.content {
                Content::Normal => expected.max(0.0),
                _ => expected,
            };
            worst = worst.max((value.max(0.0) - expected).abs());
        }
    }
    worst / STEP
}

/// Demands that nearest pixels are at most so many steps off, and that they are seen.
fn check_nearest(
    viewer: &mut Viewer,
    name: &str,
    image: &WaveletImage,
    storage: WaveletStorage,
    most: f32,
) {
    let shown = viewer.show_filtered(image, storage, WaveletFilter::Nearest, WHOLE);
    let steps = worst_steps(image, &shown, viewer);
    println!("{name}, {storage:?}: {steps:.3} steps of {most:.2}");
    assert!(steps <= most, "{name}, {storage:?}: {steps} steps");
    let mean = shown.pixels.iter().map(|p| p[0] + p[1] + p[2]).sum::<f32>();
    assert!(mean > 0.1, "{name}: nothing is shown");
}

#[test]
fn nearest_is_the_decoded_pixel_in_every_mode() {
    let Some(mut viewer) = Viewer::new([93, 61]) else {
        return;
    };
    let mut packings = BTreeSet::new();
    let textures = wavelet_textures();
    for (name, image) in &textures {
        packings.extend(image.groups().map(|g| g.packing.name()));
        let most = 1.0 + chroma_rounding(image) / STEP;
        check_nearest(&mut viewer, name, image, WaveletStorage::Blocks, most);
    }
    for (name, image) in drawn(2, &textures) {
        // The driver's texels are up to 1.7 levels off, of which a pixel adds several.
        check_nearest(&mut viewer, name, image, WaveletStorage::Decoded, 2.7);
    }
    let all: Vec<_> = Packing::ALL.iter().map(|p| p.name()).collect();
    assert!(
        all.iter().all(|name| packings.contains(name)),
        "{packings:?}"
    );
}

#[test]
fn nearest_is_the_decoded_pixel_in_every_plain_format() {
    let mut formats = BTreeSet::new();
    let (mut scaled, mut padded) = (0, 0);
    for size in [[96, 64], [93, 61]] {
        let mut viewer = Viewer::with_settings(gpu(), size, HeadlessSettings::default());
        let images = textures(size, Rate::ALL.into_iter(), &[Method::Best], Formats::Plain);
        for (name, image) in images {
            let plain = image.plain().expect("plain");
            formats.insert(plain.format.name());
            let is_scaled = plain.is_scaled(size);
            scaled += u32::from(is_scaled);
            padded += u32::from(plain.is_padded(size));
            // lavapipe's texture unit interpolates with 8 bits, which adds a level of what is stored:
            // two steps of a normal, which is stored as 0.5 + 0.5 n.
            let most = match (is_scaled, image.content) {
                (true, Content::Normal) => 3.0,
                (true, _) => 2.0,
                (false, _) => 1.0,
            };
            check_nearest(&mut viewer, &name, &image, WaveletStorage::Blocks, most);
        }
    }
    assert!(formats.into_iter().eq(["bc1", "bc4", "bc5", "bc7"]));
    assert!(scaled > 10 && padded > 3, "{scaled} {padded}");
}

#[test]
fn every_filter_and_address_mode_shows_one_colour_as_it_is() {
    let color = [200u8, 90, 31];
    let flat = RgbImage::from_pixel(64, 64, Rgb(color));
    let mut viewer = Viewer::with_settings(gpu(), [24, 16], HeadlessSettings::default());
    for rate in drawn(1, [Rate::Color2_25, Rate::Color8]) {
        let settings = EncodeSettings {
            rate,
            formats: Formats::Plain,
            ..EncodeSettings::default()
        };
        let image = encoded_with(&flat, &settings);
        assert!(image.plain().is_some() && image.levels > 4);
        for filter in [
            WaveletFilter::Nearest,
            WaveletFilter::NearestMipLinear,
            WaveletFilter::Bilinear,
            WaveletFilter::Trilinear,
            WaveletFilter::Anisotropic,
            WaveletFilter::Stochastic,
            WaveletFilter::StochasticQuad,
        ] {
            for address_mode in [WaveletAddressMode::Repeat, WaveletAddressMode::ClampToEdge] {
                let extension = WaveletExtension {
                    filter,
                    address_mode,
                    ..Default::default()
                };
                let view = [Vec2::splat(-0.4), Vec2::splat(3.0)];
                let shown = viewer.show(&image, WaveletStorage::Blocks, extension, view);
                for pixel in &shown.pixels {
                    for (shown, expected) in pixel.iter().zip(color) {
                        let off = (srgb_from_linear(*shown) - f32::from(expected) * STEP).abs();
                        // BC1 has 5 bits for red and blue.
                        assert!(off <= 4.5 * STEP, "{rate:?} {filter:?}: {pixel:?}");
                    }
                }
            }
        }
    }
}

const TARGET: [u32; 2] = [64, 48];

const ADDRESS_MODES: [WaveletAddressMode; 3] = [
    WaveletAddressMode::Repeat,
    WaveletAddressMode::ClampToEdge,
    WaveletAddressMode::MirrorRepeat,
];

/// Demands that the bilinear filter is that of the reference in a view that is `extent` uv wide and high: four
/// neighbouring pixels are decoded together, inside of a texture, at its edges and across them.
fn check_bilinear(
    viewer: &mut Viewer,
    name: &str,
    image: &WaveletImage,
    address_mode: WaveletAddressMode,
    [origin, extent]: [Vec2; 2],
) {
    let extension = WaveletExtension {
        filter: WaveletFilter::Bilinear,
        address_mode,
        ..Default::default()
    };
    let mut shown = viewer.show(image, WaveletStorage::Blocks, extension, [origin, extent]);
    // A target of colours shows no negative ones.
    for value in shown.pixels.iter_mut().flatten() {
        *value = value.max(0.0);
    }
    let levels = levels(image, |level| viewer.decoded(image, level));
    let difference = difference(&shown, |x, y| {
        let target = UVec2::from(TARGET).as_vec2();
        let uv = origin + (Vec2::new(x as f32, y as f32) + 0.5) / target * extent;
        levels[0]
            .bilinear(uv, address_mode)
            .map(|v| v.max(0.0) as f32)
    });
    let steps = difference.steps();
    println!("{name}, {address_mode:?}: {steps:.3} steps");
    let most = 2.0 + chroma_rounding(image) / STEP;
    assert!(steps <= most, "{name}, {address_mode:?}: {steps} steps");
}

#[test]
fn every_form_of_a_texture_is_bilinear_across_its_edges() {
    let Some(mut viewer) = Viewer::new(TARGET) else {
        return;
    };
    let views = [
        [Vec2::new(-0.17, -0.11), Vec2::new(0.35, 0.3)],
        [Vec2::new(0.87, 0.81), Vec2::new(0.33, 0.36)],
        [Vec2::new(0.31, 0.77), Vec2::new(0.4, 0.5)],
    ];
    // What is blended with the background is in the test of modes.
    let opaque = |(_, image): &(_, WaveletImage)| image.content != Content::ColorAlpha;
    let textures = wavelet_textures().into_iter().filter(opaque);
    for (i, (name, image)) in drawn(2, textures.enumerate()) {
        let view = views[i / 3 % 3];
        check_bilinear(&mut viewer, &name, &image, ADDRESS_MODES[i % 3], view);
    }
}

#[test]
fn every_small_and_odd_size_is_bilinear_across_its_edges() {
    let Some(mut viewer) = Viewer::new(TARGET) else {
        return;
    };
    let sizes = [[1, 1], [2, 1], [1, 3], [3, 5], [4, 6], [7, 8]];
    let formats = [
        (Method::Best, Rate::Gray2, Formats::Wavelet),
        (Method::Best, Rate::Color2_25, Formats::Wavelet),
        (Method::OneFetch, Rate::Gray3, Formats::Wavelet),
        (Method::Best, Rate::Color8, Formats::Plain),
        (Method::Best, Rate::Gray4, Formats::Plain),
        (Method::Best, Rate::Normal8, Formats::Plain),
    ];
    for (i, size) in drawn(1, sizes.into_iter().enumerate()) {
        for (j, (method, rate, formats)) in formats.into_iter().enumerate() {
            let settings = EncodeSettings {
                rate,
                method,
                color_space: match rate {
                    Rate::Gray2 | Rate::Gray3 => ColorSpace::Linear,
                    _ => ColorSpace::Srgb,
                },
                mips: false,
                formats,
                ..EncodeSettings::default()
            };
            let image = encoded_with(&content::photo_like(size[0], size[1], 7), &settings);
            let is_padded = image.plain().is_some_and(|p| p.is_padded(size));
            assert_eq!(formats == Formats::Plain, is_padded);
            // Each size in each address mode, and each format as well.
            let address = ADDRESS_MODES[(i + j) % 3];
            let view = [Vec2::new(-0.4, -0.3), Vec2::new(1.9, 1.7)];
            let name = format!("{size:?} {}", rate.name());
            check_bilinear(&mut viewer, &name, &image, address, view);
        }
    }
}

fn decoded_by_the_driver(blocks: &[u8], size: [u32; 2]) -> Vec<[f32; 4]> {
    let app = app(HeadlessSettings::with_size(16, 16));
    driver_texels(&app, BlockFormat::Bc3, blocks, size)
}

/// The block whose texels are all end point `index`, 0 or 1.
fn with_all_indices(block: &[u8; 16], index: u64) -> [u8; 16] {
    let mut block = *block;
    block[2..8].copy_from_slice(&(index * 0x2492_4924_9249).to_le_bytes()[..6]);
    block[12..].copy_from_slice(&(index as u32 * 0x5555_5555).to_le_bytes());
    block
}

/// Blocks with every bit pattern equally likely.
fn random_blocks(count: usize) -> Vec<[u8; 16]> {
    let mut state = 1u64;
    let mut next = || {
        // SplitMix64.
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    let mut block = || bytemuck::cast([next(), next()]);
    (0..count).map(|_| block()).collect()
}

#[test]
fn the_driver_decodes_blocks_within_its_freedom_to_round() {
    let _gpu = gpu();
    let blocks = random_blocks(64 * 64);
    let size = [256, 256];
    let driver = decoded_by_the_driver(blocks.as_flattened(), size);
    let exact = decode_bc3(blocks.as_flattened(), size);
    let [end_0, end_1] = [0, 1].map(|index| {
        let all = |block: &[u8; 16]| with_all_indices(block, index);
        decode_bc3(&blocks.iter().flat_map(all).collect::<Vec<_>>(), size)
    });
    let mut worst = [0.0f32; 4];
    for texel in 0..exact.len() {
        for (channel, worst) in worst.iter_mut().enumerate() {
            let of = |texels: &[[f32; 4]]| texels[texel][channel];
            let difference = (of(&driver) - of(&exact)).abs();
            *worst = worst.max(difference * 255.0);
            // Vulkan gives no bound. Direct3D 11 allows one level and 3 % of the way between the end
            // points; half a level is for end points made bytes before they are mixed.
            let tolerance = 1.5 / 255.0 + 0.03 * (of(&end_0) - of(&end_1)).abs();
            assert!(
                difference <= tolerance,
                "texel {texel}, channel {channel}: {difference}"
            );
        }
    }
    println!("levels off in R, G, B, A: {worst:.3?}");
}

const SIZE: [u32; 2] = [64, 40];

/// Nothing in the block is interpolated. Alpha has 8 bits at its end points; 5:6:5 colours are whole bytes at 0 and 31
/// of 31, and at 0, 21, 42 and 63 of 63.
fn without_rounding(mut block: [u8; 16]) -> [u8; 16] {
    for end in [8, 10] {
        let bits = u16::from_le_bytes([block[end], block[end + 1]]);
        let [red, blue] = [bits >> 11 & 1, bits & 1].map(|on| on * 31);
        let green = (bits >> 5 & 3) * 21;
        let color = red << 11 | green << 5 | blue;
        block[end..end + 2].copy_from_slice(&color.to_le_bytes());
    }
    // Indices 0 and 1 only: the lowest of the 3 bits of alpha and of the 2 bits of colour.
    for (indices, lowest) in [(2..8, 0x2492_4924_9249u64), (12..16, 0x5555_5555)] {
        for (byte, mask) in block[indices].iter_mut().zip(lowest.to_le_bytes()) {
            *byte &= mask;
        }
    }
    block
}

/// Gray and colour of every storable detail and mean, in YCoCg and along other axes; chroma in wavelets, as the thesis
/// has it.
fn exact_images() -> Vec<WaveletImage> {
    let coding = |mean: [f32; 2], range, gamma, w| PlaneCoding {
        range,
        gamma,
        transform: Transform::PartiallyInvertedHaar { w },
        ..PlaneCoding::linear(mean)
    };
    let luma = PlaneCoding {
        predictor: 0.16,
        ..coding([0.1, 0.9], 0.1, 0.8, 0.6)
    };
    let [co, cg] = [-0.3, -0.2].map(|min| coding([min, 0.25], 0.05, 0.7, 0.4));
    let group = |subsampling, codings: Vec<PlaneCoding>| {
        let mut group = PlaneGroup {
            subsampling,
            packing: Packing::Bc3,
            codings,
            textures: Vec::new(),
        };
        let [width, height] = group.texture_size(SIZE);
        let blocks = random_blocks(group.layers() * (width * height / 16) as usize);
        let blocks = blocks.into_iter().flat_map(without_rounding);
        group.textures.push(blocks.collect());
        group
    };
    let image = |content: Content, color_space, axes| WaveletImage {
        content,
        color_space,
        size: SIZE,
        levels: 1,
        payload: Payload::Wavelet(WaveletPlanes {
            axes,
            luma: group(0, vec![luma]),
            chroma: content.has_chroma().then(|| group(1, vec![co, cg])),
        }),
    };
    let fitted = ColorAxes {
        rgb: [[0.9, 1.1, 0.8], [0.6, -0.3, -0.4], [-0.2, 0.5, -0.7]],
    };
    vec![
        image(Content::Gray, ColorSpace::Linear, ColorAxes::YCOCG),
        image(Content::Gray, ColorSpace::Srgb, ColorAxes::YCOCG),
        image(Content::Color, ColorSpace::Srgb, ColorAxes::YCOCG),
        image(Content::Color, ColorSpace::Srgb, fitted),
    ]
}

#[test]
fn the_driver_decodes_blocks_without_interpolation_exactly() {
    let _gpu = gpu();
    let blocks = random_blocks(256).into_iter().flat_map(without_rounding);
    let blocks: Vec<u8> = blocks.collect();
    let driver = decoded_by_the_driver(&blocks, [64, 64]);
    for (driver, exact) in driver.iter().zip(decode_bc3(&blocks, [64, 64])) {
        for (a, b) in driver.iter().zip(exact) {
            assert!((a - b).abs() < 1e-6, "{a} is not {b}");
        }
    }
}
