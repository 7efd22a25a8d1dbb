//! One runner for all scenes.
//!
//! A scene is a type that implements [`Scene`]: its name, its [`SceneSetting`]s, and a function that
//! adds plugins and entities to an app. The runner does the rest, in a window (a panel with every
//! setting and the live figures, a split line to drag between before and after) or headless (three
//! pictures and a line of JSON). So what a test or a benchmark measures is what a visitor sees.
//!
//! "Before" and "after" are two cameras at the same pose. Each sees the common render layer 0 and
//! its own, [`BEFORE_LAYER`] or [`AFTER_LAYER`], and renders its side of the split line. Where a
//! plugin changes how a camera renders rather than what it sees, [`Scene::configure_camera`] adds its
//! component to one of them.

pub use crate::runner::{
    pictures::{Outcome, RunError, render_headless},
    scene::{
        AFTER_LAYER, BEFORE_LAYER, Choice, MemoryFigures, Notes, Options, Scene, SceneImage,
        SceneSetting, SceneSettings, SettingError, SettingKind, SettingValue, Side, Size,
    },
    split::{PictureArea, Split, SplitLine},
    window::ScenePicker,
};

pub mod pictures;
pub mod scene;
pub mod split;
pub mod window;
