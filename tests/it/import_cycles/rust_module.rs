//! The items, imports and paths of one Rust file.

use std::collections::{BTreeMap, BTreeSet};

use proc_macro2::{TokenStream, TokenTree};
use syn::{
    Attribute, Ident, ImplItemFn, Item, ItemMod, ItemUse, Macro, Meta, MetaList, Path, UseTree,
    Visibility,
    visit::{self, Visit},
};

/// A Rust file with its inline modules, without what is under `#[cfg(test)]`.
#[derive(Debug, Default)]
pub(super) struct Module {
    /// Names of the modules that are files of their own.
    pub(super) children: BTreeSet<String>,
    /// Names of the items that are defined outside of functions and blocks.
    pub(super) items: BTreeSet<String>,
    /// Paths that `use` brings into scope, by the names that they have there.
    pub(super) uses: BTreeMap<String, Use>,
    /// Paths in the code, and single names.
    pub(super) paths: BTreeSet<Vec<String>>,
}

#[derive(Debug)]
pub(super) struct Use {
    pub(super) path: Vec<String>,
    pub(super) is_public: bool,
}

impl Module {
    pub(super) fn parse(source: &str) -> syn::Result<Self> {
        let file = syn::parse_file(source)?;
        let named = file.items.iter().map(attributes_and_name);
        let items = named.filter(|(attributes, _)| !is_test(attributes));
        let mut module = Self {
            items: items
                .filter_map(|(_, name)| Some(name?.to_string()))
                .collect(),
            ..Self::default()
        };
        module.visit_file(&file);
        Ok(module)
    }

    /// Whether the code has a path that begins with this name.
    pub(super) fn mentions(&self, name: &str) -> bool {
        self.paths
            .iter()
            .any(|path| path.first().is_some_and(|first| first == name))
    }

    fn add_use(&mut self, tree: &UseTree, prefix: &[String], is_public: bool) {
        let with = |name: &Ident| [prefix, &[name.to_string()]].concat();
        let (name, path) = match tree {
            UseTree::Path(path) => return self.add_use(&path.tree, &with(&path.ident), is_public),
            UseTree::Group(group) => {
                let trees = group.items.iter();
                return trees.for_each(|tree| self.add_use(tree, prefix, is_public));
            }
            UseTree::Name(name) if name.ident == "self" => (prefix.last().cloned(), prefix.into()),
            UseTree::Name(name) => (Some(name.ident.to_string()), with(&name.ident)),
            UseTree::Rename(name) if name.rename == "_" => (None, with(&name.ident)),
            UseTree::Rename(name) => (Some(name.rename.to_string()), with(&name.ident)),
            UseTree::Glob(_) => (None, [prefix, &["*".to_owned()]].concat()),
        };
        let name = name.unwrap_or_else(|| path.join("::"));
        self.uses.insert(name, Use { path, is_public });
    }

    /// Adds the paths in the arguments of a macro or an attribute.
    fn add_tokens(&mut self, tokens: &TokenStream) {
        let (mut path, mut colons) = (Vec::new(), 0);
        for token in tokens.clone() {
            match token {
                TokenTree::Punct(mark) if mark.as_char() == ':' => {
                    colons += 1;
                    continue;
                }
                TokenTree::Ident(name) if colons == 2 => path.push(name.to_string()),
                TokenTree::Ident(name) => {
                    self.paths
                        .insert(std::mem::replace(&mut path, vec![name.to_string()]));
                }
                TokenTree::Group(group) => self.add_tokens(&group.stream()),
                TokenTree::Punct(_) | TokenTree::Literal(_) => {}
            }
            colons = 0;
        }
        self.paths.insert(path);
    }
}

impl Visit<'_> for Module {
    fn visit_item(&mut self, item: &Item) {
        if !is_test(attributes_and_name(item).0) {
            visit::visit_item(self, item);
        }
    }

    fn visit_impl_item_fn(&mut self, function: &ImplItemFn) {
        if !is_test(&function.attrs) {
            visit::visit_impl_item_fn(self, function);
        }
    }

    fn visit_item_mod(&mut self, module: &ItemMod) {
        if module.content.is_none() {
            self.children.insert(module.ident.to_string());
        }
        visit::visit_item_mod(self, module);
    }

    fn visit_item_use(&mut self, import: &ItemUse) {
        let is_public = !matches!(import.vis, Visibility::Inherited);
        self.add_use(&import.tree, &[], is_public);
    }

    fn visit_path(&mut self, path: &Path) {
        let names = path.segments.iter().map(|name| name.ident.to_string());
        self.paths.insert(names.collect());
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, call: &Macro) {
        visit::visit_macro(self, call);
        self.add_tokens(&call.tokens);
    }

    fn visit_meta_list(&mut self, list: &MetaList) {
        visit::visit_meta_list(self, list);
        self.add_tokens(&list.tokens);
    }
}

fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        Meta::List(list) => list.path.is_ident("cfg") && list.tokens.to_string().contains("test"),
        _ => false,
    })
}

fn attributes_and_name(item: &Item) -> (&[Attribute], Option<&Ident>) {
    match item {
        Item::Const(item) => (&item.attrs, Some(&item.ident)),
        Item::Enum(item) => (&item.attrs, Some(&item.ident)),
        Item::Fn(item) => (&item.attrs, Some(&item.sig.ident)),
        Item::Impl(item) => (&item.attrs, None),
        Item::Macro(item) => (&item.attrs, item.ident.as_ref()),
        Item::Mod(item) => (&item.attrs, None),
        Item::Static(item) => (&item.attrs, Some(&item.ident)),
        Item::Struct(item) => (&item.attrs, Some(&item.ident)),
        Item::Trait(item) => (&item.attrs, Some(&item.ident)),
        Item::Type(item) => (&item.attrs, Some(&item.ident)),
        Item::Union(item) => (&item.attrs, Some(&item.ident)),
        Item::Use(item) => (&item.attrs, None),
        _ => (&[], None),
    }
}
