//! Patching as a function of text.

use std::{error::Error, fmt};

use super::ShaderPatch;

/// Text to insert at one place.
#[derive(Clone, Debug)]
pub struct Insertion {
    /// If given, the anchor is looked for from here to the next function only; occurs once.
    pub scope: Option<&'static str>,
    /// Where; occurs exactly once in its scope.
    pub anchor: &'static str,
    /// Before the anchor rather than after it.
    pub before: bool,
    /// What is inserted.
    pub text: String,
}

impl Insertion {
    /// Inserts `text` before `anchor`.
    pub fn before(anchor: &'static str, text: impl Into<String>) -> Self {
        Self {
            scope: None,
            anchor,
            before: true,
            text: text.into(),
        }
    }

    /// Inserts `text` after `anchor`.
    pub fn after(anchor: &'static str, text: impl Into<String>) -> Self {
        Self {
            before: false,
            ..Self::before(anchor, text)
        }
    }

    /// Looks for the anchor only in the function that begins so.
    pub fn in_function(self, scope: &'static str) -> Self {
        Self {
            scope: Some(scope),
            ..self
        }
    }
}

/// Why a patch does not fit a shader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PatchError {
    /// This text should occur once.
    Anchor {
        /// The text.
        anchor: &'static str,
        /// How often it occurs.
        found: usize,
    },
    /// The shader is not WGSL.
    NotWgsl,
    /// The asset could not be replaced.
    Asset(String),
}

impl fmt::Display for PatchError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Anchor { anchor, found } => write!(
                f,
                "`{anchor}` should occur once in Bevy's shader but occurs {found} times; \
                 is this version of Bevy the one the plugin was made for?"
            ),
            Self::NotWgsl => f.write_str("Bevy's shader is not WGSL"),
            Self::Asset(error) => f.write_str(error),
        }
    }
}

impl Error for PatchError {}

/// The patched source, or `None` if the patch is in it already.
///
/// # Errors
/// [`PatchError::Anchor`]; nothing is patched in part.
pub fn patched(source: &str, patch: &ShaderPatch) -> Result<Option<String>, PatchError> {
    let marker = format!("// patch: {}\n", patch.name);
    if source.contains(&marker) {
        return Ok(None);
    }
    let mut result = source.to_owned();
    for insertion in &patch.insertions {
        let at = place(&result, insertion)?;
        result.insert_str(at, &format!("\n{marker}{}\n", insertion.text));
    }
    Ok(Some(result))
}

/// The offset at which to insert.
fn place(source: &str, insertion: &Insertion) -> Result<usize, PatchError> {
    let (start, end) = match insertion.scope {
        None => (0, source.len()),
        Some(scope) => {
            let start = only(source, scope)?;
            let body = start + scope.len();
            let end = source[body..]
                .find("\nfn ")
                .map_or(source.len(), |n| body + n);
            (start, end)
        }
    };
    let at = start + only(&source[start..end], insertion.anchor)?;
    Ok(if insertion.before {
        at
    } else {
        at + insertion.anchor.len()
    })
}

/// Where the text occurs, if it occurs once.
fn only(source: &str, anchor: &'static str) -> Result<usize, PatchError> {
    let mut places = source.match_indices(anchor).map(|(at, _)| at);
    match (places.next(), places.count()) {
        (Some(at), 0) => Ok(at),
        (first, others) => Err(PatchError::Anchor {
            anchor,
            found: others + usize::from(first.is_some()),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ShaderName;

    const SOURCE: &str = "fn a() -> f32 {\n    return x;\n}\n\nfn b() -> f32 {\n    return x;\n}\n";

    fn patch(name: &'static str, insertion: Insertion) -> ShaderPatch {
        ShaderPatch {
            name,
            shader: ShaderName::ImportPath("a::b"),
            insertions: vec![insertion],
        }
    }

    fn in_b(name: &'static str) -> ShaderPatch {
        let text = format!("    x += {name};");
        patch(
            name,
            Insertion::before("    return x;\n}", text).in_function("fn b("),
        )
    }

    #[test]
    fn inserts_in_the_named_function_only() {
        let result = patched(SOURCE, &in_b("one")).unwrap().unwrap();
        let (a, b) = result.split_once("fn b").unwrap();
        assert!(!a.contains("x += one"));
        assert!(b.find("x += one").unwrap() < b.find("return x").unwrap());
    }

    #[test]
    fn never_twice() {
        let once = patched(SOURCE, &in_b("one")).unwrap().unwrap();
        assert_eq!(patched(&once, &in_b("one")), Ok(None));
    }

    #[test]
    fn patches_live_together_in_any_order() {
        for order in [["one", "two"], ["two", "one"]] {
            let source = order.iter().fold(SOURCE.to_owned(), |source, &name| {
                patched(&source, &in_b(name)).unwrap().unwrap()
            });
            assert_eq!(source.matches("x += one").count(), 1);
            assert_eq!(source.matches("x += two").count(), 1);
            assert!(source.find(order[0]).unwrap() < source.find(order[1]).unwrap());
        }
    }

    #[test]
    fn an_anchor_that_is_missing_or_ambiguous_is_refused() {
        let anchored = |anchor| patched(SOURCE, &patch("p", Insertion::after(anchor, "")));
        let error = |anchor, found| Err(PatchError::Anchor { anchor, found });
        assert_eq!(anchored("return y"), error("return y", 0));
        assert_eq!(anchored("return x"), error("return x", 2));
        let scoped = Insertion::after("return x", "").in_function("fn c(");
        assert_eq!(patched(SOURCE, &patch("p", scoped)), error("fn c(", 0));
    }

    #[test]
    fn all_or_nothing() {
        let mut both = in_b("one");
        both.insertions.push(Insertion::after("nowhere", ""));
        assert!(patched(SOURCE, &both).is_err());
    }
}
