//! Insertion of text into Bevy's shaders when they are loaded.
//!
//! A [`ShaderPatch`] only inserts, at positions that must exist exactly once. It removes nothing, so
//! the anchors of other patches stay intact and the order of patches does not matter. It writes its name
//! into the source and is therefore never applied twice; it is applied again when the shader is
//! reloaded. If it does not fit, as may happen with another version of Bevy, the shader stays
//! unchanged, the patch is [`PatchState::Refused`] and one error names the shader and the reason.

use std::{error::Error, fmt, ops::Range};

use bevy::{
    asset::AssetEventSystems,
    platform::collections::HashMap,
    prelude::*,
    shader::{Shader, ShaderImport, Source},
};
use wesl::syntax::TranslationUnit;

/// A set of insertions into one shader.
#[derive(Clone, Debug)]
pub struct ShaderPatch {
    /// Unique name of the patch; it appears in the patched source as a comment.
    pub name: &'static str,
    /// Path of the shader as a WESL module, such as `bevy_pbr::render::pbr_functions`.
    pub shader: &'static str,
    /// Items that the inserted text imports, by their full paths.
    pub imports: Vec<&'static str>,
    /// Texts with the number of times that each must occur before anything is inserted. A shader to
    /// which a new version of Bevy added another occurrence is refused.
    pub expected_counts: Vec<(&'static str, usize)>,
    /// The insertions, which are applied all or not at all.
    pub insertions: Vec<Insertion>,
}

impl ShaderPatch {
    /// Creates a patch without insertions.
    pub fn new(name: &'static str, shader: &'static str) -> Self {
        Self {
            name,
            shader,
            imports: Vec::new(),
            expected_counts: Vec::new(),
            insertions: Vec::new(),
        }
    }

    fn is_for(&self, shader: &Shader) -> bool {
        matches!(&shader.import_path, ShaderImport::Custom(path) if path == self.shader)
    }
}

/// Text to insert at one position.
///
/// The position is between two pieces of text that must follow each other exactly once, so that the text
/// on both sides is verified.
#[derive(Clone, Debug)]
pub struct Insertion {
    /// Beginning of the function to which the search is restricted, if any; it must occur exactly once.
    pub function: Option<&'static str>,
    /// Text that must end at the position; may be empty.
    pub before: &'static str,
    /// Text that must begin at the position; may be empty.
    pub after: &'static str,
    /// Text to insert.
    pub text: String,
}

impl Insertion {
    /// Inserts `text` between `before` and `after`.
    pub fn between(before: &'static str, after: &'static str, text: impl Into<String>) -> Self {
        Self {
            function: None,
            before,
            after,
            text: text.into(),
        }
    }

    /// Inserts `text` before `anchor`.
    pub fn before(anchor: &'static str, text: impl Into<String>) -> Self {
        Self::between("", anchor, text)
    }

    /// Inserts `text` after `anchor`.
    pub fn after(anchor: &'static str, text: impl Into<String>) -> Self {
        Self::between(anchor, "", text)
    }

    /// Restricts the search to the function that begins with this text.
    pub fn in_function(self, function: &'static str) -> Self {
        Self {
            function: Some(function),
            ..self
        }
    }
}

/// The reason for which a patch does not fit a shader.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PatchError {
    /// A text occurs more or less often than the patch expects.
    Count {
        /// The text that was searched.
        text: String,
        /// Expected number of occurrences.
        expected: usize,
        /// Actual number of occurrences.
        found: usize,
    },
    /// The shader is not WESL.
    NotWesl,
    /// The patched shader does not parse.
    Syntax(String),
    /// The shader asset could not be replaced.
    Asset(String),
}

impl fmt::Display for PatchError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count {
                text,
                expected,
                found,
            } => write!(
                f,
                "`{text}` should occur {expected} times but occurs {found} times; \
                 is this version of Bevy the one that the plugin was made for?"
            ),
            Self::NotWesl => f.write_str("the shader is not WESL"),
            Self::Syntax(error) => write!(f, "the patched shader does not parse: {error}"),
            Self::Asset(error) => f.write_str(error),
        }
    }
}

impl Error for PatchError {}

/// Returns the patched source, or `None` if the source already contains the patch.
///
/// # Errors
/// Returns any error but [`PatchError::Asset`] and [`PatchError::NotWesl`] if the patch does not fit;
/// a patch is never applied in part.
pub fn patched(source: &str, patch: &ShaderPatch) -> Result<Option<String>, PatchError> {
    let marker = format!("// patch: {}\n", patch.name);
    if source.contains(&marker) {
        return Ok(None);
    }
    for &(text, expected) in &patch.expected_counts {
        expect_count(source, text, expected)?;
    }
    let mut result = source.to_owned();
    for insertion in &patch.insertions {
        let offset = insertion_offset(&result, insertion)?;
        result.insert_str(offset, &format!("\n{marker}{}\n", insertion.text));
    }
    let imports = patch.imports.iter().map(|path| format!("import {path};\n"));
    result.insert_str(0, &format!("{marker}{}", imports.collect::<String>()));
    match result.parse::<TranslationUnit>() {
        Ok(_) => Ok(Some(result)),
        Err(error) => Err(PatchError::Syntax(error.to_string())),
    }
}

/// Returns the byte offset at which to insert.
fn insertion_offset(source: &str, insertion: &Insertion) -> Result<usize, PatchError> {
    let Range { start, end } = match insertion.function {
        None => 0..source.len(),
        Some(function) => {
            let start = unique_offset(source, function)?;
            let body = start + function.len();
            let end = source[body..].find("\nfn ");
            start..end.map_or(source.len(), |end| body + end)
        }
    };
    let anchor = [insertion.before, insertion.after].concat();
    let offset = unique_offset(&source[start..end], &anchor)?;
    Ok(start + offset + insertion.before.len())
}

/// Returns the byte offset of a text that must occur exactly once.
fn unique_offset(source: &str, text: &str) -> Result<usize, PatchError> {
    expect_count(source, text, 1)?;
    Ok(source.find(text).unwrap_or_default())
}

/// Fails unless the text occurs as often as expected.
fn expect_count(source: &str, text: &str, expected: usize) -> Result<(), PatchError> {
    let found = source.matches(text).count();
    if found == expected {
        return Ok(());
    }
    Err(PatchError::Count {
        text: text.to_owned(),
        expected,
        found,
    })
}

/// The state of a patch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PatchState {
    /// The shader is not loaded yet.
    Pending,
    /// The shader contains the patch.
    Applied,
    /// The patch does not fit, and the shader is unchanged.
    Refused(PatchError),
}

/// The patches of an app and their states.
#[derive(Resource, Debug, Default)]
pub struct ShaderPatches {
    patches: Vec<ShaderPatch>,
    states: HashMap<&'static str, PatchState>,
}

impl ShaderPatches {
    /// Returns the state of the patch of this name; `None` if it was never added.
    pub fn state(&self, name: &str) -> Option<&PatchState> {
        self.states.get(name)
    }

    /// Returns true if all of these patches are applied.
    pub fn all_applied(&self, names: &[&str]) -> bool {
        names
            .iter()
            .all(|name| self.state(name) == Some(&PatchState::Applied))
    }

    /// Returns the first of these patches that was refused, and the reason.
    pub fn refused<'a>(&'a self, names: &[&'a str]) -> Option<(&'a str, &'a PatchError)> {
        names.iter().find_map(|&name| match self.state(name) {
            Some(PatchState::Refused(error)) => Some((name, error)),
            _ => None,
        })
    }

    fn add(&mut self, patch: ShaderPatch) {
        if !self.states.contains_key(patch.name) {
            self.states.insert(patch.name, PatchState::Pending);
            self.patches.push(patch);
        }
    }
}

/// Extension trait that adds patches to an app.
pub trait PatchShadersExt {
    /// Applies this patch as soon as its shader is loaded, before any pipeline is built from it.
    ///
    /// Adding a patch of the same name again does nothing.
    fn patch_shader(&mut self, patch: ShaderPatch) -> &mut Self;
}

impl PatchShadersExt for App {
    fn patch_shader(&mut self, patch: ShaderPatch) -> &mut Self {
        if !self.world().contains_resource::<ShaderPatches>() {
            self.init_resource::<ShaderPatches>().add_systems(
                PostUpdate,
                // Before asset events announce the shaders of this frame to the renderer.
                apply_patches
                    .run_if(resource_exists_and_changed::<Assets<Shader>>)
                    .before(AssetEventSystems),
            );
        }
        self.world_mut().resource_mut::<ShaderPatches>().add(patch);
        self
    }
}

fn apply_patches(mut shaders: ResMut<Assets<Shader>>, mut patches: ResMut<ShaderPatches>) {
    let ShaderPatches { patches, states } = &mut *patches;
    for patch in patches.iter() {
        let ids: Vec<_> = shaders
            .iter()
            .filter(|(_, shader)| patch.is_for(shader))
            .map(|(id, _)| id)
            .collect();
        // Another shader may override Bevy's by its import path, and it is not known which of them is compiled. So a
        // patch is applied where it is in all of them.
        let states_of_shaders = ids.into_iter().map(|id| apply(&mut shaders, id, patch));
        let Some(state) = states_of_shaders.reduce(|state, other| match state {
            PatchState::Refused(_) => state,
            _ => other,
        }) else {
            continue;
        };
        if let PatchState::Refused(error) = &state
            && states.get(patch.name) != Some(&state)
        {
            error!(
                "`{}` leaves Bevy's shader `{}` as it is: {error}",
                patch.name, patch.shader
            );
        }
        states.insert(patch.name, state);
    }
}

/// Writes to the assets only where something is inserted, because every change of them runs the system
/// again.
fn apply(
    shaders: &mut ResMut<Assets<Shader>>,
    id: AssetId<Shader>,
    patch: &ShaderPatch,
) -> PatchState {
    let Some(shader) = shaders.get(id) else {
        return PatchState::Pending;
    };
    let Source::Wesl(source) = &shader.source else {
        return PatchState::Refused(PatchError::NotWesl);
    };
    let source = match patched(source, patch) {
        Ok(Some(source)) => source,
        Ok(None) => return PatchState::Applied,
        Err(error) => return PatchState::Refused(error),
    };
    // It is parsed again, because a patch may import another module.
    let parsed = Shader::from_wesl(source, shader.path.clone());
    let patched = Shader {
        source: parsed.source,
        imports: parsed.imports,
        ..shader.clone()
    };
    match shaders.insert(id, patched) {
        Ok(()) => PatchState::Applied,
        Err(error) => PatchState::Refused(PatchError::Asset(error.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: &str = "fn a() -> f32 {\n    return x;\n}\n\nfn b() -> f32 {\n    return x;\n}\n";

    fn patch(name: &'static str, insertion: Insertion) -> ShaderPatch {
        ShaderPatch {
            insertions: vec![insertion],
            ..ShaderPatch::new(name, "bevy_pbr::render::test")
        }
    }

    fn in_b(name: &'static str) -> ShaderPatch {
        let text = format!("    x += {name};");
        patch(
            name,
            Insertion::before("    return x;\n}", text).in_function("fn b("),
        )
    }

    fn count_error(text: &str, found: usize) -> Result<Option<String>, PatchError> {
        Err(PatchError::Count {
            text: text.into(),
            expected: 1,
            found,
        })
    }

    #[test]
    fn inserts_in_the_named_function_only() {
        let result = patched(SOURCE, &in_b("one")).unwrap().unwrap();
        let (a, b) = result.split_once("fn b").unwrap();
        assert!(!a.contains("x += one"));
        assert!(b.find("x += one").unwrap() < b.find("return x").unwrap());
    }

    #[test]
    fn imports_come_first() {
        let mut patch = in_b("one");
        patch.imports.push("game::shade::shade");
        let result = patched(SOURCE, &patch).unwrap().unwrap();
        assert!(result.find("import game::shade::shade;").unwrap() < result.find("fn a").unwrap());
    }

    #[test]
    fn a_patch_is_never_inserted_twice() {
        let once = patched(SOURCE, &in_b("one")).unwrap().unwrap();
        assert_eq!(patched(&once, &in_b("one")), Ok(None));
    }

    #[test]
    fn the_order_of_patches_does_not_matter() {
        for order in [["one", "two"], ["two", "one"]] {
            let source = order.iter().fold(SOURCE.to_owned(), |source, &name| {
                patched(&source, &in_b(name)).unwrap().unwrap()
            });
            assert_eq!(source.matches("x += one").count(), 1);
            assert_eq!(source.matches("x += two").count(), 1);
            let position = |name: &str| source.find(&format!("x += {name}")).unwrap();
            assert!(position(order[0]) < position(order[1]));
        }
    }

    #[test]
    fn an_anchor_that_is_missing_or_ambiguous_is_refused() {
        let anchored = |anchor| patched(SOURCE, &patch("p", Insertion::after(anchor, "")));
        assert_eq!(anchored("return y"), count_error("return y", 0));
        assert_eq!(anchored("return x"), count_error("return x", 2));
        let scoped = Insertion::after("return x", "").in_function("fn c(");
        assert_eq!(
            patched(SOURCE, &patch("p", scoped)),
            count_error("fn c(", 0)
        );
    }

    #[test]
    fn both_sides_of_a_position_are_verified() {
        let between = |before, after| {
            let insertion = Insertion::between(before, after, "").in_function("fn a(");
            patched(SOURCE, &patch("p", insertion))
        };
        assert!(between("{\n", "    return x").is_ok());
        assert_eq!(
            between("{", "    return x"),
            count_error("{    return x", 0)
        );
    }

    #[test]
    fn another_occurrence_of_a_counted_text_is_refused() {
        let mut counted = in_b("one");
        counted.expected_counts.push(("return x", 2));
        assert!(patched(SOURCE, &counted).is_ok());
        counted.expected_counts.push(("fn ", 1));
        assert_eq!(patched(SOURCE, &counted), count_error("fn ", 2));
    }

    #[test]
    fn a_patched_source_that_does_not_parse_is_refused() {
        let broken = Insertion::after("fn b() -> f32 {", "let y = ;");
        let result = patched(SOURCE, &patch("p", broken));
        assert!(matches!(result, Err(PatchError::Syntax(_))), "{result:?}");
    }

    #[test]
    fn a_patch_is_never_applied_in_part() {
        let mut both = in_b("one");
        both.insertions.push(Insertion::after("nowhere", ""));
        assert!(patched(SOURCE, &both).is_err());
    }

    fn app(sources: &[&str]) -> App {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, AssetPlugin::default()))
            .init_asset::<Shader>()
            .patch_shader(doubled());
        let mut shaders = app.world_mut().resource_mut::<Assets<Shader>>();
        for source in sources {
            let path = "embedded://bevy_pbr/render/test.wesl";
            let shader = shaders.add(Shader::from_wesl((*source).to_owned(), path));
            // The asset stays as long as its handle.
            std::mem::forget(shader);
        }
        app.update();
        app
    }

    fn doubled() -> ShaderPatch {
        let insertion = Insertion::before("return color;", "color = 2.0 * color;\n");
        patch("test", insertion)
    }

    const BEVYS: &str = "fn f(c: f32) -> f32 { var color = c;\nreturn color;\n}";
    const OVERRIDE: &str = "fn f(c: f32) -> f32 { return c; }";

    #[test]
    fn a_shader_that_overrides_bevys_is_not_taken_for_the_patched_one() {
        for sources in [[BEVYS, OVERRIDE], [OVERRIDE, BEVYS]] {
            let app = app(&sources);
            let patches = app.world().resource::<ShaderPatches>();
            assert!(patches.refused(&["test"]).is_some(), "{patches:?}");
        }
    }

    #[test]
    fn a_patch_that_is_added_again_stays_applied() {
        let mut app = app(&[BEVYS]);
        let is_applied = |app: &App| {
            let patches = app.world().resource::<ShaderPatches>();
            patches.all_applied(&["test"])
        };
        assert!(is_applied(&app));
        app.patch_shader(doubled());
        assert!(is_applied(&app));
        app.update();
        assert!(is_applied(&app));
    }
}
