//! The walls that a camera sees.

use bevy::math::{Vec2, Vec3};

use super::{BoxScene, Ray, TraceSettings, Tracer};

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
    let tracer = Tracer::new(scene, TraceSettings::default());
    let camera = scene.camera;
    let size = Vec2::new(camera.width as f32, camera.height as f32);
    let pixels = (0..camera.width * camera.height).map(|i| (i % camera.width, i / camera.width));
    pixels
        .map(|(x, y)| {
            let at = (Vec2::new(x as f32, y as f32) + 0.5) / size;
            let at = Vec2::new(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y);
            tracer.wall(Ray {
                origin: camera.eye,
                direction: (tracer.view * at.extend(1.0)).normalize(),
            })
        })
        .collect()
}

impl Tracer<'_> {
    fn wall(&self, ray: Ray) -> Option<WallPoint> {
        let hits = (0..).zip(&self.solids).filter_map(|(number, solid)| {
            let (distance, normal, albedo) = solid.hit(ray)?;
            let local = solid.axes.transpose() * normal;
            let axis = local.abs().max_position() as u32;
            let side = u32::from(local[axis as usize] < 0.0);
            let wall = 6 * number + 2 * axis + side;
            Some((distance, wall, normal, albedo))
        });
        let (distance, wall, normal, albedo) = hits.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(WallPoint {
            wall,
            position: ray.origin + distance * ray.direction,
            normal,
            albedo,
        })
    }
}
