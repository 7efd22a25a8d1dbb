//! The walls that a camera sees.

use bevy::math::{Vec2, Vec3};

use super::{
    BoxScene,
    solids::{Solid, solids},
};
use crate::path_tracer::{Ray, View};

/// The point of a wall in the middle of a pixel.
#[derive(Clone, Copy, Debug)]
pub struct WallPoint {
    /// The same number for all points of a wall.
    pub wall: u32,
    /// The point of the wall that the pixel shows, in metres.
    pub position: Vec3,
    /// The wall's normal, a unit vector.
    pub normal: Vec3,
    /// The wall's albedo.
    pub albedo: Vec3,
}

/// The walls in the middle of all pixels, row after row; `None` where there is only the sky.
pub fn visible_walls(scene: &BoxScene) -> Vec<Option<WallPoint>> {
    let (solids, camera) = (solids(scene), scene.camera);
    let view = View::new(&camera);
    let pixels = (0..camera.width * camera.height).map(|i| (i % camera.width, i / camera.width));
    pixels
        .map(|(x, y)| wall(&solids, view.ray(Vec2::new(x as f32, y as f32) + 0.5)))
        .collect()
}

fn wall(solids: &[Solid], ray: Ray) -> Option<WallPoint> {
    let hits = (0..).zip(solids).filter_map(|(number, solid)| {
        let hit = solid.hit(ray)?;
        let local = solid.axes.transpose() * hit.normal;
        let axis = local.abs().max_position() as u32;
        let side = u32::from(local[axis as usize] < 0.0);
        Some((hit, 6 * number + 2 * axis + side))
    });
    let (hit, wall) = hits.min_by(|a, b| a.0.distance.total_cmp(&b.0.distance))?;
    Some(WallPoint {
        wall,
        position: hit.position,
        normal: hit.normal,
        albedo: hit.albedo,
    })
}
