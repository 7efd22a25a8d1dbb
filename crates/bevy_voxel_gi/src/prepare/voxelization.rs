//! What of the scene is voxelised in a frame: where it has changed since it was voxelised last.

use bevy::prelude::*;

use super::dirty_voxels::{ChangedRegions, DirtyVoxels};
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
    by: [IVec4; MAX_LEVELS],
    /// Whether these are whole ones.
    pub are_whole: bool,
}

impl Moves {
    pub(super) fn are_some(&self) -> bool {
        self.by != [IVec4::ZERO; MAX_LEVELS]
    }

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
}
