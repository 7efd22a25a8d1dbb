//! What divides neighbouring voxels, such as a thin wall or a floor between two rooms: receivers do not mix the light of
//! its two sides.

use super::{
    grid::VolumeGrid, irradiance_field::IrradianceField, packed_surface::Plane, surface::main_face,
    voxels::Voxels,
};
use glam::{IVec3, Vec2, Vec3, Vec3Swizzles, Vec4};

/// Where nothing divides a voxel from its neighbours.
pub const NOTHING: f32 = -64.0;

/// Least area of each side of a divider in a voxel that nothing in it hides, and with the voxels beside it, in voxel
/// faces: small things divide nothing.
const LEAST_AREA: f32 = 0.385;
const LEAST_AREA_AROUND: f32 = 1.37;

/// Greatest distance of its two sides, where rounding has swapped them, in voxels.
const MAX_OVERLAP: f32 = 0.01;

/// A receiver looks for dividers in the voxel at this distance in front of its surface, in voxels. Less than the half, so
/// that it is within the level.
const AHEAD: f32 = 511.0 / 1024.0;

/// How far towards the viewer a receiver's side of a divider is looked up, in voxels: its position may be a little beyond
/// the edge of its surface, as below the floor at the foot of a wall. What is seen over a wall that is higher than this stays
/// behind it.
const TOWARDS_VIEWER: f32 = 0.5;

/// Returns for each voxel and axis the place of the divider between its centre and that of a neighbour, from the voxel's lower
/// side, in voxels: -0.5 to 1.5, the one nearer to the centre if there are two; less if there is none.
pub fn dividers(voxels: &Voxels) -> Vec<Vec3> {
    let of_voxel = |index| {
        let places = [0, 1, 2].map(|axis| of_axis(voxels, index, axis));
        stored(places.into())
    };
    (0..voxels.grid.len()).map(of_voxel).collect()
}

/// Places as they are stored, rounded to 1/59 to 1/64 of a voxel, and just below -0.5 where there is nothing. Those along x
/// and y have parts of the one along z beside their own, which are never 0, so that a place between two centres is rounded to
/// the border between these voxels.
fn stored(places: Vec3) -> Vec3 {
    let along_z = (59.0 * places.z + 30.0).round().clamp(0.0, 118.0);
    let parts = Vec2::new((along_z / 8.0).floor() + 1.0, 2.0 * (along_z % 8.0) + 1.0);
    let along_xy = (64.0 * places.xy() + 33.1).floor();
    let along_xy = along_xy.clamp(Vec2::ZERO, Vec2::splat(127.0));
    let along_xy = (along_xy - 33.0) / 64.0 + parts / 1024.0;
    along_xy.extend((along_z - 30.0) / 59.0)
}

/// Between two centres, and on neither.
fn inside(distance: f32) -> f32 {
    distance.clamp(1.0 / 128.0, 127.0 / 128.0)
}

fn of_axis(voxels: &Voxels, index: usize, axis: usize) -> f32 {
    let voxel = voxels.grid.voxel(index);
    let neighbor = |step: i32| voxels.grid.index(voxel + IVec3::AXES[axis] * step);
    // Distances from the centre, upwards and downwards.
    let up = neighbor(1).and_then(|upper| between(voxels, index, upper, axis));
    let down = neighbor(-1).and_then(|lower| between(voxels, lower, index, axis));
    let (up, down) = (up.map(inside), down.map(|up| inside(1.0 - up)));
    match (up, down) {
        (Some(up), Some(down)) if up <= down => 0.5 + up,
        (Some(up), None) => 0.5 + up,
        (_, Some(down)) => 0.5 - down,
        (None, None) => NOTHING,
    }
}

/// The distance of the divider between the centres of two neighbours from that of the lower one: the middle between a
/// surface that faces up and one below it that faces down.
fn between(voxels: &Voxels, lower: usize, upper: usize, axis: usize) -> Option<f32> {
    let sides = |face: usize| {
        let of = [(lower, 0.0), (upper, 1.0)];
        of.into_iter().filter_map(move |(index, center)| {
            let height = side_height(voxels, index, face)?;
            Some(center + if face == 2 * axis { height } else { -height })
        })
    };
    let pairs =
        sides(2 * axis).flat_map(|top| sides(2 * axis + 1).map(move |bottom| (top, bottom)));
    let middles = pairs
        .filter(|(top, bottom)| bottom <= &(top + MAX_OVERLAP))
        .map(|(top, bottom)| 0.5 * (top + bottom));
    middles
        .filter(|middle| (0.0..=1.0).contains(middle))
        .reduce(f32::max)
}

/// The height of a face's surface above the centre of its voxel, along its normal, if it is along the grid and large.
fn side_height(voxels: &Voxels, index: usize, face: usize) -> Option<f32> {
    let own = side_area(voxels, index, face);
    if own < LEAST_AREA {
        return None;
    }
    let voxel = voxels.grid.voxel(index);
    let steps = [1, 2].map(|next| IVec3::AXES[(face / 2 + next) % 3]);
    let beside = steps
        .into_iter()
        .flat_map(|step| [voxel + step, voxel - step]);
    let beside = beside.filter_map(|voxel| voxels.grid.index(voxel));
    let beside: f32 = beside.map(|index| side_area(voxels, index, face)).sum();
    let height = Plane::new(voxels.packed_surfaces[index][face]).height;
    (own + beside >= LEAST_AREA_AROUND).then_some(height)
}

/// The area of a face's surface, if it is along the grid, else 0.
fn side_area(voxels: &Voxels, index: usize, face: usize) -> f32 {
    let packed = voxels.packed_surfaces[index][face];
    let areas = voxels.material_areas[index][face].iter();
    if packed != 0 && Plane::new(packed).is_exact() {
        areas.map(|material| material.visible).sum()
    } else {
        0.0
    }
}

/// Returns whether a place in a voxel, from its centre, is beyond a divider from that centre, along another axis than that
/// of the surface. The divider is that which receivers on the surface find.
pub(super) fn is_beyond_divider(voxels: &Voxels, index: usize, place: Vec3, plane: Plane) -> bool {
    let own = voxels.grid.voxel(index).as_vec3() + 0.5;
    let ahead = (own + plane.normal * (plane.height + AHEAD)).floor();
    let Some(ahead) = voxels.grid.index(ahead.as_ivec3()) else {
        return false;
    };
    let besides = main_face(plane.normal) / 2;
    (0..3).filter(|axis| *axis != besides).any(|axis| {
        let sides = [0, 1].map(|side| side_height(voxels, ahead, 2 * axis + side));
        let [Some(top), Some(depth)] = sides else {
            return false;
        };
        let at = 0.5 * (top - depth);
        let is_beyond = if at >= 0.0 {
            place[axis] >= at
        } else {
            place[axis] <= at
        };
        -depth <= top + MAX_OVERLAP && is_beyond
    })
}

/// Returns where a receiver samples the field for the faces of the other axes than the one of each component: on its side of the dividers.
/// `position` is in grid coordinates, `normal` and `to_viewer` are unit vectors.
fn on_own_side(
    grid: &VolumeGrid,
    dividers: &[Vec3],
    position: Vec3,
    normal: Vec3,
    to_viewer: Vec3,
) -> Vec3 {
    let last = Vec3::splat(grid.resolution as f32 - 0.5);
    let local = position.clamp(Vec3::splat(0.5), last);
    let voxel = (local + normal * AHEAD).floor();
    let Some(index) = grid.index(voxel.as_ivec3()) else {
        return local;
    };
    let divider = dividers[index];
    let border = voxel + divider.round();
    let distance = (local - border).abs().max(Vec3::splat(0.5));
    let seen = local + TOWARDS_VIEWER * to_viewer;
    border + Vec3::select(seen.cmpgt(voxel + divider), distance, -distance)
}

impl IrradianceField {
    /// Returns the irradiance of a surface in lux as [`IrradianceField::irradiance`], without the light from beyond
    /// [`dividers`]. `to_viewer` is a unit vector from the position to the viewer.
    pub fn divided_irradiance(
        &self,
        dividers: &[Vec3],
        position: Vec3,
        normal: Vec3,
        to_viewer: Vec3,
    ) -> Vec3 {
        let at = self.grid.to_grid(position);
        let own_side = on_own_side(&self.grid, dividers, at, normal, to_viewer);
        let mut sum = Vec4::ZERO;
        for axis in 0..3 {
            // Along its own normal a surface is no divider.
            let mut place = own_side;
            place[axis] = at[axis];
            let face = 2 * axis + usize::from(normal[axis] < 0.0);
            sum += self.sample(place, face) * normal[axis].powi(2);
        }
        sum.truncate() / sum.w.max(1e-12)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::reference::Triangle;

    /// The six sides of a box.
    fn solid(min: Vec3, max: Vec3) -> Vec<Triangle> {
        let corner = |i: usize| {
            let side = |axis: usize| if i >> axis & 1 == 0 { min } else { max };
            Vec3::new(side(0).x, side(1).y, side(2).z)
        };
        let sides = [
            [0, 4, 6, 2],
            [1, 3, 7, 5],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 2, 3, 1],
            [4, 5, 7, 6],
        ];
        let halves = sides
            .into_iter()
            .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
        let triangle = |corners: [usize; 3]| Triangle {
            corners: corners.map(corner),
            material: 0,
            double_sided: false,
        };
        halves.map(triangle).collect()
    }

    proptest! {
        #[test]
        fn receivers_read_nothing_beyond_a_thin_wall(
            axis in 0usize..3,
            from in 2.0f32..5.0,
            thickness in 0.0f32..0.95,
            distance in 0.02f32..2.0,
            is_above: bool,
        ) {
            let to = from + thickness;
            let (mut min, mut max) = (Vec3::splat(-1.0), Vec3::splat(9.0));
            (min[axis], max[axis]) = (from, to);
            let grid = VolumeGrid { min: Vec3::ZERO, voxel_size: 1.0, resolution: 8 };
            let voxels = Voxels::new(grid, &solid(min, max));
            let mut place = Vec3::splat(4.3);
            place[axis] = if is_above { to + distance } else { from - distance };
            let mut normal = Vec3::ZERO;
            normal[(axis + 1) % 3] = 1.0;
            // From where the place is seen over the wall at most.
            let mut to_viewer = normal;
            to_viewer[axis] = if is_above { -distance } else { distance } / 8.0;
            let dividers = dividers(&voxels);
            let at = on_own_side(&grid, &dividers, place, normal, to_viewer.normalize())[axis];
            // The centres of the voxels that count there.
            let low = (at - 0.5).floor() + 0.5;
            let high = if at > low { low + 1.0 } else { low };
            let middle = 0.5 * (from + to);
            prop_assert!(if is_above { low >= middle - 0.01 } else { high <= middle + 0.01 }, "{low} {high}");
            // Away from the wall all is as without it.
            prop_assert!(distance < 1.0 || (at - place[axis].clamp(0.5, 7.5)).abs() < 1e-4, "{at}");
        }
    }

    /// The top of the floor and the bottom of the box divide the voxels there.
    #[test]
    fn the_foot_of_a_box_reads_above_the_floor_that_it_stands_on() {
        let grid = VolumeGrid {
            min: Vec3::ZERO,
            voxel_size: 1.0,
            resolution: 8,
        };
        const TOP: f32 = 3.3;
        let floor = solid(Vec3::new(-1.0, 2.2, -1.0), Vec3::new(9.0, TOP, 9.0));
        let on_it = solid(Vec3::new(4.58, TOP, -1.0), Vec3::new(7.6, 7.0, 9.0));
        let dividers = dividers(&Voxels::new(grid, &[floor, on_it].concat()));
        let to_viewer = Vec3::new(-0.9, 0.3, 0.2).normalize();
        for below in [-0.1, 0.02, 0.1] {
            let place = Vec3::new(4.58, TOP - below, 4.5);
            let at = on_own_side(&grid, &dividers, place, Vec3::NEG_X, to_viewer);
            assert!(at.y >= 3.5, "{below} below the floor: {at}");
            let under = on_own_side(&grid, &dividers, place, Vec3::NEG_X, -to_viewer);
            assert!(
                under.y <= 2.5,
                "{below} below the floor, from under it: {under}"
            );
        }
    }

    #[test]
    fn ground_and_small_boxes_divide_nothing() {
        let grid = VolumeGrid {
            min: Vec3::ZERO,
            voxel_size: 1.0,
            resolution: 8,
        };
        let ground = solid(Vec3::new(-1.0, -1.0, -1.0), Vec3::new(9.0, 3.2, 9.0));
        let small = solid(Vec3::new(3.1, 3.2, 3.1), Vec3::new(4.0, 4.1, 4.0));
        let found = dividers(&Voxels::new(grid, &[ground, small].concat()));
        assert!(found.iter().all(|divider| divider.max_element() < -0.5));
    }
}
