//! What the plugins' shaders cost when they are compiled for a GPU.

use bevy_frugal_lab::cost::{budget::Budget, pipelines, shim};

use crate::support::{gpu, skipped};

#[test]
fn no_shader_has_grown_unnoticed() {
    let budget = Budget::read().expect("the committed budget");
    match shim::check() {
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
    let mut program = shim::this_program();
    program.args([
        "--exact",
        "cost::compiles_what_is_in_the_budget",
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
}

#[test]
#[ignore = "the test above runs it under the driver"]
fn compiles_what_is_in_the_budget() {
    let budget = Budget::read().expect("the committed budget");
    pipelines::print(&budget.configurations()).expect("apps");
}
