//! The first hit of a ray among many triangles.
//!
//! `obvhs` may depend on another version of `glam` than Bevy does, so vectors enter it as arrays.

use std::time::Duration;

use bevy::math::{Vec2, Vec3};
use obvhs::{
    BvhBuildParams, cwbvh::CwBvh, cwbvh::builder::build_cwbvh_from_tris, ray::RayHit,
    rt_triangle::RtTriangle, triangle::Triangle,
};

use crate::path_tracer::Ray;

/// Triangles in a bounding volume hierarchy.
pub(super) struct TriangleBvh {
    bvh: CwBvh,
    /// In the order of the hierarchy's leaves.
    triangles: Vec<RtTriangle>,
}

/// A point of a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleHit {
    /// Its distance from the origin of the ray.
    pub distance: f32,
    /// The number of the triangle.
    pub triangle: u32,
    /// Its barycentric coordinates: the weights of the second and the third corner.
    pub weights: Vec2,
}

impl TriangleBvh {
    pub fn new(corners: impl Iterator<Item = [Vec3; 3]>) -> Self {
        let triangles: Vec<_> = corners
            .map(|corners| {
                let [v0, v1, v2] = corners.map(|corner| corner.to_array().into());
                Triangle { v0, v1, v2 }
            })
            .collect();
        let parameters = BvhBuildParams::medium_build();
        let bvh = build_cwbvh_from_tris(&triangles, parameters, &mut Duration::default());
        let in_order = bvh.primitive_indices.iter();
        let triangles = in_order.map(|i| RtTriangle::from(&triangles[*i as usize]));
        Self {
            triangles: triangles.collect(),
            bvh,
        }
    }

    /// The first triangle along the ray that `is_there` at this point.
    pub fn closest(&self, ray: Ray, is_there: impl Fn(u32, Vec2) -> bool) -> Option<TriangleHit> {
        let ray = obvhs_ray(ray, f32::INFINITY);
        let mut hit = RayHit::none();
        self.bvh.ray_traverse(ray, &mut hit, |ray, leaf| {
            self.distance(ray, leaf, &is_there)
        });
        let triangle = self.triangles.get(hit.primitive_id as usize)?;
        Some(TriangleHit {
            distance: hit.t,
            triangle: self.bvh.primitive_indices[hit.primitive_id as usize],
            weights: weights(triangle, &ray),
        })
    }

    /// Whether there is any such triangle within a distance.
    pub fn blocked(&self, ray: Ray, distance: f32, is_there: impl Fn(u32, Vec2) -> bool) -> bool {
        let ray = obvhs_ray(ray, distance);
        let is_free = self
            .bvh
            .ray_traverse_miss(ray, |ray, leaf| self.distance(ray, leaf, &is_there));
        !is_free
    }

    fn distance(
        &self,
        ray: &obvhs::ray::Ray,
        leaf: usize,
        is_there: &impl Fn(u32, Vec2) -> bool,
    ) -> f32 {
        let triangle = &self.triangles[leaf];
        let distance = triangle.intersect(ray);
        if distance.is_finite()
            && !is_there(self.bvh.primitive_indices[leaf], weights(triangle, ray))
        {
            return f32::INFINITY;
        }
        distance
    }
}

fn obvhs_ray(ray: Ray, distance: f32) -> obvhs::ray::Ray {
    // The traversal misses triangles where a component of the direction is -0, which the sum makes 0.
    let parts = [ray.origin, ray.direction + Vec3::ZERO];
    let [origin, direction] = parts.map(|v| v.to_array().into());
    obvhs::ray::Ray::new(origin, direction, 0.0, distance)
}

fn weights(triangle: &RtTriangle, ray: &obvhs::ray::Ray) -> Vec2 {
    let weights = triangle.compute_barycentric(ray);
    Vec2::new(weights.x, weights.y)
}
