//! Conversion of pixels to the planes of a content.

use rayon::prelude::*;

use super::{axes::ColorAxes, image::Content, plane::Plane, source::Pixels};

/// The planes of one mip level, all at its size.
pub(super) struct LevelPlanes {
    /// Luma (then alpha), gray, or X and Y of normals.
    pub(super) luma: Vec<Plane>,
    /// The two planes of chroma; empty where the content has no chroma.
    pub(super) chroma: Vec<Plane>,
}

impl LevelPlanes {
    /// Converts given pixels.
    pub(super) fn given(
        pixels: &Pixels<'_>,
        size: [u32; 2],
        content: Content,
        axes: ColorAxes,
    ) -> Self {
        Self::new(size, content, axes, |i| pixels.get(i))
    }

    /// Converts the pixels that a function returns.
    pub(super) fn new(
        size: [u32; 2],
        content: Content,
        axes: ColorAxes,
        pixel: impl Fn(usize) -> [f32; 4] + Sync,
    ) -> Self {
        let plane = |value: &(dyn Fn([f32; 4]) -> f32 + Sync)| Plane {
            size,
            values: (0..size[0] as usize * size[1] as usize)
                .into_par_iter()
                .map(|i| value(pixel(i)))
                .collect(),
        };
        let weights = axes.weights();
        let along = |axis: usize| {
            let [r, g, b] = weights[axis];
            plane(&move |p| r * p[0] + g * p[1] + b * p[2])
        };
        let luma = match content {
            Content::Gray | Content::Color => vec![along(0)],
            Content::ColorAlpha => vec![along(0), plane(&|p| p[3])],
            Content::Normal => vec![plane(&|p| unit(p)[0]), plane(&|p| unit(p)[1])],
        };
        let chroma = if content.has_chroma() {
            vec![along(1), along(2)]
        } else {
            Vec::new()
        };
        Self { luma, chroma }
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
