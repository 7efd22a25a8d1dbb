//! The items, imports and paths of one Rust file.

use std::collections::{BTreeMap, BTreeSet};

use super::rust_tokens::tokens;

/// A Rust file with its inline modules.
#[derive(Debug, Default)]
pub(super) struct Module {
    /// Names of the modules that are files of their own.
    pub(super) children: BTreeSet<String>,
    /// Names of the items that are defined outside of functions and blocks.
    pub(super) items: BTreeSet<String>,
    /// Paths that `use` brings into scope, by the names that they have there.
    pub(super) uses: BTreeMap<String, Use>,
    /// Paths of two or more segments in the code, and single names.
    pub(super) paths: BTreeSet<Vec<String>>,
}

#[derive(Debug)]
pub(super) struct Use {
    pub(super) path: Vec<String>,
    pub(super) is_public: bool,
}

impl Module {
    pub(super) fn parse(source: &str) -> Self {
        let mut module = Self::default();
        let tokens = tokens(source);
        let mut depth = 0;
        let mut i = 0;
        while i < tokens.len() {
            match tokens[i] {
                "{" => depth += 1,
                "}" => depth -= 1,
                "use" if tokens[i + 1] != "<" => {
                    let is_public = i > 0 && matches!(tokens[i - 1], "pub" | ")");
                    i += 1;
                    module.parse_use(&tokens, &mut i, &[], is_public);
                }
                "mod" if tokens[i + 2] == ";" => {
                    module.children.insert(tokens[i + 1].to_owned());
                    i += 2;
                }
                "fn" | "struct" | "enum" | "trait" | "const" | "static" | "type" | "union"
                    if depth == 0 =>
                {
                    module.items.insert(tokens[i + 1].to_owned());
                }
                "macro_rules" => {
                    module.items.insert(tokens[i + 2].to_owned());
                }
                token if is_identifier(token) => {
                    let is_first = i == 0 || !matches!(tokens[i - 1], "::" | ".");
                    let mut path = vec![token.to_owned()];
                    while i + 2 < tokens.len()
                        && tokens[i + 1] == "::"
                        && is_identifier(tokens[i + 2])
                    {
                        path.push(tokens[i + 2].to_owned());
                        i += 2;
                    }
                    if is_first {
                        module.paths.insert(path);
                    }
                }
                _ => {}
            }
            i += 1;
        }
        module
    }

    /// Parses a tree of imports up to the token after it.
    fn parse_use(&mut self, tokens: &[&str], i: &mut usize, prefix: &[String], is_public: bool) {
        let mut path = prefix.to_vec();
        loop {
            match tokens[*i] {
                "{" => {
                    while tokens[*i] != "}" {
                        *i += 1;
                        if tokens[*i] != "}" {
                            self.parse_use(tokens, i, &path, is_public);
                        }
                    }
                    *i += 1;
                    return;
                }
                "::" => {}
                "," | ";" | "}" => break,
                "as" => {
                    let name = match tokens[*i + 1] {
                        "_" => path.join("::"),
                        name => name.to_owned(),
                    };
                    *i += 2;
                    self.uses.insert(name, Use { path, is_public });
                    return;
                }
                segment => path.push(segment.to_owned()),
            }
            *i += 1;
        }
        if path.last().is_some_and(|last| last == "self") {
            path.pop();
        }
        if let Some(name) = path.last().cloned() {
            self.uses.insert(name, Use { path, is_public });
        }
    }

    /// Whether the code has a path that begins with this name.
    pub(super) fn mentions(&self, name: &str) -> bool {
        self.paths.iter().any(|path| path[0] == name)
    }
}

fn is_identifier(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}
