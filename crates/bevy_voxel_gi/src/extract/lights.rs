//! Extracts the lights, including those outside of every view.

use bevy::{prelude::*, render::Extract};

use crate::gpu_types::{LIGHT_DIRECTIONAL, LIGHT_POINT, LIGHT_SPOT, Light};

/// The lights of this frame.
#[derive(Resource, Default)]
pub(crate) struct ExtractedLights(pub Vec<Light>);

pub(crate) fn extract_lights(
    mut lights: ResMut<ExtractedLights>,
    directional: Extract<Query<(&DirectionalLight, &GlobalTransform, &InheritedVisibility)>>,
    points: Extract<Query<(&PointLight, &GlobalTransform, &InheritedVisibility)>>,
    spots: Extract<Query<(&SpotLight, &GlobalTransform, &InheritedVisibility)>>,
) {
    let lights = &mut lights.0;
    lights.clear();
    for (light, transform, visible) in &directional {
        if visible.get() {
            lights.push(directional_light(light, transform));
        }
    }
    for (light, transform, visible) in &points {
        if visible.get() {
            lights.push(point_light(light, transform));
        }
    }
    for (light, transform, visible) in &spots {
        if visible.get() {
            lights.push(spot_light(light, transform));
        }
    }
    lights.retain(|light| {
        let finite = light.color.is_finite()
            && light.position.is_finite()
            && light.direction.is_finite()
            && light.inverse_range_squared.is_finite();
        finite && light.color.max_element() > 0.0
    });
}

fn directional_light(light: &DirectionalLight, transform: &GlobalTransform) -> Light {
    Light {
        position: Vec3::ZERO,
        kind: LIGHT_DIRECTIONAL,
        color: light.color.to_linear().to_vec3() * light.illuminance,
        inverse_range_squared: 0.0,
        direction: transform.forward().as_vec3(),
        spot_scale: 0.0,
        spot_offset: 1.0,
        pad: Vec3::ZERO,
    }
}

fn point_light(light: &PointLight, transform: &GlobalTransform) -> Light {
    Light {
        position: transform.translation(),
        kind: LIGHT_POINT,
        color: light.color.to_linear().to_vec3() * candela(light.intensity),
        inverse_range_squared: (light.range * light.range).recip(),
        ..directional_light(&DirectionalLight::default(), transform)
    }
}

fn spot_light(light: &SpotLight, transform: &GlobalTransform) -> Light {
    // The cone attenuation of Bevy's spot lights.
    let outer = light.outer_angle.cos();
    let spot_scale = (light.inner_angle.cos() - outer).max(1e-4).recip();
    Light {
        position: transform.translation(),
        kind: LIGHT_SPOT,
        color: light.color.to_linear().to_vec3() * candela(light.intensity),
        inverse_range_squared: (light.range * light.range).recip(),
        spot_scale,
        spot_offset: -outer * spot_scale,
        ..directional_light(&DirectionalLight::default(), transform)
    }
}

/// Luminous intensity of a light of this luminous power in lumens. As in Bevy, the power is spread over
/// the whole sphere, for spot lights too.
fn candela(lumens: f32) -> f32 {
    lumens / (4.0 * std::f32::consts::PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lumens_and_cones_are_bevys() {
        let transform = GlobalTransform::from_xyz(1.0, 2.0, 3.0);
        let light = PointLight {
            intensity: 4.0 * std::f32::consts::PI,
            range: 10.0,
            ..default()
        };
        let point = point_light(&light, &transform);
        assert!((point.color - Vec3::ONE).abs().max_element() < 1e-6);
        assert!((point.inverse_range_squared - 0.01).abs() < 1e-8);
        let light = SpotLight {
            inner_angle: 0.3,
            outer_angle: 0.6,
            ..default()
        };
        let spot = spot_light(&light, &transform);
        let cone = |angle: f32| angle.cos() * spot.spot_scale + spot.spot_offset;
        assert!(cone(0.6).abs() < 1e-4);
        assert!((cone(0.3) - 1.0).abs() < 1e-4);
        assert_eq!(spot.direction, Vec3::NEG_Z);
    }
}
