//! What an example is.

use std::{collections::BTreeMap, path::PathBuf};

use bevy::{camera::visibility::RenderLayers, prelude::*};

use super::SceneSetting;

/// Render layer of what only the "before" camera sees. Layer 0 is seen by both.
pub const BEFORE_LAYER: usize = 1;
/// Render layer of what only the "after" camera sees. Layer 0 is seen by both.
pub const AFTER_LAYER: usize = 2;

#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// Without the plugin: left of the line.
    Before,
    After,
}

impl Side {
    /// Both sides, from left to right.
    pub const BOTH: [Self; 2] = [Self::Before, Self::After];

    /// The layers for an entity that only this side's camera sees.
    pub fn layers(self) -> RenderLayers {
        RenderLayers::layer(match self {
            Self::Before => BEFORE_LAYER,
            Self::After => AFTER_LAYER,
        })
    }
}

/// An example scene of a plugin.
///
/// A scene is stateless; its state lives in the world that [`build`](Self::build) fills.
pub trait Scene: Sync {
    /// Name in file names and on the command line, in `snake_case`.
    fn name(&self) -> &'static str;

    /// Crate name of the plugin that it shows.
    fn plugin(&self) -> &'static str;

    /// What there is to see, in a sentence.
    fn description(&self) -> &'static str;

    /// The values to play with, in the order of the panel. Default none.
    fn settings(&self) -> Vec<SceneSetting> {
        Vec::new()
    }

    fn view(&self) -> Transform;

    /// Adds the plugin and the systems that spawn the scene.
    ///
    /// Everything but cameras: those are spawned by the runner. The resources `SceneSettings`,
    /// [`SceneImage`], [`MemoryFigures`], [`Notes`] and `AwaitedAssets` are in the world already.
    fn build(&self, app: &mut App);

    /// Adds components to a camera of the runner. Default: nothing.
    fn configure_camera(&self, camera: &mut EntityCommands, side: Side) {
        let _ = (camera, side);
    }
}

/// The image that the user chose with `--image`, for scenes that show one.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct SceneImage(pub Option<PathBuf>);

/// What the plugin occupies on the GPU, filled by the scene: a name and a number of bytes.
///
/// Names that end in ` before` and ` after` stand beside each other in the panel.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct MemoryFigures(pub BTreeMap<String, u64>);

/// What a scene has to say about itself as it runs: a name and a text.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct Notes(pub BTreeMap<String, String>);
