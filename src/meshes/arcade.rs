//! The arcade: a hall with round arches, stairs, a statue, a plant, a sign that emits light and a door.
//!
//! It is 8 m wide and long and 4.8 m high. An arcade along Z divides it into a nave, with a lantern (a point
//! light) and the sign, and an aisle, whose door lets the sun and the sky in when it is open.

use std::{
    f32::consts::{FRAC_PI_2, TAU},
    sync::Arc,
};

use bevy::math::{EulerRot, Quat, Vec2, Vec3};
use image::RgbImage;

use crate::{
    content,
    meshes::{
        MeshScene, SceneMaterial, SceneMesh, ScenePart,
        shapes::{SEED, SIZE, brightened, colored, leaves, sign, textured},
    },
    stage::{SceneCamera, SceneDirectionalLight, ScenePointLight, Stage},
};

/// How detailed the arcade is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ArcadeSettings {
    /// Triangles of the statue, about. Default 1 million.
    pub statue_triangles: u32,
    /// Width and height of the picture in pixels. Default 128.
    pub picture: u32,
}

impl Default for ArcadeSettings {
    fn default() -> Self {
        Self {
            statue_triangles: 1_000_000,
            picture: 128,
        }
    }
}

/// The variable parts of the arcade.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArcadeState {
    /// The lantern over the middle of the nave, the door closed.
    Usual,
    /// The lantern beside the statue.
    LightMoved,
    /// The door open.
    DoorOpen,
}

impl ArcadeState {
    pub const ALL: [Self; 3] = [Self::Usual, Self::LightMoved, Self::DoorOpen];

    /// The name of the scene in measurements.
    pub fn name(self) -> &'static str {
        match self {
            Self::Usual => "arcade",
            Self::LightMoved => "arcade, light moved",
            Self::DoorOpen => "arcade, door open",
        }
    }

    /// Position of the lantern in metres.
    pub fn lantern(self) -> Vec3 {
        match self {
            Self::LightMoved => Vec3::new(-2.6, 2.2, -0.6),
            Self::Usual | Self::DoorOpen => Vec3::new(-0.9, 3.6, 0.8),
        }
    }

    /// The rotation of the door.
    pub fn door(self) -> Quat {
        match self {
            Self::DoorOpen => Quat::from_rotation_y(-1.3),
            Self::Usual | Self::LightMoved => Quat::IDENTITY,
        }
    }
}

/// The arcade.
#[derive(Clone, Debug)]
pub struct Arcade {
    parts: Vec<ScenePart>,
    camera: SceneCamera,
}

impl Arcade {
    pub fn new(settings: ArcadeSettings) -> Self {
        let materials = Materials::new();
        // First, as `scene` turns it.
        let mut parts = vec![door(&materials)];
        parts.extend(hall(&materials));
        parts.extend(wall_sign(&materials));
        parts.extend(statue(&materials, settings.statue_triangles));
        parts.extend(plant(&materials));
        Self {
            parts,
            camera: SceneCamera {
                eye: Vec3::new(-1.6, 1.9, 3.8),
                target: Vec3::new(-0.5, 1.55, 0.0),
                up: Vec3::Y,
                fov_y_deg: 75.0,
                width: settings.picture,
                height: settings.picture,
            },
        }
    }

    /// The arcade in a state.
    pub fn scene(&self, state: ArcadeState) -> MeshScene {
        let mut parts = self.parts.clone();
        parts[Self::DOOR].rotation = state.door();
        MeshScene {
            parts,
            stage: Stage {
                point_lights: vec![ScenePointLight {
                    position: state.lantern(),
                    intensity_cd: Vec3::new(120.0, 105.0, 80.0),
                }],
                directional_lights: vec![SceneDirectionalLight {
                    direction: Vec3::new(-0.8, -0.42, -0.25),
                    illuminance_lux: Vec3::new(400.0, 380.0, 330.0),
                }],
                sky_radiance: Vec3::new(40.0, 55.0, 80.0),
                sky_quarter: Vec3::ZERO,
                camera: self.camera,
            },
        }
    }

    /// Index of the door among the parts of its scenes.
    pub const DOOR: usize = 0;
}

/// Half of the hall's width and length.
const HALF: f32 = 4.0;
const HEIGHT: f32 = 4.8;
/// Thickness of the walls.
const WALL: f32 = 0.4;
/// The middle of the arcade's wall along X.
const ARCADE_X: f32 = 1.8;
/// Number of arches.
const ARCHES: u32 = 3;
/// Radius of an arch, and the height at which it begins.
const RADIUS: f32 = 1.0;
const SPRING: f32 = 2.0;
/// The ends of the doorway along Z, and its height.
const DOORWAY: [f32; 2] = [-1.1, 0.7];
const DOOR_HEIGHT: f32 = 2.5;
const DOOR_THICKNESS: f32 = 0.08;
/// The step of the stairs: its height and its depth.
const RISE: f32 = 0.2;
const TREAD: f32 = 0.32;
const STEPS: u32 = 7;

/// Floor, walls, arches and stairs.
fn hall(materials: &Materials) -> Vec<ScenePart> {
    let span = |low: [f32; 3], high: [f32; 3]| SceneMesh::cuboid(low.into(), high.into());
    let (end, top) = (HALF + WALL, HEIGHT + WALL);
    let mut right = span([HALF, 0.0, -end], [end, HEIGHT, DOORWAY[0]]);
    right.add_box(
        Vec3::new(HALF, 0.0, DOORWAY[1]),
        Vec3::new(end, HEIGHT, end),
    );
    right.add_box(
        Vec3::new(HALF, DOOR_HEIGHT, DOORWAY[0]),
        Vec3::new(end, HEIGHT, DOORWAY[1]),
    );
    let mut back_and_front = span([-HALF, 0.0, -end], [HALF, HEIGHT, -HALF]);
    back_and_front.add_box(Vec3::new(-HALF, 0.0, HALF), Vec3::new(HALF, HEIGHT, end));
    let meshes = [
        (
            span([-end, -WALL, -end], [end, 0.0, end]),
            2.0,
            &materials.tiles,
        ),
        (
            span([-end, HEIGHT, -end], [end, top, end]),
            1.0,
            &materials.plaster,
        ),
        (
            span([-end, 0.0, -end], [-HALF, HEIGHT, end]),
            1.5,
            &materials.bricks,
        ),
        (right, 1.0, &materials.red),
        (back_and_front, 1.0, &materials.plaster),
        (stairs(), 1.0, &materials.planks),
    ];
    let place = |(mesh, metres, material): (SceneMesh, f32, _)| {
        ScenePart::new(mesh.repeated(metres), material, Vec3::ZERO)
    };
    let mut parts: Vec<_> = meshes.into_iter().map(place).collect();
    parts.push(arcade(materials));
    parts
}

/// The wall with the arches, along Z.
fn arcade(materials: &Materials) -> ScenePart {
    let width = 2.0 * HALF / ARCHES as f32;
    let mut mesh = SceneMesh::default();
    for i in 0..ARCHES {
        let mut arch = SceneMesh::default();
        arch.add_arch(width, HEIGHT, WALL, RADIUS, SPRING);
        let shift = (i as f32 + 0.5) * width - HALF;
        mesh.append(arch, Vec3::X * shift);
    }
    ScenePart {
        rotation: Quat::from_rotation_y(FRAC_PI_2),
        ..ScenePart::new(mesh.repeated(1.2), &materials.stone, Vec3::X * ARCADE_X)
    }
}

/// Stairs along the back wall, up to the left.
fn stairs() -> SceneMesh {
    let mut mesh = SceneMesh::default();
    for i in 0..STEPS {
        let x = -HALF + TREAD * (STEPS - i) as f32;
        let low = Vec3::new(-HALF, RISE * i as f32, -HALF);
        mesh.add_box(low, Vec3::new(x, RISE * (i + 1) as f32, -HALF + 1.3));
    }
    mesh
}

/// The closed door. Its origin is its hinge, so that its rotation opens it into the hall.
fn door(materials: &Materials) -> ScenePart {
    let width = DOORWAY[1] - DOORWAY[0];
    let mesh = SceneMesh::cuboid(Vec3::ZERO, Vec3::new(DOOR_THICKNESS, DOOR_HEIGHT, width));
    let hinge = Vec3::new(HALF, 0.0, DOORWAY[0]);
    ScenePart::new(mesh.repeated(1.0), &materials.planks, hinge)
}

/// The sign on the left wall: letters that emit light, on a box.
fn wall_sign(materials: &Materials) -> [ScenePart; 2] {
    let (center, size) = (Vec3::new(-HALF + 0.12, 2.6, -0.6), Vec2::new(1.8, 0.6));
    let half = 0.5 * Vec3::new(0.24, size.y, size.x);
    let body = SceneMesh::cuboid(-half, half);
    let letters = ScenePart {
        rotation: Quat::from_rotation_y(FRAC_PI_2),
        ..ScenePart::new(
            SceneMesh::card(size),
            &materials.sign,
            center + 0.125 * Vec3::X,
        )
    };
    [ScenePart::new(body, &materials.plaster, center), letters]
}

/// Size of the knot, and radius of its tube.
const KNOT_SIZE: f32 = 0.28;
const TUBE: f32 = 0.17;

/// The statue: a torus knot with dents, on a pedestal.
fn statue(materials: &Materials, triangles: u32) -> [ScenePart; 2] {
    /// The middle of the pedestal's foot.
    const POSITION: Vec3 = Vec3::new(-0.9, 0.0, -1.2);
    /// The middle of the knot above the pedestal.
    const KNOT_HEIGHT: f32 = 0.95;
    let (half, height) = (0.45, 0.7);
    let pedestal = SceneMesh::cuboid(Vec3::new(-half, 0.0, -half), Vec3::new(half, height, half));
    // Eight times as many along the tube as around it.
    let rows = (triangles as f32 / 16.0).sqrt().round().max(3.0) as u32;
    let knot = SceneMesh::grid(8 * rows, rows, surface);
    [
        ScenePart::new(pedestal, &materials.stone, POSITION),
        ScenePart::new(
            knot,
            &materials.marble,
            POSITION + (height + KNOT_HEIGHT) * Vec3::Y,
        ),
    ]
}

/// The middle of the tube: a trefoil that stands upright.
fn curve(t: f32) -> Vec3 {
    let angle = TAU * t;
    let at = Vec3::new(
        angle.sin() + 2.0 * (2.0 * angle).sin(),
        angle.cos() - 2.0 * (2.0 * angle).cos(),
        -(3.0 * angle).sin(),
    );
    KNOT_SIZE * at
}

/// A point of the surface, from coordinates along and around the tube.
fn surface(uv: Vec2) -> Vec3 {
    let (center, step) = (curve(uv.x), 1e-3);
    let tangent = (curve(uv.x + step) - curve(uv.x - step)).normalize();
    // The knot's tangents are never along Z, which so gives a frame that closes.
    let side = tangent.cross(Vec3::Z).normalize();
    let up = side.cross(tangent);
    let (sin, cos) = (TAU * uv.y).sin_cos();
    let dents = 0.12 * (TAU * (40.0 * uv.x + 2.0 * uv.y)).sin()
        + 0.06 * (TAU * (90.0 * uv.x - 5.0 * uv.y)).sin() * (TAU * 7.0 * uv.y).cos();
    center + TUBE * (1.0 + dents) * (cos * side + sin * up)
}

/// The plant: cards of leaves with holes, in a pot.
fn plant(materials: &Materials) -> [ScenePart; 2] {
    /// The middle of the pot's foot.
    const POSITION: Vec3 = Vec3::new(0.75, 0.0, 1.1);
    /// Radius and height of the pot.
    const POT: [f32; 2] = [0.28, 0.45];
    const CARDS: u32 = 28;
    let mut leaves = SceneMesh::default();
    for i in 0..CARDS {
        // Golden angles around the stem, from the bottom to the top.
        let (angle, height) = (2.399_963 * i as f32, i as f32 / CARDS as f32);
        let (sin, cos) = angle.sin_cos();
        let radius = 0.32 * (1.0 - 0.6 * height);
        let center = Vec3::new(radius * cos, 0.15 + 0.95 * height, radius * sin);
        let tilt = -0.4 - 0.6 * height;
        let rotation = Quat::from_euler(EulerRot::YXZ, TAU / 4.0 - angle, tilt, angle);
        leaves.append_rotated(SceneMesh::card(Vec2::splat(0.55)), rotation, center);
    }
    let pot = SceneMesh::cylinder(POT[0], POT[1], 24);
    [
        ScenePart::new(pot, &materials.red, POSITION),
        ScenePart::new(leaves, &materials.leaves, POSITION + POT[1] * Vec3::Y),
    ]
}

/// The materials of the arcade.
struct Materials {
    bricks: Arc<SceneMaterial>,
    tiles: Arc<SceneMaterial>,
    planks: Arc<SceneMaterial>,
    stone: Arc<SceneMaterial>,
    plaster: Arc<SceneMaterial>,
    marble: Arc<SceneMaterial>,
    red: Arc<SceneMaterial>,
    leaves: Arc<SceneMaterial>,
    sign: Arc<SceneMaterial>,
}

impl Materials {
    fn new() -> Self {
        let rock = content::noise(SIZE, SIZE, SEED).color;
        Self {
            bricks: textured(brightened(content::bricks(SIZE, SIZE, SEED).color, 1.5)),
            tiles: textured(tiles(&rock)),
            planks: textured(brightened(content::wood(SIZE, SIZE, SEED).color, 1.3)),
            stone: textured(brightened(rock, 1.5)),
            plaster: colored(Vec3::new(0.78, 0.74, 0.66)),
            marble: colored(Vec3::new(0.8, 0.8, 0.78)),
            red: colored(Vec3::new(0.6, 0.08, 0.06)),
            leaves: leaves(),
            sign: sign("BEVY", Vec3::new(160.0, 60.0, 130.0)),
        }
    }
}

/// Light and dark tiles with the grain of a rock, four in each direction.
fn tiles(rock: &RgbImage) -> RgbImage {
    const TILE: u32 = SIZE / 4;
    RgbImage::from_fn(SIZE, SIZE, |x, y| {
        let is_light = (x / TILE + y / TILE).is_multiple_of(2);
        let tint = if is_light {
            [225.0, 215.0, 195.0]
        } else {
            [130.0, 90.0, 75.0]
        };
        let grain = 0.85 + 0.3 * f32::from(rock.get_pixel(x, y).0[1]) / 255.0;
        image::Rgb(tint.map(|level: f32| (level * grain).min(240.0) as u8))
    })
}
