//! Starting a program on a GPU that is not there, by `scripts/gpu-static`.

use std::{
    ffi::OsStr,
    path::PathBuf,
    process::{Command, Output},
};

use super::CostError;

/// This program, to be started again.
pub fn this_program() -> Command {
    // Only Linux has the driver; there a program always finds itself.
    Command::new(std::env::current_exe().unwrap_or_default())
}

/// The version of Mesa that would be used, such as `Mesa 25.0.7`.
///
/// # Errors
/// [`CostError::NoDriver`] with what to do where it is not there, or too old.
pub fn check() -> Result<String, CostError> {
    let output = script([OsStr::new("check")])?;
    let text = String::from_utf8_lossy(&output.stdout);
    Ok(text.split(" in ").next().unwrap_or_default().into())
}

/// Runs a program on a GPU and returns what it and the driver wrote to the standard error output.
///
/// # Errors
/// [`CostError::NoDriver`] as of [`check`]; [`CostError::Failed`] where the program fails.
pub fn run(gpu: &str, program: &Command) -> Result<String, CostError> {
    check()?;
    let arguments = [OsStr::new("run"), OsStr::new(gpu), program.get_program()];
    match script(arguments.into_iter().chain(program.get_args())) {
        Ok(output) => Ok(String::from_utf8_lossy(&output.stderr).into_owned()),
        Err(CostError::NoDriver(text)) => {
            let lines: Vec<_> = text.lines().collect();
            let end = lines.len().saturating_sub(12);
            Err(CostError::Failed(lines[end..].join("\n")))
        }
        Err(error) => Err(error),
    }
}

fn script<'a>(arguments: impl IntoIterator<Item = &'a OsStr>) -> Result<Output, CostError> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("scripts/gpu-static");
    let output = Command::new(&path).args(arguments).output();
    let output = output.map_err(|source| CostError::File { path, source })?;
    if output.status.success() {
        return Ok(output);
    }
    let text = String::from_utf8_lossy(&output.stderr);
    Err(CostError::NoDriver(
        text.trim_start_matches("error: ").trim_end().into(),
    ))
}
