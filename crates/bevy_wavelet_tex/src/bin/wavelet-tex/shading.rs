//! Light that a flat square with the maps of a material reflects to a camera.
//!
//! The BRDF is that of glTF 2.0, appendix B: a Lambertian base under a GGX microfacet layer with Smith's
//! height-correlated visibility and Schlick's Fresnel term. Bevy's differs in its diffuse part alone. The
//! two layers of a white dielectric reflect up to 1.09 of the light together at grazing angles, since the
//! Fresnel term of the appendix does not take all of the upper layer's light from the base.

use std::f64::consts::{FRAC_1_PI, PI};

pub type Vec3 = [f64; 3];

/// What a pixel of the maps says about the surface, in linear units.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    pub base_color: Vec3,
    pub emissive: Vec3,
    /// Unit normal in tangent space.
    pub normal: Vec3,
    pub metallic: f64,
    /// Perceptual roughness, the square root of GGX's alpha.
    pub roughness: f64,
    /// Part of the ambient light that arrives.
    pub occlusion: f64,
}

/// Position of the camera. The square spans -1 to 1 in X and Y at Z = 0 and faces +Z.
const CAMERA: Vec3 = [0.0, 0.0, 2.0];

/// Positions of the point lights and their intensities: one from the upper left, one from the right, and a
/// grazing one from below, which shows the normals.
const LIGHTS: [(Vec3, f64); 3] = [
    ([-0.8, 0.9, 1.2], 3.0),
    ([1.0, 0.2, 1.6], 2.0),
    ([0.1, -1.3, 0.5], 1.5),
];

/// Radiance of the ambient light, the same from all sides.
const AMBIENT: f64 = 0.15;

/// Least roughness, as in Bevy: the highlight of a smoother surface would be missed between pixels.
const MIN_ROUGHNESS: f64 = 0.089;

/// Reflectance of dielectrics at normal incidence.
const DIELECTRIC: f64 = 0.04;

/// Radiance that the surface at `[x, y]` sends to the camera.
pub fn radiance(surface: &Surface, [x, y]: [f64; 2]) -> Vec3 {
    let position = [x, y, 0.0];
    let view = normalized(sub(CAMERA, position));
    let ambient = AMBIENT * surface.occlusion;
    let mut sum: Vec3 = std::array::from_fn(|c| {
        let specular = mix(DIELECTRIC, surface.base_color[c], surface.metallic);
        let diffuse = surface.base_color[c] * (1.0 - surface.metallic);
        surface.emissive[c] + ambient * (diffuse + specular)
    });
    for (light, intensity) in LIGHTS {
        let to_light = sub(light, position);
        let direction = normalized(to_light);
        let cosine = dot(surface.normal, direction).max(0.0);
        let irradiance = PI * intensity * cosine / dot(to_light, to_light);
        let reflected = brdf(surface, view, direction);
        (0..3).for_each(|c| sum[c] += reflected[c] * irradiance);
    }
    sum
}

/// The bidirectional reflectance distribution function, of each channel.
pub fn brdf(surface: &Surface, view: Vec3, light: Vec3) -> Vec3 {
    let n = surface.normal;
    let half = normalized([0, 1, 2].map(|i| view[i] + light[i]));
    let alpha = surface.roughness.clamp(MIN_ROUGHNESS, 1.0).powi(2);
    let (n_v, n_l) = (dot(n, view).max(1e-4), dot(n, light).max(1e-4));
    let specular = distribution(dot(n, half).max(0.0), alpha) * visibility(n_v, n_l, alpha);
    let grazing = (1.0 - dot(view, half).clamp(0.0, 1.0)).powi(5);
    std::array::from_fn(|c| {
        let base = surface.base_color[c];
        let fresnel = |f0: f64| f0 + (1.0 - f0) * grazing;
        let dielectric = fresnel(DIELECTRIC);
        let dielectric = mix(base * FRAC_1_PI, specular, dielectric);
        mix(dielectric, specular * fresnel(base), surface.metallic)
    })
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

fn mix(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [0, 1, 2].map(|i| a[i] - b[i])
}

fn normalized(v: Vec3) -> Vec3 {
    let length = dot(v, v).sqrt();
    v.map(|v| v / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface(metallic: f64, roughness: f64) -> Surface {
        Surface {
            base_color: [1.0; 3],
            emissive: [0.0; 3],
            normal: [0.0, 0.0, 1.0],
            metallic,
            roughness,
            occlusion: 1.0,
        }
    }

    /// Integrates over the directions of the hemisphere, which have equal solid angles.
    fn integral(f: impl Fn(Vec3) -> f64) -> f64 {
        // Enough for the lobe of a smooth surface at a grazing angle.
        let (steps, around) = (1000, 512);
        let ring = |i: usize| {
            let z = (i as f64 + 0.5) / steps as f64;
            let r = (1.0 - z * z).sqrt();
            let direction = |j: u32| {
                let angle = 2.0 * PI * (j as f64 + 0.5) / f64::from(around);
                f([r * angle.cos(), r * angle.sin(), z])
            };
            (0..around).map(direction).sum::<f64>() / f64::from(around)
        };
        2.0 * PI * (0..steps).map(ring).sum::<f64>() / steps as f64
    }

    #[test]
    fn microfacets_cover_the_surface_once() {
        for alpha in [0.1, 0.3, 1.0] {
            let area = integral(|h| distribution(h[2], alpha) * h[2]);
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
            let view = [(1.0 - z * z).sqrt(), 0.0, z];
            let reflected =
                |surface: &Surface| integral(|light| brdf(surface, view, light)[0] * light[2]);
            let metal = reflected(&surface(1.0, roughness));
            assert!((metal - expected).abs() < 2e-3, "{roughness} {z}: {metal}");
            let white = surface(0.0, roughness);
            let layer = reflected(&Surface {
                base_color: [0.0; 3],
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
        let (a, b) = (normalized([0.2, 0.3, 0.9]), normalized([-0.7, 0.1, 0.5]));
        for metallic in [0.0, 0.5, 1.0] {
            let surface = surface(metallic, 0.5);
            let difference = brdf(&surface, a, b)[0] - brdf(&surface, b, a)[0];
            assert!(difference.abs() < 1e-12);
        }
    }

    #[test]
    fn light_comes_from_where_the_lights_are() {
        let center = |surface: &Surface| radiance(surface, [0.0; 2])[0];
        let tilted = |x: f64| Surface {
            normal: normalized([x, 0.0, 1.0]),
            ..surface(0.0, 1.0)
        };
        // The light on the left is the brighter one.
        assert!(center(&tilted(-0.5)) > center(&tilted(0.5)));
        let away = Surface {
            normal: [0.0, 0.0, -1.0],
            occlusion: 0.5,
            emissive: [2.0; 3],
            ..surface(0.0, 1.0)
        };
        let expected = 2.0 + 0.5 * AMBIENT * (1.0 + DIELECTRIC);
        assert!((center(&away) - expected).abs() < 1e-12);
    }
}
