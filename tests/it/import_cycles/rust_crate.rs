//! The files of a crate, and in which of them a path ends.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use super::{
    graph::Graph,
    rust_module::{Module, Use},
};

/// The path of a module in its crate, as `["codec", "blocks"]`; the root has none.
type ModulePath = Vec<String>;

/// The modules of a crate, with the paths of their files.
struct Crate(BTreeMap<ModulePath, (String, Module)>);

/// What a path names.
enum Target {
    /// An item, by the path of the module that defines it.
    Item(ModulePath),
    Module(ModulePath),
    /// An item of another crate or of the standard library.
    External,
}

/// Adds the files of a crate and their imports, beginning at the root file.
pub(super) fn add_imports(
    root: &Path,
    read: impl Fn(&Path) -> Option<String> + Copy,
    graph: &mut Graph,
) {
    let mut modules = Crate(BTreeMap::new());
    let folder = root.parent().unwrap_or(Path::new(""));
    modules.load(Vec::new(), root, folder, read);
    for (path, (file, module)) in &modules.0 {
        graph.add_file(file);
        for (name, target) in modules.imports(path, module) {
            graph.add_import(file, &modules.0[&target].0, &name);
        }
    }
}

impl Crate {
    /// Reads the file of a module and those of its children, which are in `folder`.
    fn load(
        &mut self,
        path: ModulePath,
        file: &Path,
        folder: &Path,
        read: impl Fn(&Path) -> Option<String> + Copy,
    ) {
        let source = read(file).unwrap_or_else(|| panic!("{} is missing", file.display()));
        let module =
            Module::parse(&source).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        for child in &module.children {
            let folder = folder.join(child);
            let candidates: [PathBuf; 2] = [folder.with_extension("rs"), folder.join("mod.rs")];
            let file = candidates.iter().find(|file| read(file).is_some());
            let file = file.unwrap_or_else(|| panic!("no file of {}", folder.display()));
            let path = [path.as_slice(), std::slice::from_ref(child)].concat();
            self.load(path, file, &folder, read);
        }
        self.0.insert(path, (file.display().to_string(), module));
    }

    /// Returns the names that a module imports, with the modules that define them.
    fn imports(&self, path: &ModulePath, module: &Module) -> Vec<(String, ModulePath)> {
        let used = module.uses.iter().filter(|(name, import)| {
            // A module may give the items of its children a shorter path without use of its own.
            !import.is_public || module.mentions(name) || !self.is_below(path, import)
        });
        let used = used.map(|(_, import)| &import.path);
        used.chain(&module.paths)
            .filter_map(|names| match self.resolve(path, names, 0) {
                Target::Item(target) => Some((names.join("::"), target)),
                Target::Module(_) | Target::External => None,
            })
            .collect()
    }

    fn is_below(&self, path: &ModulePath, import: &Use) -> bool {
        match self.resolve(path, &import.path, 0) {
            Target::Item(target) => target.starts_with(path),
            Target::Module(_) | Target::External => false,
        }
    }

    /// Follows a path from a module to the definition of its first item.
    fn resolve(&self, from: &ModulePath, names: &[String], depth: usize) -> Target {
        let module = &self.0[from].1;
        let Some((first, rest)) = names.split_first() else {
            return Target::Module(from.clone());
        };
        match first.as_str() {
            "crate" => return self.resolve(&Vec::new(), rest, depth),
            "self" => return self.resolve(from, rest, depth),
            "super" => return self.resolve(&from[..from.len() - 1].to_vec(), rest, depth),
            "*" => return Target::Item(from.clone()),
            _ => {}
        }
        if module.children.contains(first) {
            let child = [from.as_slice(), std::slice::from_ref(first)].concat();
            return self.resolve(&child, rest, depth);
        }
        if module.items.contains(first) {
            return Target::Item(from.clone());
        }
        match module.uses.get(first) {
            // The depth ends at a name that is imported from a crate of the same name.
            Some(import) if depth < 8 => match self.resolve(from, &import.path, depth + 1) {
                Target::Module(module) => self.resolve(&module, rest, depth),
                target => target,
            },
            _ => Target::External,
        }
    }
}
