//! Pipelines are asked for as early as Bevy asks for its own.

use bevy::{
    prelude::*,
    render::{
        RenderApp,
        render_resource::{PipelineCache, TextureFormat},
    },
};
use bevy_ewa::{EwaPlugin, EwaReport, MipReport};
use bevy_frugal_lab::headless::HeadlessSettings;

use super::scene::{Floor, checkered, checks, mips, texture};
use crate::support::gpu;

const FRAMES: u32 = 30;

fn pipelines(floor: &mut Floor) -> usize {
    let render_app = floor.app.app_mut().sub_app(RenderApp);
    let cache = render_app.world().resource::<PipelineCache>();
    cache.pipelines().count()
}

/// The pipelines that a running app asks for in each frame from that on in which a mesh with a new material appears,
/// whose textures come without mip levels, and the mip levels that they have in the end.
fn new_pipelines(plugin: Option<EwaPlugin>) -> (Vec<usize>, Option<MipReport>) {
    let settings = HeadlessSettings::with_size(96, 64);
    let mut floor = Floor::with_settings(settings, plugin, checkered(true));
    let before = pipelines(&mut floor);
    let world = floor.app.world_mut();
    let mut images = world.resource_mut::<Assets<Image>>();
    let mut map = |format, a, b| images.add(texture(false, format, checks(a, b)));
    let color = map(
        TextureFormat::Rgba8UnormSrgb,
        [250, 250, 240, 255],
        [20, 30, 60, 255],
    );
    let normals = map(
        TextureFormat::Rgba8Unorm,
        [150, 128, 240, 255],
        [106, 128, 240, 255],
    );
    let material = StandardMaterial {
        base_color_texture: Some(color.clone()),
        normal_map_texture: Some(normals),
        ..default()
    };
    let material = world.add_asset::<StandardMaterial>(material);
    let cube = Mesh::from(Cuboid::from_length(0.4)).with_generated_tangents();
    let cube = world.add_asset(cube.expect("tangents"));
    world.spawn((
        Mesh3d(cube),
        MeshMaterial3d(material),
        Transform::from_xyz(0.2, 0.4, -2.0),
    ));
    let mut counts = Vec::new();
    for _ in 0..FRAMES {
        floor.app.render_frames(1).expect("a frame");
        counts.push(pipelines(&mut floor) - before);
    }
    let has_report = floor.app.world().contains_resource::<EwaReport>();
    let levels = has_report.then(|| mips(floor.app.world(), &color));
    (counts, levels.flatten())
}

#[test]
fn a_new_material_asks_for_its_pipelines_in_the_frame_in_which_bevys_does() {
    let _gpu = gpu();
    let (stock, stock_levels) = new_pipelines(None);
    let (filtered, levels) = new_pipelines(Some(EwaPlugin::elliptical()));
    assert_eq!(
        [stock_levels, levels],
        [None, Some(MipReport::Generated(7))]
    );
    assert!(stock.last() > Some(&0), "the material needs new pipelines");
    // The same number in the same frames: none later.
    assert_eq!(filtered, stock);
}
