//! The order of the materials, which decides between two surfaces that fill as much of a voxel, such
//! as a picture and the wall it is on: the later one represents the voxel's face.

use std::cmp::Ordering;

use super::voxel_material::VoxelMaterial;

/// Sorts materials by value, not by when they were added, and removes duplicates; also returns the new
/// index of each entry of the table.
///
/// So the same scene always has the same light, and a wall does not replace the emissive surface on it.
pub(super) fn sorted_by_value(table: &[VoxelMaterial]) -> (Vec<VoxelMaterial>, Vec<u32>) {
    let mut by_value: Vec<_> = (0..table.len()).collect();
    by_value.sort_by(|&a, &b| compare(&table[a], &table[b]));
    let mut materials: Vec<VoxelMaterial> = Vec::new();
    let mut indices = vec![0; table.len()];
    for entry in by_value {
        if materials.last() != Some(&table[entry]) {
            materials.push(table[entry]);
        }
        indices[entry] = u32::try_from(materials.len() - 1).unwrap_or(0);
    }
    (materials, indices)
}

/// Compares by emission, then by albedo, then by all other fields.
fn compare(a: &VoxelMaterial, b: &VoxelMaterial) -> Ordering {
    let floats = |material: &VoxelMaterial| {
        let VoxelMaterial {
            albedo, emissive, ..
        } = material;
        let sums = [emissive.element_sum(), albedo.element_sum()];
        let rest = [material.emissive_exposure_weight, material.coverage];
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
    let words = |material: &VoxelMaterial| (material.double_sided, material.transparent);
    by_floats.unwrap_or_else(|| words(a).cmp(&words(b)))
}

#[cfg(test)]
mod tests {
    use bevy::math::Vec3;

    use super::*;

    #[test]
    fn materials_are_sorted_by_value() {
        let [dark, light] = [0.1, 0.9].map(|albedo| VoxelMaterial {
            albedo: Vec3::splat(albedo),
            ..VoxelMaterial::NEUTRAL
        });
        let emissive = VoxelMaterial {
            emissive: Vec3::X,
            ..dark
        };
        let neutral = VoxelMaterial::NEUTRAL;
        let (materials, indices) =
            sorted_by_value(&[neutral, emissive, light, dark, emissive, light]);
        assert_eq!(materials, [dark, neutral, light, emissive]);
        assert_eq!(indices, [1, 3, 2, 0, 3, 2]);
        assert_eq!(
            sorted_by_value(&[light, emissive, dark, neutral]).0,
            materials
        );
        assert!(sorted_by_value(&[]).0.is_empty());
    }
}
