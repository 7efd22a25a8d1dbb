//! The arcade: curved meshes with textures, holes and emission, a light that moves and a door that opens.

use bevy::prelude::*;
use bevy_frugal_lab::{meshes::arcade::ArcadeSettings, testing::gpu};
use bevy_voxel_gi::VoxelGiSettings;

use crate::{
    plan::ArcadePlan,
    voxel_gi::{
        LightRow,
        arcade::{app, setting_rows},
        meshes::MeshApp,
        settings::Setting,
    },
};

fn arcade() -> MeshApp {
    app(&ArcadePlan {
        scene: ArcadeSettings {
            statue_triangles: 50_000,
            picture: 64,
        },
        samples: 256,
    })
    .expect("the arcade")
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
fn it_is_near_its_truth_in_each_state_and_soon_after_a_change() {
    let _gpu = gpu();
    let mut app = arcade();
    let lit = rows(&mut app);
    for (scene, setting, most) in [
        ("arcade", "trace", 0.0415),
        ("arcade, light moved", "trace", 0.051),
        ("arcade, light moved", "trace, frame 30", 0.052),
        ("arcade, door open", "trace", 0.052),
        ("arcade, door open", "trace, frame 30", 0.052),
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
