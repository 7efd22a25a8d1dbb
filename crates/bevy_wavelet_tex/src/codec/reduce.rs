//! Downsampling of images to a size limit.

use super::{
    color::{linear_from_srgb, srgb_from_linear},
    image::ColorSpace,
    plane::Plane,
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
    let srgb = |c: usize| color_space == ColorSpace::Srgb && c < 3;
    let mut channels = [0, 1, 2, 3].map(|c: usize| {
        let value = |i| {
            let rgba = pixel(i);
            if srgb(c) {
                linear_from_srgb(rgba[c]) * (rgba[3] + LEAST_WEIGHT)
            } else {
                rgba[c]
            }
        };
        if size.iter().any(|s| *s > most) {
            Plane::next_mip_of(size, value)
        } else {
            Plane {
                size,
                values: (0..size[0] as usize * size[1] as usize)
                    .map(value)
                    .collect(),
            }
        }
    });
    while channels[0].size.iter().any(|s| *s > most.max(1)) {
        channels = channels.map(|channel| channel.next_mip());
    }
    let byte = |c: usize, i: usize| {
        let mut v = channels[c].values[i];
        if srgb(c) {
            v = srgb_from_linear(v / (channels[3].values[i] + LEAST_WEIGHT));
        }
        (v.clamp(0.0, 1.0) * 255.0).round() as u8
    };
    let pixels = (0..channels[0].values.len()).map(|i| [0, 1, 2, 3].map(|c| byte(c, i)));
    (channels[0].size, pixels.collect())
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
