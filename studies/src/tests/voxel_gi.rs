//! The study of the voxel GI, at its smallest; the arcade: curved meshes with textures, holes and emission, a light that
//! moves and a door that opens; and the town: a level that is larger than the default volume.

use std::{
    env, fs,
    path::{Path, PathBuf},
};

use bevy::prelude::*;
use bevy_frugal_lab::{
    meshes::{arcade::ArcadeSettings, town::TownCamera},
    testing::gpu,
};
use bevy_voxel_gi::VoxelGiSettings;
use indicatif::ProgressBar;

use crate::{
    plan::{GiPlan, Plan, TownPlan},
    run::Study,
    voxel_gi::{
        LightRow, VoxelGi,
        arcade::{self, setting_rows},
        meshes::{MeshApp, Truth, traced},
        settings::Setting,
        town::{self, volume_rows},
    },
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

const ARCADE: ArcadeSettings = ArcadeSettings {
    statue_triangles: 50_000,
    picture: 64,
};

/// The arcade's truth of 1024 paths a pixel; `BLESS=1` with the test below writes it.
fn committed_truth() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src/tests/arcade_truth.json")
}

#[test]
#[ignore = "long: path tracing"]
fn the_committed_truth_is_what_paths_give() {
    let traced = traced(&arcade::views(ARCADE), 1024);
    if env::var_os("BLESS").is_some() {
        let text = serde_json::to_string(&traced).expect("JSON");
        fs::write(committed_truth(), text.replace("]],", "]],\n")).expect("a writable file");
    }
    let committed = fs::read(committed_truth()).expect("a committed file");
    let committed: Truth = serde_json::from_slice(&committed).expect("a truth");
    assert_eq!(traced.len(), committed.len());
    for (name, means) in traced {
        let pairs = means
            .iter()
            .flatten()
            .zip(committed[&name].iter().flatten());
        let most = pairs.map(|(a, b)| (a - b).abs() / b.abs().max(1e-3));
        let most = most.fold(0.0, f32::max);
        // Rounding differs between processors, so a path may end at another surface.
        assert!(most < 0.02, "{name}: {most}");
    }
}

fn arcade() -> MeshApp {
    let truth = fs::read(committed_truth()).expect("a committed file");
    let truth = serde_json::from_slice(&truth).expect("a truth");
    MeshApp::new(arcade::views(ARCADE), &truth).expect("the arcade")
}

/// The rows of a volume of 16^3 voxels.
fn rows(app: &mut MeshApp) -> Vec<LightRow> {
    let setting = Setting {
        name: "trace".into(),
        settings: VoxelGiSettings {
            resolution: 16,
            ..VoxelGiSettings::default()
        },
    };
    let rows = setting_rows(app, &setting).expect("rows");
    for row in &rows {
        println!(
            "{}, {}: {:?} {:?}",
            row.scene, row.setting, row.relative_error, row.bias
        );
    }
    rows
}

fn error(rows: &[LightRow], scene: &str, setting: &str) -> f64 {
    let row = rows
        .iter()
        .find(|row| row.scene == scene && row.setting == setting);
    row.and_then(|row| row.relative_error).expect("an error")
}

/// And it would be far from its truth without the light of the sign.
#[test]
#[ignore = "long: four states of the arcade"]
fn it_is_near_its_truth_in_each_state_and_soon_after_a_change() {
    let _gpu = gpu();
    let mut app = arcade();
    let lit = rows(&mut app);
    for (scene, setting, most) in [
        ("arcade", "trace", 0.039),
        ("arcade, light moved", "trace", 0.0505),
        ("arcade, light moved", "trace, frame 30", 0.051),
        ("arcade, door open", "trace", 0.045),
        ("arcade, door open", "trace, frame 30", 0.045),
    ] {
        let found = error(&lit, scene, setting);
        assert!(found < most, "{scene}, {setting}: {found}");
    }
    // A change takes time to arrive.
    for scene in ["arcade, light moved", "arcade, door open"] {
        assert!(error(&lit, scene, "trace, frame 1") > error(&lit, scene, "trace, frame 30"));
    }

    let mut materials = app
        .app
        .world_mut()
        .resource_mut::<Assets<StandardMaterial>>();
    for (_, material) in materials.iter_mut() {
        material.emissive = LinearRgba::BLACK;
    }
    let found = error(&rows(&mut app), "arcade", "trace");
    // Nearly twice the bound above.
    assert!(found > 0.075, "{found}");
}

/// Walls, ground and other houses are outside of the finest cubes.
#[test]
#[ignore = "long: path tracing"]
fn its_rooms_are_near_to_their_truth_in_the_default_volume() {
    let _gpu = gpu();
    let resolution = VoxelGiSettings::default().resolution;
    let mut app = town::app(&TownPlan {
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
