//! Against path tracing. What the shaders compute is what the reference in plain Rust does (`reference.rs`), and
//! that is held to the truth with more voxels, in the tests of the crate.

use bevy_frugal_lab::boxes::{Agreement, TracedScene, agreement};
use bevy_voxel_gi::{Bounces, Receiver, Solver, VoxelGiSettings};

use super::fixture::*;

/// How close each of these settings comes to the truth.
fn measured(name: &str, settings: &[VoxelGiSettings]) -> Vec<Agreement> {
    let truth = TracedScene::read(name).expect("a scene");
    let mut app = box_app(&truth.scene);
    let measure = |settings: &VoxelGiSettings| {
        let volume = volume(&mut app, &truth.scene, settings.clone());
        let found = indirect(&mut app, volume);
        let found = agreement(&found, truth.scene.camera.width, &truth.indirect);
        println!("{name}: {found:?}");
        found
    };
    settings.iter().map(measure).collect()
}

/// With 16^3 voxels: traced, read per pixel, and propagated. Errors are at most these.
fn assert_near(name: &str, most_error: [f64; 3], most_bias: [f64; 3]) {
    let traced = VoxelGiSettings {
        resolution: 16,
        ..VoxelGiSettings::default()
    };
    let per_pixel = VoxelGiSettings {
        receiver: Receiver::PerPixel,
        ..traced.clone()
    };
    let propagated = VoxelGiSettings {
        light: global_illumination(Solver::Propagate { iterations: 96 }, Bounces::Endless),
        ..traced.clone()
    };
    let found = measured(name, &[traced, per_pixel, propagated]);
    for ((found, most_error), most_bias) in found.into_iter().zip(most_error).zip(most_bias) {
        assert!(found.relative_error < most_error, "{name}: {found:?}");
        assert!(found.bias.abs() < most_bias, "{name}: {found:?}");
    }
}

#[test]
fn cornell_box_with_a_point_light() {
    assert_near("cornell_point", [0.043, 0.046, 0.35], [0.015, 0.012, 0.28]);
}

#[test]
#[ignore = "long: a scene at 32^3"]
fn colonnade_under_sun_and_sky() {
    assert_near("colonnade", [0.045, 0.05, 0.23], [0.024, 0.031, 0.12]);
}

#[test]
#[ignore = "long: a scene at 32^3"]
fn room_with_a_sunlit_window() {
    assert_near("sunlit_room", [0.054, 0.073, 0.36], [0.019, 0.051, 0.24]);
}

#[test]
#[ignore = "long: the default volume"]
fn the_default_in_the_cornell_box() {
    let found = measured("cornell_point", &[VoxelGiSettings::default()])[0];
    assert!(found.relative_error < 0.032, "{found:?}");
    assert!(found.bias.abs() < 0.012, "{found:?}");
}
