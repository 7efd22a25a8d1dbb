//! What can go wrong without a window.

use thiserror::Error;

use super::TargetFormat;

/// Why a headless picture could not be made.
#[derive(Debug, Error)]
pub enum HeadlessError {
    /// A side of the picture is 0 or above the limit of the adapter.
    #[error("a picture of {width}x{height} cannot be rendered: each side must be 1 to {limit}")]
    Size {
        /// Width asked for, in pixels.
        width: u32,
        /// Height asked for, in pixels.
        height: u32,
        /// Largest side of the adapter, in pixels.
        limit: u32,
    },
    /// No adapter is there, or none has the wanted name.
    #[error(
        "no graphics adapter{}; available: {}. Install a Vulkan driver (on Linux without a GPU: \
         the Mesa software driver, package mesa-vulkan-drivers), or correct WGPU_BACKEND and \
         WGPU_ADAPTER_NAME", wanted_text(.wanted), available_text(.available)
    )]
    NoAdapter {
        /// The part of the name that was asked for, if any.
        wanted: Option<String>,
        /// The adapters that exist: name and backend.
        available: Vec<String>,
    },
    /// A pipeline failed to compile.
    #[error("pipeline `{label}` failed: {error}")]
    Pipeline {
        /// Label of its descriptor, or `unlabelled`.
        label: String,
        error: String,
    },
    /// An awaited asset failed to load.
    #[error("asset `{path}` failed to load: {error}")]
    Asset {
        path: String,
        /// Message of its loader.
        error: String,
    },
    /// Something was still loading or compiling after the last allowed frame.
    #[error("not ready after {frames} frames, still waiting for: {}", .waiting.join(", "))]
    NotReady {
        /// Number of frames rendered.
        frames: u32,
        waiting: Vec<String>,
    },
    /// The GPU did not finish in time, or the device was lost.
    #[error("the GPU did not deliver the picture within {seconds} s: {error}")]
    Readback {
        /// The time limit, in seconds.
        seconds: f32,
        error: String,
    },
    /// The renderer reported an error, such as a command that the device refused, and stopped.
    #[error("the renderer stopped: {error}")]
    Renderer { error: String },
    /// The target image was never prepared for the GPU.
    #[error("the target image is not on the GPU: render at least one frame before capturing")]
    NoTarget,
    /// The picture was asked for in another format than that of the target.
    #[error("the target is {actual:?}: choose {wanted:?} in the settings to capture this way")]
    Format {
        actual: TargetFormat,
        /// Format that the capture needs.
        wanted: TargetFormat,
    },
}

fn wanted_text(wanted: &Option<String>) -> String {
    match wanted {
        Some(name) => format!(" with a name that contains `{name}`"),
        None => String::new(),
    }
}

fn available_text(available: &[String]) -> String {
    if available.is_empty() {
        "none".into()
    } else {
        available.join(", ")
    }
}
