//! All scenes: one window to pick among them, or one page that shows every picture.
//!
//! A Bevy app with a window cannot be built twice in a process, so picking another scene starts
//! the gallery anew with `--scene NAME`.

mod page;

use std::{
    path::Path,
    process::{Command, ExitCode},
    sync::{Arc, Mutex},
};

use indicatif::{ProgressBar, ProgressStyle};

use crate::runner::{
    Options, RunError, Scene, ScenePicker, SceneSettings, pictures::STEPS, render_headless, window,
};

/// The `main` of the gallery of `scenes`, of which the first is the default.
///
/// Exit code 0 for success, 1 for a failure and 2 for a wrong command line; the reason is on the standard error
/// output.
pub fn run(scenes: &[&'static dyn Scene]) -> ExitCode {
    let names: Vec<_> = scenes.iter().map(|scene| scene.name()).collect();
    let settings = |scene: &&dyn Scene| {
        let settings = SceneSettings::new(scene.settings()).list();
        format!("{}:\n{settings}\n", scene.name())
    };
    let help: String = scenes.iter().map(settings).collect();
    let matches = Options::added_to(clap::Command::new("gallery"))
        .about("Shows the example scenes, in a window or as a page of pictures")
        .after_help(format!(
            "Settings (name=value; with several scenes, each must have the setting):\n\n{help}"
        ))
        .arg(
            clap::Arg::new("scene")
                .long("scene")
                .value_name("NAME")
                .help(format!("Only this scene: {}", names.join(", "))),
        )
        .get_matches();
    let options = match Options::from_matches(&matches) {
        Ok(options) => options,
        Err(error) => error.exit(),
    };
    exit_code(dispatch(
        scenes,
        &options,
        matches.get_one("scene").map(String::as_str),
    ))
}

/// Exit code for a command line that cannot be followed, as clap's.
const USAGE: u8 = 2;

fn exit_code(result: Result<(), RunError>) -> ExitCode {
    let Err(error) = result else {
        return ExitCode::SUCCESS;
    };
    eprintln!("error: {error}");
    match error {
        RunError::Setting(_) | RunError::NoScene { .. } => ExitCode::from(USAGE),
        _ => ExitCode::FAILURE,
    }
}

fn dispatch(
    scenes: &[&'static dyn Scene],
    options: &Options,
    name: Option<&str>,
) -> Result<(), RunError> {
    let names: Vec<_> = scenes.iter().map(|scene| scene.name()).collect();
    let chosen: Vec<_> = scenes
        .iter()
        .copied()
        .filter(|scene| name.is_none_or(|name| scene.name() == name))
        .collect();
    let Some(first) = chosen.first() else {
        let name = name.unwrap_or_default().into();
        return Err(RunError::NoScene { name, names });
    };
    match &options.headless {
        Some(folder) => render_all(&chosen, options, folder),
        None => open(*first, options, names),
    }
}

/// Renders `scenes` into `folder`, with a page `index.html` unless [`Options::split`] is set. Figures go to
/// the standard output,
/// one line of JSON a scene, and progress to the standard error output.
pub fn render_all(
    scenes: &[&'static dyn Scene],
    options: &Options,
    folder: &Path,
) -> Result<(), RunError> {
    // A setting that does not fit should not show up after minutes of rendering.
    for scene in scenes {
        options.settings(*scene)?;
    }
    let progress = progress_bar(scenes.len());
    let mut outcomes = Vec::new();
    for scene in scenes {
        progress.set_message(scene.name());
        let outcome = render_headless(*scene, options, folder, &progress)?;
        progress.suspend(|| println!("{}", outcome.json_line()));
        outcomes.push((scene.description(), outcome));
    }
    progress.finish_and_clear();
    if options.split {
        return Ok(());
    }
    let path = folder.join("index.html");
    std::fs::write(&path, page::html(&outcomes)).map_err(|source| RunError::Write {
        path: path.clone(),
        source,
    })?;
    Ok(())
}

/// The bar has [`STEPS`] for each scene; it is not drawn where there is no terminal.
fn progress_bar(scenes: usize) -> ProgressBar {
    let progress = ProgressBar::new(scenes as u64 * STEPS);
    let style = ProgressStyle::with_template("{bar:30} {elapsed} {msg}");
    progress.with_style(style.expect("a template"))
}

fn open(
    scene: &'static dyn Scene,
    options: &Options,
    names: Vec<&'static str>,
) -> Result<(), RunError> {
    let chosen = Arc::new(Mutex::new(None));
    let picker = ScenePicker {
        names,
        chosen: chosen.clone(),
    };
    window::open(scene, options, Some(picker))?;
    let next = chosen.lock().ok().and_then(|chosen| *chosen);
    match next {
        Some(name) => start_anew(name, options),
        None => Ok(()),
    }
}

/// Runs this program again with another scene; settings are those of a scene and do not go along.
fn start_anew(name: &str, options: &Options) -> Result<(), RunError> {
    let program = std::env::current_exe().map_err(|source| RunError::Start {
        program: "gallery".into(),
        source,
    })?;
    let mut command = Command::new(&program);
    command.args(["--scene", name]);
    command.args([
        "--size",
        &format!("{}x{}", options.size.width, options.size.height),
    ]);
    if let Some(adapter) = &options.adapter {
        command.args(["--adapter", adapter]);
    }
    if let Some(image) = &options.image {
        command.arg("--image").arg(image);
    }
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(_) => Err(RunError::Window),
        Err(source) => Err(RunError::Start { program, source }),
    }
}
