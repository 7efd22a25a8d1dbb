//! Textures without a wavelet: the texture unit reads what the CPU decodes.

use bevy_frugal_lab::content;
use bevy_wavelet_tex::{
    WaveletAddressMode, WaveletExtension, WaveletFilter, WaveletStorage,
    codec::{
        color::srgb_from_linear,
        image::{Content, WaveletImage},
        rate::Rate,
        settings::{EncodeSettings, Formats},
    },
};

use super::{
    driver::Driver,
    modes::{encoded, worst},
    scene::STEP,
    viewer::{Viewer, WHOLE},
};
use crate::support::gpu;

/// All formats, at full size, padded to whole blocks, and smaller.
fn images(size: [u32; 2]) -> Vec<(String, WaveletImage)> {
    let picture = content::photo_like(size[0], size[1], 7);
    let normals = content::bricks(size[0], size[1], 3).normal;
    let mut images = Vec::new();
    for rate in Rate::ALL {
        for alpha in [false, true] {
            let content = rate.content(alpha);
            if alpha && content != Content::ColorAlpha {
                continue;
            }
            let settings = EncodeSettings {
                rate,
                alpha,
                mips: false,
                formats: Formats::Plain,
                ..EncodeSettings::default()
            };
            let source = match content {
                Content::Normal => &normals,
                _ => &picture,
            };
            let image = encoded(source, &settings);
            let name = format!("{}, {}, {size:?}", rate.name(), image.storage_name());
            images.push((name, image));
        }
    }
    images
}

#[test]
fn nearest_is_the_decoded_pixel_in_every_format() {
    let _gpu = gpu();
    let driver = Driver::new();
    let mut formats = std::collections::BTreeSet::new();
    let (mut scaled, mut padded) = (0, 0);
    for size in [[96, 64], [93, 61]] {
        let mut viewer = Viewer::new(size);
        for (name, image) in images(size) {
            let extension = WaveletExtension {
                filter: WaveletFilter::Nearest,
                ..Default::default()
            };
            let plain = image.plain.as_ref().expect("plain");
            formats.insert(plain.format.name());
            let is_scaled = plain.is_scaled(size);
            scaled += u32::from(is_scaled);
            padded += u32::from(plain.is_padded(size));
            let shown = viewer.show(&image, WaveletStorage::Blocks, extension, WHOLE);
            let (steps, _) = worst(&image, &shown, &driver);
            println!("{name}: {steps:.3} steps");
            // lavapipe's texture unit interpolates with 8 bits, which adds a level of what is stored:
            // two steps of a normal, which is stored as 0.5 + 0.5 n.
            let level = if image.content == Content::Normal {
                2.0
            } else {
                1.0
            };
            let most = if is_scaled { 1.0 + level } else { 1.0 };
            assert!(steps <= most, "{name}: {steps} steps");
            let mean = shown.pixels.iter().map(|p| p[0] + p[1] + p[2]).sum::<f32>();
            assert!(mean > 0.1, "{name}: nothing is shown");
        }
    }
    assert!(formats.into_iter().eq(["bc1", "bc4", "bc5", "bc7"]));
    assert!(scaled > 10 && padded > 3, "{scaled} {padded}");
}

#[test]
fn every_filter_and_address_mode_shows_one_colour_as_it_is() {
    let _gpu = gpu();
    let size = [64, 64];
    let color = [200u8, 90, 31];
    let flat = image::RgbImage::from_pixel(size[0], size[1], image::Rgb(color));
    let mut viewer = Viewer::new([24, 16]);
    for rate in [Rate::Color2_25, Rate::Color8] {
        let settings = EncodeSettings {
            rate,
            formats: Formats::Plain,
            ..EncodeSettings::default()
        };
        let image = super::scene::encoded_with(&flat, &settings);
        assert!(image.plain.is_some() && image.levels > 4);
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
                let view = [bevy::math::Vec2::splat(-0.4), bevy::math::Vec2::splat(3.0)];
                let shown = viewer.show(&image, WaveletStorage::Blocks, extension, view);
                for pixel in &shown.pixels {
                    for (shown, wanted) in pixel.iter().zip(color) {
                        let off = (srgb_from_linear(*shown) - f32::from(wanted) * STEP).abs();
                        // BC1 has 5 bits for red and blue.
                        assert!(off <= 4.5 * STEP, "{rate:?} {filter:?}: {pixel:?}");
                    }
                }
            }
        }
    }
}
