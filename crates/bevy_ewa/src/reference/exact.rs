//! The exact EWA: the weighted average of the texels in an ellipse (thesis 5.3 and 5.4).

use std::f64::consts::PI;

use super::{
    footprint::{Footprint, MAX_RADIUS_TEXELS},
    texture::{Color, Texture, add_weighted, mix},
};
use crate::settings::{EwaKernel, EwaMethod, EwaSettings};

/// Square of a texel's own radius, added to the ellipse as Heckbert's unit matrix (listing 5.1): it
/// stands for the reconstruction of the texture between its texels. Measured against the ground truth,
/// 0.5 and 0.25 have larger errors on most scenes.
const TEXEL_RADIUS_SQUARED: f64 = 1.0;

/// Value of a Gaussian at twice its standard deviation.
const GAUSSIAN_EDGE: f64 = 0.135_335_283_236_612_7;

/// Sum of weights below which an ellipse counts as empty and is replaced by a bilinear fetch. In an ellipse of
/// many texels their sum is 0.9 with a Gaussian.
const MIN_WEIGHT: f64 = 1e-6;

/// An ellipse around a point of a mip level, in texels, as a symmetric 2 x 2 matrix.
#[derive(Clone, Copy, Debug)]
pub struct Ellipse {
    /// Centre of the ellipse; the centre of texel 0 is at 0.5.
    pub center: [f64; 2],
    /// Square of the half-width of its bounding box.
    pub xx: f64,
    /// Square of the half-height of its bounding box.
    pub yy: f64,
    /// Off-diagonal element of the same symmetric matrix.
    pub xy: f64,
    /// Determinant of the matrix.
    pub determinant: f64,
}

impl Ellipse {
    /// Creates the ellipse of a footprint with its radii scaled by `radius`, in a level of a texture of this size.
    pub fn new(
        footprint: &Footprint,
        radius: f64,
        uv: [f64; 2],
        size: [u32; 2],
        level: u32,
    ) -> Self {
        let level_size = size.map(|side| (side >> level).max(1));
        // A side of one texel is not halved any further. Without the minimum, the ellipse would get
        // wider along that side, where all texels are the same.
        let halved = (-f64::from(level)).exp2();
        let scale = [0, 1].map(|i| (f64::from(level_size[i]) / f64::from(size[i])).min(halved));
        let [c, s] = footprint.major_direction;
        let major = (radius * footprint.major_radius_texels).powi(2);
        let minor = (radius * footprint.minor_radius_texels).powi(2);
        let xx = (major * c * c + minor * s * s) * scale[0] * scale[0];
        let yy = (major * s * s + minor * c * c) * scale[1] * scale[1];
        let xy = (major - minor) * c * s * scale[0] * scale[1];
        let pad = TEXEL_RADIUS_SQUARED;
        // The determinant is expanded, since that of the matrix without the pad is known: the difference
        // of products `xx * yy - xy * xy` suffers cancellation for long ellipses.
        let unpadded = major * minor * (scale[0] * scale[1]).powi(2);
        Self {
            center: [0, 1].map(|i| uv[i] * f64::from(level_size[i])),
            xx: xx + pad,
            yy: yy + pad,
            xy,
            determinant: unpadded + pad * (xx + yy) + pad * pad,
        }
    }

    /// Returns the squared distance of a texel's centre relative to the ellipse: 0 in its centre and 1
    /// on its border (thesis equation 5.2).
    pub fn distance_squared(&self, texel: [i64; 2]) -> f64 {
        let [x, y] = [0, 1].map(|i| texel[i] as f64 + 0.5 - self.center[i]);
        (self.yy * x * x - 2.0 * self.xy * x * y + self.xx * y * y) / self.determinant
    }

    /// Returns the first and last index of texels whose centres are inside an interval.
    fn range(center: f64, half: f64) -> [i64; 2] {
        [
            (center - half - 0.5).ceil() as i64,
            (center + half - 0.5).floor() as i64,
        ]
    }

    /// Returns the ellipse with x and y swapped.
    fn transposed(self) -> Self {
        Self {
            center: [self.center[1], self.center[0]],
            xx: self.yy,
            yy: self.xx,
            ..self
        }
    }

    /// Returns the first and last row of the bounding box.
    fn rows(&self) -> [i64; 2] {
        Self::range(self.center[1], self.yy.sqrt())
    }

    /// Returns the first and last texel of a row inside the ellipse, by solving its equation for x. The
    /// row is empty if the first is greater than the last.
    fn row(&self, y: i64) -> [i64; 2] {
        let dy = y as f64 + 0.5 - self.center[1];
        let half = (self.determinant * (1.0 - dy * dy / self.yy).max(0.0)).sqrt() / self.yy.sqrt();
        Self::range(self.center[0] + dy * self.xy / self.yy, half)
    }
}

/// Looks up a texture by the exact method in `settings`. `uv` must be finite.
pub fn exact(
    texture: &Texture,
    footprint: &Footprint,
    uv: [f64; 2],
    settings: &EwaSettings,
) -> Color {
    let radius = f64::from(settings.kernel.radius_pixels());
    let radius_texels = radius * footprint.major_radius_texels;
    // Below a major radius of one texel, only the bilinear reconstruction of the texture is left.
    let minification = (radius_texels - 1.0).clamp(0.0, 1.0);
    let bilinear = |level: u32| {
        let size = texture.levels[level as usize].size;
        texture.bilinear(level, [0, 1].map(|i| uv[i] * f64::from(size[i])))
    };
    if minification <= 0.0 {
        return bilinear(0);
    }
    let lod = footprint.lod(settings);
    let last = f64::from(texture.last_level());
    // Beyond the last level there is nothing coarser to read. The ellipse keeps the size in texels that
    // it has at the level of detail of the last level.
    let excess = (lod - last).max(0.0);
    let scaled = Footprint {
        major_radius_texels: footprint.major_radius_texels * (-excess).exp2(),
        minor_radius_texels: footprint.minor_radius_texels * (-excess).exp2(),
        ..*footprint
    };
    let lod = lod.clamp(0.0, last);
    let fine = lod.floor();
    let blend = f64::from(settings.level_blend);
    let fraction = if blend > 0.0 && fine < last {
        ((lod - fine - 1.0) / blend + 1.0).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let (mut sum, mut total) = ([0.0; 4], 0.0);
    for (level, level_weight) in [(fine, 1.0 - fraction), (fine + 1.0, fraction)] {
        if level_weight > 0.0 {
            let (level_sum, weight) = filter_level(texture, &scaled, uv, level as u32, settings);
            sum = add_weighted(sum, level_sum, level_weight);
            total += level_weight * weight;
        }
    }
    if total < MIN_WEIGHT {
        return bilinear(fine as u32);
    }
    let color = sum.map(|c| c / total);
    if minification < 1.0 {
        return mix(bilinear(0), color, minification);
    }
    color
}

/// Returns the weighted sum of the texels in the ellipse, and that of the weights, both relative to the size of the
/// ellipse, so that a level counts as much as another one. An ellipse beyond all budgets counts as empty.
fn filter_level(
    texture: &Texture,
    footprint: &Footprint,
    uv: [f64; 2],
    level: u32,
    settings: &EwaSettings,
) -> (Color, f64) {
    let radius = f64::from(settings.kernel.radius_pixels());
    let ellipse = Ellipse::new(footprint, radius, uv, texture.size(), level);
    if !(ellipse.xx < MAX_RADIUS_TEXELS && ellipse.yy < MAX_RADIUS_TEXELS) {
        return ([0.0; 4], 0.0);
    }
    // Rows run along the longer side: there are fewer of them, with more texels each.
    let transposed = ellipse.yy > ellipse.xx;
    let scan = if transposed {
        ellipse.transposed()
    } else {
        ellipse
    };
    let scan = Scan {
        texture,
        level,
        kernel: settings.kernel,
        ellipse: scan,
        transposed,
    };
    let (sum, weight) = match settings.method {
        EwaMethod::Linear => scan.pairs(),
        EwaMethod::Bilinear => scan.blocks(),
        _ => scan.texels(),
    };
    let density = 1.0 / ellipse.determinant.sqrt();
    (sum.map(|c| density * c), density * weight)
}

/// A scan over the texels of an ellipse, row by row.
struct Scan<'a> {
    texture: &'a Texture,
    level: u32,
    kernel: EwaKernel,
    ellipse: Ellipse,
    /// Whether the rows of the scan are columns of the texture.
    transposed: bool,
}

impl Scan<'_> {
    fn in_texture<T: Copy>(&self, position: [T; 2]) -> [T; 2] {
        let [x, y] = position;
        if self.transposed { [y, x] } else { [x, y] }
    }

    fn weight(&self, texel: [i64; 2]) -> f64 {
        weight(self.kernel, self.ellipse.distance_squared(texel))
    }

    fn texel(&self, texel: [i64; 2]) -> Color {
        self.texture.texel(self.level, self.in_texture(texel))
    }

    fn bilinear(&self, position: [f64; 2]) -> Color {
        self.texture.bilinear(self.level, self.in_texture(position))
    }

    fn texels(&self) -> (Color, f64) {
        let (mut sum, mut total) = ([0.0; 4], 0.0);
        let [top, bottom] = self.ellipse.rows();
        for y in top..=bottom {
            let [left, right] = self.ellipse.row(y);
            for x in left..=right {
                let w = self.weight([x, y]);
                sum = add_weighted(sum, self.texel([x, y]), w);
                total += w;
            }
        }
        (sum, total)
    }

    /// Reads two texels per bilinear fetch at a position between them (equation 5.4). A texel outside
    /// of the ellipse has the weight zero; two texels with weights of different sign are fetched one by
    /// one.
    fn pairs(&self) -> (Color, f64) {
        let (mut sum, mut total) = ([0.0; 4], 0.0);
        let [top, bottom] = self.ellipse.rows();
        for y in top..=bottom {
            let [left, right] = self.ellipse.row(y);
            for x in (left..=right).step_by(2) {
                let (a, b) = (self.weight([x, y]), self.weight([x + 1, y]));
                let (x, y) = (x as f64 + 0.5, y as f64 + 0.5);
                if a * b >= 0.0 {
                    let fraction = if a + b == 0.0 { 0.0 } else { b / (a + b) };
                    sum = add_weighted(sum, self.bilinear([x + fraction, y]), a + b);
                } else {
                    sum = add_weighted(sum, self.bilinear([x, y]), a);
                    sum = add_weighted(sum, self.bilinear([x + 1.0, y]), b);
                }
                total += a + b;
            }
        }
        (sum, total)
    }

    /// Reads four texels per bilinear fetch, at the position where the sums of the weights over each
    /// column and each row are exact. If a weight is negative, the four texels are fetched one by one.
    fn blocks(&self) -> (Color, f64) {
        let (mut sum, mut total) = ([0.0; 4], 0.0);
        let [top, bottom] = self.ellipse.rows();
        for y in (top..=bottom).step_by(2) {
            let [first, second] = [self.ellipse.row(y), self.ellipse.row(y + 1)];
            let (left, right) = if second[0] > second[1] {
                (first[0], first[1])
            } else if first[0] > first[1] {
                (second[0], second[1])
            } else {
                (first[0].min(second[0]), first[1].max(second[1]))
            };
            for x in (left..=right).step_by(2) {
                let texels = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]];
                let w = texels.map(|texel| self.weight(texel));
                let all: f64 = w.iter().sum();
                if w.iter().any(|w| *w < 0.0) {
                    for (texel, w) in texels.iter().zip(w) {
                        if w != 0.0 {
                            sum = add_weighted(sum, self.texel(*texel), w);
                        }
                    }
                } else if all > 0.0 {
                    let position = [
                        x as f64 + 0.5 + (w[1] + w[3]) / all,
                        y as f64 + 0.5 + (w[2] + w[3]) / all,
                    ];
                    sum = add_weighted(sum, self.bilinear(position), all);
                }
                total += all;
            }
        }
        (sum, total)
    }
}

/// Returns the weight at a squared distance from the centre, relative to the kernel's squared radius. It
/// is 0 outside of 0 to 1.
pub fn weight(kernel: EwaKernel, distance_squared: f64) -> f64 {
    if !(0.0..1.0).contains(&distance_squared) {
        return 0.0;
    }
    let distance = distance_squared.sqrt();
    match kernel {
        EwaKernel::Box => 1.0,
        EwaKernel::Tent => 1.0 - distance,
        EwaKernel::Gaussian { .. } => (-2.0 * distance_squared).exp() - GAUSSIAN_EDGE,
        EwaKernel::MitchellNetravali => mitchell_netravali(2.0 * distance),
        EwaKernel::Lanczos => sinc(2.0 * distance) * sinc(distance),
    }
}

/// The cubic with B = C = 1/3, for `x` from 0 to 2.
fn mitchell_netravali(x: f64) -> f64 {
    if x < 1.0 {
        (7.0 * x * x * x - 12.0 * x * x + 16.0 / 3.0) / 6.0
    } else {
        (-7.0 / 3.0 * x * x * x + 12.0 * x * x - 20.0 * x + 32.0 / 3.0) / 6.0
    }
}

fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-6 {
        1.0
    } else {
        (PI * x).sin() / (PI * x)
    }
}
