//! What the plugins' shaders cost when they are compiled for a GPU.

use bevy_frugal_lab::testing::{gpu, skipped};

use crate::{
    cost::{
        configurations::{Configuration, NO_MAP, Scene, configurations},
        fetches, pipelines,
        record::{Budget, CostRow},
    },
    ycocg_fb::settings,
};

#[test]
#[ignore = "long: compiles a hundred shaders"]
fn no_shader_has_grown_unnoticed() {
    let budget = Budget::read().expect("the committed budget");
    match pipelines::check() {
        Ok(mesa) if mesa == budget.mesa => {}
        Ok(mesa) => {
            return skipped(&format!(
                "the budget of shaders is of {}, here is {mesa}",
                budget.mesa
            ));
        }
        Err(error) => return skipped(&format!("the budget of shaders: {error}")),
    }
    let _gpu = gpu();
    let mut program = pipelines::this_program();
    program.args([
        "--exact",
        "tests::cost::compiles_what_is_in_the_budget",
        "--ignored",
        "--nocapture",
    ]);
    let rows =
        pipelines::compile(&budget.gpu, &program, &budget.configurations()).expect("compiled");
    let exceeded = budget.exceeded_by(&rows);
    assert!(
        exceeded.is_empty(),
        "{}\nWhere it is worth that: change docs/measurements/radv/budget.json in the same commit.",
        exceeded.join("\n")
    );
    for (filter, fetches) in FETCHES {
        let found = fetches_of(&rows, filter) - fetches_of(&rows, NO_MAP);
        println!("{filter}: {found} fetches");
        assert_eq!(found, fetches, "{filter}");
    }
}

/// The fetches that filters of colours at 3 bpp have in their code: gathers of the low band, loads of
/// details, and samples of chroma. Trilinear has those of one level in a loop.
const FETCHES: [(&str, i64); 4] = [
    ("nearest", 4 + 1 + 1),
    ("stochastic", 4 + 1 + 1),
    ("bilinear", 4 + 4 + 4),
    ("trilinear", 4 + 4 + 4),
];

fn fetches_of(rows: &[CostRow], setting: &str) -> i64 {
    let row = rows.iter().find(|row| {
        [&*row.plugin, &*row.setting, &*row.material, &*row.pass]
            == ["wavelet_tex", setting, "base color", "forward"]
    });
    row.unwrap_or_else(|| panic!("{setting}")).vmem as i64
}

#[test]
#[ignore = "the test above runs it under the driver"]
fn compiles_what_is_in_the_budget() {
    let budget = Budget::read().expect("the committed budget");
    pipelines::print(&budget.configurations()).expect("apps");
}

#[test]
#[ignore = "long: nine apps"]
fn a_pixel_counts_its_own_fetches() {
    let _gpu = gpu();
    let all = configurations();
    let counted = |plugin, setting, scene| {
        let is_it = |c: &&Configuration| c.plugin == plugin && c.setting == setting;
        let configuration = all.iter().find(is_it).expect("a configuration");
        fetches::counted(configuration, scene).expect("counted")
    };
    for (scene, maps) in [(Scene::BaseColor, 1.0), (Scene::FiveMaps, 5.0)] {
        let bevy = counted("bevy", "default", scene);
        assert_eq!((bevy.samples, bevy.loads, bevy.gathers), (maps, 0.0, 0.0));
        assert!(bevy.comparisons > 0.0, "{bevy:?}");
    }
    let trilinear = counted("ewa", "trilinear", Scene::BaseColor);
    let linear = counted("ewa", "linear", Scene::BaseColor);
    assert_eq!(trilinear.samples, 1.0);
    assert!(linear.samples > 4.0 && linear.comparisons == trilinear.comparisons);
    let documented = settings();
    for name in ["default", "guided", "quad"] {
        let expected = documented.iter().find(|setting| setting.name == name);
        let found = counted("ycocg_fb", name, Scene::BaseColor);
        assert_eq!(
            found.fetches(),
            expected.expect("a setting").fetches,
            "{name}"
        );
    }
}
