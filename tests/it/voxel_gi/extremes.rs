//! The edges: whatever is put in, the picture is finite and the game goes on.

use std::f32::consts::PI;

use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};
use bevy_frugal_lab::headless::HeadlessApp;
use bevy_voxel_gi::{
    Bounces, Follow, Sky, Solver, VoxelGiReport, VoxelGiSettings, VoxelGiVolume, VoxelLight,
    Voxelizer,
};

use super::{
    scene::{app, at, block, floor, hidden, matt, settings, small_volume, under_sky},
    support::picture,
};
use crate::support::gpu;

fn ready(app: &mut HeadlessApp) {
    app.run_until_ready(200).expect("not ready");
}

fn finite(app: &mut HeadlessApp) -> Vec<Vec3> {
    let found = picture(app);
    assert!(
        found
            .iter()
            .all(|p| p.is_finite() && p.min_element() >= 0.0)
    );
    found
}

fn solvers() -> [VoxelLight; 3] {
    let with = |solver, bounces| VoxelLight::GlobalIllumination { solver, bounces };
    [
        with(Solver::Trace { rays: 16 }, Bounces::Endless),
        with(Solver::Trace { rays: 16 }, Bounces::Count(4)),
        with(Solver::Propagate { iterations: 24 }, Bounces::Endless),
    ]
}

#[test]
fn a_bright_sun_and_pale_walls() {
    let _gpu = gpu();
    for light in solvers() {
        let mut app = app();
        let world = app.world_mut();
        floor(world);
        block(world, Vec3::new(1.5, 1.0, 0.0), Vec3::new(0.3, 2.0, 3.8));
        world.spawn((
            DirectionalLight {
                illuminance: 130_000.0,
                ..default()
            },
            Transform::default().looking_to(Vec3::new(0.5, -1.0, 0.1), Vec3::Z),
        ));
        settings(world).light = light;
        ready(&mut app);
        let direct = at(&finite(&mut app), 1.0, 0.0).x;
        app.world_mut().spawn(small_volume());
        app.run_until_ready(200).expect("not ready");
        app.render_frames(12).expect("a frame");
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
    let _gpu = gpu();
    for light in solvers() {
        let mut app = app();
        let world = app.world_mut();
        floor(world);
        block(world, Vec3::new(1.5, 1.0, 0.0), Vec3::new(0.3, 2.0, 3.8));
        world.spawn((
            PointLight {
                intensity: 1e6,
                range: 1e3,
                ..default()
            },
            Transform::from_xyz(1.25, 1.0, 0.0),
        ));
        settings(world).light = light;
        world.spawn(small_volume());
        ready(&mut app);
        app.render_frames(12).expect("a frame");
        finite(&mut app);
    }
}

#[test]
fn settings_that_are_none() {
    let _gpu = gpu();
    let mut app = app();
    floor(app.world_mut());
    let volume = app.world_mut().spawn(small_volume()).id();
    ready(&mut app);
    let nan = f32::NAN;
    let coarse = settings(app.world_mut()).clone();
    for broken in [
        VoxelGiVolume {
            size: nan,
            ..small_volume()
        },
        VoxelGiVolume {
            size: -1.0,
            ..small_volume()
        },
        VoxelGiVolume {
            cascades: 0,
            ..small_volume()
        },
        VoxelGiVolume {
            intensity: nan,
            ..small_volume()
        },
        VoxelGiVolume {
            sky: Some(Sky::uniform(LinearRgba::rgb(nan, f32::INFINITY, -1.0))),
            ..small_volume()
        },
        VoxelGiVolume {
            follow: Follow::Entity(Entity::PLACEHOLDER),
            ..small_volume()
        },
    ] {
        app.world_mut().entity_mut(volume).insert(broken);
        app.render_frames(2).expect("a frame");
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
            light: VoxelLight::AmbientOcclusion {
                radius: nan,
                rays: 0,
            },
            ..coarse.clone()
        },
    ] {
        app.world_mut().insert_resource(broken);
        app.render_frames(2).expect("a frame");
        finite(&mut app);
    }
    app.world_mut().insert_resource(coarse);
    app.world_mut()
        .entity_mut(volume)
        .insert((small_volume(), Transform::from_xyz(nan, 0.0, f32::INFINITY)));
    app.render_frames(2).expect("a frame");
    finite(&mut app);
}

#[test]
fn triangles_that_are_none_and_huge_ones() {
    let _gpu = gpu();
    let mut app = app();
    let world = app.world_mut();
    floor(world);
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
    let mesh = Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::default(),
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
    // Indices beyond the vertices, too.
    .with_inserted_indices(Indices::U32((0..12).chain([40, 41, 42]).collect()));
    let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
    let material = matt(world, 0.2);
    world.spawn((
        Mesh3d(mesh),
        MeshMaterial3d(material),
        hidden(),
        bevy::camera::visibility::NoFrustumCulling,
    ));
    world.spawn(under_sky(1.0));
    ready(&mut app);
    app.render_frames(12).expect("a frame");
    let found = finite(&mut app);
    // The huge triangle shades the floor.
    assert!(at(&found, 0.0, 0.0).x < 0.9, "{}", at(&found, 0.0, 0.0));
}

#[test]
fn lights_switched_every_frame_and_thousands_of_meshes() {
    let _gpu = gpu();
    let mut app = app();
    floor(app.world_mut());
    let light = app
        .world_mut()
        .spawn((
            PointLight {
                intensity: 400.0 * PI,
                range: 100.0,
                ..default()
            },
            Transform::from_xyz(0.0, 1.5, 0.0),
        ))
        .id();
    app.world_mut().spawn(small_volume());
    ready(&mut app);
    app.render_frames(3).expect("a frame");
    let mut memory = Vec::new();
    let mesh = app
        .world_mut()
        .resource_mut::<Assets<Mesh>>()
        .add(Cuboid::from_size(Vec3::splat(0.02)));
    let material = matt(app.world_mut(), 0.2);
    for round in 0..10 {
        let visible = if round % 2 == 0 {
            Visibility::Hidden
        } else {
            Visibility::Visible
        };
        app.world_mut().entity_mut(light).insert(visible);
        let crowd: Vec<_> = (0..1000)
            .map(|i| {
                let at = Vec3::new((i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32);
                (
                    Mesh3d(mesh.clone()),
                    MeshMaterial3d(material.clone()),
                    Transform::from_translation(at * 0.3 - 1.4),
                )
            })
            .collect();
        let crowd: Vec<_> = app.world_mut().spawn_batch(crowd).collect();
        app.render_frames(1).expect("a frame");
        finite(&mut app);
        for entity in crowd {
            app.world_mut().despawn(entity);
        }
        memory.push(app.world().resource::<VoxelGiReport>().memory);
    }
    app.render_frames(2).expect("a frame");
    let report = *app.world().resource::<VoxelGiReport>();
    // The buffers grow with the first crowd, and then no more.
    assert_eq!(memory[5..], [report.memory; 5]);
    assert_eq!(report.triangles, 12);
}

#[test]
fn volumes_that_come_and_go() {
    let _gpu = gpu();
    let mut app = app();
    floor(app.world_mut());
    ready(&mut app);
    for round in 0..6 {
        let resolution = [8, 16, 32][round % 3];
        settings(app.world_mut()).resolution = resolution;
        let volume = app.world_mut().spawn(under_sky(1.0)).id();
        app.render_frames(6).expect("a frame");
        let shade = at(&finite(&mut app), 0.0, 0.0).x;
        assert!((shade - 1.0).abs() < 0.05, "{shade} at {resolution}");
        app.world_mut().despawn(volume);
        app.render_frames(2).expect("a frame");
    }
}

/// Each of its samples is drawn once, which takes 2 to 4 times as long as to mark sub-voxels. If all were drawn for each
/// slice that it crosses, it would take 16 times as long.
#[test]
fn a_large_sloped_triangle_is_clipped_in_a_moment() {
    let _gpu = gpu();
    let times = [Voxelizer::Conservative, Voxelizer::FragmentClipping].map(|voxelizer| {
        let mut app = app();
        let world = app.world_mut();
        let mesh = Mesh::new(
            PrimitiveTopology::TriangleList,
            RenderAssetUsages::default(),
        )
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_POSITION,
            vec![[-1.9, -1.9, -1.9], [1.9, -1.8, 1.9], [-1.8, 1.9, 1.8]],
        );
        let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
        let material = matt(world, 0.5);
        let triangle = world
            .spawn((
                Mesh3d(mesh),
                MeshMaterial3d(material),
                hidden(),
                Transform::default(),
            ))
            .id();
        let mut settings = settings(world);
        (settings.voxelizer, settings.resolution) = (voxelizer, 32);
        // Hardly anything but voxelisation.
        settings.light = VoxelLight::AmbientOcclusion {
            radius: 0.0,
            rays: 4,
        };
        world.spawn(small_volume());
        ready(&mut app);
        let times = (0..3).map(|frame| {
            let mut transform = app.world_mut().get_mut::<Transform>(triangle);
            transform.as_mut().expect("it").translation.x = 1e-3 * frame as f32;
            let (_, spans) = app.measure_spans(2).expect("frames");
            let passes = ["voxel_gi_voxelize", "voxel_gi_surfaces"];
            passes
                .iter()
                .filter_map(|pass| spans.get(*pass))
                .sum::<f64>()
        });
        // Frames without voxelisation have none.
        times.filter(|ms| *ms > 0.0).fold(f64::INFINITY, f64::min)
    });
    println!("conservative {} ms, clipped {} ms", times[0], times[1]);
    assert!(
        times[0].is_finite() && times[1] < 8.0 * times[0],
        "{times:?}"
    );
}
