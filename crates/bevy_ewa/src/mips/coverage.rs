//! Coverage of alpha masks: the part of the area that a material shows of them, as its texture is filtered bilinearly.
//!
//! Means of alpha are flatter than the mask, so fewer of them reach the material's cutoff from level to level, and
//! leaves vanish with distance. Each level's alpha is therefore scaled until its coverage is that of the finest level
//! (I. Castaño, *Computing Alpha Mipmaps*, 2010).

/// Number of positions along each axis of a texel at which the mask is sampled.
const POSITIONS: u32 = 8;

/// Scales beyond these powers of two are not tried. Thin masks need large ones.
pub(crate) const LOG_SCALES: [f32; 2] = [-3.0, 8.0];

/// Returns the part of the area, 0 to 1, where the scaled alpha of an RGBA level is at least `cutoff`.
pub(super) fn coverage(values: &[f32], size: [u32; 2], cutoff: f32, scale: f32) -> f64 {
    let alpha = |x: i64, y: i64| {
        let x = x.clamp(0, i64::from(size[0]) - 1) as usize;
        let y = y.clamp(0, i64::from(size[1]) - 1) as usize;
        (values[(y * size[0] as usize + x) * 4 + 3] * scale).min(1.0)
    };
    let along = |n: u32| {
        (0..n * POSITIONS).map(|i| {
            let position = (f64::from(i) + 0.5) / f64::from(POSITIONS) - 0.5;
            (position.floor() as i64, position.rem_euclid(1.0) as f32)
        })
    };
    let mut visible = 0_u64;
    for (y, fy) in along(size[1]) {
        for (x, fx) in along(size[0]) {
            let row = |y| alpha(x, y) * (1.0 - fx) + alpha(x + 1, y) * fx;
            visible += u64::from(row(y) * (1.0 - fy) + row(y + 1) * fy >= cutoff);
        }
    }
    visible as f64 / (f64::from(size[0] * POSITIONS) * f64::from(size[1] * POSITIONS))
}

/// Returns the factor of a level's alpha that brings its coverage next to `visible`.
pub(super) fn scale(values: &[f32], size: [u32; 2], cutoff: f32, visible: f64) -> f32 {
    if visible <= 0.0 || visible >= 1.0 {
        return 1.0;
    }
    let [mut low, mut high] = LOG_SCALES;
    for _ in 0..16 {
        let middle = 0.5 * (low + high);
        if coverage(values, size, cutoff, middle.exp2()) < visible {
            low = middle;
        } else {
            high = middle;
        }
    }
    let error = |log: f32| (coverage(values, size, cutoff, log.exp2()) - visible).abs();
    (if error(low) < error(high) { low } else { high }).exp2()
}

#[cfg(test)]
mod tests {
    use crate::mips::{
        MipContent, generate_mip_chain,
        texel::{Storage, TexelFormat},
    };

    const SIZE: u32 = 64;
    const RGBA: TexelFormat = TexelFormat {
        channels: 4,
        storage: Storage::Unorm8,
        srgb: true,
    };

    /// The coverage of all levels but the last two, which are hardly more than one value.
    fn coverages(content: MipContent, cutoff: f32) -> Vec<f64> {
        // Blades of grass: slanted lines of 2 texels, 19% of the area.
        let texel = |i: u32| {
            let is_blade = (i % SIZE + i / SIZE / 3) % 11 < 2;
            [60, 120, 40, if is_blade { 255 } else { 0 }]
        };
        let data: Vec<u8> = (0..SIZE * SIZE).flat_map(texel).collect();
        let chain = generate_mip_chain([SIZE; 2], RGBA, data, content).expect("a chain");
        let mut start = 0;
        let coverages = (0..chain.levels - 2).map(|level| {
            let side = SIZE >> level;
            let end = start + (side * side * 4) as usize;
            let values = RGBA.decode(&chain.data[start..end]);
            start = end;
            super::coverage(&values, [side; 2], cutoff, 1.0)
        });
        coverages.collect()
    }

    #[test]
    fn masks_keep_their_coverage() {
        for cutoff in [0.25, 0.5, 0.75] {
            let kept = coverages(MipContent::Mask { cutoff }, cutoff);
            for (level, coverage) in kept.iter().enumerate() {
                let difference = coverage - kept[0];
                assert!(difference.abs() < 0.01, "{cutoff}, level {level}: {kept:?}");
            }
        }
        // The mean alpha alone loses all blades.
        let lost = coverages(MipContent::Transparent, 0.5);
        assert!(lost[0] > 0.15 && lost[3] == 0.0, "{lost:?}");
    }
}
