//! The edges: whatever is put in, the picture is finite and the game goes on.

use std::f32::consts::PI;

use bevy::{
    camera::visibility::NoFrustumCulling,
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};
use bevy_voxel_gi::{Bounces, Follow, Sky, Solver, VoxelGiSettings, VoxelGiVolume, VoxelLight};

use super::fixture::*;
use crate::support::triangle_mesh;

fn finite(app: &mut HeadlessApp) -> Vec<Vec3> {
    let found = picture(app);
    let is_light = |p: &Vec3| p.is_finite() && p.min_element() >= 0.0;
    assert!(found.iter().all(is_light));
    found
}

/// Apps in which a pale floor and a wall are lit by each solver.
fn beside_a_wall(light: impl Bundle + Clone) -> impl Iterator<Item = (VoxelLight, Borrowed)> {
    let solvers = [
        global_illumination(Solver::Trace { rays: 16 }, Bounces::Endless),
        global_illumination(Solver::Trace { rays: 16 }, Bounces::Count(4)),
        global_illumination(Solver::Propagate { iterations: 24 }, Bounces::Endless),
    ];
    solvers.into_iter().map(move |solver| {
        let mut app = floor_app();
        let world = app.world_mut();
        block(world, Vec3::new(1.5, 1.0, 0.0), Vec3::new(0.3, 2.0, 3.8));
        world.spawn(light.clone());
        settings(world).light = solver;
        (solver, app)
    })
}

#[test]
fn a_bright_sun_and_pale_walls() {
    for (light, mut app) in beside_a_wall(sun(130_000.0, Vec3::new(0.5, -1.0, 0.1))) {
        ready(&mut app);
        let direct = at(&finite(&mut app), 1.0, 0.0).x;
        app.world_mut().spawn(small_volume());
        ready(&mut app);
        frames(&mut app, 12);
        let bounced = at(&finite(&mut app), 1.0, 0.0).x - direct;
        println!("{light:?}: {bounced} beside {direct} of direct light");
        // The wall beside the place reflects a fifth of the sun.
        assert!(
            (1000.0..0.5 * direct).contains(&bounced),
            "{bounced} {direct}"
        );
    }
}

#[test]
fn a_light_of_a_million_lumens_close_to_a_wall() {
    let place = Transform::from_xyz(1.25, 1.0, 0.0);
    for (_, mut app) in beside_a_wall((point_light(1e6, 1e3), place)) {
        app.world_mut().spawn(small_volume());
        ready(&mut app);
        frames(&mut app, 12);
        finite(&mut app);
    }
}

#[test]
fn settings_that_are_none() {
    let mut app = floor_app();
    let volume = app.world_mut().spawn(small_volume()).id();
    ready(&mut app);
    let nan = f32::NAN;
    let coarse = settings(app.world_mut()).clone();
    let broken = |change: &dyn Fn(&mut VoxelGiVolume)| {
        let mut volume = small_volume();
        change(&mut volume);
        volume
    };
    for broken in [
        broken(&|volume| volume.size = nan),
        broken(&|volume| volume.size = -1.0),
        broken(&|volume| volume.cascades = 0),
        broken(&|volume| volume.intensity = nan),
        broken(&|volume| {
            volume.sky = Some(Sky::uniform(LinearRgba::rgb(nan, f32::INFINITY, -1.0)));
        }),
        broken(&|volume| volume.follow = Follow::Entity(Entity::PLACEHOLDER)),
    ] {
        app.world_mut().entity_mut(volume).insert(broken);
        frames(&mut app, 2);
        finite(&mut app);
    }
    for broken in [
        VoxelGiSettings {
            resolution: 0,
            ..coarse.clone()
        },
        VoxelGiSettings {
            shadow_samples: 0,
            update_interval: 0,
            ..coarse.clone()
        },
        VoxelGiSettings {
            light: occlusion(nan, 0),
            ..coarse.clone()
        },
    ] {
        app.world_mut().insert_resource(broken);
        frames(&mut app, 2);
        finite(&mut app);
    }
    app.world_mut().insert_resource(coarse);
    app.world_mut()
        .entity_mut(volume)
        .insert((small_volume(), Transform::from_xyz(nan, 0.0, f32::INFINITY)));
    frames(&mut app, 2);
    finite(&mut app);
}

#[test]
fn triangles_that_are_none_and_huge_ones() {
    let nan = f32::NAN;
    let positions = vec![
        // No area.
        [0.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.5, 1.0, 0.0],
        // Not a number, and infinite.
        [nan, 1.0, 0.0],
        [0.0, nan, 0.0],
        [0.0, f32::INFINITY, 1.0],
        // A kilometre large, at the height of 1.2 m.
        [-1000.0, 1.2, -1000.0],
        [0.0, 1.2, 1000.0],
        [1000.0, 1.2, -1000.0],
        // Half outside.
        [1.0, 0.5, 0.0],
        [9.0, 0.5, 0.0],
        [9.0, 0.5, 1.0],
    ];
    // Indices beyond the vertices, too.
    let indices = Indices::U32((0..12).chain([40, 41, 42]).collect());
    let mesh =
        triangle_mesh(PrimitiveTopology::TriangleList, positions).with_inserted_indices(indices);
    let (mut app, ..) = floor_under_sky(|world| {
        let model = model(world, mesh, matt_material(0.2));
        world.spawn((model, hidden(), NoFrustumCulling));
    });
    ready(&mut app);
    frames(&mut app, 12);
    let found = finite(&mut app);
    // The huge triangle shades the floor.
    assert!(at(&found, 0.0, 0.0).x < 0.9, "{}", at(&found, 0.0, 0.0));
}

#[test]
fn lights_switched_every_frame_and_thousands_of_meshes() {
    let mut app = floor_app();
    let world = app.world_mut();
    let place = Transform::from_xyz(0.0, 1.5, 0.0);
    let light = world.spawn((point_light(400.0 * PI, 100.0), place)).id();
    world.spawn(small_volume());
    ready(&mut app);
    frames(&mut app, 3);
    let mut memory = Vec::new();
    let one_of_crowd = model(
        app.world_mut(),
        Cuboid::from_length(0.02),
        matt_material(0.2),
    );
    for round in 0..10 {
        let visible = [Visibility::Hidden, Visibility::Visible][round % 2];
        app.world_mut().entity_mut(light).insert(visible);
        let crowd: Vec<_> = (0..1000)
            .map(|i| {
                let at = Vec3::new((i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32);
                let place = Transform::from_translation(at * 0.3 - 1.4);
                (one_of_crowd.clone(), place)
            })
            .collect();
        let crowd: Vec<_> = app.world_mut().spawn_batch(crowd).collect();
        frames(&mut app, 1);
        finite(&mut app);
        for entity in crowd {
            app.world_mut().despawn(entity);
        }
        memory.push(report(&app).memory);
    }
    frames(&mut app, 2);
    let report = report(&app);
    // The buffers grow with the first crowd, and then no more.
    assert_eq!(memory[5..], [report.memory; 5]);
    assert_eq!(report.triangles, 12);
}

#[test]
fn volumes_that_come_and_go() {
    let mut app = floor_app();
    ready(&mut app);
    for round in 0..6 {
        let resolution = [8, 16, 32][round % 3];
        settings(app.world_mut()).resolution = resolution;
        let volume = app.world_mut().spawn(under_sky(1.0)).id();
        frames(&mut app, 6);
        let shade = at(&finite(&mut app), 0.0, 0.0).x;
        assert!((shade - 1.0).abs() < 0.05, "{shade} at {resolution}");
        app.world_mut().despawn(volume);
        frames(&mut app, 2);
    }
}
