//! What a headless app is asked for.

use std::time::Duration;

use bevy::render::render_resource::TextureFormat;

/// Pixel format of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TargetFormat {
    /// Eight bits a channel, sRGB encoded: what a display would show.
    #[default]
    Srgb8,
    /// 32-bit floats, linear. The scene decides on tone mapping.
    Float32,
    /// 16-bit floats, linear. The scene decides on tone mapping.
    Float16,
}

impl TargetFormat {
    pub fn texture_format(self) -> TextureFormat {
        match self {
            Self::Srgb8 => TextureFormat::Rgba8UnormSrgb,
            Self::Float32 => TextureFormat::Rgba32Float,
            Self::Float16 => TextureFormat::Rgba16Float,
        }
    }
}

/// Settings of a [`HeadlessApp`](super::HeadlessApp).
#[derive(Clone, Debug)]
pub struct HeadlessSettings {
    /// Width of the picture in pixels, 1 to the adapter's limit. Default 640.
    pub width: u32,
    /// Height of the picture in pixels, 1 to the adapter's limit. Default 360.
    pub height: u32,
    /// Pixel format of the picture. Default [`TargetFormat::Srgb8`].
    pub format: TargetFormat,
    /// Part of the adapter's name, in any case. Default none: the fastest adapter. The
    /// environment variable `WGPU_ADAPTER_NAME` has precedence, as in Bevy.
    pub adapter_name: Option<String>,
    /// Features that the device must not have even if the adapter does, to test fall-backs.
    /// Default none.
    pub disabled_features: wgpu::Features,
    /// Limits that the device must not exceed even if the adapter does. Default none.
    pub constrained_limits: Option<wgpu::Limits>,
    /// Time between two frames as the scene sees it. Default 1/60 s.
    pub time_step: Duration,
    /// Longest wait for the GPU to finish a frame. Default 60 s.
    pub gpu_timeout: Duration,
    /// Whether pipelines compile in the background while frames go on, as in a game. Default `false`: a frame waits
    /// for what it needs.
    pub compiles_in_background: bool,
    /// Folder of the assets, absolute or relative to the package. Default `assets`.
    pub asset_folder: String,
}

impl Default for HeadlessSettings {
    fn default() -> Self {
        Self {
            width: 640,
            height: 360,
            format: TargetFormat::default(),
            adapter_name: None,
            disabled_features: wgpu::Features::empty(),
            constrained_limits: None,
            time_step: Duration::from_nanos(1_000_000_000 / 60),
            gpu_timeout: Duration::from_secs(60),
            compiles_in_background: false,
            asset_folder: "assets".into(),
        }
    }
}

impl HeadlessSettings {
    /// Default settings with a picture of `width` by `height` pixels.
    pub fn with_size(width: u32, height: u32) -> Self {
        Self {
            width,
            height,
            ..Self::default()
        }
    }
}
