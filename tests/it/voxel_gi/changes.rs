//! Meshes are extracted when they change: after any change the light is that of an app that begins with it.

use bevy::{camera::Exposure, prelude::*};
use bevy_frugal_lab::headless::{HeadlessApp, LabTarget};
use bevy_voxel_gi::NotVoxelized;

use super::{
    history::copy,
    scene::{app, app_with, block, floor, matt, small_volume, under_sky},
    support::{read_texels, settle},
};
use crate::support::gpu;

/// A change of the block, and whether it changes the light.
type Change = (&'static str, fn(&mut World, Entity), bool);

const CHANGES: [Change; 14] = [
    (
        "moved",
        |world, block| place(world, block, Vec3::new(-1.0, 0.5, 0.5)),
        true,
    ),
    (
        "moved back",
        |world, block| place(world, block, BEGIN),
        true,
    ),
    (
        "touched",
        |world, block| {
            world
                .get_mut::<Transform>(block)
                .expect("a block")
                .set_changed();
        },
        false,
    ),
    (
        "hidden",
        |world, block| {
            world.entity_mut(block).insert(Visibility::Hidden);
        },
        true,
    ),
    (
        "shown",
        |world, block| {
            world.entity_mut(block).insert(Visibility::Visible);
        },
        true,
    ),
    (
        "excluded",
        |world, block| {
            world.entity_mut(block).insert(NotVoxelized);
        },
        true,
    ),
    (
        "included",
        |world, block| {
            world.entity_mut(block).remove::<NotVoxelized>();
        },
        true,
    ),
    (
        "of another material",
        |world, block| {
            let white = matt(world, 0.9);
            world.entity_mut(block).insert(MeshMaterial3d(white));
        },
        true,
    ),
    (
        "of another mesh",
        |world, block| {
            let ball = world.resource_mut::<Assets<Mesh>>().add(Sphere::new(0.6));
            world.entity_mut(block).insert(Mesh3d(ball));
        },
        true,
    ),
    (
        "of an edited mesh",
        |world, block| {
            let mesh = world.get::<Mesh3d>(block).expect("a mesh").id();
            let mut meshes = world.resource_mut::<Assets<Mesh>>();
            let mut ball = meshes.get_mut(mesh).expect("the ball");
            ball.scale_by(Vec3::new(1.5, 0.5, 1.0));
        },
        true,
    ),
    (
        "of an edited material",
        |world, block| {
            let material = world
                .get::<MeshMaterial3d<StandardMaterial>>(block)
                .expect("a material")
                .id();
            let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
            let mut material = materials.get_mut(material).expect("the material");
            material.base_color = LinearRgba::rgb(0.5, 0.1, 0.1).into();
        },
        true,
    ),
    (
        "one of many",
        |world, block| {
            let mesh = world.get::<Mesh3d>(block).expect("a mesh").clone();
            let material = matt(world, 0.6);
            for i in 0..20 {
                let at = Vec3::new((i % 5) as f32 * 0.7 - 1.4, 0.1, (i / 5) as f32 * 0.7 - 1.4);
                let scaled = Transform::from_translation(at).with_scale(Vec3::splat(0.3));
                let material = MeshMaterial3d(material.clone());
                world.spawn((OneOfMany, mesh.clone(), material, scaled));
            }
        },
        true,
    ),
    (
        "one of fewer, of which some are new",
        |world, block| {
            let mesh = world.get::<Mesh3d>(block).expect("a mesh").clone();
            let mut many = world.query_filtered::<Entity, With<OneOfMany>>();
            let many: Vec<_> = many.iter(world).collect();
            many.iter().step_by(2).for_each(|other| {
                world.despawn(*other);
            });
            let material = matt(world, 0.6);
            for i in 0..3 {
                let at = Transform::from_xyz(i as f32 - 1.0, 0.8, 1.2);
                let scaled = at.with_scale(Vec3::splat(0.4));
                let material = MeshMaterial3d(material.clone());
                world.spawn((OneOfMany, mesh.clone(), material, scaled));
            }
        },
        true,
    ),
    (
        "out of the volume",
        |world, block| place(world, block, Vec3::splat(50.0)),
        true,
    ),
];

#[derive(Component)]
struct OneOfMany;

const BEGIN: Vec3 = Vec3::new(0.7, 0.5, 0.0);

fn place(world: &mut World, block: Entity, at: Vec3) {
    world
        .get_mut::<Transform>(block)
        .expect("a block")
        .translation = at;
}

/// Mean difference as a share of the mean.
fn difference(a: &[Vec4], b: &[Vec4]) -> f32 {
    let sum =
        |values: &mut dyn Iterator<Item = Vec4>| values.map(|v| v.abs().element_sum()).sum::<f32>();
    sum(&mut a.iter().zip(b).map(|(a, b)| *a - *b)) / sum(&mut a.iter().copied())
}

fn settled(app: &mut HeadlessApp) -> Vec<Vec4> {
    app.render_frames(2).expect("frames");
    settle(app);
    read_texels(app).into_iter().flatten().collect()
}

#[test]
fn after_any_change_the_light_is_that_of_a_new_app() {
    let _gpu = gpu();
    let mut app = app();
    let world = app.world_mut();
    floor(world);
    let block = block(world, BEGIN, Vec3::ONE);
    world.spawn(under_sky(1.0));
    app.run_until_ready(200).expect("ready");
    let mut before = settled(&mut app);
    for (name, change, matters) in CHANGES {
        change(app.world_mut(), block);
        let found = settled(&mut app);
        let mut new = app_with(|_| ());
        copy(app.world_mut(), new.world_mut());
        new.run_until_ready(200).expect("ready");
        let anew = settled(&mut new);
        let (wrong, effect) = (difference(&anew, &found), difference(&before, &anew));
        println!("{name}: {wrong:.5} of an effect of {effect:.5}");
        assert!(wrong < 0.001, "{name}: {wrong}");
        assert_eq!(effect > 5e-4, matters, "{name}: {effect}");
        before = anew;
    }
}

#[test]
fn what_happens_elsewhere_leaves_settled_light_alone() {
    let _gpu = gpu();
    let mut app = app();
    let world = app.world_mut();
    floor(world);
    let far = block(world, Vec3::splat(50.0), Vec3::ONE);
    world.spawn(under_sky(1.0));
    app.run_until_ready(200).expect("ready");
    settle(&mut app);
    for step in 0..3 {
        place(app.world_mut(), far, Vec3::splat(51.0 + step as f32));
        assert_eq!(settle(&mut app), 1, "step {step}");
    }
}

/// The order in which a query has cameras of several exposures is not that of their entities.
#[test]
fn components_of_cameras_leave_settled_light_alone() {
    #[derive(Component)]
    struct Marker;

    let _gpu = gpu();
    let mut app = app();
    let world = app.world_mut();
    floor(world);
    let emitter = block(world, Vec3::new(0.0, 1.0, 0.0), Vec3::splat(0.5));
    let material = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(StandardMaterial {
            emissive: LinearRgba::WHITE,
            ..default()
        });
    world.entity_mut(emitter).insert(MeshMaterial3d(material));
    let target = world.resource::<LabTarget>().0.clone();
    let earlier = Camera {
        order: -1,
        ..default()
    };
    let earlier = world
        .spawn((
            Camera3d::default(),
            earlier,
            target,
            Exposure { ev100: 3.0 },
        ))
        .id();
    world.spawn(small_volume());
    app.run_until_ready(200).expect("ready");
    settle(&mut app);
    let world = app.world_mut();
    let mut cameras = world.query_filtered::<Entity, With<Camera3d>>();
    let later = cameras.iter(world).find(|camera| *camera != earlier);
    // The earlier camera behind the later one, and the other way round.
    for camera in [earlier, later.expect("the camera of the scene")] {
        app.world_mut().entity_mut(camera).insert(Marker);
        assert_eq!(settle(&mut app), 1, "a component of {camera}");
    }
}
