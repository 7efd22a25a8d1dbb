//! A line of text, such as the name of a picture beside it.

use ab_glyph::{Font, FontRef, Glyph, PxScale, ScaleFont, point};
use image::{Rgba, RgbaImage};

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
