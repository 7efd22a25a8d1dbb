//! The settings of a camera and its lights.

use bevy::{
    camera::Hdr,
    prelude::*,
    render::{
        RenderApp, extract_component::ExtractComponent, extract_resource::ExtractResource,
        render_resource::ShaderType,
    },
};

/// Largest number of lights; those beyond it are ignored.
pub const MAX_SOURCES: usize = 8;

/// How a camera accumulates the light of the lights before it lights the surface with it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Hash, ExtractComponent)]
#[extract_app(RenderApp)]
#[require(Hdr)]
pub enum LightAccumulation {
    /// Diffuse and specular light in a target each: 16 bytes a pixel.
    Exact,
    /// Both in one target, each as luminance and one chrominance in a checkerboard: 8 bytes a pixel.
    #[default]
    Packed,
    /// Diffuse light and the luminance of specular light in one target: 8 bytes a pixel, and
    /// highlights in the colour of the diffuse light (the shortcut of thesis figure 4.12).
    SpecularLuminance,
}

impl LightAccumulation {
    pub const ALL: [Self; 3] = [Self::Exact, Self::Packed, Self::SpecularLuminance];

    /// Number of four-channel targets.
    pub fn targets(self) -> usize {
        match self {
            Self::Exact => 2,
            Self::Packed | Self::SpecularLuminance => 1,
        }
    }

    /// Bytes of all its targets, a pixel.
    pub fn bytes_per_pixel(self) -> u64 {
        8 * self.targets() as u64
    }
}

/// A light without extent.
#[derive(Clone, Copy, Debug, Default, PartialEq, ShaderType)]
pub struct LightSource {
    /// Position in metres.
    pub position: Vec3,
    /// Scene-linear light at a distance of one metre.
    pub intensity: Vec3,
}

/// The lights, [`MAX_SOURCES`] at most. Default: none.
#[derive(Resource, Clone, Debug, Default, PartialEq, ExtractResource)]
#[extract_app(RenderApp)]
pub struct LightSources(pub Vec<LightSource>);
