//! A budget of time.

use bevy::math::Vec3;
use bevy_frugal_lab::headless::HeadlessApp;
use bevy_voxel_gi::{VoxelGiBudget, VoxelGiBudgetPlugin, VoxelGiReport, budget::BudgetChoice};

use super::scene::{app_with, block, floor, settings, under_sky};
use crate::support::gpu;

/// The quality level after so many frames with a budget.
fn level_after(app: &mut HeadlessApp, milliseconds: f32, frames: u32) -> usize {
    app.world_mut()
        .insert_resource(VoxelGiBudget { milliseconds });
    app.render_frames(frames).expect("a frame");
    let choice = app.world().resource::<BudgetChoice>();
    choice.quality_level().map_or(0, |(level, _)| level)
}

#[test]
fn a_budget_chooses_by_measured_times() {
    let _gpu = gpu();
    let mut app = app_with(|app| {
        app.add_plugins(VoxelGiBudgetPlugin);
    });
    floor(app.world_mut());
    block(app.world_mut(), Vec3::new(1.0, 0.5, 0.1), Vec3::splat(1.1));
    settings(app.world_mut()).pause_when_settled = false;
    app.world_mut().spawn(under_sky(1.0));
    app.run_until_ready(200).expect("not ready");
    assert_eq!(app.world().resource::<BudgetChoice>().quality_level(), None);
    // The adapter of the tests has time stamps.
    let lavish = level_after(&mut app, 1e6, 120);
    let (_, count) = app
        .world()
        .resource::<BudgetChoice>()
        .quality_level()
        .expect("one");
    assert_eq!(lavish + 1, count, "all that there is");
    let frugal = level_after(&mut app, 1e-6, 120);
    assert_eq!(frugal, 0, "as little as there is");
    let back = level_after(&mut app, 1e6, 60);
    assert!(back > 0, "{back}");
    assert!(app.world().resource::<VoxelGiReport>().memory > 0);
    // Without a budget the app's own settings count.
    app.world_mut().remove_resource::<VoxelGiBudget>();
    app.render_frames(2).expect("a frame");
    assert_eq!(app.world().resource::<BudgetChoice>().quality_level(), None);
}
