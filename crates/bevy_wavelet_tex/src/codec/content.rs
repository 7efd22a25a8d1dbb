//! The kind of data in an image.

use serde::{Deserialize, Serialize};

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
