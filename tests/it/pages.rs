//! The shaders on the pages of the plugins compose and validate.

use bevy_ewa::EwaPlugin;
use bevy_frugal_lab::headless::{HeadlessApp, HeadlessSettings};
use bevy_voxel_gi::VoxelGiPlugin;
use bevy_wavelet_tex::WaveletTexPlugin;
use bevy_ycocg_fb::YCoCgFrameBufferPlugin;

use crate::support::{compose::mesh_numbers, composer, gpu};

const PAGES: [(&str, &str, usize); 4] = [
    (
        "bevy_ewa",
        include_str!("../../crates/bevy_ewa/README.md"),
        1,
    ),
    (
        "bevy_ycocg_fb",
        include_str!("../../crates/bevy_ycocg_fb/README.md"),
        1,
    ),
    (
        "bevy_wavelet_tex",
        include_str!("../../crates/bevy_wavelet_tex/README.md"),
        1,
    ),
    (
        "bevy_voxel_gi",
        include_str!("../../crates/bevy_voxel_gi/README.md"),
        0,
    ),
];

#[test]
fn shaders_on_the_pages_validate() {
    let _gpu = gpu();
    let mut app = HeadlessApp::new(HeadlessSettings::with_size(1, 1), |app| {
        app.add_plugins((
            EwaPlugin::OPT_IN,
            VoxelGiPlugin,
            WaveletTexPlugin,
            YCoCgFrameBufferPlugin,
        ));
    })
    .expect("an app");
    let mut composer = composer(&mut app);
    let mut defs = mesh_numbers();
    defs.push("VERTEX_UVS_A".into());
    for (name, page, count) in PAGES {
        let blocks = page.split("```wgsl\n").skip(1);
        let shaders: Vec<_> = blocks
            .filter_map(|block| block.split("```").next())
            .collect();
        assert_eq!(shaders.len(), count, "{name}");
        for shader in shaders {
            let valid = composer.compose_source(shader, &defs);
            assert!(valid.is_ok(), "{name}: {}\n{shader}", valid.unwrap_err());
        }
    }
}
