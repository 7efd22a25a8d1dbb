//! Pixels that look for the voxels around them, beside walls and where things touch: the foot of a ball, the edge of a
//! door.

use std::f32::consts::PI;

use bevy::{camera::ScalingMode, prelude::*, render::view::Msaa};
use bevy_voxel_gi::{Receiver, VoxelGiVolume};

use super::fixture::*;
use crate::support::drawn;

/// A room that a wall divides, from and to a place along x, and a light on one side. The floor's light on
/// that side, and at places on the other.
fn leak(receiver: Receiver, intensity: f32, wall: [f32; 2], places: &[f32]) -> (f32, Vec<f32>) {
    let mut app = app();
    let world = app.world_mut();
    settings(world).receiver = receiver;
    floor(world);
    // Up to the ceiling, so that no light goes over it.
    block_of(
        world,
        0.8,
        Vec3::new(0.5 * (wall[0] + wall[1]), 0.9, 0.0),
        Vec3::new(wall[1] - wall[0], 1.8, 3.8),
    );
    for (center, size) in [
        (Vec3::new(0.0, 1.85, 0.0), Vec3::new(3.8, 0.1, 3.8)),
        (Vec3::new(-1.85, 0.9, 0.0), Vec3::new(0.1, 1.8, 3.8)),
        (Vec3::new(1.85, 0.9, 0.0), Vec3::new(0.1, 1.8, 3.8)),
        (Vec3::new(0.0, 0.9, -1.85), Vec3::new(3.6, 1.8, 0.1)),
        (Vec3::new(0.0, 0.9, 1.85), Vec3::new(3.6, 1.8, 0.1)),
    ] {
        let wall = block_of(world, 0.8, center, size);
        // The camera looks from above.
        if center.y > 1.8 {
            world.entity_mut(wall).insert(hidden());
        }
    }
    let place = Transform::from_xyz(-1.0, 1.0, 0.0);
    world.spawn((point_light(4.0 * PI, 100.0), place));
    world.spawn(VoxelGiVolume {
        intensity,
        ..small_volume()
    });
    let found = settled(&mut app);
    let unlit = places.iter().map(|&x| at(&found, x, 0.4).x).collect();
    (at(&found, -1.0, 0.4).x, unlit)
}

/// What bounces to places behind the wall, in parts of what bounces on the lit side: the largest.
fn leaked(receiver: Receiver, wall: [f32; 2], places: &[f32]) -> f32 {
    let (lit, unlit) = leak(receiver, 1.0, wall, places);
    // Direct light passes the wall in the picture, which has no shadow maps.
    let (direct_lit, direct_unlit) = leak(receiver, 0.0, wall, places);
    let bounced = lit - direct_lit;
    assert!(bounced > 0.05, "{bounced}");
    unlit
        .iter()
        .zip(direct_unlit)
        .map(|(with, without)| (with - without) / bounced)
        .fold(0.0, f32::max)
}

#[test]
fn a_wall_one_voxel_thick_is_dark_behind() {
    let places = [0.6, 0.8, 1.0, 1.2, 1.4];
    let leaked = leaked(Receiver::Interpolated, [-0.125, 0.125], &places);
    assert!(leaked < 0.01, "{leaked}");
}

#[test]
fn the_foot_of_a_thin_wall_is_dark() {
    // A tenth of a voxel thick, and in the middle of one: the next pixels are beside it.
    let (wall, places) = ([0.0875, 0.1125], [0.3125, 0.6]);
    for receiver in drawn(1, [Receiver::Interpolated, Receiver::PerPixel]) {
        let leaked = leaked(receiver, wall, &places);
        println!("share of the lit side's light at the foot, {receiver:?}: {leaked}");
        assert!(leaked < 0.04, "{receiver:?}: {leaked}");
    }
}

#[test]
fn where_nothing_is_hidden_both_see_the_same() {
    let [plain, per_pixel] = [Receiver::Interpolated, Receiver::PerPixel].map(|receiver| {
        let (mut app, ..) = floor_under_sky(usual_block);
        settings(app.world_mut()).receiver = receiver;
        (settled(&mut app), report(&app).memory)
    });
    for x in [-1.4, -1.0, 0.0, 0.2] {
        let [plain, per_pixel] = [&plain.0, &per_pixel.0].map(|found| at(found, x, 0.1).x);
        assert!(
            (plain / per_pixel - 1.0).abs() < 0.03,
            "{x}: {plain} {per_pixel}"
        );
    }
    // Twelve bytes a voxel more, and up to three slices.
    let more = per_pixel.1 - plain.1;
    let slice = 16 * 32 * 8;
    assert!(
        (12 * 4096 - 3 * slice..=12 * 4096 + 3 * slice).contains(&more),
        "{more}"
    );
}

/// Edge of what the camera sees, in metres.
const SEEN: f32 = 1.2;

/// The settled picture of a scene from `offset` beside what is in its middle, with the place of each pixel on the
/// plane y = 0.
fn seen(app: &mut HeadlessApp, middle: Vec3, offset: Vec3) -> Vec<(Vec3, f32)> {
    let view = Transform::from_translation(middle + offset).looking_at(middle, Vec3::Y);
    let mut camera = camera(app.world_mut());
    camera.insert(view);
    let mut projection = camera.get_mut::<Projection>().expect("a projection");
    if let Projection::Orthographic(projection) = &mut *projection {
        projection.scaling_mode = ScalingMode::Fixed {
            width: SEEN,
            height: SEEN,
        };
    }
    let light = settled(app);
    let places = (0..SIZE * SIZE).map(|i| {
        let pixel = Vec2::new((i % SIZE) as f32, (i / SIZE) as f32) + 0.5;
        let offset = (pixel / SIZE as f32 - 0.5) * SEEN;
        let start = view.transform_point(Vec3::new(offset.x, -offset.y, 0.0));
        start - view.forward() * (start.y / view.forward().y)
    });
    places.zip(light.iter().map(|light| light.x)).collect()
}

/// Most rays of the voxels at its foot start inside the ball, and see its black back.
#[test]
#[ignore = "long: a fine volume"]
fn the_foot_of_a_ball_is_in_shadow_and_not_black() {
    const RADIUS: f32 = 0.7;
    let mut found = Vec::new();
    for receiver in [Receiver::Interpolated, Receiver::PerPixel] {
        for x in [0.0, 0.16] {
            let center = Vec3::new(x, RADIUS, 0.05);
            let mut app = floor_app();
            let world = app.world_mut();
            let mesh = Sphere::new(RADIUS).mesh().ico(16).expect("few triangles");
            let mesh = Mesh3d(world.add_asset(mesh));
            let material = MeshMaterial3d(matt(world, 0.0));
            world.spawn((mesh, material, Transform::from_translation(center)));
            // The floor is inside of a layer of voxels and not between two.
            settings(world).receiver = receiver;
            world.spawn((under_sky(1.0), Transform::from_xyz(0.0, 0.18, 0.0)));
            let offset = Vec3::new(0.0, 0.9, 2.0);
            let errors = seen(&mut app, Vec3::new(x, 0.0, 0.5), offset)
                .into_iter()
                .filter(|(place, _)| {
                    let is_hidden = (center - place).reject_from(offset).length() < RADIUS + 0.03;
                    !is_hidden && place.x.abs().max(place.z.abs()) < 1.8
                })
                .map(|(place, light)| {
                    // The sky less the form factor of the ball.
                    light - (1.0 - (RADIUS / center.distance(place)).powi(3))
                });
            let errors: Vec<f32> = errors.collect();
            let dark = errors.iter().copied().fold(0.0, f32::min);
            let bright = errors.iter().copied().fold(0.0, f32::max);
            let mean = errors.iter().map(|e| e.abs()).sum::<f32>() / errors.len() as f32;
            println!("{receiver:?}, {x}: from {dark} to {bright}, mean {mean}");
            assert!(errors.len() > 500);
            found.push((dark, bright, mean));
        }
    }
    for (dark, bright, mean) in found {
        assert!(dark > -0.26 && bright < 0.22 && mean < 0.045);
    }
}

/// Where a pixel's samples are of the floor and of a box that stands on it, Bevy shades the box below the floor. The box's
/// bottom and the floor divide the voxel there.
#[test]
fn the_edge_between_a_box_and_its_floor_is_not_dark() {
    let mut app = floor_app();
    let world = app.world_mut();
    // Its side is in the farther half of a layer of voxels, and the floor inside of one.
    block_of(
        world,
        0.5,
        Vec3::new(0.8, 0.5, 0.0),
        Vec3::new(0.8, 1.0, 3.0),
    );
    world.spawn((under_sky(1.0), Transform::from_xyz(0.0, 0.18, 0.0)));
    let mut least = |msaa: Msaa| {
        camera(app.world_mut()).insert(msaa);
        let middle = Vec3::new(0.4, 0.0, 0.0);
        let light = seen(&mut app, middle, Vec3::new(-0.8, 0.3, 0.5));
        let row = SIZE as usize;
        let inner = (1..row - 1).flat_map(|y| (1..row - 1).map(move |x| y * row + x));
        let over_neighbours = inner.map(|i| {
            let around = [i - 1, i + 1, i - row, i + row].map(|i| light[i].1);
            light[i].1 / around.into_iter().fold(f32::MAX, f32::min)
        });
        over_neighbours.fold(f32::MAX, f32::min)
    };
    let [one_sample, four] = [Msaa::Off, Msaa::Sample4].map(&mut least);
    println!("least light of a pixel over that beside it: {one_sample}, {four} with four samples");
    assert!(one_sample > 0.97 && four > 0.97, "{one_sample} {four}");
}

/// Light beside a door, at the jamb, in a dark room under a bright sky: the largest of the picture.
fn leak_beside_a_door(thickness: f32, shift: f32) -> f32 {
    const BACK: f32 = -0.2;
    const FRONT: f32 = BACK - 0.04;
    let mut app = app();
    let world = app.world_mut();
    // Floor, ceiling, left, right, front, back at both sides of the door, door.
    for (low, high) in [
        ([-1.6, -0.3, -0.6], [1.6, 0.0, 1.9]),
        ([-1.6, 1.3, -0.6], [1.6, 1.6, 1.9]),
        ([-1.6, 0.0, -0.6], [-1.3, 1.3, 1.9]),
        ([1.3, 0.0, -0.6], [1.6, 1.3, 1.9]),
        ([-1.3, 0.0, 1.6], [1.3, 1.3, 1.9]),
        ([-1.3, 0.0, -0.6], [-0.2, 1.3, BACK]),
        ([0.6, 0.0, -0.6], [1.3, 1.3, BACK]),
        ([-0.2, 0.0, FRONT - thickness], [0.6, 1.3, FRONT]),
    ] {
        let (low, high) = (Vec3::from(low), Vec3::from(high));
        block_of(world, 0.5, 0.5 * (low + high), high - low);
    }
    let place = Transform::from_translation(Vec3::splat(shift));
    settings(world).receiver = Receiver::PerPixel;
    world.spawn((under_sky(1.0), place));
    let (jamb, offset) = (Vec3::new(-0.2, 0.5, BACK), Vec3::new(0.8, 0.1, 0.8));
    let light = seen(&mut app, jamb, offset).into_iter();
    light.map(|(_, light)| light).fold(0.0, f32::max)
}

/// A voxel's edge is 0.25 m. The thin door is not tested where the only voxel of the jamb in reach is beyond it, as with
/// no shift: there the light is 0.3.
#[test]
fn beside_a_thin_door_is_no_light_of_its_other_side() {
    let rows = [
        (0.2, 0.0, 0.001),
        (0.2, 0.06, 0.001),
        (0.2, 0.09, 0.001),
        (0.1, 0.03, 0.03),
        (0.1, 0.06, 0.03),
        (0.1, 0.09, 0.03),
    ];
    for (thickness, shift, most) in drawn(1, rows) {
        let leak = leak_beside_a_door(thickness, shift);
        println!("{thickness} m, moved by {shift}: {leak}");
        assert!(leak < most, "{thickness} m, moved by {shift}: {leak}");
    }
}
