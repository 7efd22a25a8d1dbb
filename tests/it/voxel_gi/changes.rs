//! Meshes are extracted when they change: after any change the light is that of an app that begins with it.

use bevy::{camera::Exposure, prelude::*};
use bevy_frugal_lab::headless::LabTarget;
use bevy_voxel_gi::NotVoxelized;

use super::{fixture::*, history::copied};
use crate::support::drawn;

/// A change of the block, and whether it changes the light.
type Change = (&'static str, bool, fn(&mut World, Entity));

const CHANGES: [Change; 14] = [
    ("moved", true, |world, block| {
        place(world, block, Vec3::new(-1.0, 0.5, 0.5));
    }),
    ("moved back", true, |world, block| {
        place(world, block, BEGIN);
    }),
    ("touched", false, |world, block| {
        pose(world, block).set_changed();
    }),
    ("hidden", true, |world, block| {
        world.entity_mut(block).insert(Visibility::Hidden);
    }),
    ("shown", true, |world, block| {
        world.entity_mut(block).insert(Visibility::Visible);
    }),
    ("excluded", true, |world, block| {
        world.entity_mut(block).insert(NotVoxelized);
    }),
    ("included", true, |world, block| {
        world.entity_mut(block).remove::<NotVoxelized>();
    }),
    ("of another material", true, |world, block| {
        let white = matt(world, 0.9);
        world.entity_mut(block).insert(MeshMaterial3d(white));
    }),
    ("of another mesh", true, |world, block| {
        let ball = world.add_asset(Sphere::new(0.6));
        world.entity_mut(block).insert(Mesh3d(ball));
    }),
    ("of an edited mesh", true, |world, block| {
        scale_mesh(world, block, Vec3::new(1.5, 0.5, 1.0));
    }),
    ("of an edited material", true, |world, block| {
        edit_material(world, block, |material| {
            material.base_color = LinearRgba::rgb(0.5, 0.1, 0.1).into();
        });
    }),
    ("one of many", true, |world, block| {
        spawn_many(world, block, 0.3, 20, |i| {
            Vec3::new((i % 5) as f32 * 0.7 - 1.4, 0.1, (i / 5) as f32 * 0.7 - 1.4)
        });
    }),
    (
        "one of fewer, of which some are new",
        true,
        |world, block| {
            let mut many = world.query_filtered::<Entity, With<OneOfMany>>();
            let many: Vec<_> = many.iter(world).collect();
            many.iter().step_by(2).for_each(|other| {
                world.despawn(*other);
            });
            let place = |i| Vec3::new(i as f32 - 1.0, 0.8, 1.2);
            spawn_many(world, block, 0.4, 3, place);
        },
    ),
    ("out of the volume", true, |world, block| {
        place(world, block, Vec3::splat(50.0));
    }),
];

#[derive(Component)]
struct OneOfMany;

const BEGIN: Vec3 = Vec3::new(0.7, 0.5, 0.0);

fn place(world: &mut World, block: Entity, at: Vec3) {
    pose(world, block).translation = at;
}

/// Spawns more of the block's mesh.
fn spawn_many(world: &mut World, block: Entity, scale: f32, count: u32, place: fn(u32) -> Vec3) {
    let mesh = world.get::<Mesh3d>(block).expect("a mesh").clone();
    let material = MeshMaterial3d(matt(world, 0.6));
    for i in 0..count {
        let place = Transform::from_translation(place(i)).with_scale(Vec3::splat(scale));
        world.spawn((OneOfMany, mesh.clone(), material.clone(), place));
    }
}

fn settled_light(app: &mut HeadlessApp) -> Vec<f32> {
    frames(app, 2);
    settle(app);
    let texels = read_texels(app).into_iter().flatten();
    texels.flat_map(|texel| texel.to_array()).collect()
}

#[test]
fn after_any_change_the_light_is_that_of_a_new_app() {
    let (mut app, _, block) = floor_under_sky(|world| block(world, BEGIN, Vec3::ONE));
    ready(&mut app);
    let tested = drawn(2, 0..CHANGES.len());
    let mut before = None;
    for (i, (name, matters, change)) in CHANGES.into_iter().enumerate() {
        if !tested.contains(&i) {
            change(app.world_mut(), block);
            frames(&mut app, 3);
            before = None;
            continue;
        }
        let light_before = before.unwrap_or_else(|| settled_light(&mut app));
        change(app.world_mut(), block);
        let found = settled_light(&mut app);
        let mut new = copied(&mut app);
        ready(&mut new);
        let anew = settled_light(&mut new);
        let (wrong, effect) = (
            relative_difference(&anew, &found),
            relative_difference(&light_before, &anew),
        );
        println!("{name}: {wrong:.5} of an effect of {effect:.5}");
        assert!(wrong < 0.001, "{name}: {wrong}");
        assert_eq!(effect > 5e-4, matters, "{name}: {effect}");
        before = Some(anew);
    }
}

#[test]
fn what_happens_elsewhere_leaves_settled_light_alone() {
    let (mut app, _, far) = floor_under_sky(|world| block(world, Vec3::splat(50.0), Vec3::ONE));
    ready(&mut app);
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

    let mut app = floor_app();
    let world = app.world_mut();
    let emitter = block(world, Vec3::new(0.0, 1.0, 0.0), Vec3::splat(0.5));
    edit_material(world, emitter, |material| {
        material.emissive = LinearRgba::WHITE;
    });
    let target = world.resource::<LabTarget>().0.clone();
    let earlier = Camera {
        order: -1,
        ..default()
    };
    let exposure = Exposure { ev100: 3.0 };
    let earlier = world
        .spawn((Camera3d::default(), earlier, target, exposure))
        .id();
    world.spawn(small_volume());
    ready(&mut app);
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
