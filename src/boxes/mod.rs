//! Scenes of boxes and lights in plain numbers, of which path-traced light is known.
//!
//! Metres, right-handed, Y up; light per channel.

use std::{
    fs,
    path::{Path, PathBuf},
};

use bevy::{
    math::{DVec3, Mat3, Quat, Vec2, Vec3},
    prelude::*,
};
use bevy_voxel_gi::reference::noise::{WallSample, wall_noise};
use serde::Deserialize;

use crate::{
    path_tracer::{self, Gloss, Hit, Ray, Receiver, Surfaces, TraceSettings, TracedPicture, View},
    stage::{
        SceneCamera, SceneDirectionalLight, ScenePointLight, Stage, spawn_camera, spawn_lights,
        volume_around,
    },
};

/// A scene whose light an independent renderer has path-traced.
pub struct TracedScene {
    /// The geometry, the lights and the camera.
    pub scene: BoxScene,
    /// Block means of the radiance that the lights cause directly.
    pub direct: Vec<Vec3>,
    /// Block means of all other radiance of surfaces, the sky's first arrival included.
    pub indirect: Vec<Vec3>,
}

impl TracedScene {
    /// Names of all traced scenes.
    pub const NAMES: [&str; 3] = ["cornell_point", "colonnade", "sunlit_room"];

    /// Reads a scene from `crates/bevy_voxel_gi/tests/data`, whose README describes the files.
    pub fn read(name: &str) -> Result<Self, TruthError> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/bevy_voxel_gi/tests/data");
        let truth = |part| read_npy(&folder.join(format!("{name}.{part}.npy")));
        Ok(Self {
            scene: BoxScene::read(&folder.join(format!("{name}.json")))?,
            direct: truth("direct")?,
            indirect: truth("indirect")?,
        })
    }
}

/// The Cornell box, 2 m wide, open in front, with a point light of 10 cd under its ceiling.
pub fn cornell_box() -> BoxScene {
    serde_json::from_str(include_str!(
        "../../crates/bevy_voxel_gi/tests/data/cornell_point.json"
    ))
    .expect("a scene, as its tests show")
}

/// A scene of boxes.
#[derive(Clone, Debug, Deserialize)]
pub struct BoxScene {
    /// The scene's name.
    pub name: String,
    /// The boxes of the scene.
    pub boxes: Vec<SceneBox>,
    /// Lights without size.
    #[serde(default)]
    pub point_lights: Vec<ScenePointLight>,
    /// Lights that are infinitely far away.
    #[serde(default)]
    pub directional_lights: Vec<SceneDirectionalLight>,
    /// Radiance of the sky, in candela per square metre.
    #[serde(default)]
    pub sky_radiance: Vec3,
    /// What the quarter of the sky at +X and +Z has beyond that.
    #[serde(default)]
    pub sky_quarter: Vec3,
    /// The camera of the truth.
    pub camera: SceneCamera,
}

/// A box, Lambertian unless it has gloss.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct SceneBox {
    /// The centre of the box in metres.
    pub center: Vec3,
    /// Half of the lengths of its edges in metres.
    pub half: Vec3,
    /// The diffuse albedo per channel, 0 to 1.
    pub albedo: Vec3,
    /// The rotation about Y in degrees, counter-clockwise seen from above. Default 0.
    #[serde(default)]
    pub rotate_y_deg: f32,
    /// Its gloss. Default none.
    #[serde(default)]
    pub gloss: Option<BoxGloss>,
}

/// The gloss of a box, in the terms of `StandardMaterial`.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct BoxGloss {
    /// The perceptual roughness, 0.089 to 1.
    pub roughness: f32,
    /// The specular reflectance of what is no metal, 0.36 to 1.
    pub reflectance: f32,
    /// Whether it is a metal, which reflects its albedo without diffuse light.
    pub is_metal: bool,
}

impl SceneBox {
    /// The rotation about Y.
    pub fn rotation(&self) -> Quat {
        Quat::from_rotation_y(self.rotate_y_deg.to_radians())
    }
}

impl BoxGloss {
    /// The specular lobe of a box of this albedo.
    pub fn lobe(&self, albedo: Vec3) -> Gloss {
        Gloss {
            roughness: self.roughness,
            f0: if self.is_metal {
                albedo
            } else {
                Vec3::splat(0.16 * self.reflectance.powi(2))
            },
        }
    }
}

impl BoxScene {
    fn read(path: &Path) -> Result<Self, TruthError> {
        let wrong = |error: &dyn std::fmt::Display| TruthError {
            path: path.to_owned(),
            error: error.to_string(),
        };
        let text = fs::read_to_string(path).map_err(|error| wrong(&error))?;
        serde_json::from_str(&text).map_err(|error| wrong(&error))
    }

    /// Its lights, sky and camera.
    pub fn stage(&self) -> Stage {
        Stage {
            point_lights: self.point_lights.clone(),
            directional_lights: self.directional_lights.clone(),
            sky_radiance: self.sky_radiance,
            sky_quarter: self.sky_quarter,
            camera: self.camera,
        }
    }

    /// Corners of the bounds of all boxes.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let mut bounds = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for part in &self.boxes {
            for corner in 0..8 {
                let sign = Vec3::new(
                    if corner & 1 == 0 { -1.0 } else { 1.0 },
                    if corner & 2 == 0 { -1.0 } else { 1.0 },
                    if corner & 4 == 0 { -1.0 } else { 1.0 },
                );
                let at = part.center + part.rotation() * (part.half * sign);
                bounds = (bounds.0.min(at), bounds.1.max(at));
            }
        }
        bounds
    }

    /// Centre and edge of the smallest volume of this many voxels along an edge that leaves one
    /// free on each side.
    pub fn volume(&self, resolution: u32) -> (Vec3, f32) {
        volume_around(self.bounds(), resolution)
    }
}

/// A file that is not what it should be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {error}", .path.display())]
pub struct TruthError {
    /// Which.
    pub path: PathBuf,
    /// Why.
    pub error: String,
}

/// Reads an H x W x 3 array of little-endian 32-bit floats in NumPy's format, version 1.
pub fn read_npy(path: &Path) -> Result<Vec<Vec3>, TruthError> {
    let wrong = |error: &str| TruthError {
        path: path.to_owned(),
        error: error.to_owned(),
    };
    let bytes = fs::read(path).map_err(|error| wrong(&error.to_string()))?;
    parse_npy(&bytes).map_err(wrong)
}

pub fn parse_npy(bytes: &[u8]) -> Result<Vec<Vec3>, &'static str> {
    let (header, data) = bytes
        .strip_prefix(b"\x93NUMPY\x01\x00")
        .and_then(|rest| rest.split_first_chunk::<2>())
        .and_then(|(length, rest)| rest.split_at_checked(u16::from_le_bytes(*length).into()))
        .ok_or("not a NumPy file of version 1")?;
    let header = String::from_utf8_lossy(header);
    if !header.contains("'<f4'") || !header.contains("'fortran_order': False") {
        return Err("not little-endian 32-bit floats in C order");
    }
    let floats: Vec<f32> = data
        .chunks_exact(4)
        .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect();
    Ok(floats.chunks_exact(3).map(Vec3::from_slice).collect())
}

/// Edge in pixels of the blocks whose means are compared: single pixels of a path-traced picture are noisy.
const BLOCK: usize = 4;

/// Indices of the pixels of each whole block, row after row.
fn blocks(width: u32, pixels: usize) -> impl Iterator<Item = [usize; BLOCK * BLOCK]> {
    let width = width as usize;
    let (columns, rows) = (width / BLOCK, pixels / width.max(1) / BLOCK);
    (0..rows * columns).map(move |block| {
        let corner = block / columns * BLOCK * width + block % columns * BLOCK;
        std::array::from_fn(|i| corner + i / BLOCK * width + i % BLOCK)
    })
}

fn mean(picture: &[Vec3], block: &[usize]) -> Vec3 {
    let sum: DVec3 = block.iter().map(|&i| picture[i].as_dvec3()).sum();
    (sum / block.len() as f64).as_vec3()
}

/// Means of 4 x 4 pixels; zero where one of the 16 sees no surface, and so is zero.
pub fn block_means(picture: &[Vec3], width: u32) -> Vec<Vec3> {
    blocks(width, picture.len())
        .map(|block| {
            if block.iter().any(|&i| picture[i] == Vec3::ZERO) {
                Vec3::ZERO
            } else {
                mean(picture, &block)
            }
        })
        .collect()
}

/// How close a picture comes to the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Agreement {
    /// Mean absolute difference over mean truth.
    pub relative_error: f64,
    /// Mean difference over mean truth.
    pub bias: f64,
    /// The 95th percentile of the relative error of blocks: of the absolute difference over the block's truth, or over
    /// a tenth of the mean truth where that is more.
    pub percentile_95: f64,
    /// The share of black blocks: of those below 1% of the mean truth whose truth is above it.
    pub black: f64,
}

/// Compares the picture with the block means of the truth, where those are not zero.
///
/// # Panics
/// If the picture has another number of blocks than the truth.
pub fn agreement(picture: &[Vec3], width: u32, truth: &[Vec3]) -> Agreement {
    let blocks: Vec<_> = blocks(width, picture.len()).collect();
    assert_eq!(blocks.len(), truth.len(), "pictures of two sizes");
    let compared = blocks.iter().zip(truth);
    let compared = compared.filter(|(_, truth)| **truth != Vec3::ZERO);
    let compared: Vec<_> = compared
        .map(|(block, truth)| (mean(picture, block).as_dvec3(), truth.as_dvec3()))
        .collect();
    let count = compared.len() as f64;
    let mean_of = |value: &dyn Fn(&(DVec3, DVec3)) -> f64| {
        compared.iter().map(value).sum::<f64>() / count.max(1.0)
    };
    let reference = mean_of(&|(_, truth)| truth.element_sum());
    let absolute = |(found, truth): &(DVec3, DVec3)| (found - truth).abs().element_sum();
    let relative =
        |block: &(DVec3, DVec3)| absolute(block) / block.1.element_sum().max(0.1 * reference);
    let mut errors: Vec<_> = compared.iter().map(relative).collect();
    errors.sort_by(f64::total_cmp);
    let is_black = |(found, truth): &(DVec3, DVec3)| {
        let least = 0.01 * reference;
        f64::from(found.element_sum() < least && truth.element_sum() > least)
    };
    Agreement {
        relative_error: mean_of(&absolute) / reference,
        bias: mean_of(&|(found, truth)| (found - truth).element_sum()) / reference,
        percentile_95: errors.get(errors.len() * 19 / 20).copied().unwrap_or(0.0),
        black: mean_of(&is_black),
    }
}

/// The smooth neighbourhood of a pixel is within this many voxels of the volume.
const RADIUS: f32 = 3.0;

/// Returns the noise of the light on the walls that the scene's camera sees: root mean square of a pixel's
/// deviation from its smooth neighbourhood, relative to the mean; `None` if no wall is large enough.
///
/// The picture is radiance, of which each wall has one albedo; `resolution` is that of the volume.
pub fn picture_noise(picture: &[Vec3], scene: &BoxScene, resolution: u32) -> Option<f64> {
    let (_, size) = scene.volume(resolution);
    let walls = visible_walls(scene).into_iter().zip(picture);
    let samples: Vec<_> = walls
        .filter_map(|(point, radiance)| {
            let point = point?;
            let albedo = point.albedo.element_sum();
            (albedo > 0.0).then(|| WallSample {
                wall: point.wall,
                position: point.position,
                normal: point.normal,
                light: radiance.element_sum() / albedo,
            })
        })
        .collect();
    wall_noise(&samples, RADIUS * size / resolution as f32).map(f64::from)
}

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
fn solids(scene: &BoxScene) -> Vec<Solid> {
    scene.boxes.iter().map(Solid::new).collect()
}

/// A box.
struct Solid {
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
