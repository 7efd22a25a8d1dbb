//! Bevy without a window: the same frames on every run.
//!
//! [`HeadlessApp`] owns a Bevy [`App`](bevy::app::App) with the default plugins but no window, no
//! event loop and no second render thread: one call to update is one frame, rendered when it
//! returns. Time advances by a fixed step, pipelines compile synchronously, and the picture lands
//! in an image of a fixed size. What is wrong is said: a missing adapter, a broken pipeline, an
//! asset that fails to load or a GPU that does not answer are values of [`HeadlessError`], not a
//! black picture, a panic or an endless wait.
//!
//! Bevy panics when there is no adapter and silently takes another one when none has the wanted
//! name. So the adapters are listed first, in the way Bevy does it.

use bevy::{render::settings::WgpuSettings, tasks::block_on};
use serde::{Deserialize, Serialize};
use thiserror::Error;

pub use crate::headless::{
    app::{
        AwaitedAssets, AwaitedWork, HeadlessApp, HeadlessSettings, LabTarget, TargetFormat,
        Unwatched, pixel_camera,
    },
    frames::{FrameTimes, Rgba32FImage, median},
};

pub mod app;
pub mod frames;

/// The adapter that renders.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AdapterInfo {
    pub name: String,
    /// Name and version of the driver, as far as it tells.
    pub driver: String,
    /// Interface to it, e.g. `vulkan`.
    pub backend: String,
    /// Kind of device, e.g. `DiscreteGpu` or `Cpu`.
    pub device_type: String,
}

impl From<&wgpu::AdapterInfo> for AdapterInfo {
    fn from(info: &wgpu::AdapterInfo) -> Self {
        Self {
            name: info.name.clone(),
            driver: format!("{} {}", info.driver, info.driver_info)
                .trim()
                .into(),
            backend: info.backend.to_string(),
            device_type: format!("{:?}", info.device_type),
        }
    }
}

/// The settings to give to Bevy, once it is sure that they find an adapter.
pub(crate) fn wgpu_settings(settings: &HeadlessSettings) -> Result<WgpuSettings, HeadlessError> {
    let result = WgpuSettings {
        adapter_name: settings.adapter_name.clone(),
        disabled_features: Some(settings.disabled_features),
        constrained_limits: settings.constrained_limits.clone(),
        ..WgpuSettings::default()
    };
    let all = adapters(result.backends);
    let requested = requested(settings.adapter_name.as_deref());
    let fitting = all.iter().filter(|adapter| fits(adapter, &requested));
    let limit = fitting
        .map(|adapter| adapter.limits().max_texture_dimension_2d)
        .max();
    let Some(limit) = limit else {
        let available = all.iter().map(describe).collect();
        return Err(HeadlessError::NoAdapter {
            requested,
            available,
        });
    };
    let sides = 1..=limit;
    if !sides.contains(&settings.width) || !sides.contains(&settings.height) {
        return Err(HeadlessError::Size {
            width: settings.width,
            height: settings.height,
            limit,
        });
    }
    Ok(result)
}

/// Whether every adapter with `name` in its name, or every adapter at all, draws on the CPU.
pub fn is_software(name: Option<&str>) -> bool {
    let requested = requested(name);
    let all = adapters(WgpuSettings::default().backends);
    let mut fitting = all.iter().filter(|adapter| fits(adapter, &requested));
    fitting.all(|adapter| adapter.get_info().device_type == wgpu::DeviceType::Cpu)
}

fn adapters(backends: Option<wgpu::Backends>) -> Vec<wgpu::Adapter> {
    let backends = backends.unwrap_or(wgpu::Backends::all());
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = backends;
    block_on(wgpu::Instance::new(descriptor).enumerate_adapters(backends))
}

/// Part of the name of the adapter to use, which the environment may override.
fn requested(name: Option<&str>) -> Option<String> {
    let overridden = std::env::var("WGPU_ADAPTER_NAME").ok();
    overridden.or_else(|| name.map(Into::into))
}

fn fits(adapter: &wgpu::Adapter, requested: &Option<String>) -> bool {
    let name = adapter.get_info().name.to_lowercase();
    requested
        .as_ref()
        .is_none_or(|requested| name.contains(&requested.to_lowercase()))
}

fn describe(adapter: &wgpu::Adapter) -> String {
    let info = adapter.get_info();
    format!("{} ({})", info.name, info.backend)
}

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
         WGPU_ADAPTER_NAME", requested_text(.requested), available_text(.available)
    )]
    NoAdapter {
        /// The part of the name that was asked for, if any.
        requested: Option<String>,
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
    #[error("the target is {actual:?}: choose {requested:?} in the settings to capture this way")]
    Format {
        actual: TargetFormat,
        /// Format that the capture needs.
        requested: TargetFormat,
    },
}

fn requested_text(requested: &Option<String>) -> String {
    match requested {
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
