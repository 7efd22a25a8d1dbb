//! Several volumes in one world.

use bevy::{camera::visibility::RenderLayers, prelude::*};
use bevy_voxel_gi::{Bounces, Receiver, Sky, Solver, VoxelGiVolume, VoxelLight};

use super::fixture::*;

/// A volume of 1.8 m about a place, under a sky of its own.
fn beside(x: f32, radiance: f32) -> (VoxelGiVolume, Transform) {
    let volume = sky_volume(1.8, radiance);
    (volume, Transform::from_xyz(x, 0.0, 0.0))
}

#[test]
fn volumes_side_by_side_light_what_is_in_each() {
    let propagate = global_illumination(Solver::Propagate { iterations: 24 }, Bounces::Endless);
    for light in [VoxelLight::default(), propagate] {
        let mut app = floor_app();
        settings(app.world_mut()).light = light;
        let left = app.world_mut().spawn(beside(-1.0, 1.0)).id();
        app.world_mut().spawn(beside(1.0, 7.0));
        let found = settled(&mut app);
        // Propagated light is no exact uniform sky.
        let one = if light == propagate {
            at(&found, -1.0, 0.0).x
        } else {
            1.0
        };
        assert!(one > 0.5, "{one}");
        assert_near(at(&found, -1.0, 0.0), one, 0.03);
        assert_near(at(&found, 1.0, 0.0), 7.0 * one, 0.03);
        // Outside of both there is nothing.
        assert_eq!(at(&found, 1.0, 1.4), Vec3::ZERO);
        // The other stays as it is when one goes.
        app.world_mut().despawn(left);
        let found = settled_again(&mut app);
        assert_eq!(at(&found, -1.0, 0.0), Vec3::ZERO);
        assert_near(at(&found, 1.0, 0.0), 7.0 * one, 0.03);
    }
}

#[test]
fn pixels_read_the_smallest_of_nested_volumes_and_rays_continue_in_the_larger() {
    for receiver in [Receiver::Interpolated, Receiver::PerPixel] {
        let mut app = floor_app();
        settings(app.world_mut()).receiver = receiver;
        app.world_mut().spawn(under_sky(1.0));
        // Its own sky is dark, but rays go on in the volume around it, and see that one's.
        app.world_mut().spawn(VoxelGiVolume {
            size: 2.0,
            intensity: 3.0,
            sky: Some(Sky::default()),
            ..small_volume()
        });
        // Outside of the inner volume.
        let size = Vec3::new(0.3, 1.2, 3.0);
        block(app.world_mut(), Vec3::new(-1.5, 0.6, 0.0), size);
        let found = settled(&mut app);
        let (outer, inner) = (at(&found, 1.4, 0.0).x, at(&found, 0.3, 0.0).x);
        let shaded = at(&found, -0.6, 0.0).x;
        println!("{receiver:?}: {outer} outside, {inner} inside, {shaded} beside the block");
        assert!((0.9..1.01).contains(&outer), "{outer}");
        assert!((2.7..3.03).contains(&inner), "{inner}");
        assert!(shaded < 0.97 * inner, "{shaded}");
    }
}

#[test]
fn more_cubes_than_eight_are_left_out() {
    let mut app = app_with(|_| ());
    floor(app.world_mut());
    settings(app.world_mut()).resolution = 8;
    let cascades = VoxelGiVolume {
        cascades: 4,
        size: 0.5,
        ..under_sky(1.0)
    };
    for _ in 0..2 {
        app.world_mut().spawn(cascades.clone());
        // Later than the volumes before, whichever entities are free.
        app.render_frames(1).expect("a frame");
    }
    app.world_mut().spawn(sky_volume(0.3, 9.0));
    assert_near(at(&settled(&mut app), 0.0, 0.0), 1.0, 0.03);
    // Eight levels of 8^3 voxels at 68 bytes, 24 and seven times 6 slots for each of 8^2 at 56, and the materials.
    let memory = report(&app).memory;
    assert!((8 * 512 * 126..8 * 512 * 134).contains(&memory), "{memory}");
}

#[test]
#[ignore = "long: many frames"]
fn a_change_of_the_settings_counts_for_all_volumes_at_once() {
    let mut app = floor_app();
    for x in [-1.0, 1.0] {
        app.world_mut().spawn(beside(x, 1.0));
        let size = Vec3::new(0.6, 0.8, 0.4);
        block(app.world_mut(), Vec3::new(x, 0.4, -0.3), size);
    }
    ready(&mut app);
    settle(&mut app);
    let mut with = |light: VoxelLight, resolution: u32| {
        let mut settings = settings(app.world_mut());
        (settings.light, settings.resolution) = (light, resolution);
        let found = settled_again(&mut app);
        let light = [-1.0, 1.0].map(|x| at(&found, x, 0.1).x);
        (light, report(&app).memory)
    };
    let (shaded, coarse) = with(default(), 16);
    assert!(shaded.iter().all(|light| *light < 0.9), "{shaded:?}");
    // Nothing is so near that it hides the sky.
    let nearby = occlusion(0.02, 32);
    let (open, _) = with(nearby, 16);
    assert!(open.iter().all(|light| *light > 0.95), "{open:?}");
    let (_, fine) = with(default(), 32);
    assert!(fine > 5 * coarse, "{fine} {coarse}");
    assert_eq!(with(default(), 16).0, shaded);
}

/// In an app whose frames do not wait for pipelines, as games are.
#[test]
fn what_is_lit_stays_in_the_picture_while_volumes_come_and_go() {
    let mut app = app_of(|settings| settings.compiles_in_background = true, |_| ());
    let world = app.world_mut();
    floor(world);
    let light = DirectionalLight::default();
    world.spawn(sun(light.illuminance, Vec3::new(0.2, -1.0, 0.1)));
    let seen_by_cameras = RenderLayers::default();
    world.spawn((under_sky(1.0), seen_by_cameras.clone()));
    app.run_until_ready(100_000).expect("ready");
    settle(&mut app);
    let before = at(&picture(&mut app), 0.0, 0.0).x;
    assert!(before > 100.0, "{before}");
    for round in 0..2 {
        let volume = sky_volume(2.0, 1.0);
        let second = app
            .world_mut()
            .spawn((volume, seen_by_cameras.clone()))
            .id();
        let check = |app: &mut HeadlessApp, what: &str| {
            for frame in 0..10 {
                let found = at(&picture(app), 0.0, 0.0).x;
                let wrong = (found / before - 1.0).abs();
                assert!(
                    wrong < 0.02,
                    "{found} for {before} in frame {frame} {what} {round}"
                );
            }
        };
        check(&mut app, "of a second volume");
        app.world_mut().despawn(second);
        check(&mut app, "after a second volume");
    }
}
