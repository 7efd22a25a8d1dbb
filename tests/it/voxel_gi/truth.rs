//! Against path tracing.

use std::path::Path;

use bevy_frugal_lab::boxes::{Agreement, BoxScene, agreement, read_npy};
use bevy_voxel_gi::{Bounces, Solver, VoxelGiVolume, VoxelLight};

use super::support::{box_app, indirect, volume};
use crate::support::gpu;

/// A setting against the truth; none where that is not.
pub fn measured(name: &str, settings: VoxelGiVolume) -> Option<Agreement> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/gi");
    if !folder.exists() {
        println!("{} is not here: nothing compared", folder.display());
        return None;
    }
    let scene = BoxScene::read(&folder, name).expect("a scene");
    let truth = read_npy(&folder.join(format!("{name}.indirect.npy"))).expect("its truth");
    let _gpu = gpu();
    let mut app = box_app(&scene);
    let found = indirect(&mut app, volume(&scene, settings));
    let result = agreement(&found, &truth, scene.camera.width);
    println!("{name}: {result:?}");
    Some(result)
}

/// The goals were 15, 20 and 25%; the bounds are a little more than what is measured.
fn default_is_within(name: &str, most_error: f64) {
    if let Some(found) = measured(name, VoxelGiVolume::default()) {
        assert!(found.relative_error < most_error, "{found:?}");
        assert!(found.bias.abs() < 0.02, "{found:?}");
    }
}

#[test]
fn cornell_box_with_a_point_light() {
    default_is_within("cornell_point", 0.035);
}

#[test]
fn colonnade_under_sun_and_sky() {
    default_is_within("colonnade", 0.035);
}

#[test]
fn room_with_a_sunlit_window() {
    default_is_within("sunlit_room", 0.045);
}

/// A solver's figures, printed; a bound so wide that only what is broken exceeds it is none of use,
/// so these are what the reference in plain Rust has, and a fifth more.
#[test]
fn propagation_in_all_three() {
    let propagate = VoxelGiVolume {
        light: VoxelLight::GlobalIllumination {
            solver: Solver::Propagate { iterations: 96 },
            bounces: Bounces::Endless,
        },
        ..VoxelGiVolume::default()
    };
    for (name, most_error) in [
        ("cornell_point", 0.5),
        ("colonnade", 0.25),
        ("sunlit_room", 0.4),
    ] {
        if let Some(found) = measured(name, propagate.clone()) {
            assert!(found.relative_error < most_error, "{name}: {found:?}");
        }
    }
}
