//! The shader decodes as the reference does, then filters.

use bevy_frugal_lab::headless::{HeadlessSettings, Rgba32FImage};
use bevy_wavelet_tex::{
    WaveletFilter, WaveletStorage,
    codec::{
        color::srgb_from_linear,
        decoder::{DecodedImage, decode},
        image::{ColorSpace, Content, WaveletImage},
    },
};

use super::{
    driver::Driver,
    exact::exact_images,
    modes::chroma_rounding,
    scene::{
        Difference, STEP, add_texture, decoded_by, difference, encoded, gpu_with_all_planes,
        linear, picture, render_quad,
    },
};

fn contents() -> [WaveletImage; 3] {
    [
        encoded(&picture(), Content::Gray, ColorSpace::Linear),
        encoded(&picture(), Content::Gray, ColorSpace::Srgb),
        encoded(&picture(), Content::Color, ColorSpace::Srgb),
    ]
}

fn shown_nearest(image: &WaveletImage, storage: WaveletStorage) -> Rgba32FImage {
    let settings = HeadlessSettings::default();
    render_quad(image.size, 1.0, WaveletFilter::Nearest, settings, |world| {
        add_texture(world, image, storage)
    })
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

fn report(name: &str, image: &WaveletImage, found: &Difference) {
    println!(
        "{:?} {:?}, {name}: {:.3} steps at {:?}, {:.2} % of pixels beyond 1",
        image.content,
        image.color_space,
        found.largest / STEP,
        found.at,
        found.percent_beyond_a_step,
    );
}

#[test]
fn nearest_equals_the_reference_decoder_within_one_step_at_every_pixel() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let driver = Driver::new();
    for image in contents() {
        let blocks = shown_nearest(&image, WaveletStorage::Blocks);
        let exact = decode(&image, 0);
        let found = encoded_difference(&image, blocks.clone(), &exact);
        report("blocks, against exact texels", &image, &found);

        let found = encoded_difference(&image, blocks, &decoded_by(&driver, &image, 0));
        report("blocks, against the driver's texels", &image, &found);
        let most = STEP + chroma_rounding(&image);
        assert!(found.largest <= most, "{:?}", found.at);

        let decoded = shown_nearest(&image, WaveletStorage::Decoded);
        let found = encoded_difference(&image, decoded, &exact);
        report("decoded", &image, &found);
        assert!(found.largest <= STEP, "{:?}", found.at);
    }
}

#[test]
fn blocks_that_no_driver_rounds_are_within_one_step_of_the_reference_at_every_pixel() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    for image in exact_images() {
        let shown = shown_nearest(&image, WaveletStorage::Blocks);
        let found = encoded_difference(&image, shown, &decode(&image, 0));
        report("blocks without rounding", &image, &found);
        assert!(found.largest <= STEP, "{:?}", found.at);
    }
}

#[test]
fn bilinear_equals_filtering_the_decoded_image_in_linear_light() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let driver = Driver::new();
    for image in contents() {
        // Magnified by 1.7, with a part of the next repetition in view.
        let (uv_max, target) = (1.3, image.size.map(|s| (s as f32 * 1.3 * 1.7) as u32));
        let shown = render_quad(
            target,
            uv_max,
            WaveletFilter::Bilinear,
            HeadlessSettings::default(),
            |world| add_texture(world, &image, WaveletStorage::Blocks),
        );
        let filtered_difference = |decoded| {
            let (size, pixels) = linear(&image, decoded);
            difference(&shown, |x, y| {
                let uv = [(x, target[0]), (y, target[1])]
                    .map(|(pixel, pixels)| (pixel as f32 + 0.5) / pixels as f32 * uv_max);
                bilinear_repeated(size, &pixels, uv)
            })
        };
        let found = filtered_difference(decode(&image, 0));
        report("bilinear, against exact texels", &image, &found);
        let found = filtered_difference(decoded_by(&driver, &image, 0));
        report("bilinear, against the driver's texels", &image, &found);
        assert!(found.largest <= 2.0 * STEP, "{:?}", found.at);
    }
}

#[test]
fn minification_reads_the_mip_that_the_encoder_stored() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let image = encoded(&picture(), Content::Color, ColorSpace::Srgb);
    let decoded = decoded_by(&Driver::new(), &image, 1);
    for filter in [WaveletFilter::Bilinear, WaveletFilter::Trilinear] {
        // Half the width in x, 46 pixels for 93 texels: level 1 is 46 pixels wide.
        let (size, pixels) = linear(&image, decoded.clone());
        let shown = render_quad(size, 1.0, filter, HeadlessSettings::default(), |world| {
            add_texture(world, &image, WaveletStorage::Blocks)
        });
        // 93 / 46 is a little more than 2: trilinear mixes some of level 2 in.
        let expected = |x, y| pixels[(y * size[0] + x) as usize];
        let found = difference(&shown, expected);
        report(&format!("{filter:?} minified"), &image, &found);
        let bound = if filter == WaveletFilter::Bilinear {
            2.0
        } else {
            8.0
        };
        assert!(found.largest <= bound * STEP, "{filter:?}: {:?}", found.at);
    }
}

/// Bilinear filtering of a repeated image, in f64.
fn bilinear_repeated(size: [u32; 2], pixels: &[[f32; 3]], uv: [f32; 2]) -> [f32; 3] {
    let place = |axis: usize| {
        let centered = f64::from(uv[axis]) * f64::from(size[axis]) - 0.5;
        let first = centered.floor();
        let wrap = |i: f64| i.rem_euclid(f64::from(size[axis])) as usize;
        ([wrap(first), wrap(first + 1.0)], centered - first)
    };
    let ((xs, wx), (ys, wy)) = (place(0), place(1));
    std::array::from_fn(|channel| {
        let at = |x: usize, y: usize| f64::from(pixels[y * size[0] as usize + x][channel]);
        let row = |y: usize| at(xs[0], y) * (1.0 - wx) + at(xs[1], y) * wx;
        (row(ys[0]) * (1.0 - wy) + row(ys[1]) * wy) as f32
    })
}
