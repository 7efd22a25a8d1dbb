//! The number of bounces.

use bevy::prelude::*;
use bevy_voxel_gi::{Bounces, Solver, VoxelLight};

use super::{
    scene::{app, block, settings, small_volume},
    support::{read_texels, settle},
};
use crate::support::gpu;

/// A closed room whose walls all emit the same light and reflect half: each bounce adds half of the one before, and
/// everywhere it is the same.
#[test]
fn each_bounce_adds_its_light() {
    let _gpu = gpu();
    let mut app = app();
    let world = app.world_mut();
    let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
    let material = materials.add(StandardMaterial {
        base_color: LinearRgba::gray(0.5).into(),
        emissive: LinearRgba::WHITE,
        metallic: 0.0,
        ..default()
    });
    for (center, size) in [
        (Vec3::new(0.0, -0.2, 0.0), Vec3::new(3.8, 0.4, 3.8)),
        (Vec3::new(0.0, 1.7, 0.0), Vec3::new(3.8, 0.4, 3.8)),
        (Vec3::new(1.7, 0.75, 0.0), Vec3::new(0.4, 2.3, 3.8)),
        (Vec3::new(-1.7, 0.75, 0.0), Vec3::new(0.4, 2.3, 3.8)),
        (Vec3::new(0.0, 0.75, 1.7), Vec3::new(3.8, 2.3, 0.4)),
        (Vec3::new(0.0, 0.75, -1.7), Vec3::new(3.8, 2.3, 0.4)),
    ] {
        let wall = block(world, center, size);
        world
            .entity_mut(wall)
            .insert(MeshMaterial3d(material.clone()));
    }
    app.run_until_ready(200).expect("not ready");
    let mut light_of = |bounces: Bounces| {
        settings(app.world_mut()).light = VoxelLight::GlobalIllumination {
            solver: Solver::default(),
            bounces,
        };
        let volume = app.world_mut().spawn(small_volume()).id();
        settle(&mut app);
        // The top of the floor, in the middle of the room.
        let texel = read_texels(&mut app)[(8 * 16 + 7) * 16 + 8][2];
        app.world_mut().despawn(volume);
        app.render_frames(3).expect("frames");
        texel.x / texel.w
    };
    let once = light_of(Bounces::Count(1));
    assert!(once > 0.0);
    for (bounces, expected) in [
        (Bounces::Count(2), 1.5),
        (Bounces::Count(3), 1.75),
        (Bounces::Count(8), 2.0 - 0.5_f32.powi(7)),
        (Bounces::Endless, 2.0),
    ] {
        let found = light_of(bounces) / once;
        println!("{bounces:?}: {found}, expected {expected}");
        assert!(
            (found / expected - 1.0).abs() < 0.005,
            "{bounces:?}: {found}"
        );
    }
}
