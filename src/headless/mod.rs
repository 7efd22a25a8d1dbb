//! Bevy without a window: the same frames on every run.
//!
//! [`HeadlessApp`] owns a Bevy [`App`](bevy::app::App) with the default plugins but no window, no
//! event loop and no second render thread: one call to update is one frame, rendered when it
//! returns. Time advances by a fixed step, pipelines compile synchronously, and the picture lands
//! in an image of a fixed size. What is wrong is said: a missing adapter, a broken pipeline, an
//! asset that fails to load or a GPU that does not answer are values of [`HeadlessError`], not a
//! black picture, a panic or an endless wait.

pub use crate::headless::{
    adapter::{AdapterInfo, HeadlessError},
    app::{
        AwaitedAssets, AwaitedWork, HeadlessApp, HeadlessSettings, LabTarget, TargetFormat,
        Unwatched, pixel_camera,
    },
    frames::{FrameTimes, Rgba32FImage, median},
};

pub mod adapter;
pub mod app;
pub mod frames;
