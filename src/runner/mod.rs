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
//!
//! | module | gives |
//! | --- | --- |
//! | [`scene`] | the trait, and what the runner and a scene tell each other |
//! | [`mod@setting`] | a named value with a range |
//! | [`mod@settings`] | the settings of a scene with their values |
//! | [`split`] | the two cameras and the line between them |
//! | [`options`] | the command line |
//! | [`pictures`] | the headless run |
//! | [`window`] | the window |

mod memory_table;
pub mod options;
mod panel;
pub mod pictures;
pub mod scene;
pub mod setting;
pub mod settings;
pub mod split;
pub mod window;

pub use options::{Options, Size};
pub use panel::ScenePicker;
pub use pictures::{Outcome, RunError, render_headless};
pub use scene::{AFTER_LAYER, BEFORE_LAYER, MemoryFigures, Notes, Scene, SceneImage, Side};
pub use setting::{SceneSetting, SettingKind, SettingValue};
pub use settings::{SceneSettings, SettingError};
pub use split::{PictureArea, Split, SplitLine};
