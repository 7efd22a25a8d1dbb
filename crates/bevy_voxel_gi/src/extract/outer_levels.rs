//! The levels around the volumes: rays that leave the volumes see the world outside in them, out to its bounds. They are
//! coarser, and no pixel reads their light.

use bevy::{
    math::Vec3A,
    prelude::*,
    render::renderer::RenderDevice,
    shape::{Aabb3d, BoundingVolume},
};

use super::{
    meshes::{ExtractedMesh, ExtractedScene, SceneMeshes},
    place_volume::ExtractedVolume,
    placement::PlacedLevel,
};
use crate::{
    gpu_types::{MAX_LEVELS, MAX_LIT_LEVELS},
    prepare::buffers::{largest_buffer, most_bytes},
};

const MOST: usize = MAX_LEVELS - MAX_LIT_LEVELS;

/// How much larger each is than the one before: positions in a level are exact to an eighth of its voxel, which is seen
/// from the middle under less than one and a half degrees where the level before ends.
const STEP: f32 = 4.0;

/// A level moves by this part of its size, so that it stays where the bounds of the world hardly change.
const GRID: f32 = 1.0 / 16.0;

/// Appends them to the levels of the volumes.
pub(crate) fn place_outer_levels(
    mut volume: ResMut<ExtractedVolume>,
    mut scene: ResMut<ExtractedScene>,
    device: Res<RenderDevice>,
) {
    let Some(volume) = &mut volume.0 else {
        return;
    };
    let light = volume.settings.light;
    let sees_far = !light.propagates() && !light.is_occlusion();
    let Some(largest) = volume.levels.last().filter(|_| sees_far) else {
        // Changes are not followed meanwhile.
        scene.world = WorldBounds::default();
        return;
    };
    let resolution = volume.settings.resolution;
    let ExtractedScene { world, meshes, .. } = &mut *scene;
    let Some(bounds) = world.update(meshes, largest.center, resolution) else {
        return;
    };
    let mut outer = outer_levels(largest, bounds, resolution);
    let most_bytes = most_bytes(&device.limits());
    let lit = volume.levels.len();
    while !outer.is_empty()
        && largest_buffer(&volume.settings, resolution, (lit + outer.len()) as u64) > most_bytes
    {
        outer.pop();
    }
    volume.levels.extend(outer);
}

/// The levels around the largest level of the volumes, from small to large, for a world with these corners.
fn outer_levels(
    largest: &PlacedLevel,
    (low, high): (Vec3, Vec3),
    resolution: u32,
) -> Vec<PlacedLevel> {
    let mut levels: Vec<PlacedLevel> = Vec::new();
    let contains = |level: &PlacedLevel| {
        let half = Vec3::splat(0.5 * level.size);
        low.cmpge(level.center - half).all() && high.cmple(level.center + half).all()
    };
    let level = |center: Vec3, size: f32, step: f32| PlacedLevel {
        center: (center / step).round() * step,
        size,
        is_outer: true,
        ..largest.clone()
    };
    // The smallest cube in half steps of powers of two that contains the world, wherever it is on its grid.
    let length = (high - low).max_element() / (1.0 - GRID);
    let steps = (2.0 * (length / largest.size).log2()).ceil().max(0.0);
    let size = largest.size * (0.5 * steps).exp2();
    let whole = level(0.5 * (low + high), size, GRID * size);
    while levels.len() < MOST && !contains(levels.last().unwrap_or(largest)) {
        let next = STEP * levels.last().unwrap_or(largest).size;
        if whole.size <= next {
            levels.push(whole);
            break;
        }
        levels.push(level(largest.center, next, next / resolution as f32));
    }
    levels
}

/// The bounds of the world as far as rays from the volumes can tell. Those of what rests are kept from frame to frame.
#[derive(Default)]
pub(crate) struct WorldBounds {
    resting: Option<Aabb3d>,
    center: Vec3,
    resolution: u32,
}

impl WorldBounds {
    fn update(
        &mut self,
        meshes: &mut SceneMeshes,
        center: Vec3,
        resolution: u32,
    ) -> Option<(Vec3, Vec3)> {
        let is_same = (self.center, self.resolution) == (center, resolution);
        (self.center, self.resolution) = (center, resolution);
        let left = meshes.take_left().filter(|_| is_same);
        let [recent, resting] = meshes.recent_and_resting();
        if left.is_none_or(|left| left.iter().any(|mesh| self.rests_at_corners(mesh))) {
            self.resting = self.bounds(resting);
        }
        let both = [self.bounds(recent), self.resting].into_iter().flatten();
        let all = both.reduce(|a, b| a.merge(&b))?;
        Some((all.min.into(), all.max.into()))
    }

    /// Whether the bounds of what rests may be smaller without a mesh.
    fn rests_at_corners(&self, mesh: &ExtractedMesh) -> bool {
        let both = self.resting.zip(self.bounds_of(mesh));
        both.is_some_and(|(all, mesh)| {
            mesh.min.cmple(all.min).any() || mesh.max.cmpge(all.max).any()
        })
    }

    fn bounds<'a>(&self, meshes: impl Iterator<Item = &'a ExtractedMesh>) -> Option<Aabb3d> {
        let all = meshes.filter_map(|mesh| self.bounds_of(mesh));
        all.reduce(|a, b| a.merge(&b))
    }

    /// The bounds of a mesh that counts.
    fn bounds_of(&self, mesh: &ExtractedMesh) -> Option<Aabb3d> {
        let counts = mesh.is_culled && !mesh.is_deformed();
        let (center, half_size) = mesh.bounds.filter(|_| counts)?;
        // Else it would be smaller than a sub-voxel of a level that reaches as far.
        let distance = (center - Vec3A::from(self.center)).abs().max_element();
        let resolved = half_size.max_element() * 4.0 * self.resolution as f32;
        let counts = center.is_finite() && half_size.is_finite() && resolved >= distance;
        counts.then(|| Aabb3d {
            min: center - half_size,
            max: center + half_size,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sizes(levels: &[PlacedLevel]) -> Vec<f32> {
        levels.iter().map(|level| level.size).collect()
    }

    #[test]
    fn the_world_is_in_as_many_levels_as_it_takes_and_in_none_where_the_volume_has_it() {
        let volume = PlacedLevel::of(Vec3::new(1.0, 2.0, 3.0), 16.0);
        let cube = |half: f32| (Vec3::splat(-half), Vec3::splat(half));
        assert!(outer_levels(&volume, cube(4.9), 32).is_empty());
        // 60 metres need 64.
        assert_eq!(sizes(&outer_levels(&volume, cube(30.0), 32)), [64.0]);
        assert_eq!(
            sizes(&outer_levels(&volume, cube(100.0), 32)),
            [64.0, 256.0]
        );
        let far = outer_levels(&volume, cube(1e4), 32);
        assert_eq!(sizes(&far), [64.0, 256.0, 1024.0]);
        for level in &far {
            let voxel = level.size / 32.0;
            assert!((level.center / voxel).fract().abs().max_element() < 1e-5);
            assert!(level.center.distance(volume.center) < voxel);
        }
    }

    #[test]
    fn the_last_level_contains_the_world_and_stays_as_long_as_its_bounds_hardly_change() {
        let volume = PlacedLevel::of(Vec3::ZERO, 16.0);
        let whole = |low: Vec3, high: Vec3| outer_levels(&volume, (low, high), 32).remove(0);
        for shift in 0..20 {
            let low = Vec3::new(-20.0 + 0.7 * shift as f32, -3.0, 2.0);
            let high = low + Vec3::new(39.0, 5.0, 12.0);
            let found = whole(low, high);
            assert_eq!(found.size, 45.254833);
            let half = Vec3::splat(0.5 * found.size);
            assert!(low.cmpge(found.center - half).all());
            assert!(high.cmple(found.center + half).all());
        }
        let (low, high) = (Vec3::splat(-20.0), Vec3::splat(20.0));
        assert_eq!(whole(low, high), whole(low - 0.1, high));
    }

    fn mesh(center: Vec3, half_size: f32) -> ExtractedMesh {
        ExtractedMesh::with_bounds(Some((center.into(), Vec3A::splat(half_size))))
    }

    #[test]
    fn bounds_follow_what_comes_moves_and_goes_as_if_they_were_found_anew() {
        let mut meshes = SceneMeshes::default();
        let mut kept = WorldBounds::default();
        let entity = |index: u32| Entity::from_raw_u32(index).expect("an index");
        let bounds =
            |kept: &mut WorldBounds, meshes: &mut SceneMeshes| kept.update(meshes, Vec3::ZERO, 32);
        let mut state = 1_u32;
        for step in 0..2000 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let (index, x) = (state >> 8 & 31, (state >> 16 & 63) as f32 - 32.0);
            meshes.begin_frame();
            let stays = state >> 28 != 0;
            meshes.set(entity(index), stays.then(|| mesh(Vec3::X * x, 1.0)));
            let found = bounds(&mut kept, &mut meshes);
            let anew = bounds(&mut WorldBounds::default(), &mut meshes);
            assert_eq!(found, anew, "step {step}");
            meshes.update_changed(|_| {});
        }
        for index in 0..32 {
            meshes.set(entity(index), Some(mesh(Vec3::X * 3.0, 1.0)));
        }
        // From 200 metres a metre is less than a sub-voxel.
        meshes.set(entity(40), Some(mesh(Vec3::X * 200.0, 1.0)));
        meshes.set(entity(41), Some(mesh(Vec3::X, f32::INFINITY)));
        meshes.set(entity(42), Some(mesh(Vec3::NAN, 1.0)));
        let (low, high) = bounds(&mut kept, &mut meshes).expect("bounds");
        assert_eq!((low.x, high.x), (2.0, 4.0));
    }
}
