//! No file imports itself through other files, so that a reader can begin with those that import nothing.
//!
//! | module | contents |
//! | --- | --- |
//! | `graph` | which file imports which, and the cycles among them |
//! | `rust_module` | the items, imports and paths of one Rust file |
//! | `rust_crate` | the files of a crate, and in which of them a path ends |
//! | `wesl` | the imports of shaders |

mod graph;
mod rust_crate;
mod rust_module;
mod tests;
mod wesl;

use std::{fs, path::Path};

use graph::Graph;

/// The folders of sources, each with the roots of its crates.
const CRATES: [(&str, &[&str]); 6] = [
    ("src", &["lib.rs"]),
    ("crates/bevy_ewa/src", &["lib.rs"]),
    ("crates/bevy_frugal_hooks/src", &["lib.rs"]),
    ("crates/bevy_voxel_gi/src", &["lib.rs"]),
    (
        "crates/bevy_wavelet_tex/src",
        &["lib.rs", "bin/wavelet-tex/main.rs"],
    ),
    ("crates/bevy_ycocg_fb/src", &["lib.rs"]),
];

fn imports(read: impl Fn(&Path) -> Option<String> + Copy) -> Graph {
    let mut graph = Graph::default();
    for (folder, roots) in CRATES {
        for root in roots {
            rust_crate::add_imports(&Path::new(folder).join(root), read, &mut graph);
        }
        let shaders = wesl::files(Path::new(env!("CARGO_MANIFEST_DIR")), Path::new(folder));
        wesl::add_imports(Path::new(folder), &shaders, read, &mut graph);
    }
    graph
}

#[test]
fn no_file_imports_itself_through_others() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let graph = imports(|path| fs::read_to_string(root.join(path)).ok());
    assert!(graph.file_count() > 300, "{} files", graph.file_count());
    let cycles = graph.cycles();
    assert!(
        cycles.is_empty(),
        "{} import cycles:\n{}",
        cycles.len(),
        cycles.join("\n")
    );
}
