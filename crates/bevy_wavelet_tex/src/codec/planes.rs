//! Conversion of pixels to the planes of a content.

use rayon::prelude::*;

use super::{
    axes::ColorAxes, image::Content, layout, plane::Plane, source::Pixels, source::Source,
};

/// The pixels of one mip level, from which its planes are made where they are needed: all planes together would
/// take several times the memory of the pixels.
#[derive(Clone, Copy)]
pub(super) struct LevelPlanes<'a> {
    pub(super) size: [u32; 2],
    pixels: Pixels<'a>,
    pub(super) content: Content,
    /// The weights of R, G and B in luma and in each plane of chroma.
    weights: [[f32; 3]; 3],
}

impl<'a> LevelPlanes<'a> {
    pub(super) fn new(
        pixels: Pixels<'a>,
        size: [u32; 2],
        content: Content,
        axes: ColorAxes,
    ) -> Self {
        Self {
            size,
            pixels,
            content,
            weights: axes.weights(),
        }
    }

    /// The levels of a source.
    pub(super) fn of(source: &Source<'a>, content: Content, axes: ColorAxes) -> Vec<Self> {
        let level = |(level, pixels): (usize, &Pixels<'a>)| {
            let size = layout::mip_size(source.size, level as u32);
            Self::new(*pixels, size, content, axes)
        };
        source.levels.iter().enumerate().map(level).collect()
    }

    /// A plane of the luma group: luma (then alpha), gray, or X and Y of normals.
    pub(super) fn luma(&self, plane: usize) -> Plane {
        let values = 0..self.pixels.len();
        let values = values.into_par_iter().map(|i| {
            let pixel = self.pixels.get(i);
            match (self.content, plane) {
                (Content::Normal, plane) => unit(pixel)[plane],
                (Content::ColorAlpha, 1) => pixel[3],
                _ => self.along(0, pixel),
            }
        });
        Plane {
            size: self.size,
            values: values.collect(),
        }
    }

    /// A pixel of a plane of chroma.
    pub(super) fn chroma(&self, plane: usize, i: usize) -> f32 {
        self.along(1 + plane, self.pixels.get(i))
    }

    fn along(&self, axis: usize, pixel: [f32; 4]) -> f32 {
        let [r, g, b] = self.weights[axis];
        r * pixel[0] + g * pixel[1] + b * pixel[2]
    }
}

/// The normal that a pixel stands for. The zero vector has no direction and becomes +Z.
pub(super) fn unit([x, y, z, _]: [f32; 4]) -> [f32; 3] {
    let v = [x, y, z].map(|v| 2.0 * v - 1.0);
    let length = v.iter().map(|v| v * v).sum::<f32>().sqrt();
    if length > 1e-6 {
        v.map(|v| v / length)
    } else {
        [0.0, 0.0, 1.0]
    }
}
