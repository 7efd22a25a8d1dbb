//! A picture of floats without alpha.

use bevy_ycocg_fb::reference::image::mirrored;
use image::{Rgb, RgbImage};

use crate::headless::Rgba32FImage;

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

    /// The colour of a pixel; beyond the border, of the nearest one.
    pub fn clamped(&self, x: i64, y: i64) -> [f32; 3] {
        let clamp = |i: i64, side: u32| i.clamp(0, i64::from(side) - 1) as u32;
        self.at(clamp(x, self.size[0]), clamp(y, self.size[1]))
    }

    /// The colour of a pixel; beyond the border, of its mirror image at the outermost pixels.
    pub fn mirrored(&self, x: i64, y: i64) -> [f32; 3] {
        self.at(mirrored(x, self.size[0]), mirrored(y, self.size[1]))
    }

    /// The same picture with every channel changed.
    pub fn map(&self, channel: impl Fn(f32) -> f32) -> Self {
        Self {
            size: self.size,
            pixels: self.pixels.iter().map(|p| p.map(&channel)).collect(),
        }
    }

    /// The same picture at another exposure.
    pub fn scaled(&self, factor: f32) -> Self {
        self.map(|channel| channel * factor)
    }
}

impl Frame {
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
