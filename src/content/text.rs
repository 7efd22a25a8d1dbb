//! A printed page: thin strokes, the hardest edges there are.

use ab_glyph::{Font, FontRef, InvalidFont};

use crate::content::{
    lattice::Noise,
    material::{Border, Material, Sample, assemble, units},
    texture::{Color, for_each_glyph, hex, line_width, mix},
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
