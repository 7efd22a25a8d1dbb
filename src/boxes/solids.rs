//! Boxes for the path tracer.

use bevy::math::{Mat3, Vec2, Vec3};

use super::{BoxScene, SceneBox};
use crate::path_tracer::{self, Hit, Ray, Receiver, Surfaces, TraceSettings, TracedPicture};

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
    /// From its axes to those of the world.
    pub axes: Mat3,
}

impl Solid {
    fn new(part: &SceneBox) -> Self {
        Self {
            center: part.center,
            half: part.half,
            albedo: part.albedo,
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
