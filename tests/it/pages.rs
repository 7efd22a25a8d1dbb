//! The pages: shaders on them compose and validate, their snippets are the examples, and their links lead somewhere.

use std::path::Path;

use bevy_frugal_lab::ROOT;

use crate::support::{add_plugins, compose::mesh_numbers, composer, gpu, headless};

pub const PLUGINS: [&str; 4] = [
    "bevy_ewa",
    "bevy_ycocg_fb",
    "bevy_wavelet_tex",
    "bevy_voxel_gi",
];

fn text(path: impl AsRef<Path>) -> String {
    let path = Path::new(ROOT).join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// What stands in the page's blocks of a language.
fn blocks<'a>(page: &'a str, language: &str) -> Vec<&'a str> {
    let start = format!("```{language}\n");
    page.split(&start)
        .skip(1)
        .map(|block| block.split("```").next().expect("a block"))
        .collect()
}

#[test]
fn shaders_on_the_pages_validate() {
    let _gpu = gpu();
    let mut app = headless(1, 1, add_plugins);
    let mut composer = composer(&mut app);
    let mut defs = mesh_numbers();
    defs.push("VERTEX_UVS_A".into());
    let page = text("docs/custom-shaders.md");
    let shaders = blocks(&page, "wgsl");
    assert_eq!(shaders.len(), 3);
    for shader in shaders {
        let valid = composer.compose_source(shader, &defs);
        assert!(valid.is_ok(), "{}\n{shader}", valid.unwrap_err());
    }
}

#[test]
fn snippets_are_the_examples() {
    for plugin in PLUGINS {
        let page = text(format!("crates/{plugin}/README.md"));
        let example = text(format!("crates/{plugin}/examples/minimal.rs"));
        let lines = example.lines().skip_while(|line| line.starts_with("//!"));
        let code: String = lines.skip(1).flat_map(|line| [line, "\n"]).collect();
        assert_eq!(blocks(&page, "rust,no_run"), [code], "{plugin}");
    }
    let meta = text("examples/source_assets/bricks.jpg.meta");
    assert_eq!(blocks(&text("docs/encoding.md"), "ron"), [meta]);
}

/// On docs.rs links of a crate's page lead to the repository: they are defined once more in `lib.rs`.
#[test]
fn links_lead_somewhere() {
    let plugins = PLUGINS.map(|plugin| format!("crates/{plugin}/README.md"));
    let docs = std::fs::read_dir(Path::new(ROOT).join("docs")).expect("a folder");
    let docs = docs.map(|entry| entry.expect("an entry").file_name());
    let docs = docs.filter_map(|name| Some(format!("docs/{}", name.to_str()?)));
    let others = [
        "README.md",
        "ARCHITECTURE.md",
        "CHANGELOG.md",
        "CREDITS.md",
        "examples/README.md",
    ];
    let others = others.map(String::from).into_iter();
    let pages = others.chain(docs.filter(|page| page.ends_with(".md")));
    for page in pages.chain(plugins.clone()) {
        let text = text(&page);
        let inline = text.split("](").skip(1).filter_map(|link| {
            let link = link.split([')', ' ']).next()?;
            link.split('#').next().filter(|path| !path.is_empty())
        });
        let defined =
            { text.lines() }.filter_map(|line| Some(line.strip_prefix('[')?.split_once("]: ")?.1));
        let folder = Path::new(ROOT).join(&page);
        let folder = folder.parent().expect("a folder");
        let is_dead = |link: &&str| !link.starts_with("http") && !folder.join(link).exists();
        let dead: Vec<_> = inline.chain(defined).filter(is_dead).collect();
        assert!(dead.is_empty(), "{page}: {dead:?}");
    }
    for (plugin, page) in PLUGINS.iter().zip(plugins) {
        let page = text(page);
        assert!(
            !page.contains("](../"),
            "{plugin}: a link that is not defined below"
        );
        let root = text(format!("crates/{plugin}/src/lib.rs"));
        for link in page.lines().filter(|line| line.contains("]: ../../")) {
            let (name, path) = link.split_once("]: ../../").expect("a link");
            let kind = if path.ends_with(".md") { "blob" } else { "raw" };
            let line = format!(
                r#"concat!("{name}]: ", env!("CARGO_PKG_REPOSITORY"), "/{kind}/main/{path}")"#
            );
            assert!(root.contains(&line), "{plugin}: lib.rs lacks {line}");
        }
    }
}
