//! Cycles that are made on purpose are found.

use std::path::{Path, PathBuf};

use super::{graph::Graph, rust_crate, wesl};

fn cycles(sources: &[(&str, &str)]) -> Vec<String> {
    let read = |path: &Path| {
        let mut sources = sources.iter();
        let found = sources.find(|(file, _)| Path::new(file) == path);
        found.map(|(_, source)| (*source).to_owned())
    };
    let mut graph = Graph::default();
    rust_crate::add_imports(Path::new("src/lib.rs"), read, &mut graph);
    let shaders: Vec<_> = sources
        .iter()
        .map(|(file, _)| PathBuf::from(file))
        .collect();
    let shaders: Vec<_> = shaders
        .into_iter()
        .filter(|file| file.extension().is_some_and(|e| e == "wesl"))
        .collect();
    wesl::add_imports(Path::new("src"), &shaders, read, &mut graph);
    graph.cycles()
}

#[test]
fn two_files_that_import_each_other() {
    let found = cycles(&[
        ("src/lib.rs", "mod a;\nmod b;"),
        ("src/a.rs", "use crate::b::B;\npub struct A;"),
        ("src/b.rs", "pub struct B(super::a::A);"),
    ]);
    assert_eq!(
        found,
        ["src/a.rs -(crate::b::B)-> src/b.rs -(super::a::A)-> src/a.rs"]
    );
}

#[test]
fn re_exports_are_followed_to_the_definition() {
    let leaves = [
        ("src/lib.rs", "mod a;\nmod group;"),
        (
            "src/group/mod.rs",
            "mod c;\nmod d;\npub(crate) use c::C;\npub use d::{d, D as E};",
        ),
        ("src/group/c.rs", "use crate::a::A;\npub struct C;"),
        ("src/group/d.rs", "pub fn d() {}\npub struct D;"),
    ];
    let with = |a: (&'static str, &'static str)| [leaves.as_slice(), &[a]].concat();
    let none: [&str; 0] = [];
    assert_eq!(
        cycles(&with(("src/a.rs", "use crate::group::{E, d};\nstruct A;"))),
        none
    );
    let found = cycles(&with((
        "src/a.rs",
        "use crate::{group, Other};\nfn a() -> group::C {}\nstruct A;",
    )));
    assert_eq!(
        found,
        ["src/a.rs -(group::C)-> src/group/c.rs -(crate::a::A)-> src/a.rs"]
    );
}

#[test]
fn a_module_that_uses_its_child_is_not_used_by_it() {
    let found = cycles(&[
        (
            "src/lib.rs",
            "pub mod child;\npub struct Parent;\nfn f() { child::g::<u8>('\"', \"\\\"\") }",
        ),
        ("src/child.rs", "pub fn g() -> super::Parent { todo!() }"),
    ]);
    assert_eq!(
        found,
        ["src/child.rs -(super::Parent)-> src/lib.rs -(child::g)-> src/child.rs"]
    );
}

#[test]
fn tests_comments_and_text_import_nothing() {
    let found = cycles(&[
        (
            "src/lib.rs",
            "//! [`a::A`]\nmod a;\npub struct Root;\n#[cfg(test)]\nmod tests;",
        ),
        (
            "src/a.rs",
            "/* super::Root */ pub struct A<'a>(&'a str);\nconst C: &str = r#\"super::Root\"#;\n\
             #[cfg(test)]\nuse super::{Root, a};\n#[cfg(test)]\nmod tests { use super::super::Root; }\n",
        ),
    ]);
    assert_eq!(found, [""; 0]);
}

#[test]
fn shaders_that_import_each_other() {
    let found = cycles(&[
        ("src/lib.rs", ""),
        (
            "src/a.wesl",
            "// package::c::c\nimport package::pass::b::{\n  b,\n};",
        ),
        ("src/pass/b.wesl", "fn b() { package::c::c(); }"),
        ("src/c.wesl", "import package::a;"),
    ]);
    assert_eq!(
        found,
        [
            "src/a.wesl -(package::pass::b)-> src/pass/b.wesl -(package::c::c)-> src/c.wesl -(package::a)-> src/a.wesl"
        ]
    );
}
