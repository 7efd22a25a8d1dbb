//! The roles that the names of files tell.

use std::path::Path;

use clap::ValueEnum;
use glob::Pattern;

use crate::{args::Role, error::Error, files};

/// Ends of file names, and the roles that they stand for.
const ENDS: [(Role, &[&str]); 5] = [
    (
        Role::Normal,
        &["n", "nrm", "nor", "norm", "normal", "normals", "normalmap"],
    ),
    (
        Role::Data,
        &[
            "orm",
            "arm",
            "rma",
            "mra",
            "metallicroughness",
            "metalroughness",
            "metalrough",
            "occlusionroughnessmetallic",
            "roughnessmetallic",
        ],
    ),
    (
        Role::Occlusion,
        &[
            "ao",
            "occ",
            "occlusion",
            "ambientocclusion",
            "rough",
            "roughness",
            "metal",
            "metallic",
            "metalness",
            "height",
            "disp",
            "displacement",
        ],
    ),
    (Role::Mask, &["opacity", "cutout"]),
    (
        Role::Color,
        &[
            "albedo",
            "basecolor",
            "basecolour",
            "color",
            "colour",
            "diff",
            "diffuse",
            "emissive",
            "emission",
        ],
    ),
];

/// Ends that say nothing of the role: whose Y a normal map has, and the size.
const IGNORED: [&str; 10] = [
    "gl", "dx", "opengl", "directx", "1k", "2k", "4k", "8k", "16k", "512",
];

/// The patterns of a file, each with a role, which come before the ends of names.
#[derive(Default)]
pub struct Patterns(Vec<(Pattern, Role)>);

impl Patterns {
    /// Reads lines of a pattern and a role. Lines that begin with # are comments.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let bytes = files::read(path)?;
        let text = String::from_utf8_lossy(&bytes);
        let mut patterns = Vec::new();
        for (number, line) in text.lines().enumerate() {
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let fail =
                |problem: String| Error::file(path, format_args!("line {}: {problem}", number + 1));
            let (pattern, role) = line
                .rsplit_once(char::is_whitespace)
                .ok_or_else(|| fail("a pattern and a role are needed".into()))?;
            let pattern = Pattern::new(pattern.trim()).map_err(|e| fail(e.to_string()))?;
            let role = Role::from_str(role, true).map_err(|_| {
                let roles = Role::value_variants().iter().map(|role| role.name());
                let roles: Vec<_> = roles.collect();
                fail(format!(
                    "{role} is no role: possible are {}",
                    roles.join(", ")
                ))
            })?;
            patterns.push((pattern, role));
        }
        Ok(Self(patterns))
    }

    /// The role of a file, by its path below the argument, its name, or its name without the extension.
    pub fn role(&self, relative: &Path) -> Option<Role> {
        let name = relative.file_name().unwrap_or_default().to_string_lossy();
        let stem = relative.file_stem().unwrap_or_default().to_string_lossy();
        let fits = |(pattern, _): &&(Pattern, Role)| {
            pattern.matches_path(relative) || pattern.matches(&name) || pattern.matches(&stem)
        };
        let given = self.0.iter().find(fits).map(|(_, role)| *role);
        given.or_else(|| by_end(&stem))
    }
}

/// The role that the last word of a name stands for, which is not its only one.
fn by_end(stem: &str) -> Option<Role> {
    let lower = stem.to_ascii_lowercase();
    let mut words = lower.split(['_', '-', '.', ' ']).collect::<Vec<_>>();
    while words.len() > 2 && words.last().is_some_and(|word| IGNORED.contains(word)) {
        words.pop();
    }
    let [_, .., last] = words.as_slice() else {
        return None;
    };
    let mut all = ENDS.iter();
    all.find(|(_, ends)| ends.contains(last))
        .map(|(role, _)| *role)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_texture_sites_tell_their_role() {
        for (name, role) in [
            ("wall_n", Some(Role::Normal)),
            ("Wall_Normal", Some(Role::Normal)),
            ("rock_nor_gl_4k", Some(Role::Normal)),
            ("wall_orm", Some(Role::Data)),
            ("Default_metalRoughness", Some(Role::Data)),
            ("wall-ao", Some(Role::Occlusion)),
            ("leaf_opacity", Some(Role::Mask)),
            ("Wall_BaseColor", Some(Role::Color)),
            ("n", None),
            ("normal", None),
            ("canyon", None),
            ("photo_1", None),
        ] {
            assert_eq!(by_end(name), role, "{name}");
        }
    }
}
