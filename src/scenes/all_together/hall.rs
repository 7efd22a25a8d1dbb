//! The hall in numbers: metres, lux and cd/m², Y up. It is long and low in front of the camera, so
//! that most of its floor is seen at grazing angles; the sun comes in between columns at the right.

use bevy::prelude::*;
use bevy_voxel_gi::Sky;

/// Exposure of the cameras: the walls in bounced light are in the middle of the scale.
pub const EV100: f32 = 11.5;
/// Direction of the sunlight at time 0.
pub const SUN: Vec3 = Vec3::new(-0.72, -0.62, -0.3);
/// Illuminance of a plane that faces the sun, in lux.
pub const SUN_LUX: f32 = 80_000.0;
/// Brightness of the ambient light where nothing computes it, in cd/m²: about the mean of what
/// bounces in the hall.
pub const AMBIENT: f32 = 1500.0;

/// Half the width, the height, and the two ends of the hall.
const HALF_WIDTH: f32 = 2.6;
const HEIGHT: f32 = 3.8;
const BACK: f32 = -15.0;
const FRONT: f32 = 4.0;
const WALL: f32 = 0.6;
/// Distance of the columns, and half their thickness.
const COLUMNS: f32 = 2.7;
const COLUMN: f32 = 0.3;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Matter {
    Bricks,
    Planks,
    Stone,
    Picture,
    Leaves,
    Tiles,
    /// A cloth of one colour, without textures.
    Cloth(Cloth),
    Ground,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cloth {
    Red,
    Blue,
}

/// A box, or a card where it has no depth.
#[derive(Clone, Copy, Debug)]
pub struct HallPart {
    pub matter: Matter,
    pub center: Vec3,
    /// Its edges; a depth of 0 makes a card that faces +Z before it is turned.
    pub size: Vec3,
    /// Turned about the vertical, in radians.
    pub turned: f32,
}

impl HallPart {
    /// Repetitions of the texture a metre; none stretches the texture over the part.
    pub fn repeats(&self) -> Option<f32> {
        match self.matter {
            Matter::Picture | Matter::Leaves => None,
            Matter::Tiles => Some(0.25),
            Matter::Stone => Some(0.6),
            Matter::Bricks | Matter::Planks => Some(0.7),
            Matter::Cloth(_) | Matter::Ground => Some(1.0),
        }
    }
}

/// Where the cameras are at the start.
pub fn view() -> Transform {
    Transform::from_xyz(0.7, 1.5, 3.2).looking_at(Vec3::new(-0.7, 1.15, -8.0), Vec3::Y)
}

/// Light from outside: a clear sky, and sunlit ground below it.
pub fn sky() -> Sky {
    Sky {
        zenith: LinearRgba::rgb(2200.0, 3200.0, 5000.0),
        horizon: LinearRgba::rgb(4200.0, 4700.0, 5200.0),
        ground: LinearRgba::rgb(6500.0, 6000.0, 5000.0),
    }
}

pub fn background() -> Color {
    let exposure = bevy::camera::Exposure { ev100: EV100 }.exposure();
    (sky().horizon * exposure).with_alpha(1.0).into()
}

/// Middle and edge of the volume in which light bounces.
pub fn volume() -> (Vec3, f32) {
    let center = Vec3::new(0.0, 0.5 * HEIGHT, 0.5 * (BACK + FRONT));
    (center, FRONT - BACK + 2.0 * WALL + 1.0)
}

pub fn parts() -> Vec<HallPart> {
    let mut parts = vec![
        // Floor and ceiling.
        span(
            Matter::Tiles,
            [-HALF_WIDTH - WALL, -WALL, BACK - WALL],
            [HALF_WIDTH + WALL, 0.0, FRONT + WALL],
        ),
        span(
            Matter::Planks,
            [-HALF_WIDTH - WALL, HEIGHT, BACK - WALL],
            [HALF_WIDTH + WALL, HEIGHT + WALL, FRONT + WALL],
        ),
        // Left, at the back and in front.
        span(
            Matter::Bricks,
            [-HALF_WIDTH - WALL, 0.0, BACK - WALL],
            [-HALF_WIDTH, HEIGHT, FRONT + WALL],
        ),
        span(
            Matter::Bricks,
            [-HALF_WIDTH, 0.0, BACK - WALL],
            [HALF_WIDTH + WALL, HEIGHT, BACK],
        ),
        span(
            Matter::Bricks,
            [-HALF_WIDTH, 0.0, FRONT],
            [HALF_WIDTH + WALL, HEIGHT, FRONT + WALL],
        ),
        // Right: a low wall, columns and what they bear.
        span(
            Matter::Stone,
            [HALF_WIDTH, 0.0, BACK],
            [HALF_WIDTH + WALL, 0.5, FRONT],
        ),
        span(
            Matter::Stone,
            [HALF_WIDTH, HEIGHT - 0.7, BACK],
            [HALF_WIDTH + WALL, HEIGHT, FRONT],
        ),
        // Cloth at the left wall and at the back.
        span(
            Matter::Cloth(Cloth::Red),
            [-HALF_WIDTH, 0.9, -6.3],
            [-HALF_WIDTH + 0.06, 3.3, -4.9],
        ),
        span(
            Matter::Cloth(Cloth::Blue),
            [-HALF_WIDTH, 0.9, -11.7],
            [-HALF_WIDTH + 0.06, 3.3, -10.3],
        ),
        span(
            Matter::Cloth(Cloth::Red),
            [-1.1, 0.7, BACK],
            [1.1, 3.2, BACK + 0.06],
        ),
        // Outside.
        span(Matter::Ground, [-60.0, -1.6, -70.0], [60.0, -0.9, 50.0]),
    ];
    let columns = ((FRONT - BACK) / COLUMNS) as u32;
    for i in 0..=columns {
        let z = BACK + COLUMN + i as f32 * COLUMNS;
        parts.push(span(
            Matter::Stone,
            [HALF_WIDTH, 0.5, z - COLUMN],
            [HALF_WIDTH + WALL, HEIGHT - 0.7, z + COLUMN],
        ));
    }
    for (center, edge, turned) in [
        (Vec3::new(-1.75, 0.45, -2.1), 0.9, 0.3),
        (Vec3::new(-1.7, 1.2, -2.15), 0.6, -0.25),
        (Vec3::new(-1.9, 0.35, -0.85), 0.7, 0.1),
        (Vec3::new(1.7, 0.4, -7.6), 0.8, 0.6),
    ] {
        parts.push(HallPart {
            matter: Matter::Planks,
            center,
            size: Vec3::splat(edge),
            turned,
        });
    }
    for z in [-3.7, -8.3] {
        parts.push(HallPart {
            matter: Matter::Picture,
            center: Vec3::new(-HALF_WIDTH + 0.03, 1.9, z),
            size: Vec3::new(1.8, 1.2, 0.0),
            turned: std::f32::consts::FRAC_PI_2,
        });
    }
    for (center, turned) in [
        (Vec3::new(1.75, 0.55, -1.7), 0.5),
        (Vec3::new(1.85, 0.55, -4.4), -0.4),
        (Vec3::new(-1.9, 0.55, -6.9), 0.8),
    ] {
        for quarter in [0.0, std::f32::consts::FRAC_PI_2] {
            parts.push(HallPart {
                matter: Matter::Leaves,
                center,
                size: Vec3::new(1.0, 1.1, 0.0),
                turned: turned + quarter,
            });
        }
    }
    parts
}

/// A box from corner to corner.
fn span(matter: Matter, low: [f32; 3], high: [f32; 3]) -> HallPart {
    let (low, high) = (Vec3::from(low), Vec3::from(high));
    HallPart {
        matter,
        center: 0.5 * (low + high),
        size: high - low,
        turned: 0.0,
    }
}
