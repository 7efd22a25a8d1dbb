//! The description of a patch.

use bevy::shader::{Shader, ShaderImport};

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

    pub(super) fn is_for(&self, shader: &Shader) -> bool {
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
