//! The shader decodes as the reference does, then filters.

use bevy_frugal_lab::headless::HeadlessSettings;
use bevy_wavelet_tex::{
    WaveletFilter, WaveletStorage,
    codec::{
        color::srgb_from_linear,
        image::{ColorSpace, Content, WaveletImage},
    },
};

use super::scene::{
    add_texture, decoded_linear, encoded, largest_difference, picture, render_quad,
};
use crate::support::gpu;

/// One 8-bit step.
const STEP: f32 = 1.0 / 255.0;

fn contents() -> [WaveletImage; 3] {
    [
        encoded(&picture(), Content::Gray, ColorSpace::Linear),
        encoded(&picture(), Content::Gray, ColorSpace::Srgb),
        encoded(&picture(), Content::Color, ColorSpace::Srgb),
    ]
}

#[test]
fn nearest_equals_the_reference_decoder_within_one_step_at_every_pixel() {
    let _gpu = gpu();
    for image in contents() {
        for storage in [WaveletStorage::Blocks, WaveletStorage::Decoded] {
            let mut shown = render_quad(
                image.size,
                1.0,
                WaveletFilter::Nearest,
                HeadlessSettings::default(),
                |world| add_texture(world, &image, storage),
            );
            let (size, mut pixels) = decoded_linear(&image, 0);
            if image.color_space == ColorSpace::Srgb {
                // Steps are those of the 8-bit picture that a display shows.
                let encode = |v: &mut f32| *v = srgb_from_linear(v.max(0.0));
                shown.pixels.iter_mut().flatten().for_each(encode);
                pixels.iter_mut().flatten().for_each(encode);
            }
            let expected = |x, y| pixels[(y * size[0] + x) as usize];
            let (difference, at) = largest_difference(&shown, expected);
            println!(
                "{:?} {storage:?}: {:.3} steps at {at:?}",
                image.content,
                difference / STEP
            );
            assert!(
                difference <= STEP,
                "{:?}: {difference} at {at:?}",
                image.content
            );
        }
    }
}

#[test]
fn bilinear_equals_filtering_the_decoded_image_in_linear_light() {
    let _gpu = gpu();
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
        let (size, pixels) = decoded_linear(&image, 0);
        let expected = |x: u32, y: u32| {
            let uv = [(x, target[0]), (y, target[1])]
                .map(|(pixel, pixels)| (pixel as f32 + 0.5) / pixels as f32 * uv_max);
            bilinear_repeated(size, &pixels, uv)
        };
        let (difference, at) = largest_difference(&shown, expected);
        println!(
            "{:?} bilinear: {:.3} steps at {at:?}",
            image.content,
            difference / STEP
        );
        assert!(
            difference <= 2.0 * STEP,
            "{:?}: {difference} at {at:?}",
            image.content
        );
    }
}

#[test]
fn minification_reads_the_mip_that_the_encoder_stored() {
    let _gpu = gpu();
    let image = encoded(&picture(), Content::Color, ColorSpace::Srgb);
    for filter in [WaveletFilter::Bilinear, WaveletFilter::Trilinear] {
        // Half the width in x, 46 pixels for 93 texels: level 1 is 46 pixels wide.
        let (size, pixels) = decoded_linear(&image, 1);
        let shown = render_quad(size, 1.0, filter, HeadlessSettings::default(), |world| {
            add_texture(world, &image, WaveletStorage::Blocks)
        });
        // 93 / 46 is a little more than 2: trilinear mixes some of level 2 in.
        let expected = |x, y| pixels[(y * size[0] + x) as usize];
        let (difference, at) = largest_difference(&shown, expected);
        println!(
            "{filter:?} minified: {:.3} steps at {at:?}",
            difference / STEP
        );
        let bound = if filter == WaveletFilter::Bilinear {
            2.0
        } else {
            8.0
        };
        assert!(
            difference <= bound * STEP,
            "{filter:?}: {difference} at {at:?}"
        );
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
