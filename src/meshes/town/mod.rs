//! The town: a level of 80 m with houses, a depot with a cellar, a yard and a tower.
//!
//! It is lit by the sun and an even sky, by point lights where there are no windows, and by signs. Most colours are cells of
//! one palette. The depot's corridor is sealed from the sky while its door is closed, and its lift closes a shaft
//! under a skylight while it is up.

use std::sync::Arc;

use bevy::math::{Quat, Rect, Vec2, Vec3};

use crate::{
    content,
    meshes::{
        MeshScene, SceneMaterial, SceneMesh, ScenePart,
        shapes::{self, SEED, SIZE, brightened, textured},
        town::{
            house::{House, Roof, tower},
            things::{Paint, Painted, palette},
        },
    },
    stage::{SceneCamera, SceneDirectionalLight, ScenePointLight, Stage},
};

mod depot;
mod house;
mod things;
mod yard;

/// The state of what moves in the town.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TownState {
    /// The corridor's door closed, the lift up.
    Usual,
    /// The door open.
    DoorOpen,
    /// The lift in the cellar.
    LiftMoved,
}

/// The cameras of the town.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TownCamera {
    /// In the yard.
    Yard,
    /// In a house, with daylight through windows.
    Room,
    /// In the corridor without windows.
    Corridor,
    /// In the cellar, beside the lift.
    Cellar,
    /// From the tower over the whole town.
    Tower,
}

impl TownCamera {
    pub const ALL: [Self; 5] = [
        Self::Yard,
        Self::Room,
        Self::Corridor,
        Self::Cellar,
        Self::Tower,
    ];

    /// The name of the town from here in measurements.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Yard => "town, yard",
            Self::Room => "town, room",
            Self::Corridor => "town, corridor",
            Self::Cellar => "town, cellar",
            Self::Tower => "town, tower",
        }
    }

    /// The state that differs here from the usual one, and its name in measurements.
    pub fn change(self) -> Option<(TownState, &'static str)> {
        match self {
            Self::Corridor => Some((TownState::DoorOpen, "town, corridor, door open")),
            Self::Cellar => Some((TownState::LiftMoved, "town, cellar, lift moved")),
            Self::Yard | Self::Room | Self::Tower => None,
        }
    }

    /// Position and target in metres.
    fn eye_and_target(self) -> [Vec3; 2] {
        match self {
            Self::Yard => [Vec3::new(-20.4, 1.8, 17.0), Vec3::new(3.0, 1.9, 22.5)],
            Self::Room => [Vec3::new(-17.6, 1.7, -13.7), Vec3::new(-14.9, 1.15, -18.0)],
            Self::Corridor => [Vec3::new(20.5, 1.6, 18.4), Vec3::new(8.3, 1.2, 18.9)],
            Self::Cellar => [Vec3::new(32.2, -1.4, 19.2), Vec3::new(27.0, -2.0, 13.0)],
            Self::Tower => [Vec3::new(-28.8, 17.4, 11.4), Vec3::new(0.0, 0.0, 2.0)],
        }
    }
}

/// The materials of the town.
pub(super) struct Materials {
    palette: Arc<SceneMaterial>,
    stone: Arc<SceneMaterial>,
    bricks: Arc<SceneMaterial>,
    planks: Arc<SceneMaterial>,
    leaves: Arc<SceneMaterial>,
    shop: Arc<SceneMaterial>,
    depot: Arc<SceneMaterial>,
    exit: Arc<SceneMaterial>,
    panel: Arc<SceneMaterial>,
}

impl Materials {
    fn new() -> Self {
        Self {
            palette: palette(),
            stone: textured(brightened(content::noise(SIZE, SIZE, SEED).color, 1.4)),
            bricks: textured(brightened(content::bricks(SIZE, SIZE, SEED).color, 1.5)),
            planks: textured(brightened(content::wood(SIZE, SIZE, SEED).color, 1.3)),
            leaves: shapes::leaves(),
            shop: shapes::sign("BAKERY", Vec3::new(160.0, 60.0, 130.0)),
            depot: shapes::sign("DEPOT", Vec3::new(150.0, 130.0, 50.0)),
            exit: shapes::sign("EXIT", Vec3::new(20.0, 90.0, 35.0)),
            panel: Arc::new(SceneMaterial {
                albedo: Vec3::ZERO,
                emission: Vec3::new(40.0, 80.0, 140.0),
                ..SceneMaterial::default()
            }),
        }
    }

    /// A part in colours of the palette.
    fn painted(&self, mesh: Painted) -> ScenePart {
        ScenePart::new(mesh.0, &self.palette, Vec3::ZERO)
    }
}

/// Letters that emit light on a box in front of a wall, at this point of it; both face +Z before they are turned.
fn sign(
    letters: Arc<SceneMaterial>,
    palette: &Arc<SceneMaterial>,
    at: Vec3,
    turn: f32,
    size: Vec2,
) -> [ScenePart; 2] {
    let rotation = Quat::from_rotation_y(turn);
    let half = 0.5 * size;
    let mut body = Painted::default();
    body.add_box(Paint::Coal, [-half.x, -half.y, 0.0], [half.x, half.y, 0.1]);
    [
        (body.0, palette, at),
        (
            SceneMesh::card(size),
            &letters,
            at + rotation * (0.105 * Vec3::Z),
        ),
    ]
    .map(|(mesh, material, at)| ScenePart {
        rotation,
        ..ScenePart::new(mesh, material, at)
    })
}

fn houses() -> Vec<House> {
    let house = |[x, z]: [f32; 2], [width, depth]: [f32; 2]| House {
        footprint: Rect::new(x, z, x + width, z + depth),
        storeys: 2,
        is_door_at_end: true,
        outside: Paint::Cream,
        rooms: Paint::White,
        roof: Roof::Gable(Paint::Terracotta),
    };
    vec![
        House {
            rooms: Paint::Cream,
            ..house([-24.0, -22.0], [11.0, 9.0])
        },
        House {
            outside: Paint::Rose,
            roof: Roof::Flat,
            rooms: Paint::Mint,
            ..house([-7.0, -20.0], [12.0, 9.0])
        },
        House {
            storeys: 1,
            outside: Paint::Sky,
            roof: Roof::Gable(Paint::Slate),
            ..house([10.0, -24.0], [10.0, 9.0])
        },
        House {
            outside: Paint::Ochre,
            rooms: Paint::Sky,
            ..house([25.0, -22.0], [12.0, 10.0])
        },
        House {
            storeys: 1,
            outside: Paint::Mint,
            ..house([-38.0, -23.0], [10.0, 9.0])
        },
        House {
            outside: Paint::Teal,
            roof: Roof::Gable(Paint::Coal),
            ..house([-4.0, -38.0], [12.0, 9.0])
        },
        House {
            storeys: 1,
            outside: Paint::Brick,
            rooms: Paint::Ochre,
            ..house([-22.0, -38.0], [9.0, 9.0])
        },
        House {
            roof: Roof::Flat,
            outside: Paint::White,
            rooms: Paint::Rose,
            ..house([22.0, -38.0], [11.0, 9.0])
        },
        House {
            storeys: 1,
            is_door_at_end: false,
            outside: Paint::Sand,
            ..house([-38.0, 22.0], [10.0, 10.0])
        },
    ]
}

/// The town.
#[derive(Clone, Debug)]
pub struct Town {
    parts: Vec<ScenePart>,
    picture: u32,
}

impl Town {
    /// The town in pictures of this width and height in pixels.
    pub fn new(picture: u32) -> Self {
        let materials = Materials::new();
        // First, as `scene` moves them.
        let mut parts = vec![depot::door(&materials)];
        parts.extend(depot::lift(&materials));
        parts.extend(depot::parts(&materials));
        parts.extend(yard::parts(&materials));
        parts.extend(houses().iter().map(|house| materials.painted(house.mesh())));
        parts.push(materials.painted(tower()));
        parts.extend(sign(
            materials.shop.clone(),
            &materials.palette,
            Vec3::new(0.5, 2.5, -11.0),
            0.0,
            Vec2::new(3.0, 0.7),
        ));
        Self { parts, picture }
    }

    /// The town in a state, from a camera.
    pub fn scene(&self, state: TownState, camera: TownCamera) -> MeshScene {
        let mut parts = self.parts.clone();
        if state == TownState::DoorOpen {
            parts[Self::DOOR].rotation = Quat::from_rotation_y(-1.4);
        }
        for part in Self::LIFT {
            parts[part].translation += depot::lift_shift(state);
        }
        let [eye, target] = camera.eye_and_target();
        let light = |position, strength| ScenePointLight {
            position,
            intensity_cd: strength * Vec3::new(1.0, 0.88, 0.68),
        };
        MeshScene {
            parts,
            stage: Stage {
                point_lights: vec![
                    light(Vec3::new(16.3, 2.2, 18.75), 25.0),
                    light(Vec3::new(31.5, 2.2, 22.5), 15.0),
                    light(Vec3::new(31.0, -1.1, 15.0), 30.0),
                    light(Vec3::new(-32.0, 3.2, 12.0), 30.0),
                ],
                directional_lights: vec![SceneDirectionalLight {
                    direction: Vec3::new(-0.5, -0.8, -0.35),
                    illuminance_lux: Vec3::new(400.0, 380.0, 330.0),
                }],
                sky_radiance: Vec3::new(40.0, 55.0, 80.0),
                sky_quarter: Vec3::ZERO,
                camera: SceneCamera {
                    eye,
                    target,
                    up: Vec3::Y,
                    fov_y_deg: 70.0,
                    width: self.picture,
                    height: self.picture,
                },
            },
        }
    }

    /// Index of the door among the parts of its scenes.
    const DOOR: usize = 0;
    /// Indices of the lift and its panel.
    const LIFT: [usize; 2] = [1, 2];
}
