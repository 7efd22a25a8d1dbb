//! The town: a level that is larger than the default volume.

use bevy_frugal_lab::{meshes::town::TownCamera, testing::gpu};

use crate::{
    plan::TownPlan,
    voxel_gi::town::{app, volume_rows},
};

/// The default volume ends in the corridor, and light of the sky comes in there.
#[test]
fn its_rooms_are_as_near_to_their_truth_as_their_volumes_allow() {
    let _gpu = gpu();
    let resolution = 16;
    let mut app = app(&TownPlan {
        cameras: vec![TownCamera::Room, TownCamera::Corridor],
        resolution,
        picture: 48,
        samples: 128,
    })
    .expect("the town");
    // The most of the relative error, of that of 95 of 100 blocks, and of the share of black blocks.
    let (room, corridor, open) = ("town, room", "town, corridor", "town, corridor, door open");
    for (volume, bounds) in [
        (
            "cascades from 16 m",
            [
                (room, [0.28, 0.52, 0.0]),
                (corridor, [0.15, 0.76, 0.0]),
                (open, [0.165, 0.43, 0.0]),
            ],
        ),
        (
            "default",
            [
                (room, [0.67, 1.5, 0.015]),
                (corridor, [4.1, 12.0, 0.015]),
                (open, [3.05, 9.1, 0.015]),
            ],
        ),
    ] {
        let rows = volume_rows(&mut app, volume, resolution).expect("rows");
        for row in &rows {
            println!("{row:?}");
        }
        for (scene, most) in bounds {
            let is_settled = |setting: &str| setting == volume;
            let row = rows
                .iter()
                .find(|row| row.scene == scene && is_settled(&row.setting));
            let row = row.expect("a row");
            let found = [row.relative_error, row.percentile_95, row.black].map(Option::unwrap);
            for (found, most) in found.into_iter().zip(most) {
                assert!(found <= most, "{scene}, {volume}: {found} of {most}");
            }
        }
    }
}
