//! The order of the surface table, which decides between two surfaces that fill as much of a voxel, such
//! as a picture and the wall it is on: the later one represents the voxel's face.

use std::cmp::Ordering;

use super::voxel_material::VoxelMaterial;

/// Sorts surfaces by value, not by when they were added, and removes duplicates; also returns the new
/// index of each entry of the table.
///
/// So the same scene always has the same light, and a wall does not replace the emissive surface on it.
pub(super) fn ordered(table: &[VoxelMaterial]) -> (Vec<VoxelMaterial>, Vec<u32>) {
    let mut by_value: Vec<_> = (0..table.len()).collect();
    by_value.sort_by(|&a, &b| compare(&table[a], &table[b]));
    let mut surfaces: Vec<VoxelMaterial> = Vec::new();
    let mut indices = vec![0; table.len()];
    for place in by_value {
        if surfaces.last() != Some(&table[place]) {
            surfaces.push(table[place]);
        }
        indices[place] = u32::try_from(surfaces.len() - 1).unwrap_or(0);
    }
    (surfaces, indices)
}

/// Compares by emission, then by albedo, then by all other fields.
fn compare(a: &VoxelMaterial, b: &VoxelMaterial) -> Ordering {
    let floats = |surface: &VoxelMaterial| {
        let VoxelMaterial {
            albedo, emissive, ..
        } = surface;
        let sums = [emissive.element_sum(), albedo.element_sum()];
        let rest = [surface.emissive_exposure_weight, surface.coverage];
        [
            &sums[..],
            &emissive.to_array(),
            &albedo.to_array(),
            &rest[..],
        ]
        .concat()
    };
    let mut pairs = floats(a).into_iter().zip(floats(b));
    let by_floats = pairs.find_map(|(a, b)| Some(a.total_cmp(&b)).filter(|order| order.is_ne()));
    let words = |surface: &VoxelMaterial| (surface.double_sided, surface.transparent);
    by_floats.unwrap_or_else(|| words(a).cmp(&words(b)))
}

#[cfg(test)]
mod tests {
    use bevy::math::Vec3;

    use super::*;

    #[test]
    fn surfaces_are_ordered_by_what_they_are() {
        let [dark, light] = [0.1, 0.9].map(|albedo| VoxelMaterial {
            albedo: Vec3::splat(albedo),
            ..VoxelMaterial::NEUTRAL
        });
        let lamp = VoxelMaterial {
            emissive: Vec3::X,
            ..dark
        };
        let neutral = VoxelMaterial::NEUTRAL;
        let (surfaces, indices) = ordered(&[neutral, lamp, light, dark, lamp, light]);
        assert_eq!(surfaces, [dark, neutral, light, lamp]);
        assert_eq!(indices, [1, 3, 2, 0, 3, 2]);
        assert_eq!(ordered(&[light, lamp, dark, neutral]).0, surfaces);
        assert!(ordered(&[]).0.is_empty());
    }
}
