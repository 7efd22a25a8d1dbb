//! The arcade: a hall with round arches, stairs, a statue, a plant, a sign that emits light and a door.
//!
//! It is 8 m wide and long and 4.8 m high. An arcade along Z divides it into a nave, with a lantern (a point
//! light) and the sign, and an aisle, whose door lets the sun and the sky in when it is open.

use bevy::math::{Quat, Vec3};

use crate::{
    meshes::{
        arcade::materials::Materials,
        scene::{MeshScene, ScenePart},
    },
    stage::{SceneCamera, SceneDirectionalLight, ScenePointLight, Stage},
};

mod hall;
mod materials;
mod plant;
mod statue;

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
        let mut parts = vec![hall::door(&materials)];
        parts.extend(hall::parts(&materials));
        parts.extend(hall::sign(&materials));
        parts.extend(statue::parts(&materials, settings.statue_triangles));
        parts.extend(plant::parts(&materials));
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
