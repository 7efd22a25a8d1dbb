//! The scenes that the frame buffer is measured on.
//!
//! | scene | what it is hard for |
//! | --- | --- |
//! | `lit` | nothing in particular: textures, lights and shadows as in a game |
//! | `equal_luminance_edges` | filters that look for edges in luminance: there are none |
//! | `thin_lines` | filters that need a neighbour of the same surface |
//! | `foliage` | all filters: detail as fine as a pixel, in luminance and chrominance |
//! | `hdr_edge` | filters that compare absolute values: 10,000 beside 0 |
//! | `dark` | filters that compare absolute values, and formats: 0.01 on average |

pub use crate::scenes::ycocg_fb::scenes::{scene::TestScene, shapes::add};

mod dark;
mod equal_luminance;
mod foliage;
mod hdr_edge;
mod lit;
mod scene;
mod shapes;
mod thin_lines;

pub const SCENES: [TestScene; 6] = [
    lit::SCENE,
    equal_luminance::SCENE,
    thin_lines::SCENE,
    foliage::SCENE,
    hdr_edge::SCENE,
    dark::SCENE,
];
