//! The world outside of volumes: rays see it, and pixels do not end at an edge.

use bevy::prelude::*;

use super::{
    scene::{app, at, block_of, under_sky},
    support::indirect,
};
use crate::support::gpu;

/// A closed hall of 12 m whose floor's top is at y = 0, with or without its ceiling.
fn hall(world: &mut World, has_ceiling: bool) {
    const WALL: f32 = 0.3;
    let mut slab = |center: Vec3, size: Vec3| {
        block_of(world, 0.5, center, size);
    };
    let flat = Vec3::new(12.0 + 2.0 * WALL, WALL, 12.0 + 2.0 * WALL);
    slab(Vec3::Y * -0.5 * WALL, flat);
    if has_ceiling {
        slab(Vec3::Y * (6.0 + 0.5 * WALL), flat);
    }
    for side in [-1.0, 1.0] {
        let at = side * (6.0 + 0.5 * WALL);
        slab(
            Vec3::new(at, 3.0, 0.0),
            Vec3::new(WALL, 6.0, 12.0 + 2.0 * WALL),
        );
        slab(Vec3::new(0.0, 3.0, at), Vec3::new(12.0, 6.0, WALL));
    }
}

#[test]
fn a_sealed_hall_around_a_volume_is_dark_and_an_open_one_is_not() {
    let _gpu = gpu();
    let added = |has_ceiling: bool| {
        let mut app = app();
        hall(app.world_mut(), has_ceiling);
        let sun = DirectionalLight {
            illuminance: 10.0,
            ..default()
        };
        let down = Transform::default().looking_to(Vec3::new(0.3, -1.0, 0.2), Vec3::Z);
        app.world_mut().spawn((sun, down));
        app.run_until_ready(200).expect("ready");
        let found = indirect(&mut app, under_sky(1.0));
        [(0.0, 0.0), (1.5, -1.5), (-1.2, 0.8)].map(|(x, z)| at(&found, x, z).x)
    };
    let dark = added(true);
    assert!(dark.iter().all(|light| light.abs() < 0.01), "{dark:?}");
    let open = added(false);
    assert!(open.iter().all(|light| *light > 0.3), "{open:?}");
}
