//! Mip chains, whose texels are the means of the areas that they cover, in linear light.

use super::*;

#[test]
fn every_level_has_the_mean_of_the_texture() {
    for size in [[64, 64], [37, 21], [5, 1], [1, 9], [3, 3], [100, 7]] {
        let texture = noise(size);
        let mean = |level: &Level| {
            let sum = level.texels.iter().fold([0.0; 4], |sum, texel| {
                [0, 1, 2, 3].map(|i| sum[i] + texel[i])
            });
            sum.map(|c| c / level.texels.len() as f64)
        };
        let wanted = mean(&texture.levels[0]);
        for level in &texture.levels {
            for (found, wanted) in mean(level).iter().zip(wanted) {
                assert!((found - wanted).abs() < 1e-12, "{size:?} {:?}", level.size);
            }
        }
        let last = texture.levels.last().expect("a level");
        assert_eq!(last.size, [1, 1]);
    }
}

#[test]
fn sizes_are_halved_and_rounded_down() {
    let sizes: Vec<_> = noise([13, 6]).levels.iter().map(|l| l.size).collect();
    assert_eq!(sizes, [[13, 6], [6, 3], [3, 1], [1, 1]]);
}
