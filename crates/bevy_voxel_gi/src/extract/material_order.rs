//! The order of the materials, which decides between two surfaces that fill as much of a voxel, such
//! as a picture and the wall it is on: the later one represents the voxel's face.
//!
//! Materials have labels, which voxels store. Their order is that of the materials' values, so the same scene has the
//! same light, whatever happened before, and a wall does not replace the emissive surface on it. Between labels there
//! are gaps: a material that changes gets another label only if it comes before or after another one than it did.

use std::{cmp::Ordering, iter};

use bevy::math::Vec3;

use super::voxel_material::VoxelMaterial;

/// The packed surface of a voxel's face has 12 bits for the label.
const MOST_LABELS: usize = 4096;

/// The part of a table entry that meshes use.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Entry {
    pub label: u32,
    pub transparent: bool,
    double_sided: bool,
    coverage: f32,
}

/// See the module documentation.
#[derive(Debug, Default)]
pub(super) struct MaterialOrder {
    /// All different values in their order, with their labels.
    labels: Vec<(VoxelMaterial, usize)>,
    /// The entries of the table.
    pub entries: Vec<Entry>,
}

impl MaterialOrder {
    /// Takes over a table, and returns its values by their labels.
    pub fn update(&mut self, mut table: Vec<VoxelMaterial>) -> Vec<VoxelMaterial> {
        let mut values = sorted(&table);
        let mut steps = 128.0;
        while values.len() > MOST_LABELS && steps >= 1.0 {
            bevy::log::warn_once!(
                "voxel GI: there are {} different materials (with those of vertex colours and \
                 `MeshVoxelMaterial`), and voxels tell {MOST_LABELS} apart: similar ones become one. Use fewer \
                 materials",
                values.len()
            );
            for material in &mut table {
                *material = rounded(*material, steps);
            }
            values = sorted(&table);
            steps /= 2.0;
        }
        values.truncate(MOST_LABELS);
        self.labels = labelled(values, &self.labels);
        let position = |material: &VoxelMaterial| {
            let found = self
                .labels
                .binary_search_by(|(value, _)| compare(value, material));
            found.unwrap_or_else(|place| place.min(self.labels.len() - 1))
        };
        let entry = |material: &VoxelMaterial| {
            let (value, label) = self.labels[position(material)];
            Entry {
                label: u32::try_from(label).unwrap_or(0),
                transparent: value.transparent == 1,
                double_sided: value.double_sided == 1,
                coverage: value.coverage,
            }
        };
        self.entries = table.iter().map(entry).collect();
        let most = self.labels.last().map_or(0, |(_, label)| label + 1);
        let mut by_label = vec![VoxelMaterial::NEUTRAL; most];
        for &(value, label) in &self.labels {
            by_label[label] = value;
        }
        by_label
    }
}

/// The different values of a table in their order.
fn sorted(table: &[VoxelMaterial]) -> Vec<VoxelMaterial> {
    let mut values = table.to_vec();
    values.sort_unstable_by(compare);
    values.dedup_by(|a, b| compare(a, b).is_eq());
    values
}

/// The material with its colours rounded to so many steps: of albedo, and of emission in each octave.
fn rounded(material: VoxelMaterial, steps: f32) -> VoxelMaterial {
    let linear = |v: f32| (v * steps).round() / steps;
    let relative = |v: f32| {
        if v > 0.0 {
            ((v.log2() * steps / 8.0).round() / (steps / 8.0)).exp2()
        } else {
            0.0
        }
    };
    let all = |v: Vec3, f: &dyn Fn(f32) -> f32| Vec3::new(f(v.x), f(v.y), f(v.z));
    VoxelMaterial {
        albedo: all(material.albedo, &linear),
        emissive: all(material.emissive, &relative),
        emissive_exposure_weight: linear(material.emissive_exposure_weight),
        coverage: linear(material.coverage),
        ..material
    }
}

/// Gives values in their order their labels: those that they had, and others in the gaps between these.
fn labelled(
    values: Vec<VoxelMaterial>,
    former: &[(VoxelMaterial, usize)],
) -> Vec<(VoxelMaterial, usize)> {
    let kept = |value: &VoxelMaterial| {
        let place = former.binary_search_by(|(known, _)| compare(known, value));
        place.ok().map(|place| former[place].1)
    };
    let mut labels: Vec<_> = values.iter().map(kept).collect();
    // Room for four times as many.
    let room = (4 * values.len())
        .next_power_of_two()
        .clamp(64, MOST_LABELS);
    let taken = former.last().map_or(0, |(_, label)| label + 1);
    if !fill_gaps(&mut labels, room.max(taken)) {
        labels = (0..values.len())
            .map(|i| Some((2 * i + 1) * room / (2 * values.len())))
            .collect();
    }
    iter::zip(values, labels.into_iter().flatten()).collect()
}

/// Spreads missing labels evenly between those that are there, below `room`; returns whether there is room for all.
fn fill_gaps(labels: &mut [Option<usize>], room: usize) -> bool {
    let mut start = 0;
    // The first label that is free.
    let mut low = 0;
    while start < labels.len() {
        let missing = labels[start..]
            .iter()
            .take_while(|label| label.is_none())
            .count();
        let next = labels.get(start + missing).copied().flatten();
        let high = next.unwrap_or(room);
        if high - low < missing {
            return false;
        }
        for i in 0..missing {
            labels[start + i] = Some(low + (2 * i + 1) * (high - low) / (2 * missing));
        }
        start += missing + 1;
        low = high + 1;
    }
    true
}

/// Compares by emission, then by albedo, then by all other fields.
fn compare(a: &VoxelMaterial, b: &VoxelMaterial) -> Ordering {
    let floats = |material: &VoxelMaterial| {
        let VoxelMaterial {
            albedo,
            emissive,
            emissive_exposure_weight,
            coverage,
            double_sided: _,
            transparent: _,
        } = *material;
        [
            emissive.element_sum(),
            albedo.element_sum(),
            emissive.x,
            emissive.y,
            emissive.z,
            albedo.x,
            albedo.y,
            albedo.z,
            emissive_exposure_weight,
            coverage,
        ]
    };
    let mut pairs = iter::zip(floats(a), floats(b));
    let by_floats = pairs.find_map(|(a, b)| Some(a.total_cmp(&b)).filter(|order| order.is_ne()));
    let words = |material: &VoxelMaterial| (material.double_sided, material.transparent);
    by_floats.unwrap_or_else(|| words(a).cmp(&words(b)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(albedo: f32) -> VoxelMaterial {
        VoxelMaterial {
            albedo: Vec3::splat(albedo),
            ..VoxelMaterial::NEUTRAL
        }
    }

    fn glowing(emissive: f32) -> VoxelMaterial {
        VoxelMaterial {
            emissive: Vec3::splat(emissive),
            ..VoxelMaterial::NEUTRAL
        }
    }

    fn labels(order: &MaterialOrder) -> Vec<u32> {
        order.entries.iter().map(|entry| entry.label).collect()
    }

    #[test]
    fn labels_have_the_order_of_values() {
        let table = vec![
            gray(0.5),
            glowing(1.0),
            gray(0.9),
            gray(0.1),
            glowing(1.0),
            gray(0.9),
        ];
        let mut order = MaterialOrder::default();
        let by_label = order.update(table.clone());
        let found = labels(&order);
        assert!(found[3] < found[0] && found[0] < found[2] && found[2] < found[1]);
        assert_eq!(
            (found[1], found[2]),
            (found[4], found[5]),
            "equal ones have one label"
        );
        for (value, label) in iter::zip(&table, found) {
            assert_eq!(by_label[label as usize], *value);
        }
        assert!(MaterialOrder::default().update(Vec::new()).is_empty());
    }

    #[test]
    fn a_pulsing_material_leaves_the_labels_of_others_alone() {
        let mut table: Vec<_> = (0..100).map(|i| glowing(1.0 + i as f32)).collect();
        let mut order = MaterialOrder::default();
        order.update(table.clone());
        let before = labels(&order);
        for step in 0..1000 {
            // Within its neighbours, and then past all of them.
            let wide = if step < 500 { 0.4 } else { 60.0 };
            table[50] = glowing(51.0 + wide * (0.37 * step as f32).sin());
            let by_label = order.update(table.clone());
            let mut now = labels(&order);
            assert_eq!(by_label[now[50] as usize], table[50]);
            if step < 500 {
                assert_eq!(now[50], before[50]);
            }
            now[50] = before[50];
            assert_eq!(now, before, "step {step}");
        }
    }

    #[test]
    fn labels_are_spread_anew_where_there_is_no_gap() {
        let mut table = vec![glowing(1.0), glowing(2.0)];
        let mut order = MaterialOrder::default();
        for i in 0..500 {
            table.push(glowing(1.0 + 0.5_f32.powi(1 + i % 20) + i as f32 * 1e-7));
            let by_label = order.update(table.clone());
            let found = labels(&order);
            for (a, first) in iter::zip(&table, &found) {
                for (b, second) in iter::zip(&table, &found) {
                    assert_eq!(a.emissive.x.total_cmp(&b.emissive.x), first.cmp(second));
                }
            }
            assert!(by_label.len() <= MOST_LABELS);
        }
    }

    #[test]
    fn too_many_materials_become_similar_ones() {
        let unit = |seed: u32| f32::from((seed.wrapping_mul(0x9e37_79b9) >> 16) as u16) / 65536.0;
        let table: Vec<_> = (0..50_000)
            .map(|i| VoxelMaterial {
                albedo: Vec3::new(unit(3 * i), unit(3 * i + 1), unit(3 * i + 2)),
                emissive: Vec3::X * f32::from(i % 10 == 0),
                ..VoxelMaterial::NEUTRAL
            })
            .collect();
        let mut order = MaterialOrder::default();
        let by_label = order.update(table.clone());
        assert!(by_label.len() <= MOST_LABELS);
        for (value, label) in iter::zip(&table, labels(&order)) {
            let found = by_label[label as usize];
            let wrong = (found.albedo - value.albedo).abs().max_element();
            assert!(
                wrong < 0.07 && found.emissive == value.emissive,
                "{found:?} {value:?}"
            );
        }
    }
}
