//! A picture of floats without alpha.

use image::{Rgb, RgbImage};

use bevy_frugal_lab::headless::Rgba32FImage;

/// A picture of floats: scene-linear as a camera draws it, or sRGB-encoded as a display shows it.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Red, green and blue, row after row from the top left.
    pub pixels: Vec<[f32; 3]>,
}

impl Frame {
    /// A picture whose colours come from pixel positions.
    pub fn from_fn(size: [u32; 2], color: impl Fn(u32, u32) -> [f32; 3]) -> Self {
        let positions = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
        Self {
            size,
            pixels: positions.map(|(x, y)| color(x, y)).collect(),
        }
    }

    /// The colour of a pixel.
    pub fn at(&self, x: u32, y: u32) -> [f32; 3] {
        self.pixels[(y * self.size[0] + x) as usize]
    }

    /// The same picture with every channel changed.
    pub fn map(&self, channel: impl Fn(f32) -> f32) -> Self {
        Self {
            size: self.size,
            pixels: self.pixels.iter().map(|p| p.map(&channel)).collect(),
        }
    }

    /// An encoded picture, rounded to 8 bits.
    pub fn to_rgb8(&self) -> RgbImage {
        let byte = |channel: f32| (channel.clamp(0.0, 1.0) * 255.0).round() as u8;
        RgbImage::from_fn(self.size[0], self.size[1], |x, y| {
            Rgb(self.at(x, y).map(byte))
        })
    }
}

impl From<&Rgba32FImage> for Frame {
    fn from(image: &Rgba32FImage) -> Self {
        Self {
            size: [image.width, image.height],
            pixels: image.pixels.iter().map(|p| [p[0], p[1], p[2]]).collect(),
        }
    }
}
