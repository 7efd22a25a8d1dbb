//! The imports of shaders.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use super::graph::Graph;

/// Returns the shaders in a folder and those below, by paths relative to `root`.
pub(super) fn files(root: &Path, folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(root.join(folder)) else {
        return Vec::new();
    };
    let entries = entries.flatten().map(|entry| entry.path());
    let mut found = Vec::new();
    for path in entries {
        let Ok(relative) = path.strip_prefix(root) else {
            continue;
        };
        if path.is_dir() {
            found.extend(files(root, relative));
        } else if path
            .extension()
            .is_some_and(|extension| extension == "wesl")
        {
            found.push(relative.to_owned());
        }
    }
    found
}

/// Adds the shaders of a crate, whose module paths begin at `folder`, and their imports.
pub(super) fn add_imports(
    folder: &Path,
    shaders: &[PathBuf],
    read: impl Fn(&Path) -> Option<String>,
    graph: &mut Graph,
) {
    let module = |shader: &PathBuf| {
        let path = shader.strip_prefix(folder).unwrap_or(shader);
        let path = path.with_extension("");
        let names = path.iter().map(|name| name.to_string_lossy());
        format!("package::{}", names.collect::<Vec<_>>().join("::"))
    };
    let modules: BTreeMap<_, _> = shaders
        .iter()
        .map(|shader| (module(shader), shader.display().to_string()))
        .collect();
    for shader in shaders {
        let file = shader.display().to_string();
        graph.add_file(&file);
        for path in paths(&read(shader).unwrap_or_default()) {
            let target = modules.iter().find(|(module, _)| {
                let item = path.strip_prefix(module.as_str());
                item.is_some_and(|item| item.is_empty() || item.starts_with("::"))
            });
            if let Some((_, target)) = target {
                graph.add_import(&file, target, &path);
            }
        }
    }
}

/// Returns the paths in a shader that begin with its package, up to the first brace.
fn paths(source: &str) -> Vec<String> {
    let code: String = source
        .lines()
        .map(|line| line.split("//").next().unwrap_or_default())
        .collect();
    let starts = code.match_indices("package::").map(|(at, _)| &code[at..]);
    starts
        .map(|path| {
            let end = path.find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':'));
            path[..end.unwrap_or(path.len())]
                .trim_end_matches(':')
                .to_owned()
        })
        .collect()
}
