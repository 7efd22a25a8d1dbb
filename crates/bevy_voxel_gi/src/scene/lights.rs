//! Extracts the lights, including those outside of every view.

use bevy::{prelude::*, render::Extract, render::render_resource::ShaderType};

/// A light as `inject.wesl` reads it. Keep both in sync.
#[derive(ShaderType, Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct GpuLight {
    /// Position in metres; unused for directional lights.
    pub position: Vec3,
    /// 0: directional, 1: point, 2: spot.
    pub kind: u32,
    /// Illuminance in lux (directional) or luminous intensity in candela, per channel.
    pub color: Vec3,
    /// 1 / range² in 1/m².
    pub inverse_range_squared: f32,
    /// Direction in which the light travels, a unit vector.
    pub direction: Vec3,
    /// Attenuation of the cone: (cos angle · scale + offset)², where the base is clamped to 0..1.
    pub spot_scale: f32,
    pub spot_offset: f32,
    pub pad: Vec3,
}

const DIRECTIONAL: u32 = 0;
const POINT: u32 = 1;
const SPOT: u32 = 2;

/// The lights of this frame.
#[derive(Resource, Default)]
pub(crate) struct ExtractedLights(pub Vec<GpuLight>);

pub(crate) fn extract_lights(
    mut lights: ResMut<ExtractedLights>,
    suns: Extract<Query<(&DirectionalLight, &GlobalTransform, &InheritedVisibility)>>,
    lamps: Extract<Query<(&PointLight, &GlobalTransform, &InheritedVisibility)>>,
    spots: Extract<Query<(&SpotLight, &GlobalTransform, &InheritedVisibility)>>,
) {
    let lights = &mut lights.0;
    lights.clear();
    for (light, transform, visible) in &suns {
        if visible.get() {
            lights.push(sun(light, transform));
        }
    }
    for (light, transform, visible) in &lamps {
        if visible.get() {
            lights.push(lamp(light, transform));
        }
    }
    for (light, transform, visible) in &spots {
        if visible.get() {
            lights.push(spot(light, transform));
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

fn sun(light: &DirectionalLight, transform: &GlobalTransform) -> GpuLight {
    GpuLight {
        position: Vec3::ZERO,
        kind: DIRECTIONAL,
        color: light.color.to_linear().to_vec3() * light.illuminance,
        inverse_range_squared: 0.0,
        direction: transform.forward().as_vec3(),
        spot_scale: 0.0,
        spot_offset: 1.0,
        pad: Vec3::ZERO,
    }
}

fn lamp(light: &PointLight, transform: &GlobalTransform) -> GpuLight {
    GpuLight {
        position: transform.translation(),
        kind: POINT,
        color: light.color.to_linear().to_vec3() * candela(light.intensity),
        inverse_range_squared: (light.range * light.range).recip(),
        ..sun(&DirectionalLight::default(), transform)
    }
}

fn spot(light: &SpotLight, transform: &GlobalTransform) -> GpuLight {
    // The cone attenuation of Bevy's spot lights.
    let outer = light.outer_angle.cos();
    let spot_scale = (light.inner_angle.cos() - outer).max(1e-4).recip();
    GpuLight {
        position: transform.translation(),
        kind: SPOT,
        color: light.color.to_linear().to_vec3() * candela(light.intensity),
        inverse_range_squared: (light.range * light.range).recip(),
        spot_scale,
        spot_offset: -outer * spot_scale,
        ..sun(&DirectionalLight::default(), transform)
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
        let point = lamp(&light, &transform);
        assert!((point.color - Vec3::ONE).abs().max_element() < 1e-6);
        assert!((point.inverse_range_squared - 0.01).abs() < 1e-8);
        let light = SpotLight {
            inner_angle: 0.3,
            outer_angle: 0.6,
            ..default()
        };
        let spot = spot(&light, &transform);
        let cone = |angle: f32| angle.cos() * spot.spot_scale + spot.spot_offset;
        assert!(cone(0.6).abs() < 1e-4);
        assert!((cone(0.3) - 1.0).abs() < 1e-4);
        assert_eq!(spot.direction, Vec3::NEG_Z);
    }
}
