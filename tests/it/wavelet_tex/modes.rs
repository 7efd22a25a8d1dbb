//! Every way to store a texture, at every pixel: nearest on the GPU is what the CPU decodes.

use bevy_frugal_lab::{content, headless::Rgba32FImage};
use bevy_wavelet_tex::{
    WaveletExtension, WaveletFilter, WaveletStorage,
    codec::{
        color::srgb_from_linear,
        encoder::encode,
        image::{ColorSpace, Content, WaveletImage},
        packing::Packing,
        rate::Rate,
        settings::{Effort, EncodeSettings, Formats, Method},
        source::{Pixels, Source},
    },
};
use image::RgbImage;

use super::{
    driver::Driver,
    scene::{STEP, decoded_by, gpu_with_all_planes, picture},
    viewer::{Viewer, WHOLE},
};

/// With an alpha channel that has edges and slopes.
pub fn encoded(picture: &RgbImage, settings: &EncodeSettings) -> WaveletImage {
    let pixels: Vec<[u8; 4]> = picture
        .enumerate_pixels()
        .map(|(x, y, p)| {
            let alpha = if (x / 16 + y / 16) % 2 == 0 {
                255
            } else {
                (x * 2 + y) % 256
            };
            [p[0], p[1], p[2], alpha as u8]
        })
        .collect();
    let source = Source::new(picture.dimensions().into(), Pixels::Rgba8(&pixels));
    encode(&source, settings, &|_, _| {}).expect("a good image")
}

pub fn modes() -> Vec<(String, WaveletImage)> {
    let picture = picture();
    let normals = content::bricks(93, 61, 3).normal;
    let mut modes = Vec::new();
    for rate in Rate::ALL.into_iter().filter(|rate| rate.wavelet() == *rate) {
        for method in [Method::Best, Method::OneFetch, Method::Thesis] {
            for alpha in [false, true] {
                let content = rate.content(alpha);
                if alpha && content != Content::ColorAlpha {
                    continue;
                }
                let settings = EncodeSettings {
                    rate,
                    alpha,
                    method,
                    color_space: ColorSpace::Srgb,
                    effort: Effort::Default,
                    mips: false,
                    formats: Formats::Wavelet,
                    ..EncodeSettings::default()
                };
                let source = match content {
                    Content::Normal => &normals,
                    _ => &picture,
                };
                let name = format!("{} {method:?}, alpha {alpha}", rate.name());
                modes.push((name, encoded(source, &settings)));
            }
        }
    }
    modes
}

/// What a texture unit that filters with 8 bits, as lavapipe's does, may add: one level of what is
/// stored, in Co and Cg, of which R and B take half each.
pub fn chroma_rounding(image: &WaveletImage) -> f32 {
    let chroma = image.groups.get(1).filter(|g| g.packing == Packing::Bc1);
    let extents = chroma.iter().flat_map(|g| &g.codings);
    0.5 * STEP * extents.map(|c| c.low_max - c.low_min).sum::<f32>()
}

/// The largest difference in steps of an 8-bit picture, and what it may be.
pub fn worst(image: &WaveletImage, shown: &Rgba32FImage, driver: &Driver) -> (f32, f32) {
    let decoded = decoded_by(driver, image, 0);
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
            let expected = if image.content == Content::Normal {
                expected.max(0.0)
            } else {
                expected
            };
            worst = worst.max((value.max(0.0) - expected).abs());
        }
    }
    (worst / STEP, 1.0 + chroma_rounding(image) / STEP)
}

#[test]
fn nearest_is_the_decoded_pixel_in_every_mode() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let driver = Driver::new();
    let mut viewer = Viewer::new([93, 61]);
    let mut packings = std::collections::BTreeSet::new();
    for (name, image) in modes() {
        let extension = WaveletExtension {
            filter: WaveletFilter::Nearest,
            ..Default::default()
        };
        let shown = viewer.show(&image, WaveletStorage::Blocks, extension.clone(), WHOLE);
        let (steps, most) = worst(&image, &shown, &driver);
        packings.extend(image.groups.iter().map(|g| g.packing.name()));
        println!("{name}: {steps:.3} steps of {most:.2}");
        assert!(steps <= most, "{name}: {steps} steps");
        let mean = shown.pixels.iter().map(|p| p[0] + p[1] + p[2]).sum::<f32>();
        assert!(mean > 0.1, "{name}: nothing is shown");

        let decoded = viewer.show(&image, WaveletStorage::Decoded, extension, WHOLE);
        let (steps, _) = worst(&image, &decoded, &driver);
        println!("{name}, decoded on load: {steps:.3} steps");
        // The driver's texels are up to 1.7 levels off, of which a pixel adds several.
        assert!(steps <= 2.7, "{name}, decoded on load: {steps} steps");
    }
    let all: Vec<_> = Packing::ALL.iter().map(|p| p.name()).collect();
    assert!(
        all.iter().all(|name| packings.contains(name)),
        "{packings:?}"
    );
}
