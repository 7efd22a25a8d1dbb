//! Colours of content, images as textures of Bevy with mips, maps packed in one image, and labels.

use ab_glyph::{Font, FontRef, Glyph, PxScale, ScaleFont, point};
use bevy::{
    asset::RenderAssetUsages,
    image::{Image, ImageAddressMode, ImageSampler, ImageSamplerDescriptor},
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_wavelet_tex::codec::{
    color::{linear_from_srgb, srgb_from_linear},
    plane::Plane,
};
use image::{Rgba, RgbaImage};

use crate::content::{
    lattice::{Noise, lerp, smoothstep},
    material::{Border, Material, Sample, render, units},
};

/// `pixels` as an RGBA8 texture that repeats, with a full chain of mips.
///
/// Mips of colours (`srgb`) are filtered in linear light.
pub fn mipped_texture(pixels: &RgbaImage, srgb: bool) -> Image {
    let (width, height) = pixels.dimensions();
    let curve = |channel: usize, f: fn(f32) -> f32, v: f32| {
        if srgb && channel < 3 { f(v) } else { v }
    };
    let mut planes = [0, 1, 2, 3].map(|channel| Plane {
        size: [width, height],
        values: pixels
            .pixels()
            .map(|p| curve(channel, linear_from_srgb, f32::from(p[channel]) / 255.0))
            .collect(),
    });
    let mut data = pixels.as_raw().clone();
    let mut levels = 1;
    while planes[0].size != [1, 1] {
        planes = planes.map(|plane| plane.next_mip());
        for i in 0..planes[0].values.len() {
            let texel = [0, 1, 2, 3].map(|channel: usize| {
                let encoded = curve(channel, srgb_from_linear, planes[channel].values[i]);
                (encoded * 255.0).round() as u8
            });
            data.extend(texel);
        }
        levels += 1;
    }
    let format = if srgb {
        TextureFormat::Rgba8UnormSrgb
    } else {
        TextureFormat::Rgba8Unorm
    };
    let size = Extent3d {
        width,
        height,
        depth_or_array_layers: 1,
    };
    let usage = RenderAssetUsages::RENDER_WORLD;
    let mut image = Image::new_uninit(size, TextureDimension::D2, format, usage);
    image.data = Some(data);
    image.texture_descriptor.mip_level_count = levels;
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        address_mode_v: ImageAddressMode::Repeat,
        ..ImageSamplerDescriptor::linear()
    });
    image
}

/// An sRGB-encoded colour, channels 0 to 1.
pub(super) type Color = [f32; 3];

/// The colour of a hexadecimal code such as `0xB2_55_3C`.
pub(super) const fn hex(code: u32) -> Color {
    [
        ((code >> 16) & 0xFF) as f32 / 255.0,
        ((code >> 8) & 0xFF) as f32 / 255.0,
        (code & 0xFF) as f32 / 255.0,
    ]
}

/// Interpolates from `a` to `b`.
pub(super) fn mix(a: Color, b: Color, t: f32) -> Color {
    [0, 1, 2].map(|c| lerp(a[c], b[c], t))
}

/// Multiplies the brightness.
pub(super) fn shade(color: Color, factor: f32) -> Color {
    color.map(|channel| channel * factor)
}

/// Interpolates along evenly spaced colours; `t` is clamped to 0 to 1.
pub(super) fn ramp(stops: &[Color], t: f32) -> Color {
    let position = t.clamp(0.0, 1.0) * (stops.len() - 1) as f32;
    let index = (position as usize).min(stops.len() - 2);
    mix(stops[index], stops[index + 1], position - index as f32)
}

/// Fully saturated colour of a hue of 0 to 1 (red, green, blue, red).
pub(super) fn hue(turn: f32) -> Color {
    [0.0, 2.0 / 3.0, 1.0 / 3.0].map(|offset| {
        let distance = ((turn + offset).rem_euclid(1.0) - 0.5).abs();
        (distance * 6.0 - 1.0).clamp(0.0, 1.0)
    })
}

/// Occlusion in R (smooth), roughness in G (scratches and stains of all scales), metallic in B (sharp
/// regions of all or nothing), as glTF packs them. Tiles; the mask is the metal.
pub fn packed_maps(width: u32, height: u32, seed: u64) -> Material {
    let noise = Noise::new(seed, units(width, height));
    render(width, height, Border::Wrap, |point| sample(noise, point))
}

fn sample(noise: Noise, point: [f32; 2]) -> Sample {
    // Noise is 0 on its lattice, which the border of the image is not on.
    let point = point.map(|p| p + 0.137);
    let fractal = |stream, scale, octaves| {
        let noise = noise.stream(stream);
        noise.fractal(point, [scale; 2], octaves)
    };
    let hollow = smoothstep(0.1, 0.5, fractal(1, 4, 3));
    let scratch = smoothstep(0.05, 0.0, fractal(2, 19, 3).abs());
    let stain = fractal(3, 7, 7);
    let metal = smoothstep(-0.02, 0.02, fractal(4, 9, 2) - 0.05);
    let occlusion = 1.0 - 0.7 * hollow;
    let roughness = (0.55 + 0.35 * stain - 0.3 * scratch).clamp(0.0, 1.0);
    Sample {
        color: [occlusion, roughness, metal],
        height: -0.06 * hollow - 0.006 * scratch,
        mask: metal,
    }
}

/// A line in white on transparent black, `em` pixels to the em; 1.4 em high and as wide as it must be.
pub fn label(line: &str, em: u32) -> RgbaImage {
    let size = em as f32;
    // Embedded, hence valid: a failure would be one of the font crate, and leaves a blank label.
    let Ok(font) = FontRef::try_from_slice(epaint_default_fonts::HACK_REGULAR) else {
        return RgbaImage::new(em, em);
    };
    let (width, height) = (
        line_width(&font, line, size).ceil() as u32,
        (1.4 * size).ceil() as u32,
    );
    let mut image = RgbaImage::from_pixel(width.max(1), height.max(1), Rgba([255, 255, 255, 0]));
    for_each_glyph(&font, line, size, |mut glyph| {
        glyph.position.y += 1.05 * size;
        let Some(outline) = font.outline_glyph(glyph) else {
            return;
        };
        let origin = outline.px_bounds().min;
        outline.draw(|dx, dy, coverage| {
            let place = |origin: f32, d: u32| u32::try_from(origin as i64 + i64::from(d)).ok();
            if let (Some(x), Some(y)) = (place(origin.x, dx), place(origin.y, dy))
                && let Some(pixel) = image.get_pixel_mut_checked(x, y)
            {
                pixel.0[3] = pixel.0[3].max((255.0 * coverage.min(1.0)).round() as u8);
            }
        });
    });
    image
}

/// Width of a line in pixels.
pub(super) fn line_width(font: &FontRef, line: &str, size: f32) -> f32 {
    for_each_glyph(font, line, size, |_| ())
}

/// Places the glyphs of a line at the origin, with kerning, and returns its width in pixels.
pub(super) fn for_each_glyph(
    font: &FontRef,
    line: &str,
    size: f32,
    mut place: impl FnMut(Glyph),
) -> f32 {
    let scaled = font.as_scaled(PxScale::from(size));
    let mut x = 0.0;
    let mut previous = None;
    for character in line.chars() {
        let id = scaled.glyph_id(character);
        x += previous.map_or(0.0, |previous| scaled.kern(previous, id));
        place(id.with_scale_and_position(size, point(x, 0.0)));
        x += scaled.h_advance(id);
        previous = Some(id);
    }
    x
}
