//! A printed page and other lines of text, with thin strokes and the hardest edges there are; and smooth ramps, in which
//! banding and quantisation show first.

use ab_glyph::{Font, FontRef, Glyph, InvalidFont, PxScale, ScaleFont, point};
use image::{Rgba, RgbaImage};

use crate::content::surface::{
    Border, Color, Material, Noise, Sample, assemble, hex, hue, lerp, mix, ramp, render, shade,
    units,
};

const PAPER: Color = hex(0xF4EFE4);
const INK: Color = hex(0x1C1B1E);
const HEADING: Color = hex(0x8C1D2C);
const CODE: Color = hex(0x1D4E89);

/// Sentences of the page; the seed decides their order.
const SENTENCES: [&str; 12] = [
    "A texture is stored once and read a million times, so what counts is how fast it is read.",
    "The quick brown fox jumps over the lazy dog; 0123456789.",
    "Fixed-rate blocks let a sampler find any texel without reading its neighbours.",
    "Wavelets gather the energy of an image in few coefficients, and most of the rest are zero.",
    "Sphinx of black quartz, judge my vow!",
    "An error below the threshold of vision is no error, unless the next stage magnifies it.",
    "Chroma is blurred by the eye itself: half its samples may go, and nobody will miss them.",
    "Pack my box with five dozen liquor jugs (and 48 marbles).",
    "At grazing angles the footprint of a pixel is a long ellipse, not a square.",
    "Letters are the hardest test, for a reader knows exactly how an edge should look.",
    "What is frugal is not poor: it has spent its bits where they are seen.",
    "Every filter is a compromise between blur, ringing and aliasing.",
];

/// Lines of the listing at the foot of the page.
const LISTING: [&str; 5] = [
    "fn psnr_db(mse: f64) -> f64 {",
    "    // 8-bit peak: 255 * 255",
    "    10.0 * (65025.0 / mse).log10()",
    "}",
    "#[test] // {} [] <> |&*+-=/\\ 0O 1lI",
];

/// A page of text in two typefaces and several sizes, dark on paper, filled with as many lines as
/// fit. Below 512 pixels the page is cut off rather than shrunk, so that its letters stay legible.
/// Does not tile; the mask is the ink, which the normals press into the paper.
pub fn text(width: u32, height: u32, seed: u64) -> Material {
    let noise = Noise::new(seed, units(width, height));
    let mut page = Page::new(width, height);
    // Embedded, hence valid: a failure would be one of the font crate, and leaves blank paper.
    let _ = page.print(noise);
    page.into_material(noise)
}

/// Ink on a page that is being printed.
struct Page {
    width: u32,
    height: u32,
    /// Size of a letter of 1 em in the body, in pixels.
    em: f32,
    /// Colour and coverage of every pixel.
    ink: Vec<(Color, f32)>,
}

impl Page {
    fn new(width: u32, height: u32) -> Self {
        let em = (width.min(height) as f32 / 512.0).max(1.0) * 15.0;
        Self {
            width,
            height,
            em,
            ink: vec![(INK, 0.0); width as usize * height as usize],
        }
    }

    /// Sets heading, body in shrinking sizes, and the listing.
    fn print(&mut self, noise: Noise) -> Result<(), InvalidFont> {
        let sans = FontRef::try_from_slice(epaint_default_fonts::UBUNTU_LIGHT)?;
        let monospaced = FontRef::try_from_slice(epaint_default_fonts::HACK_REGULAR)?;
        let margin = 1.6 * self.em;
        let right = self.width as f32 - margin;
        let bottom = self.height as f32 - margin - LISTING.len() as f32 * 1.4 * self.em;

        let mut order: Vec<usize> = (0..SENTENCES.len()).collect();
        order.sort_by(|a, b| {
            noise
                .uniform(*a as i32, 0)
                .total_cmp(&noise.uniform(*b as i32, 0))
        });

        let mut baseline = margin + 1.8 * self.em;
        self.set_line(
            &sans,
            "On frugal rendering",
            margin,
            baseline,
            2.0 * self.em,
            HEADING,
        );
        baseline += 1.2 * self.em;
        // On a small page the listing follows the heading at once.
        let bottom = bottom.max(baseline);
        for paragraph in 0.. {
            let size = self.em * [1.0, 0.8, 1.25, 0.67][paragraph % 4];
            baseline += 0.5 * self.em;
            let sentences = order.iter().cycle().skip(paragraph * 4).take(4);
            let words = sentences.flat_map(|index| SENTENCES[*index].split(' '));
            let mut x = margin;
            baseline += 1.3 * size;
            for word in words {
                if x + line_width(&sans, word, size) > right && x > margin {
                    x = margin;
                    baseline += 1.3 * size;
                }
                if baseline > bottom {
                    break;
                }
                x = self.set_line(&sans, word, x, baseline, size, INK);
                x += 0.28 * size;
            }
            if baseline > bottom {
                break;
            }
        }
        for (row, line) in LISTING.iter().enumerate() {
            let baseline = bottom + (row as f32 + 1.4) * 1.3 * self.em;
            self.set_line(&monospaced, line, margin, baseline, self.em, CODE);
        }
        Ok(())
    }

    /// Sets one line from `x` on a `baseline` and returns where it ends, all in pixels.
    fn set_line(
        &mut self,
        font: &FontRef,
        line: &str,
        x: f32,
        baseline: f32,
        size: f32,
        color: Color,
    ) -> f32 {
        for_each_glyph(font, line, size, |glyph| {
            let mut glyph = glyph;
            glyph.position.x += x;
            glyph.position.y += baseline;
            let Some(outline) = font.outline_glyph(glyph) else {
                return;
            };
            let origin = outline.px_bounds().min;
            outline.draw(|dx, dy, coverage| {
                let (x, y) = (
                    origin.x as i64 + i64::from(dx),
                    origin.y as i64 + i64::from(dy),
                );
                let (width, height) = (i64::from(self.width), i64::from(self.height));
                if (0..width).contains(&x) && (0..height).contains(&y) {
                    let ink = &mut self.ink[(y * width + x) as usize];
                    *ink = (color, ink.1.max(coverage.min(1.0)));
                }
            });
        });
        x + line_width(font, line, size)
    }

    fn into_material(self, noise: Noise) -> Material {
        // Pressed into the paper by a twentieth of an em.
        let depth = 0.05 * self.em / self.width.min(self.height).max(1) as f32;
        let samples: Vec<Sample> = self
            .ink
            .iter()
            .enumerate()
            .map(|(i, &(ink, coverage))| {
                let (x, y) = (i as u32 % self.width, i as u32 / self.width);
                // Paper is nearly smooth.
                let fibre = noise.stream(1).uniform(x as i32, y as i32) - 0.5;
                let paper = PAPER.map(|channel| channel + 0.012 * fibre);
                Sample {
                    color: mix(paper, ink, coverage),
                    height: -depth * coverage,
                    mask: coverage,
                }
            })
            .collect();
        assemble(self.width, self.height, Border::Clamp, &samples)
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
fn line_width(font: &FontRef, line: &str, size: f32) -> f32 {
    for_each_glyph(font, line, size, |_| ())
}

/// Places the glyphs of a line at the origin, with kerning, and returns its width in pixels.
fn for_each_glyph(font: &FontRef, line: &str, size: f32, mut place: impl FnMut(Glyph)) -> f32 {
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

const DUSK: [Color; 5] = [
    hex(0x101A3A),
    hex(0x3A3F73),
    hex(0xA8627E),
    hex(0xF0A36B),
    hex(0xFBE3B0),
];

/// Six panels in two rows. Top: all hues against brightness, a dusk sky, a glow in the dark.
/// Bottom: the eight darkest grays stretched over a panel, a saturated crossfade of four colours,
/// and a grayscale. Panels that would be the same for every seed are turned by it. Does not tile;
/// the normals are one smooth dome per panel, the mask is a radial falloff.
pub fn gradients(width: u32, height: u32, seed: u64) -> Material {
    let turn = (seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40) as f32 / (1u64 << 24) as f32;
    let units = units(width, height).map(|units| units as f32);
    render(width, height, Border::Clamp, |[x, y]| {
        gradient_sample(x / units[0], y / units[1], turn)
    })
}

/// The sample at a point of the unit square.
fn gradient_sample(x: f32, y: f32, turn: f32) -> Sample {
    let (column, row) = ((x * 3.0).floor().min(2.0), (y * 2.0).floor().min(1.0));
    let (s, t) = (x * 3.0 - column, y * 2.0 - row);
    let radius = (s - 0.5).hypot(t - 0.5) * std::f32::consts::SQRT_2;

    let color = match (row as u32, column as u32) {
        (0, 0) => {
            let pure = hue(s + turn);
            if t < 0.5 {
                shade(pure, t * 2.0)
            } else {
                mix(pure, [1.0; 3], t * 2.0 - 1.0)
            }
        }
        (0, 1) => ramp(&DUSK, t + 0.08 * (s - 0.5)),
        (0, _) => shade(
            mix(hue(turn), [1.0; 3], 0.6),
            (1.0 - radius).max(0.0).powi(2) * 0.7,
        ),
        (_, 0) => [lerp(0.0, 8.0 / 255.0, s); 3],
        (_, 1) => {
            let corner = |quarter: f32| hue(turn + quarter);
            mix(
                mix(corner(0.0), corner(0.25), s),
                mix(corner(0.5), corner(0.75), s),
                t,
            )
        }
        _ => [lerp(1.0, 0.0, t); 3],
    };
    let wave = |v: f32| (v * std::f32::consts::PI).sin();
    Sample {
        color,
        height: 0.06 * wave(s) * wave(t),
        mask: 1.0 - radius,
    }
}
