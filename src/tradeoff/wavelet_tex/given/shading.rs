//! Light that a flat square with the maps of a material reflects to a camera.
//!
//! The BRDF is that of glTF 2.0, appendix B: a Lambertian base under a GGX microfacet layer with Smith's
//! height-correlated visibility and Schlick's Fresnel term. Bevy's differs in its diffuse part alone. The
//! two layers of a white dielectric reflect up to 1.09 of the light together at grazing angles, since the
//! Fresnel term of the appendix does not take all of the upper layer's light from the base.

use std::f64::consts::{FRAC_1_PI, PI};

use bevy::math::DVec3;

/// What a pixel of the maps says about the surface, in linear units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    pub(super) base_color: DVec3,
    pub(super) emissive: DVec3,
    /// Unit normal in tangent space.
    pub(super) normal: DVec3,
    pub(super) metallic: f64,
    /// Perceptual roughness, the square root of GGX's alpha.
    pub(super) roughness: f64,
    /// Part of the ambient light that arrives.
    pub(super) occlusion: f64,
}

/// Position of the camera. The square spans -1 to 1 in X and Y at Z = 0 and faces +Z.
const CAMERA: DVec3 = DVec3::new(0.0, 0.0, 2.0);

/// Positions of the point lights and their intensities: one from the upper left, one from the right, and a
/// grazing one from below, which shows the normals.
const LIGHTS: [(DVec3, f64); 3] = [
    (DVec3::new(-0.8, 0.9, 1.2), 3.0),
    (DVec3::new(1.0, 0.2, 1.6), 2.0),
    (DVec3::new(0.1, -1.3, 0.5), 1.5),
];

/// Radiance of the ambient light, the same from all sides.
const AMBIENT: f64 = 0.15;

/// Least roughness, as in Bevy: the highlight of a smoother surface would be missed between pixels.
const MIN_ROUGHNESS: f64 = 0.089;

/// Reflectance of dielectrics at normal incidence.
const DIELECTRIC: f64 = 0.04;

/// Radiance that the surface at `[x, y]` sends to the camera.
pub(super) fn radiance(surface: &Surface, [x, y]: [f64; 2]) -> DVec3 {
    let position = DVec3::new(x, y, 0.0);
    let view = (CAMERA - position).normalize();
    let specular = DVec3::splat(DIELECTRIC).lerp(surface.base_color, surface.metallic);
    let diffuse = surface.base_color * (1.0 - surface.metallic);
    let mut sum = surface.emissive + AMBIENT * surface.occlusion * (diffuse + specular);
    for (light, intensity) in LIGHTS {
        let to_light = light - position;
        let direction = to_light.normalize();
        let cosine = surface.normal.dot(direction).max(0.0);
        let irradiance = PI * intensity * cosine / to_light.length_squared();
        sum += brdf(surface, view, direction) * irradiance;
    }
    sum
}

/// The bidirectional reflectance distribution function, of each channel.
fn brdf(surface: &Surface, view: DVec3, light: DVec3) -> DVec3 {
    let n = surface.normal;
    let half = (view + light).normalize();
    let alpha = surface.roughness.clamp(MIN_ROUGHNESS, 1.0).powi(2);
    let (n_v, n_l) = (n.dot(view).max(1e-4), n.dot(light).max(1e-4));
    let specular = distribution(n.dot(half).max(0.0), alpha) * visibility(n_v, n_l, alpha);
    let specular = DVec3::splat(specular);
    let grazing = (1.0 - view.dot(half).clamp(0.0, 1.0)).powi(5);
    let fresnel = |f0: DVec3| f0.lerp(DVec3::ONE, grazing);
    let diffuse = surface.base_color * FRAC_1_PI;
    let dielectric = fresnel(DVec3::splat(DIELECTRIC));
    let dielectric = diffuse + (specular - diffuse) * dielectric;
    dielectric.lerp(specular * fresnel(surface.base_color), surface.metallic)
}

/// GGX: the density of microfacets whose normals have this cosine to the surface's.
fn distribution(n_h: f64, alpha: f64) -> f64 {
    let a2 = alpha * alpha;
    a2 / (PI * (n_h * n_h * (a2 - 1.0) + 1.0).powi(2))
}

/// Smith's height-correlated masking and shadowing, divided by `4 n_v n_l`.
fn visibility(n_v: f64, n_l: f64, alpha: f64) -> f64 {
    let a2 = alpha * alpha;
    let side = |a: f64, b: f64| a * (b * b * (1.0 - a2) + a2).sqrt();
    0.5 / (side(n_l, n_v) + side(n_v, n_l))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface(metallic: f64, roughness: f64) -> Surface {
        Surface {
            base_color: DVec3::ONE,
            emissive: DVec3::ZERO,
            normal: DVec3::Z,
            metallic,
            roughness,
            occlusion: 1.0,
        }
    }

    /// Integrates over the directions of the hemisphere, which have equal solid angles.
    fn integral(f: impl Fn(DVec3) -> f64) -> f64 {
        // Enough for the lobe of a smooth surface at a grazing angle.
        let (steps, around) = (1000, 512);
        let ring = |i: usize| {
            let z = (i as f64 + 0.5) / steps as f64;
            let r = (1.0 - z * z).sqrt();
            let direction = |j: u32| {
                let angle = 2.0 * PI * (j as f64 + 0.5) / f64::from(around);
                f(DVec3::new(r * angle.cos(), r * angle.sin(), z))
            };
            (0..around).map(direction).sum::<f64>() / f64::from(around)
        };
        2.0 * PI * (0..steps).map(ring).sum::<f64>() / steps as f64
    }

    #[test]
    fn microfacets_cover_the_surface_once() {
        for alpha in [0.1, 0.3, 1.0] {
            let area = integral(|h| distribution(h.z, alpha) * h.z);
            assert!((area - 1.0).abs() < 1e-2, "{alpha}: {area}");
        }
    }

    /// The light that a white metal reflects, against an integration over the normals of the microfacets
    /// (400,000 random ones with the density of GGX), and the two layers of a white dielectric.
    #[test]
    fn reflected_light_is_that_of_the_microfacets() {
        let cases: [(f64, f64, f64); 6] = [
            (0.3, 0.3, 0.9462),
            (0.3, 0.7, 0.9850),
            (0.3, 1.0, 0.9904),
            (1.0, 0.3, 0.5605),
            (1.0, 0.7, 0.3802),
            (1.0, 1.0, 0.3071),
        ];
        for (roughness, z, expected) in cases {
            let view = DVec3::new((1.0 - z * z).sqrt(), 0.0, z);
            let reflected =
                |surface: &Surface| integral(|light| brdf(surface, view, light).x * light.z);
            let metal = reflected(&surface(1.0, roughness));
            assert!((metal - expected).abs() < 2e-3, "{roughness} {z}: {metal}");
            let white = surface(0.0, roughness);
            let layer = reflected(&Surface {
                base_color: DVec3::ZERO,
                ..white
            });
            let base = reflected(&white) - layer;
            assert!(
                layer < metal && base < 1.0,
                "{roughness} {z}: {layer} {base}"
            );
        }
    }

    #[test]
    fn light_and_view_are_exchangeable() {
        let [a, b] = [DVec3::new(0.2, 0.3, 0.9), DVec3::new(-0.7, 0.1, 0.5)].map(DVec3::normalize);
        for metallic in [0.0, 0.5, 1.0] {
            let surface = surface(metallic, 0.5);
            let difference = brdf(&surface, a, b).x - brdf(&surface, b, a).x;
            assert!(difference.abs() < 1e-12);
        }
    }

    #[test]
    fn light_comes_from_where_the_lights_are() {
        let center = |surface: &Surface| radiance(surface, [0.0; 2]).x;
        let tilted = |x: f64| Surface {
            normal: DVec3::new(x, 0.0, 1.0).normalize(),
            ..surface(0.0, 1.0)
        };
        // The light on the left is the brighter one.
        assert!(center(&tilted(-0.5)) > center(&tilted(0.5)));
        let away = Surface {
            normal: DVec3::NEG_Z,
            occlusion: 0.5,
            emissive: DVec3::splat(2.0),
            ..surface(0.0, 1.0)
        };
        let expected = 2.0 + 0.5 * AMBIENT * (1.0 + DIELECTRIC);
        assert!((center(&away) - expected).abs() < 1e-12);
    }
}
