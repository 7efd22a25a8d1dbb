//! Starting a program on a GPU that is not there, by `scripts/gpu-static`.

use bevy_frugal_lab::ROOT;
use std::{
    ffi::OsStr,
    path::Path,
    process::{Command, Output},
};

use super::error::CostError;

/// Name of the environment variable with the part of the work that a process does.
pub(super) const PART: &str = "COST_PART";

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
    let output = output(script().arg("check"))?;
    let text = String::from_utf8_lossy(&output.stdout);
    Ok(text.split(" in ").next().unwrap_or_default().into())
}

/// Runs a program on a GPU for each of the names, one after the other, with `PART` set to it, so that nothing of one
/// is left in the next. Returns what each wrote.
///
/// # Errors
/// [`CostError::NoDriver`] as of [`check`]; [`CostError::Failed`] where the program fails.
pub fn run<'a>(
    gpu: &'a str,
    program: &'a Command,
    parts: impl IntoIterator<Item = String> + 'a,
) -> Result<impl Iterator<Item = Result<Output, CostError>> + 'a, CostError> {
    check()?;
    Ok(parts.into_iter().map(move |part| {
        let arguments = [OsStr::new("run"), OsStr::new(gpu), program.get_program()];
        let mut command = script();
        command
            .args(arguments)
            .args(program.get_args())
            .env(PART, &part);
        output(&mut command).map_err(|error| match error {
            CostError::NoDriver(text) => {
                let lines: Vec<_> = text.lines().collect();
                let end = &lines[lines.len().saturating_sub(12)..];
                CostError::Failed(format!("{part}\n{}", end.join("\n")))
            }
            error => error,
        })
    }))
}

/// The part that this process is to do, or empty.
pub fn part() -> String {
    std::env::var(PART).unwrap_or_default()
}

/// The script that runs a program on a GPU that is not there.
pub(super) fn script() -> Command {
    Command::new(Path::new(ROOT).join("scripts/gpu-static"))
}

fn output(command: &mut Command) -> Result<Output, CostError> {
    let path = command.get_program().into();
    let output = command.output();
    let output = output.map_err(|source| CostError::File { path, source })?;
    if output.status.success() {
        return Ok(output);
    }
    let text = String::from_utf8_lossy(&output.stderr);
    let text = text.trim_start_matches("error: ").trim_end();
    Err(CostError::NoDriver(text.into()))
}
