//! The plugin, which registers what the other modules define.

use bevy::{prelude::*, shader::load_shader_library};
use bevy_frugal_hooks::ViewWireframesPlugin;

use crate::{
    material::MaterialPackingPlugin,
    pass::PackedPassPlugin,
    report::ReportPlugin,
    settings::{DefaultFrameBufferQuality, FrameBufferQuality},
    view::PackedViewPlugin,
};

/// Lets cameras with a [`FrameBufferQuality`] draw into fewer bytes.
///
/// An app without such a camera has no additional pass, texture or pipeline.
#[derive(Clone, Copy, Debug, Default)]
pub struct YCoCgFrameBufferPlugin;

impl Plugin for YCoCgFrameBufferPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<ViewWireframesPlugin>() {
            app.add_plugins(ViewWireframesPlugin);
        }
        load_shader_library!(app, "shaders/formats.wesl");
        load_shader_library!(app, "shaders/pack.wesl");
        load_shader_library!(app, "shaders/reconstruct.wesl");
        app.register_type::<FrameBufferQuality>()
            .register_type::<DefaultFrameBufferQuality>()
            .add_plugins((
                ReportPlugin,
                MaterialPackingPlugin,
                PackedViewPlugin,
                PackedPassPlugin,
            ));
    }
}
