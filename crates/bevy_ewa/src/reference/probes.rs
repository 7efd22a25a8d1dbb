//! The approximation of an ellipse by a few anisotropic fetches (thesis 5.5).

use super::{
    footprint::{CEIL_TOLERANCE, Footprint},
    texture::{Color, Texture, add_weighted},
};
use crate::settings::{EwaProbes, EwaSettings};

/// Longest footprint of a texture unit, in multiples of its width, and so the most taps (trilinear
/// fetches) per probe.
pub const MAX_TAPS: f64 = 16.0;

/// Increase of an ellipse's aspect ratio for each additional pair of probes: probes four widths long
/// leave no gap and keep their weights distinct.
pub const ASPECT_PER_PROBE_PAIR: f64 = 8.0;

/// The subset of the probes that one frame takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProbeSubset {
    /// All probes.
    All,
    /// The central probe and those of even index, counted from the centre (thesis 5.5.2).
    Even,
    /// The central probe and those of odd index.
    Odd,
}

impl ProbeSubset {
    /// Whether the subset contains the probe of this index, counted from the centre (index 0).
    fn contains(self, index: u32) -> bool {
        match self {
            Self::All => true,
            Self::Even => index.is_multiple_of(2),
            Self::Odd => index == 0 || !index.is_multiple_of(2),
        }
    }
}

/// Returns the number of probes, which is odd.
pub fn probe_count(probes: EwaProbes, anisotropy: f64) -> u32 {
    match probes {
        EwaProbes::Three => 3,
        EwaProbes::Five => 5,
        EwaProbes::Seven => 7,
        EwaProbes::ByAspect => {
            let pairs = (anisotropy / ASPECT_PER_PROBE_PAIR - CEIL_TOLERANCE)
                .ceil()
                .clamp(1.0, 7.0);
            2 * pairs as u32 + 1
        }
    }
}

/// Filters by probes on the major axis with Gaussian weights (equations 5.5 and 5.6).
pub fn approximate(
    texture: &Texture,
    footprint: &Footprint,
    uv: [f64; 2],
    settings: &EwaSettings,
    probes: EwaProbes,
    subset: ProbeSubset,
) -> Color {
    let count = probe_count(
        probes,
        footprint.major_radius_texels / footprint.minor_radius_texels.max(1e-12),
    );
    let probe = Probe::new(footprint, settings, count);
    let (mut sum, mut total) = ([0.0; 4], 0.0);
    for index in (1..=count / 2).filter(|index| subset.contains(*index)) {
        let along = f64::from(index) * probe.spacing_texels;
        let weight = probe.weight(index);
        sum = add_weighted(sum, probe.fetch(texture, uv, along), weight);
        sum = add_weighted(sum, probe.fetch(texture, uv, -along), weight);
        total += 2.0 * weight;
    }
    // Each of two frames has half of the total weight, so that their mean is the picture of all probes.
    let frame_weight = match subset {
        ProbeSubset::All => PROFILE_INTEGRAL,
        ProbeSubset::Even | ProbeSubset::Odd => PROFILE_INTEGRAL / 2.0,
    };
    let center = (frame_weight - total).max(0.0);
    if center > 0.0 {
        sum = add_weighted(sum, probe.fetch(texture, uv, 0.0), center);
    }
    sum.map(|c| c / (total + center))
}

/// Length of the single fetch that stands for a whole ellipse, in major radii. A line of equal weights
/// has the variance of the kernel at 1.28. Measured in the same way as [`PROBE_WIDTH`], 1.25 has the
/// smallest error, also on texture units that space their taps more closely.
const SINGLE_LENGTH: f64 = 1.25;

/// Filters by one anisotropic fetch along the axes of the ellipse. The derivatives themselves would not
/// do: texture units compare their lengths, which say little about an ellipse whose axes have other
/// directions.
pub fn single_probe(
    texture: &Texture,
    footprint: &Footprint,
    uv: [f64; 2],
    settings: &EwaSettings,
) -> Color {
    Probe::single(footprint, settings).fetch(texture, uv, 0.0)
}

/// Models the anisotropic filter of a texture unit for given derivatives.
pub fn software_anisotropic(texture: &Texture, derivatives: [[f64; 2]; 2], uv: [f64; 2]) -> Color {
    let size = texture.size();
    let texels = |d: [f64; 2]| [0, 1].map(|i| d[i] * f64::from(size[i]));
    let [a, b] = derivatives.map(texels);
    let lengths = [a, b].map(|d| d[0].hypot(d[1]));
    let (long, length, width) = if lengths[0] >= lengths[1] {
        (a, lengths[0], lengths[1])
    } else {
        (b, lengths[1], lengths[0])
    };
    if !(length.is_finite() && width.is_finite()) {
        return texture.trilinear(uv, f64::from(texture.last_level()));
    }
    let direction = if length > 0.0 {
        long.map(|c| c / length)
    } else {
        [1.0, 0.0]
    };
    taps(texture, uv, direction, length, width)
}

/// Averages trilinear fetches (taps) along a line. Their number and their level of detail, which does
/// not depend on the rounding of the number, follow the Vulkan specification. Each tap covers an equal
/// part of the line, while the example in the specification omits the ends (and has twice the error).
fn taps(
    texture: &Texture,
    uv: [f64; 2],
    direction: [f64; 2],
    length_texels: f64,
    width_texels: f64,
) -> Color {
    let size = texture.size();
    let (count, width) = tap_count(length_texels, width_texels);
    let lod = width.log2();
    let mut sum = [0.0; 4];
    for i in 0..count as u32 {
        let along = ((f64::from(i) + 0.5) / count - 0.5) * length_texels;
        let at = [0, 1].map(|axis| uv[axis] + direction[axis] * along / f64::from(size[axis]));
        sum = add_weighted(sum, texture.trilinear(at, lod), 1.0 / count);
    }
    sum
}

/// Returns the number of taps and their width in texels.
fn tap_count(length_texels: f64, width_texels: f64) -> (f64, f64) {
    // No tap is narrower than a texel of the finest level.
    let width = width_texels.max(length_texels / MAX_TAPS).max(1.0);
    let count = (length_texels / width - CEIL_TOLERANCE).ceil();
    (count.clamp(1.0, MAX_TAPS), width)
}

/// The parameters that all probes of an ellipse share.
pub(crate) struct Probe {
    is_texture_units: bool,
    count: f64,
    direction: [f64; 2],
    length_texels: f64,
    width_texels: f64,
    spacing_texels: f64,
}

/// Variance of the Gaussian kernel along any axis, relative to its squared radius.
const KERNEL_VARIANCE: f64 = 0.1361;

/// Variance of the profile `(1 - t^2)^2`, which approximates the kernel integrated across the major
/// axis.
const PROFILE_VARIANCE: f64 = 1.0 / 7.0;

/// Integral of the profile from -1 to 1.
const PROFILE_INTEGRAL: f64 = 16.0 / 15.0;

/// Width of the trilinear fetches in minor radii. The variance of the kernel would need 0.74, but at
/// that width a trilinear fetch reads too few texels and aliases: measured from 0.74 to 1.3 on tunnels,
/// planes and noise, 1.2 has the smallest error.
const PROBE_WIDTH: f64 = 1.2;

impl Probe {
    /// Distributes the probes along the major axis. The line of probes is shorter than the axis by the
    /// width of a probe, so that its variance is that of the ellipse even if the ellipse is nearly
    /// round: all probes of a disc are at its centre. It is shortened again by the variance that the
    /// length and the small number of the probes add.
    pub(crate) fn new(footprint: &Footprint, settings: &EwaSettings, count: u32) -> Self {
        let radius = f64::from(settings.kernel.probe_radius_pixels());
        let count = f64::from(count);
        let major = radius * footprint.major_radius_texels;
        let minor = radius * footprint.minor_radius_texels;
        let line = ((major - minor).max(0.0) * (major + minor)).sqrt();
        let spread = PROFILE_VARIANCE + 2.0 / 3.0 / (count * count);
        let spacing = 2.0 * line / count * (KERNEL_VARIANCE / spread).sqrt();
        let width = PROBE_WIDTH * minor;
        Self {
            is_texture_units: settings.sampler_anisotropy > 1,
            count,
            direction: footprint.major_direction,
            length_texels: spacing.max(width),
            width_texels: width,
            spacing_texels: spacing,
        }
    }

    /// The single probe of an ellipse.
    pub(crate) fn single(footprint: &Footprint, settings: &EwaSettings) -> Self {
        let radius = f64::from(settings.kernel.probe_radius_pixels());
        let probe = Self::new(footprint, settings, 1);
        let length = SINGLE_LENGTH * radius * footprint.major_radius_texels;
        Self {
            length_texels: length.max(probe.width_texels),
            ..probe
        }
    }

    /// Returns the fetches of each probe.
    pub(crate) fn fetches(&self) -> f64 {
        if self.is_texture_units {
            1.0
        } else {
            tap_count(self.length_texels, self.width_texels).0
        }
    }

    /// Returns the weight of a probe by its index from the centre: the integral of the profile over its
    /// part of the line.
    fn weight(&self, index: u32) -> f64 {
        let index = f64::from(index);
        let integral = |t: f64| t - 2.0 / 3.0 * t.powi(3) + t.powi(5) / 5.0;
        integral((2.0 * index + 1.0) / self.count) - integral((2.0 * index - 1.0) / self.count)
    }

    /// Takes a probe, which counts as one fetch where the texture unit computes it.
    fn fetch(&self, texture: &Texture, uv: [f64; 2], along: f64) -> Color {
        let size = texture.size();
        let at = [0, 1].map(|i| uv[i] + self.direction[i] * along / f64::from(size[i]));
        let (length, width) = (self.length_texels, self.width_texels);
        let fetch = || taps(texture, at, self.direction, length, width);
        if self.is_texture_units {
            texture.count_as_one(fetch)
        } else {
            fetch()
        }
    }
}
