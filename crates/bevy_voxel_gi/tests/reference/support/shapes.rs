//! Boxes, rooms and properties of fields.

use super::{Solid, triangles};
use bevy_voxel_gi::reference::{
    IrradianceField, Material, RayTracing, RayTracingSettings, Triangle, VolumeGrid, Voxels,
};
use glam::{Mat3, Vec3};

/// A box from corner to corner.
pub fn solid(min: Vec3, max: Vec3) -> Vec<Triangle> {
    triangles(&Solid {
        center: 0.5 * (min + max),
        half: 0.5 * (max - min),
        rotation: Mat3::IDENTITY,
        material: 0,
    })
}

/// A room seen from inside: a box whose fronts are inside.
pub fn room(min: Vec3, max: Vec3) -> Vec<Triangle> {
    let mut all = solid(min, max);
    for triangle in &mut all {
        triangle.corners.swap(1, 2);
    }
    all
}

/// A volume with voxels of 1 m, with its lowest corner at the origin.
pub fn unit_grid(resolution: u32) -> VolumeGrid {
    VolumeGrid {
        min: Vec3::ZERO,
        voxel_size: 1.0,
        resolution,
    }
}

/// A gray material.
pub fn gray(albedo: f32, emission: f32) -> [Material; 1] {
    [Material {
        albedo: Vec3::splat(albedo),
        emission: Vec3::splat(emission),
    }]
}

/// The field after this number of frames.
pub fn traced_field(mut ray_tracing: RayTracing, frames: u32) -> IrradianceField {
    for _ in 0..frames {
        ray_tracing.step();
    }
    ray_tracing.field()
}

/// Whether every value of a field is finite and not negative.
pub fn is_sound(field: &IrradianceField) -> bool {
    let sound = |x: f32| x.is_finite() && x >= 0.0;
    let mut texels = field.texels.iter().flatten();
    texels.all(|t| t.to_array().into_iter().all(sound))
}

/// Runs both solvers on a scene, with lights and bounces; returns their fields.
pub fn both(
    grid: VolumeGrid,
    triangles: &[Triangle],
    materials: &[Material],
    lights: &[bevy_voxel_gi::reference::Light],
    sky: Vec3,
    bounces: u32,
) -> [IrradianceField; 2] {
    use bevy_voxel_gi::reference::{Propagation, PropagationSettings};
    let voxels = Voxels::new(grid, triangles);
    let settings = RayTracingSettings::default();
    let ray_tracing = RayTracing::new(&voxels, materials, lights, sky, settings);
    let settings = PropagationSettings {
        steps: 4 * bounces,
        ..Default::default()
    };
    let mut flow = Propagation::new(&ray_tracing, &voxels, materials, sky, settings);
    flow.run();
    [traced_field(ray_tracing, bounces), flow.field()]
}

/// Whether there is no light anywhere in a field.
pub fn is_dark(field: &IrradianceField) -> bool {
    let mut texels = field.texels.iter().flatten();
    texels.all(|t| t.truncate() == Vec3::ZERO)
}

/// Irradiance at points on the walls of a cube about (6, 6, 6), each point relative to the centre, and at
/// its 48 images.
pub fn images_in_cube(field: &IrradianceField) -> [(Vec3, Vec<f32>); 3] {
    const AXES: [[usize; 3]; 6] = [
        [0, 1, 2],
        [0, 2, 1],
        [1, 0, 2],
        [1, 2, 0],
        [2, 0, 1],
        [2, 1, 0],
    ];
    [
        Vec3::new(-5.0, 0.0, 0.0),
        Vec3::new(-5.0, 2.2, 3.9),
        Vec3::new(-5.0, 4.8, 4.8),
    ]
    .map(|offset| {
        let images = AXES.into_iter().flat_map(|axes| {
            (0..8).map(move |signs| {
                let sign = |i: usize| if signs >> i & 1 != 0 { -1.0 } else { 1.0 };
                let image = |v: Vec3| Vec3::from_array([0, 1, 2].map(|i| v[axes[i]] * sign(i)));
                field.irradiance(image(offset) + 6.0, image(Vec3::X), 0.0).x
            })
        });
        (offset, images.collect())
    })
}
