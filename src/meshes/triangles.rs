//! A scene of meshes for the path tracer, in a bounding volume hierarchy.

use std::{sync::Arc, time::Duration};

use bevy::math::{Vec2, Vec3};
use obvhs::{
    BvhBuildParams,
    cwbvh::{CwBvh, builder::build_cwbvh_from_tris},
    ray::RayHit,
    rt_triangle::RtTriangle,
    triangle::Triangle as BvhTriangle,
};

use crate::{
    meshes::{MeshScene, SceneMaterial},
    path_tracer::{self, Hit, LightSample, Ray, Surfaces, TraceSettings, TracedPicture},
};

/// The scene as its camera sees it, traced on all cores.
pub fn trace(scene: &MeshScene, settings: &TraceSettings) -> TracedPicture {
    path_tracer::trace(&Triangles::new(scene), &scene.stage, settings)
}

/// All triangles of a scene, in the world.
pub(super) struct Triangles {
    bvh: TriangleBvh,
    vertices: Vec<Vertex>,
    triangles: Vec<Triangle>,
    materials: Vec<Arc<SceneMaterial>>,
    /// The triangles that emit, each with the area of those before it and its own.
    emitters: Vec<(usize, f32)>,
}

#[derive(Clone, Copy)]
struct Vertex {
    position: Vec3,
    normal: Vec3,
    uv: Vec2,
}

#[derive(Clone, Copy)]
struct Triangle {
    corners: [u32; 3],
    material: u32,
}

impl Triangles {
    pub fn new(scene: &MeshScene) -> Self {
        let (mut vertices, mut triangles, mut materials) = (Vec::new(), Vec::new(), Vec::new());
        for part in &scene.parts {
            let world_from_mesh = part.world_from_mesh();
            let first = vertices.len() as u32;
            let mesh = &part.mesh;
            let parts = mesh.positions.iter().zip(&mesh.normals).zip(&mesh.uvs);
            vertices.extend(parts.map(|((position, normal), uv)| Vertex {
                position: world_from_mesh.transform_point3(*position),
                normal: part.rotation * *normal,
                uv: *uv,
            }));
            let material = materials.len() as u32;
            materials.push(part.material.clone());
            triangles.extend(mesh.indices.chunks_exact(3).map(|corners| Triangle {
                corners: [0, 1, 2].map(|k| first + corners[k]),
                material,
            }));
        }
        let position = |corner: u32| vertices[corner as usize].position;
        let bvh = TriangleBvh::new(triangles.iter().map(|t: &Triangle| t.corners.map(position)));
        let mut scene = Self {
            bvh,
            vertices,
            triangles,
            materials,
            emitters: Vec::new(),
        };
        let mut area = 0.0;
        for (index, triangle) in scene.triangles.iter().enumerate() {
            if scene.materials[triangle.material as usize].emission != Vec3::ZERO {
                area += 0.5 * scene.doubled_area(triangle).length();
                scene.emitters.push((index, area));
            }
        }
        scene
    }

    /// The vertex of each corner.
    fn corners(&self, triangle: &Triangle) -> [Vertex; 3] {
        triangle
            .corners
            .map(|corner| self.vertices[corner as usize])
    }

    /// A vector along the normal of the front, twice as long as the triangle's area.
    fn doubled_area(&self, triangle: &Triangle) -> Vec3 {
        let [a, b, c] = self.corners(triangle).map(|vertex| vertex.position);
        (b - a).cross(c - a)
    }

    fn uv(&self, triangle: &Triangle, weights: Vec2) -> Vec2 {
        let [a, b, c] = self.corners(triangle).map(|vertex| vertex.uv);
        a + weights.x * (b - a) + weights.y * (c - a)
    }

    /// Whether there is no hole at a point of a triangle.
    fn is_there(&self, triangle: u32, weights: Vec2) -> bool {
        let triangle = &self.triangles[triangle as usize];
        let material = &self.materials[triangle.material as usize];
        match (material.alpha_cutoff, &material.texture) {
            (Some(cutoff), Some(texture)) => texture.sample(self.uv(triangle, weights)).w >= cutoff,
            _ => true,
        }
    }

    fn emission(&self, triangle: &Triangle, weights: Vec2) -> Vec3 {
        let material = &self.materials[triangle.material as usize];
        match &material.emissive_texture {
            Some(texture) if material.emission != Vec3::ZERO => {
                material.emission * texture.sample(self.uv(triangle, weights)).truncate()
            }
            _ => material.emission,
        }
    }
}

impl Surfaces for Triangles {
    fn closest(&self, ray: Ray) -> Option<Hit> {
        let found = self
            .bvh
            .closest(ray, |t, weights| self.is_there(t, weights))?;
        let triangle = &self.triangles[found.triangle as usize];
        let material = &self.materials[triangle.material as usize];
        let front = self.doubled_area(triangle).normalize_or_zero();
        let is_front = front.dot(ray.direction) <= 0.0;
        let side = if is_front { 1.0 } else { -1.0 };
        let [a, b, c] = self.corners(triangle).map(|vertex| vertex.normal);
        let normal = a + found.weights.x * (b - a) + found.weights.y * (c - a);
        let albedo = match &material.texture {
            _ if !is_front && !material.is_double_sided => Vec3::ZERO,
            None => material.albedo,
            Some(texture) => {
                material.albedo * texture.sample(self.uv(triangle, found.weights)).truncate()
            }
        };
        Some(Hit {
            distance: found.distance,
            position: ray.origin + found.distance * ray.direction,
            face_normal: side * front,
            normal: side * normal.normalize_or(front),
            albedo,
            gloss: None,
            emission: if is_front {
                self.emission(triangle, found.weights)
            } else {
                Vec3::ZERO
            },
        })
    }

    fn blocked(&self, ray: Ray, distance: f32) -> bool {
        self.bvh
            .blocked(ray, distance, |t, weights| self.is_there(t, weights))
    }

    fn emissive_area(&self) -> f32 {
        self.emitters.last().map_or(0.0, |(_, area)| *area)
    }

    fn sample_light(&self, [which, a, b]: [f32; 3]) -> Option<LightSample> {
        let area = which * self.emissive_area();
        let index = self.emitters.partition_point(|(_, end)| *end <= area);
        let (triangle, _) = self.emitters.get(index).or(self.emitters.last())?;
        let triangle = &self.triangles[*triangle];
        // Even over the triangle: the square's upper half folded onto its lower one.
        let weights = if a + b > 1.0 {
            Vec2::new(1.0 - a, 1.0 - b)
        } else {
            Vec2::new(a, b)
        };
        let [p, q, r] = self.corners(triangle).map(|vertex| vertex.position);
        Some(LightSample {
            position: p + weights.x * (q - p) + weights.y * (r - p),
            normal: self.doubled_area(triangle).normalize_or_zero(),
            emission: self.emission(triangle, weights),
        })
    }
}

// The first hit of a ray among many triangles.
//
// `obvhs` may depend on another version of `glam` than Bevy does, so vectors enter it as arrays.

/// Triangles in a bounding volume hierarchy.
pub struct TriangleBvh {
    bvh: CwBvh,
    /// In the order of the hierarchy's leaves.
    triangles: Vec<RtTriangle>,
}

/// A point of a triangle.
#[derive(Clone, Copy, Debug)]
pub struct TriangleHit {
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
                BvhTriangle { v0, v1, v2 }
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
