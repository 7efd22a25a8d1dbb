//! Pixels that look for the voxels around them.

use bevy::prelude::*;
use bevy_voxel_gi::{Receiver, VoxelGiReport};

use super::{
    basics::leaked,
    scene::{app, at, block, floor, settings, under_sky},
    support::{picture, settle},
};
use crate::support::gpu;

#[test]
fn the_foot_of_a_thin_wall_is_dark() {
    let _gpu = gpu();
    // A tenth of a voxel thick, and in the middle of one: the next pixels are beside it.
    let (wall, places) = ([0.0875, 0.1125], [0.3125, 0.6]);
    let plain = leaked(Receiver::Interpolated, wall, &places);
    let per_pixel_light = leaked(Receiver::PerPixel, wall, &places);
    println!(
        "share of the lit side's light at the foot: interpolated {plain}, per pixel {per_pixel_light}"
    );
    assert!(plain < 0.04, "{plain}");
    assert!(per_pixel_light < 0.04, "{per_pixel_light}");
}

#[test]
fn where_nothing_is_hidden_both_see_the_same() {
    let _gpu = gpu();
    let pictures = [Receiver::Interpolated, Receiver::PerPixel].map(|receiver| {
        let mut app = app();
        settings(app.world_mut()).receiver = receiver;
        floor(app.world_mut());
        block(app.world_mut(), Vec3::new(1.0, 0.5, 0.1), Vec3::splat(1.1));
        app.world_mut().spawn(under_sky(1.0));
        app.run_until_ready(200).expect("not ready");
        settle(&mut app);
        (
            picture(&mut app),
            app.world().resource::<VoxelGiReport>().memory,
        )
    });
    for x in [-1.4, -1.0, 0.0, 0.2] {
        let [plain, per_pixel_light] = [0, 1].map(|i| at(&pictures[i].0, x, 0.1).x);
        assert!(
            (plain / per_pixel_light - 1.0).abs() < 0.03,
            "{x}: {plain} {per_pixel_light}"
        );
    }
    // Twelve bytes a voxel more, and up to three slices.
    let more = pictures[1].1 - pictures[0].1;
    let slice = 16 * 32 * 8;
    assert!(
        (12 * 4096 - 3 * slice..=12 * 4096 + 3 * slice).contains(&more),
        "{more}"
    );
}
