//! Downsampling of images to a size limit.

use super::{
    color::{linear_from_srgb, srgb_from_linear},
    image::ColorSpace,
    plane::next_mip_of,
    source::LEAST_WEIGHT,
};

/// Halves an image until no side is longer than `most` pixels, and returns its size and its RGBA
/// pixels of 8 bits. It is filtered by the box filter that makes mips; sRGB colours are filtered in linear
/// light and weighted by their alpha. `pixel` returns RGBA in `[0, 1]`.
pub fn reduced_rgba8(
    size: [u32; 2],
    pixel: impl Fn(usize) -> [f32; 4] + Sync,
    most: u32,
    color_space: ColorSpace,
) -> ([u32; 2], Vec<[u8; 4]>) {
    let is_srgb = color_space == ColorSpace::Srgb;
    let linear = |i: usize| {
        let [r, g, b, alpha] = pixel(i);
        if !is_srgb {
            return [r, g, b, alpha];
        }
        let [r, g, b] = [r, g, b].map(|v| linear_from_srgb(v) * (alpha + LEAST_WEIGHT));
        [r, g, b, alpha]
    };
    let is_too_large = |size: [u32; 2], most: u32| size.iter().any(|s| *s > most);
    let (mut size, mut pixels) = if is_too_large(size, most) {
        next_mip_of(size, linear)
    } else {
        let count = size[0] as usize * size[1] as usize;
        (size, (0..count).map(linear).collect())
    };
    while is_too_large(size, most.max(1)) {
        (size, pixels) = next_mip_of(size, |i| pixels[i]);
    }
    let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0).round() as u8;
    let encoded = |[r, g, b, alpha]: [f32; 4]| {
        let color = |v: f32| match is_srgb {
            true => byte(srgb_from_linear(v / (alpha + LEAST_WEIGHT))),
            false => byte(v),
        };
        [color(r), color(g), color(b), byte(alpha)]
    };
    (size, pixels.into_iter().map(encoded).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transparent_pixels_give_no_colour_to_others() {
        // Columns of opaque red and of transparent green.
        let striped = |i: usize| {
            if i.is_multiple_of(2) {
                [1.0, 0.0, 0.0, 1.0]
            } else {
                [0.0, 1.0, 0.0, 0.0]
            }
        };
        let (_, pixels) = reduced_rgba8([8, 8], striped, 4, ColorSpace::Srgb);
        assert!(
            pixels
                .iter()
                .all(|p| p[0] == 255 && p[1] < 16 && p[3] == 128),
            "{pixels:?}"
        );
        let clear = |_| [0.2, 0.4, 0.6, 0.0];
        let (_, pixels) = reduced_rgba8([8, 8], clear, 4, ColorSpace::Srgb);
        assert!(pixels.iter().all(|p| *p == [51, 102, 153, 0]), "{pixels:?}");
    }

    #[test]
    fn sides_are_halved_until_they_fit() {
        let flat = |_| [0.2, 0.4, 0.6, 0.8];
        for (size, most, expected) in [
            ([64, 48], 20, [16, 12]),
            ([7, 100], 30, [1, 25]),
            ([5, 5], 5, [5, 5]),
            ([3, 1], 1, [1, 1]),
        ] {
            for space in [ColorSpace::Srgb, ColorSpace::Linear] {
                let (actual, pixels) = reduced_rgba8(size, flat, most, space);
                assert_eq!(actual, expected);
                assert!(pixels.iter().all(|p| *p == [51, 102, 153, 204]));
            }
        }
    }
}
