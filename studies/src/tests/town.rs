//! The town: a level that is larger than the default volume.

use bevy_frugal_lab::{meshes::town::TownCamera, testing::gpu};
use bevy_voxel_gi::VoxelGiSettings;

use crate::{
    plan::TownPlan,
    voxel_gi::town::{app, volume_rows},
};

/// Walls, ground and other houses are outside of the finest cubes.
#[test]
fn its_rooms_are_near_to_their_truth_in_the_default_volume() {
    let _gpu = gpu();
    let resolution = VoxelGiSettings::default().resolution;
    let mut app = app(&TownPlan {
        cameras: vec![TownCamera::Room, TownCamera::Corridor],
        resolution,
        picture: 48,
        samples: 128,
    })
    .expect("the town");
    let rows = volume_rows(&mut app, "default", resolution).expect("rows");
    for row in &rows {
        println!("{row:?}");
    }
    // The most of the relative error, and of that of 95 of 100 blocks.
    for (scene, most) in [
        ("town, room", [0.082, 0.25]),
        ("town, corridor", [0.08, 0.36]),
        ("town, corridor, door open", [0.11, 0.3]),
    ] {
        let mut rows = rows.iter();
        let row = rows.find(|row| row.scene == scene && row.setting == "default");
        let row = row.expect("a row");
        let found = [row.relative_error, row.percentile_95].map(Option::unwrap);
        for (found, most) in found.into_iter().zip(most) {
            assert!(found <= most, "{scene}: {found} of {most}");
        }
        assert_eq!(row.black, Some(0.0), "{scene}");
    }
}
