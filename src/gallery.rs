//! All scenes: one window to pick among them, or one page that shows every picture.
//!
//! A Bevy app with a window cannot be built twice in a process, so picking another scene starts
//! the gallery anew with `--scene NAME`.

use std::{
    fmt::Write,
    path::Path,
    process::{Command, ExitCode},
    sync::{Arc, Mutex},
};

use indicatif::{ProgressBar, ProgressStyle};

use crate::runner::{
    Options, Outcome, RunError, Scene, ScenePicker, SceneSettings,
    pictures::{STEPS, picture_name},
    render_headless, window,
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
    std::fs::write(&path, html(&outcomes)).map_err(|source| RunError::Write {
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

const STYLE: &str = "
body { font: 15px/1.5 system-ui, sans-serif; max-width: 1100px; margin: 2em auto; padding: 0 1em;
  background: #16181c; color: #ddd }
.split { position: relative; overflow: hidden; --position: 50% }
.split img, .difference { display: block; width: 100% }
.split .before { position: absolute; inset: 0;
  clip-path: inset(0 calc(100% - var(--position)) 0 0) }
.split .line { position: absolute; top: 0; bottom: 0; left: var(--position); width: 1px;
  background: #fff; pointer-events: none }
.split input { position: absolute; inset: 0; width: 100%; height: 100%; margin: 0; opacity: 0;
  cursor: ew-resize }
.pair { display: grid; grid-template-columns: 1fr 1fr 1fr; gap: 1em; margin-top: 1em }
figure { margin: 0 } figure img { width: 100% } table { border-spacing: 1em 0 }
td { font-variant-numeric: tabular-nums }
";

/// The page for scenes with their descriptions; it refers to the pictures beside it.
pub(super) fn html(outcomes: &[(&str, Outcome)]) -> String {
    let mut sections = String::new();
    for (description, outcome) in outcomes {
        sections.push_str(&section(description, outcome));
    }
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n\
         <title>bevy_frugal gallery</title>\n<style>{STYLE}</style>\n\
         <h1>bevy_frugal gallery</h1>\n{sections}</html>\n"
    )
}

fn section(description: &str, outcome: &Outcome) -> String {
    let name = outcome.scene;
    let [before, after, difference] =
        ["before", "after", "difference"].map(|part| picture_name(name, part));
    format!(
        "<section>\n<h2>{name}</h2>\n<p>{}. Plugin: {}.</p>\n\
         <div class=\"split\"><img src=\"{after}\" alt=\"after\">\
         <img class=\"before\" src=\"{before}\" alt=\"before\"><div class=\"line\"></div>\
         <input type=\"range\" min=\"0\" max=\"100\" value=\"50\" step=\"0.1\" \
         aria-label=\"before or after\" \
         oninput=\"this.parentNode.style.setProperty('--position', this.value + '%')\"></div>\n\
         <div class=\"pair\">{}{}{}</div>\n{}</section>\n",
        escape(description),
        outcome.plugin,
        figure(&before, "before"),
        figure(&after, "after"),
        figure(&difference, "difference (FLIP)"),
        figures(outcome),
    )
}

fn figure(path: &str, caption: &str) -> String {
    format!(
        "<figure><a href=\"{path}\"><img src=\"{path}\" alt=\"{caption}\"></a>\
         <figcaption>{caption}</figcaption></figure>"
    )
}

fn figures(outcome: &Outcome) -> String {
    let mut rows = vec![
        ("adapter".to_string(), escape(&outcome.adapter.name)),
        (
            "size".into(),
            format!("{} x {}", outcome.width, outcome.height),
        ),
        (
            "PSNR".into(),
            match outcome.psnr_db {
                Some(psnr) => format!("{psnr:.2} dB"),
                None => "infinite (equal)".into(),
            },
        ),
        ("FLIP".into(), format!("{:.4}", outcome.flip)),
        (
            "largest difference".into(),
            format!("{} of 255", outcome.max_error),
        ),
    ];
    for (side, times) in [("before", outcome.before), ("after", outcome.after)] {
        for (unit, time) in [("CPU", times.cpu_ms), ("GPU", times.gpu_ms)] {
            if let Some(ms) = time {
                rows.push((format!("{unit} time {side}"), format!("{ms:.2} ms")));
            }
        }
    }
    for (name, bytes) in &outcome.memory {
        let kib = *bytes as f64 / 1024.0;
        rows.push((format!("memory {}", escape(name)), format!("{kib:.1} KiB")));
    }
    for (name, text) in &outcome.notes {
        rows.push((escape(name), escape(text)));
    }
    for (name, value) in &outcome.settings {
        rows.push(((*name).into(), escape(&value.to_string())));
    }
    let mut table = String::from("<table>\n");
    for (name, value) in rows {
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "<tr><th align=\"left\">{name}</th><td>{value}</td></tr>"
        );
    }
    table + "</table>\n"
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
