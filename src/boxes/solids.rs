//! Boxes for the path tracer and for Bevy, and the walls that a camera sees.

use bevy::{
    math::{Mat3, Vec2, Vec3},
    prelude::*,
};

use crate::{
    boxes::{BoxGloss, BoxScene, SceneBox},
    path_tracer::{self, Gloss, Hit, Ray, Receiver, Surfaces, TraceSettings, TracedPicture, View},
    stage::{spawn_camera, spawn_lights},
};

/// The scene as its camera sees it, traced on all cores.
pub fn trace(scene: &BoxScene, settings: &TraceSettings) -> TracedPicture {
    path_tracer::trace(&solids(scene), &scene.stage(), settings)
}

/// How far in front of a receiver there must be no box, in metres.
const FREE: f32 = 1e-3;

/// The indirect light of receivers in the scene: see [`path_tracer::trace_receivers`]. They receive nothing where
/// they are in a box, or a box covers them.
pub fn trace_receivers(
    scene: &BoxScene,
    settings: &TraceSettings,
    count: u32,
    receiver: impl Fn(u32, Vec2) -> Option<Receiver> + Sync,
) -> Vec<Option<Vec3>> {
    let solids = solids(scene);
    let is_free = |point: &Receiver| {
        let front = point.position + FREE * point.normal;
        !solids.iter().any(|solid| solid.contains(front))
    };
    let receiver = |index, at| receiver(index, at).filter(is_free);
    path_tracer::trace_receivers(&solids, &scene.stage(), settings, count, receiver)
}

/// The boxes of a scene, in its order.
pub(super) fn solids(scene: &BoxScene) -> Vec<Solid> {
    scene.boxes.iter().map(Solid::new).collect()
}

/// A box.
pub(super) struct Solid {
    center: Vec3,
    half: Vec3,
    albedo: Vec3,
    gloss: Option<Gloss>,
    /// From its axes to those of the world.
    pub axes: Mat3,
}

impl Solid {
    fn new(part: &SceneBox) -> Self {
        let is_metal = part.gloss.is_some_and(|gloss| gloss.is_metal);
        Self {
            center: part.center,
            half: part.half,
            albedo: if is_metal { Vec3::ZERO } else { part.albedo },
            gloss: part.gloss.map(|gloss| gloss.lobe(part.albedo)),
            axes: Mat3::from_quat(part.rotation()),
        }
    }

    fn contains(&self, point: Vec3) -> bool {
        let local = self.axes.transpose() * (point - self.center);
        local.abs().cmplt(self.half).all()
    }

    /// Distances at which the ray enters and leaves, and per axis where it enters, in its axes.
    fn span(&self, ray: Ray) -> Option<(f32, f32, Vec3, Vec3)> {
        let origin = self.axes.transpose() * (ray.origin - self.center);
        let direction = self.axes.transpose() * ray.direction;
        // No slab is parallel to the ray, so that no distance is 0 times infinity.
        let direction = direction.map(|d| if d.abs() < 1e-12 { 1e-12 } else { d });
        let (a, b) = (
            (-self.half - origin) / direction,
            (self.half - origin) / direction,
        );
        let enter = a.min(b);
        let (near, far) = (enter.max_element(), a.max(b).min_element());
        (near <= far && far > 0.0).then_some((near, far, enter, direction))
    }

    /// The point at which a ray hits it. From inside, a box is black: nobody looks at it there.
    pub fn hit(&self, ray: Ray) -> Option<Hit> {
        let (near, far, enter, direction) = self.span(ray)?;
        let is_outside = near > 0.0;
        let distance = if is_outside { near } else { far };
        let normal = if is_outside {
            let axis = enter.max_position();
            let mut normal = Vec3::ZERO;
            normal[axis] = -direction[axis].signum();
            self.axes * normal
        } else {
            -ray.direction
        };
        Some(Hit {
            distance,
            position: ray.origin + distance * ray.direction,
            face_normal: normal,
            normal,
            albedo: if is_outside { self.albedo } else { Vec3::ZERO },
            gloss: self.gloss.filter(|_| is_outside),
            emission: Vec3::ZERO,
        })
    }
}

impl Surfaces for Vec<Solid> {
    fn closest(&self, ray: Ray) -> Option<Hit> {
        let hits = self.iter().filter_map(|solid| solid.hit(ray));
        hits.min_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    fn blocked(&self, ray: Ray, distance: f32) -> bool {
        self.iter().any(|solid| {
            let span = solid.span(ray);
            span.is_some_and(|(near, far, ..)| if near > 0.0 { near } else { far } < distance)
        })
    }
}

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

/// No gloss.
const MATT: BoxGloss = BoxGloss {
    roughness: 1.0,
    reflectance: 0.0,
    is_metal: false,
};

/// Spawns boxes and lights in the scene's units, boxes first; the sky is left out.
pub fn spawn_boxes_and_lights(world: &mut World, scene: &BoxScene) -> Vec<Entity> {
    let mut spawned = Vec::new();
    let mesh = world.add_asset(Cuboid::from_size(Vec3::splat(2.0)));
    for part in &scene.boxes {
        let gloss = part.gloss.unwrap_or(MATT);
        let material = world.add_asset::<StandardMaterial>(StandardMaterial {
            base_color: LinearRgba::from_vec3(part.albedo).into(),
            perceptual_roughness: gloss.roughness,
            reflectance: gloss.reflectance,
            metallic: f32::from(u8::from(gloss.is_metal)),
            ..default()
        });
        let entity = world.spawn((
            Mesh3d(mesh.clone()),
            MeshMaterial3d(material),
            Transform::from_translation(part.center)
                .with_rotation(part.rotation())
                .with_scale(part.half),
        ));
        spawned.push(entity.id());
    }
    spawned.extend(spawn_lights(
        world,
        &scene.point_lights,
        &scene.directional_lights,
    ));
    spawned
}

/// Spawns boxes, lights and camera; the sky is left out. Boxes and lights are returned, boxes first.
pub fn spawn_box_scene(world: &mut World, scene: &BoxScene) -> Vec<Entity> {
    let spawned = spawn_boxes_and_lights(world, scene);
    spawn_camera(world, &scene.camera);
    spawned
}
