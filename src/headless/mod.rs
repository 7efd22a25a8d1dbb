//! Bevy without a window: the same frames on every run.
//!
//! [`HeadlessApp`] owns a Bevy [`App`](bevy::app::App) with the default plugins but no window, no
//! event loop and no second render thread: one call to update is one frame, rendered when it
//! returns. Time advances by a fixed step, pipelines compile synchronously, and the picture lands
//! in an image of a fixed size. What is wrong is said: a missing adapter, a broken pipeline, an
//! asset that fails to load or a GPU that does not answer are values of [`HeadlessError`], not a
//! black picture, a panic or an endless wait.
//!
//! | module | gives |
//! | --- | --- |
//! | [`settings`] | size, format, adapter and limits |
//! | [`adapter`] | which GPU, found before Bevy looks for it |
//! | [`app`] | building and running the frames |
//! | [`ready`] | waiting for assets and pipelines |
//! | [`pixel_view`] | a camera that shows textures pixel by pixel |
//! | [`readback`] | the picture as bytes or floats |
//! | [`timing`] | median frame times of CPU and GPU |
//! | [`threads`] | on which threads systems run |
//! | [`target`] | where cameras draw to, in a window or headless |

pub mod adapter;
pub mod app;
mod awaited;
mod error;
pub mod pixel_view;
pub mod readback;
pub mod ready;
pub mod settings;
pub mod target;
pub mod threads;
pub mod timing;

pub use adapter::AdapterInfo;
pub use app::HeadlessApp;
pub use awaited::{AwaitedAssets, AwaitedWork, Unwatched};
pub use error::HeadlessError;
pub use pixel_view::pixel_camera;
pub use readback::Rgba32FImage;
pub use settings::{HeadlessSettings, TargetFormat};
pub use target::LabTarget;
pub use timing::{FrameTimes, median};
