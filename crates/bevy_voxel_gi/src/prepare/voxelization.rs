//! What of the scene is voxelised in a frame: voxels where it has changed since it was voxelised last, and those that
//! a level that has moved has not had before.

use bevy::{
    math::Vec3A,
    prelude::*,
    render::{render_resource::Buffer, renderer::RenderQueue},
};

use super::mesh_group::LevelMask;
use crate::{
    extract::placement::{PlacedLevel, PlacedVolume},
    gpu_types::{Changes, MAX_LEVELS},
    settings::Voxelizer,
};

/// What is voxelised in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Voxelization {
    Whole,
    /// The voxels that are dirty. Others of these axes have moved in levels that have moved.
    Part {
        moved: BVec3,
    },
}

/// What the voxels depend on.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Voxelized {
    /// Hash of everything except colours.
    pub fingerprint: u64,
    /// Version of the materials.
    pub materials: u64,
    pub voxelizer: Voxelizer,
    pub has_shadow_masks: bool,
}

impl Voxelized {
    /// Whether only parts of what was voxelised before may be others now.
    pub(super) fn continues(self, before: Self) -> bool {
        let Self {
            fingerprint,
            materials,
            ..
        } = before;
        let same = Self {
            fingerprint,
            materials,
            ..self
        };
        same == before
    }
}

/// By how many of its voxels each level has moved.
pub(super) struct Moves {
    pub by: [IVec4; MAX_LEVELS],
    /// Whether these are whole ones.
    pub are_whole: bool,
}

impl Moves {
    /// Those in the world since the levels were these; `None` if other ones light pixels now. The world has moved, too.
    pub(super) fn since(
        before: &[PlacedLevel],
        volume: &PlacedVolume,
        world_move: Vec3,
    ) -> Option<Self> {
        let is_same = |old: &PlacedLevel, new: &PlacedLevel| {
            (old.owner, old.size, old.is_outer) == (new.owner, new.size, new.is_outer)
        };
        let count = before.iter().take_while(|level| !level.is_outer).count();
        let are_same = count == volume.lit().len() && { before.iter().zip(volume.lit()) }
            .all(|(old, new)| is_same(old, new));
        if !are_same {
            return None;
        }
        let mut moves = Self {
            by: default(),
            are_whole: true,
        };
        for (i, (by, new)) in moves.by.iter_mut().zip(&volume.levels).enumerate() {
            let Some(old) = before.get(i).filter(|old| is_same(old, new)) else {
                *by = IVec3::splat(FAR).extend(0);
                continue;
            };
            let (moved, is_whole) =
                voxels_between(old.center + world_move, new.center, volume.voxel_size(new));
            *by = moved.extend(0);
            moves.are_whole &= is_whole;
        }
        Some(moves)
    }
}

/// So many voxels are outside of any level.
const FAR: i32 = 1_000_000;

/// Parts of a voxel that are rounding.
const ROUNDING: f32 = 1e-3;

/// The number of voxels from one position to another, and whether it is a whole one but for rounding.
fn voxels_between(old: Vec3, new: Vec3, voxel_size: f32) -> (IVec3, bool) {
    let exact = (new - old) / voxel_size;
    let voxels = exact.round();
    if voxels.is_nan() {
        return (IVec3::ZERO, false);
    }
    let far = Vec3::splat(FAR as f32);
    let is_whole = (exact - voxels).abs().max_element() <= ROUNDING;
    (voxels.clamp(-far, far).as_ivec3(), is_whole)
}

/// What is voxelised after these moves: everything, if no `regions` are given or everything may have changed in them.
pub(super) fn changes(
    volume: &PlacedVolume,
    moves: Option<Moves>,
    regions: Option<ChangedRegions>,
) -> (DirtyVoxels, Changes) {
    let (resolution, levels) = (volume.settings.resolution, &volume.levels);
    let moves = moves.map(|moves| moves.by).unwrap_or_default();
    let dirty = regions
        .filter(|regions| !regions.everything)
        .map(|regions| {
            let mut dirty = DirtyVoxels::none(resolution, levels.len());
            dirty.mark_regions(&regions, levels);
            for (level, by) in (0..).zip(&moves).take(levels.len()) {
                dirty.mark_entered(level, by.truncate());
            }
            dirty
        });
    let changes = Changes {
        moves,
        is_whole: u32::from(dirty.is_none()),
    };
    let all = || DirtyVoxels::all(resolution, levels.len());
    (dirty.unwrap_or_else(all), changes)
}

impl Voxelization {
    pub(super) fn of(changes: &Changes) -> Self {
        if changes.is_whole != 0 {
            return Self::Whole;
        }
        let moves = changes.moves.iter();
        let moves = moves.map(|by| by.truncate().cmpne(IVec3::ZERO));
        Self::Part {
            moved: moves.fold(BVec3::FALSE, |a, b| a | b),
        }
    }
}

/// Centre and half extents of a box in the world.
pub(super) type Bounds = (Vec3A, Vec3A);

/// Boxes in the world where meshes have changed, in the levels with a bit in the mask.
#[derive(Debug, Default)]
pub(super) struct ChangedRegions {
    boxes: Vec<(Bounds, LevelMask)>,
    /// Everything may have changed.
    pub everything: bool,
}

impl ChangedRegions {
    /// More boxes than these are everything.
    const MOST: usize = 1 << 16;

    /// Adds the bounds of a mesh, if they are known, in the levels that it reaches into.
    pub(super) fn add(&mut self, bounds: Option<Bounds>, levels: LevelMask) {
        match bounds.filter(|_| self.boxes.len() < Self::MOST) {
            Some(bounds) => self.boxes.push((bounds, levels)),
            None => self.everything = true,
        }
    }
}

/// A bit for each voxel of all levels.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct DirtyVoxels {
    resolution: u32,
    bits: Vec<u32>,
}

impl DirtyVoxels {
    /// What boxes are widened by in voxels, and as a share of the distance from the origin: the voxelisers round
    /// otherwise.
    const MARGIN: f32 = 0.125;
    const ROUNDING: f32 = 2e-6;

    pub(super) fn none(resolution: u32, levels: usize) -> Self {
        let voxels = resolution.pow(3) as usize * levels;
        Self {
            resolution,
            bits: vec![0; voxels.div_ceil(32)],
        }
    }

    pub(super) fn all(resolution: u32, levels: usize) -> Self {
        let mut all = Self::none(resolution, levels);
        all.bits.fill(u32::MAX);
        all
    }

    pub(super) fn write(&self, buffer: &Buffer, offset: u64, queue: &RenderQueue) {
        queue.write_buffer(buffer, offset, bytemuck::cast_slice(&self.bits));
    }

    /// Marks the voxels of the levels in which meshes have changed.
    pub(super) fn mark_regions(&mut self, regions: &ChangedRegions, levels: &[PlacedLevel]) {
        for (bounds, mask) in &regions.boxes {
            let marked = (0..).zip(levels).filter(|(i, _)| mask >> i & 1 == 1);
            for (i, level) in marked {
                self.mark_box(i, level, *bounds);
            }
        }
    }

    fn mark_box(&mut self, number: u32, level: &PlacedLevel, (center, half_size): Bounds) {
        let voxel_size = level.size / self.resolution as f32;
        let middle = (center - Vec3A::from(level.center - 0.5 * level.size)) / voxel_size;
        let rounding = Self::ROUNDING * (center.abs() + half_size);
        let reach = (half_size + rounding) / voxel_size + Self::MARGIN;
        let last = self.resolution as f32 - 1.0;
        let (low, high) = ((middle - reach).floor(), (middle + reach).floor());
        if high.cmplt(Vec3A::ZERO).any() || low.cmpgt(Vec3A::splat(last)).any() {
            return;
        }
        let cell = |v: Vec3A| v.clamp(Vec3A::ZERO, Vec3A::splat(last)).as_uvec3();
        self.mark_cells(number, cell(low), cell(high));
    }

    /// Marks what a level that has moved by so many voxels did not have before.
    pub(super) fn mark_entered(&mut self, level: u32, moved: IVec3) {
        let r = self.resolution;
        for axis in 0..3 {
            let by = moved[axis].unsigned_abs().min(r);
            if by == 0 {
                continue;
            }
            let (mut low, mut high) = (UVec3::ZERO, UVec3::splat(r - 1));
            if moved[axis] > 0 {
                low[axis] = r - by;
            } else {
                high[axis] = by - 1;
            }
            self.mark_cells(level, low, high);
        }
    }

    /// Marks the voxels from one to another.
    fn mark_cells(&mut self, level: u32, low: UVec3, high: UVec3) {
        let r = self.resolution;
        for z in low.z..=high.z {
            for y in low.y..=high.y {
                let row = r * (y + r * (z + r * level));
                self.mark_row(row + low.x, row + high.x);
            }
        }
    }

    fn mark_row(&mut self, first: u32, last: u32) {
        let words = first / 32..=last / 32;
        for word in words.clone() {
            let mut bits = u32::MAX;
            if word == *words.start() {
                bits &= u32::MAX << (first % 32);
            }
            if word == *words.end() {
                bits &= u32::MAX >> (31 - last % 32);
            }
            self.bits[word as usize] |= bits;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    #[test]
    fn a_volume_moves_by_voxels_far_from_the_origin_too() {
        let voxel_size = 0.3;
        let at = |cell: f32| Vec3::new(cell * voxel_size, 0.0, -cell * voxel_size);
        for start in [0.0_f32, 1e3, 33_333.0, 1e5] {
            let (moved, is_whole) = voxels_between(at(start), at(start + 3.0), voxel_size);
            assert_eq!(moved, IVec3::new(3, 0, -3), "from {start}");
            assert_eq!(is_whole, start < 1e4, "from {start}");
        }
        let (part, is_whole) = voxels_between(Vec3::ZERO, Vec3::splat(0.31), voxel_size);
        assert_eq!((part, is_whole), (IVec3::ONE, false));
        let (far, _) = voxels_between(Vec3::ZERO, Vec3::splat(1e30), voxel_size);
        assert_eq!(far, IVec3::splat(1_000_000));
        let nowhere = voxels_between(Vec3::ZERO, Vec3::NAN, voxel_size);
        assert_eq!(nowhere, (IVec3::ZERO, false));
    }

    #[test]
    fn parts_are_voxelised_where_something_has_changed_and_where_levels_have_moved() {
        let level = |x: f32| PlacedLevel::of(Vec3::X * x, 8.0);
        let mut volume = PlacedVolume::of(vec![level(0.5)]);
        volume.settings.resolution = 16;
        let since = |before: f32, volume: &PlacedVolume| {
            Moves::since(&[level(before)], volume, Vec3::ZERO).expect("the same levels")
        };
        let part = |before: f32| {
            let moves = since(before, &volume);
            let (dirty, found) = changes(&volume, Some(moves), Some(ChangedRegions::default()));
            (dirty, Voxelization::of(&found))
        };
        let (dirty, found) = part(0.5);
        assert_eq!(dirty, DirtyVoxels::none(16, 1));
        assert_eq!(
            found,
            Voxelization::Part {
                moved: BVec3::FALSE
            }
        );
        let (dirty, found) = part(1.5);
        let moved = BVec3::new(true, false, false);
        assert_eq!(found, Voxelization::Part { moved });
        let mut expected = DirtyVoxels::none(16, 1);
        expected.mark_entered(0, IVec3::new(-2, 0, 0));
        assert_eq!(dirty, expected);
        let mut everything = ChangedRegions::default();
        everything.add(None, 1);
        for regions in [None, Some(everything)] {
            let (dirty, found) = changes(&volume, Some(since(0.5, &volume)), regions);
            assert_eq!(dirty, DirtyVoxels::all(16, 1));
            assert_eq!(Voxelization::of(&found), Voxelization::Whole);
        }
        assert!(!since(0.6, &volume).are_whole);
        assert!(Moves::since(&[], &volume, Vec3::ZERO).is_none());
    }
    fn marked(dirty: &DirtyVoxels) -> Vec<u32> {
        let is_set = |i: &u32| dirty.bits[*i as usize / 32] >> (i % 32) & 1 == 1;
        let voxels = 32 * dirty.bits.len() as u32;
        (0..voxels).filter(is_set).collect()
    }

    /// The voxels of these levels of edge 8 for which this holds.
    fn expected(levels: u32, holds: impl Fn(u32, IVec3) -> bool) -> Vec<u32> {
        let cell = |i: u32| IVec3::new(i as i32 % 8, i as i32 / 8 % 8, i as i32 / 64 % 8);
        let voxels = 0..512 * levels;
        voxels.filter(|i| holds(i / 512, cell(*i))).collect()
    }

    #[test]
    fn boxes_are_marked_in_their_levels() {
        let levels = [4.0, 8.0, 16.0].map(|size| PlacedLevel::of(Vec3::splat(10.0), size));
        let mut regions = ChangedRegions::default();
        let bounds = (Vec3A::new(10.3, 10.3, 8.9), Vec3A::new(1.0, 0.1, 0.2));
        regions.add(Some(bounds), 0b101);
        let mut dirty = DirtyVoxels::none(8, 3);
        dirty.mark_regions(&regions, &levels);
        let expected = expected(3, |level, cell| {
            let (size, corner) = [(0.5, 8.0), (1.0, 6.0), (2.0, 2.0)][level as usize];
            let low = Vec3A::from(cell.as_vec3() * size + corner);
            let distance = (low + 0.5 * size - bounds.0).abs();
            let reach = bounds.1 + 0.5 * size + 0.125 * size;
            level != 1 && distance.cmple(reach).all()
        });
        assert_eq!(marked(&dirty), expected);
        assert!(expected.len() > 10);
    }

    #[test]
    fn boxes_outside_and_without_numbers_mark_nothing() {
        let level = [PlacedLevel::of(Vec3::ZERO, 8.0)];
        let mut dirty = DirtyVoxels::none(8, 1);
        for center in [Vec3A::splat(4.7), Vec3A::new(0.0, -1e30, 0.0)] {
            let mut regions = ChangedRegions::default();
            regions.add(Some((center, Vec3A::splat(0.5))), 1);
            dirty.mark_regions(&regions, &level);
            assert!(marked(&dirty).is_empty());
        }
    }

    #[test]
    fn what_a_level_has_not_had_is_marked() {
        for moved in [
            IVec3::new(1, 0, 0),
            IVec3::new(-2, 3, 0),
            IVec3::new(0, 0, -8),
            IVec3::new(0, 1_000_000, 0),
            IVec3::ZERO,
        ] {
            let mut dirty = DirtyVoxels::none(8, 2);
            dirty.mark_entered(1, moved);
            let expected = expected(2, |level, cell| {
                let source = cell + moved;
                let is_known = source.cmpge(IVec3::ZERO).all() && source.max_element() < 8;
                level == 1 && !is_known
            });
            assert_eq!(marked(&dirty), expected, "{moved}");
        }
    }

    #[test]
    fn unknown_bounds_and_too_many_boxes_are_everything() {
        let mut regions = ChangedRegions::default();
        for _ in 0..ChangedRegions::MOST {
            regions.add(Some((Vec3A::ZERO, Vec3A::ONE)), 1);
        }
        assert!(!regions.everything);
        regions.add(Some((Vec3A::ZERO, Vec3A::ONE)), 1);
        assert!(regions.everything);
        let mut regions = ChangedRegions::default();
        regions.add(None, 1);
        assert!(regions.everything);
    }
}
