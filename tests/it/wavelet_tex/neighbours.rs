//! Four neighbouring pixels are decoded together: inside of a texture, at its edges and across them, in
//! every form of a texture.

use bevy::math::Vec2;
use bevy_wavelet_tex::{
    WaveletAddressMode, WaveletExtension, WaveletFilter, WaveletStorage,
    codec::{
        image::{ColorSpace, Content, WaveletImage},
        rate::Rate,
        settings::{EncodeSettings, Formats, Method},
    },
};

use super::{
    driver::Driver,
    modes::{chroma_rounding, modes},
    reference::levels,
    scene::{STEP, decoded_by, difference, encoded_with, gpu_with_all_planes},
    viewer::Viewer,
};

const TARGET: [u32; 2] = [64, 48];

const ADDRESS_MODES: [WaveletAddressMode; 3] = [
    WaveletAddressMode::Repeat,
    WaveletAddressMode::ClampToEdge,
    WaveletAddressMode::MirrorRepeat,
];

/// The largest difference in steps between the shader and the reference, in a view that is `extent` uv
/// wide and high.
fn steps(
    viewer: &mut Viewer,
    driver: &Driver,
    image: &WaveletImage,
    address_mode: WaveletAddressMode,
    [origin, extent]: [Vec2; 2],
) -> f32 {
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
    let levels = levels(image, |level| decoded_by(driver, image, level));
    let found = difference(&shown, |x, y| {
        let target = Vec2::new(TARGET[0] as f32, TARGET[1] as f32);
        let uv = origin + (Vec2::new(x as f32, y as f32) + 0.5) / target * extent;
        levels[0]
            .bilinear(uv, address_mode)
            .map(|v| v.max(0.0) as f32)
    });
    found.largest / STEP
}

#[test]
fn every_form_of_a_texture_is_bilinear_across_its_edges() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let driver = Driver::new();
    let mut viewer = Viewer::new(TARGET);
    let views = [
        [Vec2::new(-0.17, -0.11), Vec2::new(0.35, 0.3)],
        [Vec2::new(0.87, 0.81), Vec2::new(0.33, 0.36)],
        [Vec2::new(0.31, 0.77), Vec2::new(0.4, 0.5)],
    ];
    // What is blended with the background is in the test of modes.
    let modes = modes()
        .into_iter()
        .filter(|(_, image)| image.content != Content::ColorAlpha);
    for (i, (name, image)) in modes.enumerate() {
        let address = ADDRESS_MODES[i % 3];
        let view = views[i / 3 % 3];
        let steps = steps(&mut viewer, &driver, &image, address, view);
        println!("{name}, {address:?}: {steps:.3} steps");
        let most = 2.0 + chroma_rounding(&image) / STEP;
        assert!(steps <= most, "{name}, {address:?}: {steps} steps");
    }
}

#[test]
fn every_small_and_odd_size_is_bilinear_across_its_edges() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let driver = Driver::new();
    let mut viewer = Viewer::new(TARGET);
    let sizes = [[1, 1], [2, 1], [1, 3], [3, 5], [4, 6], [7, 8]];
    let formats = [
        (Method::Best, Rate::Gray2, Formats::Wavelet),
        (Method::Best, Rate::Color2_25, Formats::Wavelet),
        (Method::OneFetch, Rate::Gray3, Formats::Wavelet),
        (Method::Best, Rate::Color8, Formats::Plain),
        (Method::Best, Rate::Gray4, Formats::Plain),
        (Method::Best, Rate::Normal8, Formats::Plain),
    ];
    for (i, size) in sizes.into_iter().enumerate() {
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
            let picture = bevy_frugal_lab::content::photo_like(size[0], size[1], 7);
            let image = encoded_with(&picture, &settings);
            let plain = image.plain.as_ref();
            assert_eq!(
                formats == Formats::Plain,
                plain.is_some_and(|p| p.is_padded(size))
            );
            // Each size in each address mode, and each format as well.
            let address = ADDRESS_MODES[(i + j) % 3];
            let view = [Vec2::new(-0.4, -0.3), Vec2::new(1.9, 1.7)];
            let steps = steps(&mut viewer, &driver, &image, address, view);
            let name = format!("{size:?} {} {address:?}", rate.name());
            println!("{name}: {steps:.3} steps");
            let most = 2.0 + chroma_rounding(&image) / STEP;
            assert!(steps <= most, "{name}: {steps} steps");
        }
    }
}
