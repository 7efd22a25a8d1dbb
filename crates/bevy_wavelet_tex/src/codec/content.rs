//! The kind of data in an image.

use serde::{Deserialize, Serialize};

use super::decoder::normal_from_xy;

/// The kind of data in an image, which decides its planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Content {
    /// A single channel.
    Gray,
    /// Colour, stored as luma and downsampled chroma.
    Color,
    /// Colour with an alpha channel, which is stored as luma is.
    ColorAlpha,
    /// Unit normals in tangent space: X and Y are stored, Z is reconstructed.
    Normal,
}

impl Content {
    /// Number of planes in the luma group, which is the number of layers of its textures.
    pub fn luma_planes(self) -> usize {
        match self {
            Self::Gray | Self::Color => 1,
            Self::ColorAlpha | Self::Normal => 2,
        }
    }

    /// Name of the content in the tool's output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gray => "gray",
            Self::Color => "color",
            Self::ColorAlpha => "color_alpha",
            Self::Normal => "normal",
        }
    }

    /// Number of channels over which errors are measured.
    #[cfg(feature = "encode")]
    pub(super) fn error_channels(self) -> usize {
        match self {
            Self::Gray => 1,
            Self::Color | Self::Normal => 3,
            Self::ColorAlpha => 4,
        }
    }

    /// A pixel of the channels of a plain texture: RGBA, or X, Y and Z.
    pub(super) fn of_channels(self, [r, g, b, a]: [f32; 4]) -> [f32; 4] {
        match self {
            Self::Gray => [r, r, r, 1.0],
            Self::Color => [r, g, b, 1.0],
            Self::ColorAlpha => [r, g, b, a],
            Self::Normal => {
                let [x, y, z] = normal_from_xy([2.0 * r - 1.0, 2.0 * g - 1.0]);
                [x, y, z, 1.0]
            }
        }
    }

    /// Returns whether the image has a chroma group.
    pub fn has_chroma(self) -> bool {
        matches!(self, Self::Color | Self::ColorAlpha)
    }
}

/// The transfer function of an image's values, which decides when they are filtered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ColorSpace {
    /// sRGB-encoded colour, which is decoded, then linearised, then filtered.
    #[default]
    Srgb,
    /// Linear data (masks, normals), which is filtered without a conversion.
    Linear,
}
