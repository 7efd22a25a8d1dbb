//! Path-traced scenes: their boxes as triangles, camera rays, and the light on the visible surfaces. Then shapes, lights,
//! and fields of other scenes.

use bevy_voxel_gi::reference::{
    IrradianceField, Light, Material, Propagation, PropagationSettings, RayTracing,
    RayTracingSettings, SETTLE, Triangle, VolumeGrid, Voxels,
};
use glam::{Mat3, UVec2, Vec2, Vec3};
use serde_json::Value;
use std::{f32::consts::PI, fs, path::Path, sync::LazyLock};

/// A box of a scene.
pub struct Solid {
    pub center: Vec3,
    pub half: Vec3,
    pub rotation: Mat3,
    pub material: u32,
}

/// A scene and its path-traced light.
pub struct Truth {
    pub name: String,
    pub solids: Vec<Solid>,
    pub triangles: Vec<Triangle>,
    pub materials: Vec<Material>,
    pub lights: Vec<Light>,
    pub sky: Vec3,
    pub min: Vec3,
    pub max: Vec3,
    pub size: usize,
    /// Camera position and the basis of rays through pixels.
    eye: Vec3,
    right: Vec3,
    up: Vec3,
    forward: Vec3,
    /// Indirect radiance, means of blocks of pixels; zero where a pixel shows no surface.
    pub indirect: Vec<Vec3>,
}

/// Edge in pixels of the blocks over which the path-traced light is averaged.
const BLOCK: usize = 4;

fn file(name: &str, extension: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    let path = folder.join(format!("{name}.{extension}"));
    fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

static SCENES: LazyLock<[Truth; 3]> =
    LazyLock::new(|| ["cornell_point", "colonnade", "sunlit_room"].map(load));
static VOXELS: LazyLock<[Voxels; 3]> = LazyLock::new(|| SCENES.each_ref().map(|t| t.voxels(32)));
static LIGHT: LazyLock<[RayTracing<'static>; 3]> = LazyLock::new(|| {
    [0, 1, 2].map(|i| {
        let mut light = SCENES[i].ray_tracing(&VOXELS[i], RayTracingSettings::default());
        for _ in 0..SETTLE {
            light.step();
        }
        light
    })
});

/// All scenes.
pub fn all() -> &'static [Truth; 3] {
    &SCENES
}

/// All scenes at 32^3, with their light of the default settings, settled.
pub fn settled() -> impl Iterator<
    Item = (
        &'static Truth,
        &'static Voxels,
        &'static RayTracing<'static>,
    ),
> {
    (0..3).map(|i| (&SCENES[i], &VOXELS[i], &LIGHT[i]))
}

impl Truth {
    /// The voxels of the scene.
    pub fn voxels(&self, resolution: u32) -> Voxels {
        let grid = VolumeGrid::around(self.min, self.max, resolution);
        Voxels::new(grid, &self.triangles)
    }

    /// The solver of the scene's light, without a frame yet.
    pub fn ray_tracing<'a>(
        &'a self,
        voxels: &'a Voxels,
        settings: RayTracingSettings,
    ) -> RayTracing<'a> {
        RayTracing::new(voxels, &self.materials, &self.lights, self.sky, settings)
    }
}

fn vec3(value: &Value) -> Vec3 {
    Vec3::from_array([0, 1, 2].map(|i| value[i].as_f64().expect("a number") as f32))
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], |v| v.as_slice())
}

fn npy(bytes: &[u8]) -> Vec<Vec3> {
    assert_eq!(&bytes[..8], b"\x93NUMPY\x01\0");
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let numbers: Vec<f32> = bytes[start..]
        .chunks_exact(4)
        .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect();
    numbers.chunks_exact(3).map(Vec3::from_slice).collect()
}

fn load(name: &str) -> Truth {
    let json: Value = serde_json::from_slice(&file(name, "json")).expect("JSON");
    let mut truth = Truth {
        name: name.into(),
        solids: vec![],
        triangles: vec![],
        materials: vec![],
        lights: vec![],
        sky: Vec3::ZERO,
        min: Vec3::INFINITY,
        max: Vec3::NEG_INFINITY,
        size: 128,
        eye: vec3(&json["camera"]["eye"]),
        right: Vec3::ZERO,
        up: Vec3::ZERO,
        forward: Vec3::ZERO,
        indirect: npy(&file(name, "indirect.npy")),
    };
    for solid in list(&json["boxes"]) {
        let material = truth.materials.len() as u32;
        truth.materials.push(Material {
            albedo: vec3(&solid["albedo"]),
            emission: Vec3::ZERO,
        });
        let degrees = solid["rotate_y_deg"].as_f64().unwrap_or(0.0) as f32;
        truth.solids.push(Solid {
            center: vec3(&solid["center"]),
            half: vec3(&solid["half"]),
            rotation: Mat3::from_rotation_y(degrees.to_radians()),
            material,
        });
    }
    for solid in &truth.solids {
        truth.triangles.extend(triangles(solid));
    }
    for corner in truth.triangles.iter().flat_map(|t| t.corners) {
        truth.min = truth.min.min(corner);
        truth.max = truth.max.max(corner);
    }
    for light in list(&json["point_lights"]) {
        truth.lights.push(Light::Point {
            position: vec3(&light["position"]),
            intensity: vec3(&light["intensity_cd"]),
            cone: None,
            near: 0.0,
        });
    }
    for light in list(&json["directional_lights"]) {
        truth.lights.push(Light::Directional {
            direction: vec3(&light["direction"]).normalize(),
            illuminance: vec3(&light["illuminance_lux"]),
        });
    }
    if json.get("sky_radiance").is_some_and(|s| s.is_array()) {
        truth.sky = vec3(&json["sky_radiance"]);
    }
    let camera = &json["camera"];
    truth.forward = (vec3(&camera["target"]) - truth.eye).normalize();
    truth.right = truth.forward.cross(vec3(&camera["up"])).normalize();
    truth.up = truth.right.cross(truth.forward);
    let degrees = camera["fov_y_deg"].as_f64().expect("a number") as f32;
    let height = (0.5 * degrees).to_radians().tan();
    truth.right *= height;
    truth.up *= height;
    truth
}

/// The twelve triangles of a box, fronts outside.
pub fn triangles(solid: &Solid) -> Vec<Triangle> {
    let at = |s: Vec3| solid.center + solid.rotation * (s * solid.half);
    let mut all = vec![];
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let n = Vec3::AXES[axis] * sign;
            let u = Vec3::AXES[(axis + 1) % 3];
            let v = n.cross(u);
            let corners = [n - u - v, n + u - v, n + u + v, n - u + v].map(at);
            all.extend(quad(corners, solid.material));
        }
    }
    all
}

impl Truth {
    /// Unit vector from a position to the camera.
    pub fn to_viewer(&self, place: Vec3) -> Vec3 {
        (self.eye - place).normalize()
    }

    /// The first hit of a camera ray with a box: position, normal, material.
    pub fn see(&self, pixel: Vec2) -> Option<(Vec3, Vec3, u32)> {
        let at = pixel / self.size as f32 * 2.0 - 1.0;
        let direction = (self.forward + self.right * at.x - self.up * at.y).normalize();
        let mut best = (f32::INFINITY, Vec3::ZERO, 0);
        for solid in &self.solids {
            let back = solid.rotation.transpose();
            let o = back * (self.eye - solid.center);
            let d = back * direction;
            let a = (-solid.half - o) / d;
            let b = (solid.half - o) / d;
            let (near, far) = (a.min(b), a.max(b));
            let t = near.max_element();
            if t > 1e-4 && t < far.min_element() && t < best.0 {
                let axis = (0..3).find(|i| near[*i] == t).expect("one");
                let n = Vec3::AXES[axis] * -d[axis].signum();
                best = (t, solid.rotation * n, solid.material);
            }
        }
        (best.0 < f32::INFINITY).then(|| (self.eye + direction * best.0, best.1, best.2))
    }

    /// Relative error and bias of irradiances against the path-traced light, in blocks of 4 x 4 pixels.
    pub fn compare(&self, irradiance: impl Fn(Vec3, Vec3) -> Vec3) -> (f32, f32) {
        let blocks = self.blocks(irradiance);
        let reference: f32 = blocks.iter().map(|b| b.2.element_sum()).sum();
        let error: f32 = blocks.iter().map(|b| (b.1 - b.2).abs().element_sum()).sum();
        let bias: f32 = blocks.iter().map(|b| (b.1 - b.2).element_sum()).sum();
        (error / reference, bias / reference)
    }

    /// Index of each block, its computed and its path-traced mean radiance.
    pub fn blocks(&self, irradiance: impl Fn(Vec3, Vec3) -> Vec3) -> Vec<(usize, Vec3, Vec3)> {
        const GRID: usize = 2;
        let columns = self.size / BLOCK;
        let mut all = vec![];
        'block: for (block, &theirs) in self.indirect.iter().enumerate() {
            if theirs == Vec3::ZERO {
                continue;
            }
            let corner = UVec2::new((block % columns) as u32, (block / columns) as u32);
            let mut ours = Vec3::ZERO;
            // The points of a grid with the same density in all pixels of the block.
            let points = (BLOCK * GRID) as u32;
            for point in 0..points * points {
                let offset =
                    (UVec2::new(point % points, point / points).as_vec2() + 0.5) / GRID as f32;
                let pixel = (corner * BLOCK as u32).as_vec2() + offset;
                let Some((place, normal, material)) = self.see(pixel) else {
                    continue 'block;
                };
                let albedo = self.materials[material as usize].albedo;
                ours += albedo * irradiance(place, normal) / PI;
            }
            all.push((block, ours / (points * points) as f32, theirs));
        }
        all
    }
}

/// The two triangles of a quadrilateral, whose corners are counter-clockwise on its front.
pub fn quad([a, b, c, d]: [Vec3; 4], material: u32) -> [Triangle; 2] {
    [[a, b, c], [a, c, d]].map(|corners| one_sided(corners, material))
}

pub fn one_sided(corners: [Vec3; 3], material: u32) -> Triangle {
    Triangle {
        corners,
        material,
        double_sided: false,
    }
}

/// The default settings, for receivers that test visibility.
pub fn for_visibility() -> RayTracingSettings {
    RayTracingSettings {
        tests_visibility: true,
        ..Default::default()
    }
}

/// The ray traced light of a scene with the default settings, without a frame yet.
pub fn traced<'a>(
    voxels: &'a Voxels,
    materials: &[Material],
    lights: &[Light],
    sky: Vec3,
) -> RayTracing<'a> {
    RayTracing::new(
        voxels,
        materials,
        lights,
        sky,
        RayTracingSettings::default(),
    )
}

/// The propagated light of a scene, before its first step.
pub fn propagation<'a>(
    voxels: &'a Voxels,
    materials: &[Material],
    lights: &[Light],
    sky: Vec3,
    steps: u32,
) -> Propagation<'a> {
    let settings = PropagationSettings {
        steps,
        ..Default::default()
    };
    let ray_tracing = traced(voxels, materials, lights, sky);
    Propagation::new(&ray_tracing, voxels, materials, sky, settings)
}

/// A light from afar, in lux, shining in this direction.
pub fn sun(direction: Vec3, lux: f32) -> Light {
    Light::Directional {
        direction: direction.normalize(),
        illuminance: Vec3::splat(lux),
    }
}

/// A light to all sides, in candela.
pub fn point_light(position: Vec3, candela: f32) -> Light {
    Light::Point {
        position,
        intensity: Vec3::splat(candela),
        cone: None,
        near: 0.0,
    }
}

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
    lights: &[Light],
    sky: Vec3,
    bounces: u32,
) -> [IrradianceField; 2] {
    let voxels = Voxels::new(grid, triangles);
    let mut flow = propagation(&voxels, materials, lights, sky, 4 * bounces);
    flow.run();
    let ray_tracing = traced(&voxels, materials, lights, sky);
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
