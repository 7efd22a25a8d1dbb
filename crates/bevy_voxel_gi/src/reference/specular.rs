//! The specular light of rough surfaces: what pixels read with `VoxelGiSettings::specular_light`.

use super::irradiance_field::IrradianceField;
use glam::{Vec3, Vec4};
use std::f32::consts::PI;

/// Distances of the planes along a lobe, in voxels.
const DISTANCES: [f32; 3] = [1.5, 3.0, 6.0];

/// Weight of an empty voxel.
const EMPTY_WEIGHT: f32 = 1.0 / 512.0;

impl IrradianceField {
    /// Returns about the mean radiance that the GGX lobe of a surface sees, in cd/m².
    ///
    /// The wider the lobe, the more it is that of the whole hemisphere; else irradiances of planes that face the mirror's
    /// direction, at three distances along it, are mixed in up to the first surface. That of the hemisphere is without the
    /// light from beyond [`dividers`](super::dividers::dividers). `position` is in metres; `normal` and `to_viewer` are unit
    /// vectors, and `roughness` is perceptual, 0.3 to 1.
    pub fn specular_radiance(
        &self,
        dividers: &[Vec3],
        position: Vec3,
        normal: Vec3,
        to_viewer: Vec3,
        roughness: f32,
    ) -> Vec3 {
        let direction = 2.0 * normal.dot(to_viewer) * normal - to_viewer;
        let receiver = self.grid.to_grid(position);
        let mut radiance = self.divided_irradiance(dividers, position, normal, to_viewer) / PI;
        // The weight of what no surface hides so far.
        let mut left = 1.0 - roughness * roughness;
        for distance in DISTANCES {
            let plane = self.facing_plane(receiver + direction * distance, direction);
            radiance += (plane.truncate() / PI - radiance * plane.w) * left;
            left *= plane.w * plane.w;
        }
        radiance
    }

    /// Irradiance of a plane that faces a direction times its visibility, and its visibility: in front of surfaces are
    /// voxels without one. More weight is that of a surface seen from behind, so the plane is behind it, and less is inside
    /// of a solid.
    fn facing_plane(&self, at: Vec3, direction: Vec3) -> Vec4 {
        let mut sum = Vec4::ZERO;
        for axis in 0..3 {
            let texel = self.sample(at, 2 * axis + usize::from(direction[axis] < 0.0));
            let visible = 1.0 / (texel.w / EMPTY_WEIGHT).max(1.0);
            sum += texel * ((visible * direction[axis]).powi(2) / EMPTY_WEIGHT);
        }
        sum
    }
}
