use std::f32::consts::{PI, TAU};

use bevy::math::Vec3;
use bevy_frugal_lab::path_tracer::*;

const COUNT: u32 = 200_000;

fn to_viewer(cosine: f32) -> Vec3 {
    Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine)
}

/// The share of an even sky that is reflected, by samples of the lobe.
fn sampled(gloss: Gloss, cosine: f32) -> f32 {
    let to_viewer = to_viewer(cosine);
    let mut random = Random::new(1, 2, 3);
    let light = |_| {
        let direction = gloss.sample(Vec3::Z, to_viewer, random.point())?;
        let density = gloss.pdf(Vec3::Z, to_viewer, direction);
        Some(gloss.brdf(Vec3::Z, to_viewer, direction).x * direction.z / density)
    };
    (0..COUNT).filter_map(light).sum::<f32>() / COUNT as f32
}

/// The same by a sum over a grid of directions.
fn integrated(gloss: Gloss, cosine: f32) -> f32 {
    const SIDE: u32 = 600;
    let to_viewer = to_viewer(cosine);
    let at = |index: u32| (index as f32 + 0.5) / SIDE as f32;
    let light = |index: u32| {
        let (z, (sin, cos)) = (at(index / SIDE), (TAU * at(index % SIDE)).sin_cos());
        let radius = (1.0 - z * z).sqrt();
        let direction = Vec3::new(radius * cos, radius * sin, z);
        gloss.brdf(Vec3::Z, to_viewer, direction).x * z * TAU
    };
    (0..SIDE * SIDE).map(light).sum::<f32>() / (SIDE * SIDE) as f32
}

#[test]
fn samples_reflect_what_the_integral_does_and_never_more_than_all() {
    for roughness in [0.4, 0.5, 0.7, 1.0] {
        for cosine in [0.15, 0.5, 0.9, 1.0] {
            for f0 in [0.04, 1.0] {
                let gloss = Gloss {
                    roughness,
                    f0: Vec3::splat(f0),
                };
                let (a, b) = (sampled(gloss, cosine), integrated(gloss, cosine));
                let what = format!("{roughness} {cosine} {f0}: {a} {b}");
                assert!((a / b - 1.0).abs() < 0.02, "{what}");
                assert!(a < 1.001, "{what}");
            }
        }
    }
}

#[test]
fn the_densities_of_all_directions_add_up_to_one() {
    // All but those that the sampler drops.
    let gloss = Gloss {
        roughness: 0.6,
        f0: Vec3::ONE,
    };
    let to_viewer = to_viewer(0.6);
    let mut random = Random::new(4, 5, 6);
    let (mut kept, mut density) = (0.0, 0.0);
    for _ in 0..COUNT {
        let found = gloss.sample(Vec3::Z, to_viewer, random.point());
        kept += f32::from(u8::from(found.is_some()));
        let direction = cosine_direction(Vec3::Z, random.point());
        density += gloss.pdf(Vec3::Z, to_viewer, direction) * PI / direction.z.max(1e-6);
    }
    assert!((kept / density - 1.0).abs() < 0.02, "{kept} {density}");
    assert!(kept < COUNT as f32);
}

#[test]
fn a_smooth_one_is_a_mirror_with_the_reflectance_of_fresnel() {
    let gloss = Gloss {
        roughness: 0.0,
        f0: Vec3::splat(0.04),
    };
    for cosine in [1.0_f32, 0.5] {
        let to_viewer = to_viewer(cosine);
        let mirrored = Vec3::new(-to_viewer.x, 0.0, to_viewer.z);
        let mut random = Random::new(7, 8, 9);
        for _ in 0..100 {
            let found = gloss.sample(Vec3::Z, to_viewer, random.point());
            assert!(found.is_some_and(|found| found.dot(mirrored) > 0.97));
        }
        let expected = 0.04 + 0.96 * (1.0 - cosine).powi(5);
        let found = sampled(gloss, cosine);
        assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
    }
}
