//! Where things touch: the foot of a ball, the edge of a door. Cameras look along the surfaces there.

use bevy::{camera::ScalingMode, prelude::*, render::view::Msaa};
use bevy_frugal_lab::headless::HeadlessApp;
use bevy_voxel_gi::Receiver;

use super::{
    scene::{SIZE, app, block_of, floor, matt, settings, under_sky},
    support::{picture, settle},
};
use crate::support::gpu;

/// Edge of what the camera sees, in metres.
const SEEN: f32 = 1.2;

/// The settled picture of a scene from `offset` beside what is in its middle, with the place of each pixel on the
/// plane y = 0.
fn seen(app: &mut HeadlessApp, middle: Vec3, offset: Vec3) -> Vec<(Vec3, f32)> {
    let view = Transform::from_translation(middle + offset).looking_at(middle, Vec3::Y);
    let world = app.world_mut();
    let mut cameras = world.query_filtered::<(&mut Transform, &mut Projection), With<Camera3d>>();
    let (mut transform, mut projection) = cameras.single_mut(world).expect("one camera");
    *transform = view;
    if let Projection::Orthographic(projection) = &mut *projection {
        projection.scaling_mode = ScalingMode::Fixed {
            width: SEEN,
            height: SEEN,
        };
    }
    app.run_until_ready(200).expect("not ready");
    settle(app);
    let places = (0..SIZE * SIZE).map(|i| {
        let pixel = Vec2::new((i % SIZE) as f32, (i / SIZE) as f32) + 0.5;
        let offset = (pixel / SIZE as f32 - 0.5) * SEEN;
        let start = view.transform_point(Vec3::new(offset.x, -offset.y, 0.0));
        start - view.forward() * (start.y / view.forward().y)
    });
    let light = picture(app).into_iter().map(|light| light.x);
    places.zip(light).collect()
}

/// Most rays of the voxels at its foot start inside the ball, and see its black back.
#[test]
fn the_foot_of_a_ball_is_in_shadow_and_not_black() {
    let _gpu = gpu();
    const RADIUS: f32 = 0.7;
    let mut found = Vec::new();
    for receiver in [Receiver::Interpolated, Receiver::PerPixel] {
        for x in [0.0, 0.16] {
            let center = Vec3::new(x, RADIUS, 0.05);
            let mut app = app();
            let world = app.world_mut();
            floor(world);
            let material = matt(world, 0.0);
            let mesh = Sphere::new(RADIUS).mesh().ico(16).expect("few triangles");
            let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
            let place = Transform::from_translation(center);
            world.spawn((Mesh3d(mesh), MeshMaterial3d(material), place));
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
    let _gpu = gpu();
    let mut app = app();
    let world = app.world_mut();
    floor(world);
    // Its side is in the farther half of a layer of voxels, and the floor inside of one.
    block_of(
        world,
        0.5,
        Vec3::new(0.8, 0.5, 0.0),
        Vec3::new(0.8, 1.0, 3.0),
    );
    world.spawn((under_sky(1.0), Transform::from_xyz(0.0, 0.18, 0.0)));
    let camera = world
        .query_filtered::<Entity, With<Camera3d>>()
        .single(world)
        .expect("a camera");
    let mut least = |msaa: Msaa| {
        app.world_mut().entity_mut(camera).insert(msaa);
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
    app.world_mut().entity_mut(camera).insert(Msaa::Off);
    println!("least light of a pixel over that beside it: {one_sample}, {four} with four samples");
    assert!(one_sample > 0.97 && four > 0.97, "{one_sample} {four}");
}

/// Light beside a door, at the jamb, in a dark room under a bright sky: the largest of the picture.
fn leak_beside_a_door(thickness: f32, recess: f32, shift: f32) -> f32 {
    const BACK: f32 = -0.2;
    let mut app = app();
    let world = app.world_mut();
    let mut span = |low: [f32; 3], high: [f32; 3]| {
        let (low, high) = (Vec3::from(low), Vec3::from(high));
        block_of(world, 0.5, 0.5 * (low + high), high - low)
    };
    // Floor, ceiling, left, right, front, back at both sides of the door, door.
    span([-1.6, -0.3, -0.6], [1.6, 0.0, 1.9]);
    span([-1.6, 1.3, -0.6], [1.6, 1.6, 1.9]);
    span([-1.6, 0.0, -0.6], [-1.3, 1.3, 1.9]);
    span([1.3, 0.0, -0.6], [1.6, 1.3, 1.9]);
    span([-1.3, 0.0, 1.6], [1.3, 1.3, 1.9]);
    span([-1.3, 0.0, -0.6], [-0.2, 1.3, BACK]);
    span([0.6, 0.0, -0.6], [1.3, 1.3, BACK]);
    let front = BACK - recess;
    span([-0.2, 0.0, front - thickness], [0.6, 1.3, front]);
    let place = Transform::from_translation(Vec3::splat(shift));
    settings(world).receiver = Receiver::PerPixel;
    world.spawn((under_sky(1.0), place));
    let light = seen(
        &mut app,
        Vec3::new(-0.2, 0.5, BACK),
        Vec3::new(0.8, 0.1, 0.8),
    );
    light
        .into_iter()
        .map(|(_, light)| light)
        .fold(0.0, f32::max)
}

/// A voxel's edge is 0.25 m. The thin door is not tested where the only voxel of the jamb in reach is beyond it, as with
/// no shift: there the light is 0.3.
#[test]
fn beside_a_thin_door_is_no_light_of_its_other_side() {
    let _gpu = gpu();
    for (thickness, shifts, most) in [
        (0.2, [0.0, 0.06, 0.09], 0.001),
        (0.1, [0.03, 0.06, 0.09], 0.03),
    ] {
        for shift in shifts {
            let leak = leak_beside_a_door(thickness, 0.04, shift);
            println!("{thickness} m, moved by {shift}: {leak}");
            assert!(leak < most, "{thickness} m, moved by {shift}: {leak}");
        }
    }
}
