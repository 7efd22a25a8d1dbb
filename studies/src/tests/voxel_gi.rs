//! The study of the voxel GI, at its smallest.

use bevy_frugal_lab::testing::gpu;
use indicatif::ProgressBar;

use crate::{
    plan::{GiPlan, Plan},
    run::Study,
    voxel_gi::VoxelGi,
};

#[test]
fn the_cornell_box_is_measured() {
    let _gpu = gpu();
    let mut plan = Plan::new(true);
    plan.gi = GiPlan {
        scenes: vec!["cornell_point"],
        resolutions: vec![8],
        rays: Vec::new(),
        iterations: Vec::new(),
        bounces: vec![1],
        arcade: None,
        triangles: vec![300, 3_000],
        rounds: 1,
        frames: 2,
        ..plan.gi
    };
    let report = VoxelGi::measure(&plan, &ProgressBar::hidden()).expect("a report");
    assert!(!report.adapter.name.is_empty());
    let rows = &report.rows.boxes;
    let row = |setting: &str| {
        let found = rows
            .iter()
            .find(|row| row.scene == "cornell_point" && row.setting == setting);
        found.unwrap_or_else(|| panic!("no row {setting}"))
    };
    for setting in ["trace 8^3", "propagate 8^3", "trace 1 bounces 8^3"] {
        let row = row(setting);
        let error = row.relative_error.expect("an error");
        assert!((0.01..1.5).contains(&error), "{setting}: {error}");
        assert!(row.bias.is_some_and(|bias| bias.abs() <= error), "{row:?}");
        assert!(row.bytes.is_some_and(|bytes| bytes > 10_000), "{row:?}");
        if row.times.gpu_ms.is_some() {
            let solve = if setting.starts_with("trace") {
                "gather"
            } else {
                "propagate"
            };
            for stage in ["voxelize", "compact", "inject", solve] {
                assert!(row.times.stage_ms.contains_key(stage), "{stage}: {row:?}");
            }
        }
    }
    // What is reflected once is less than what is reflected endlessly.
    let bias = |setting: &str| row(setting).bias.expect("a bias");
    assert!(bias("trace 1 bounces 8^3") < bias("trace 8^3") - 0.1);
    let triangles: Vec<u32> = { report.rows.triangles.iter() }
        .filter_map(|row| row.scene.strip_prefix("triangles_")?.parse().ok())
        .collect();
    assert_eq!(triangles.len(), 2);
    assert!(triangles[1] > 4 * triangles[0], "{triangles:?}");
    assert!(
        VoxelGi::summary(&report.rows)
            .choices
            .iter()
            .all(|c| c.cost > 0.0)
    );
}
