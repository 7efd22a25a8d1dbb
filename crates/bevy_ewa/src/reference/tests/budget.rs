//! Upper bounds of the cost of a lookup.

use proptest::prelude::*;

use super::{
    super::{exact::Ellipse, footprint::max_texels, sample::sample},
    *,
};

proptest! {
    #[test]
    fn an_exact_lookup_keeps_within_its_budget(
        log_major in -6.0..4.0f64, log_ratio in 0.0..8.0f64, angle in 0.0..3.2f64,
        u in 0.0..1.0f64, v in 0.0..1.0f64,
        budget in 16u32..600, method in 0usize..3, kernel in 0usize..5,
        minor_radius_texels in 0.5..4.0f32, blend in 0.0..1.0f32,
    ) {
        let texture = noise([37, 64]);
        let major = log_major.exp2();
        let derivatives = ellipse(major, major / log_ratio.exp2(), angle);
        let settings = EwaSettings {
            max_fetches: budget,
            max_anisotropy: 64.0,
            minor_radius_texels,
            level_blend: blend,
            kernel: KERNELS[kernel],
            ..EwaSettings::with_method(EXACT[method])
        };
        let sampled = sample(&texture, [u, v], derivatives, &settings, 0);
        // Kernels with negative lobes cannot always fetch pairs, but never take more than one fetch per
        // texel. The bilinear reconstruction may be blended in with one more.
        prop_assert!(sampled.fetches <= budget + 1, "{}", sampled.fetches);
    }

    #[test]
    fn no_ellipse_has_more_texels_than_the_bound(
        major in 0.0..60.0f64, ratio in 1.0..40.0f64, angle in 0.0..3.2f64,
        u in 0.0..1.0f64, v in 0.0..1.0f64,
    ) {
        let footprint = Footprint::new(ellipse(major, major / ratio, angle), [1, 1], 1e9);
        let ellipse = Ellipse::new(&footprint, 1.0, [u, v], 0, [1, 1], [1, 1]);
        let inside = (-70..=70i64)
            .flat_map(|y| (-70..=70i64).map(move |x| [x, y]))
            .filter(|texel| ellipse.distance_squared(*texel) <= 1.0)
            .count();
        let bound = max_texels(major + 1.0, major / ratio + 1.0);
        prop_assert!(inside as f64 <= bound, "{inside} > {bound}");
    }
}

#[test]
fn a_budget_raises_the_mip_level_and_never_cuts_the_ellipse() {
    // A cut ellipse would miss one side of the step; a coarser level covers both.
    let texture = Texture::from_fn([256, 256], |x, _| [f64::from(u8::from(x >= 128)); 4]);
    let derivatives = ellipse(0.4, 0.01, 0.0);
    for method in EXACT {
        let settings = EwaSettings {
            max_fetches: 40,
            ..EwaSettings::with_method(method)
        };
        let sampled = sample(&texture, [0.5, 0.5], derivatives, &settings, 0);
        assert!((sampled.color[0] - 0.5).abs() < 0.02, "{sampled:?}");
        assert!(sampled.fetches <= 40);
    }
}

#[test]
fn only_texels_inside_the_ellipse_are_fetched() {
    // An ellipse of 16:1 at 0.4 radians covers a fifth of its bounding box; pairs take half of that.
    let texture = noise([256, 256]);
    let derivatives = ellipse(16.0 / 256.0, 1.0 / 256.0, 0.4);
    let fetches = |method| {
        let settings = EwaSettings {
            minor_radius_texels: 1.0,
            level_blend: 0.0,
            ..EwaSettings::with_method(method)
        };
        sample(&texture, [0.5, 0.5], derivatives, &settings, 0).fetches
    };
    let [reference, linear, bilinear] = EXACT.map(fetches);
    assert!(reference <= 80, "{reference}");
    assert!(linear <= 45, "{linear}");
    assert!(bilinear <= 30, "{bilinear}");
}
