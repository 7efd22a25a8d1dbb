//! The HDR frame buffer in two channels instead of four.
//!
//! Every fragment is stored as its luminance and one of its two chrominances, in a checkerboard,
//! as it is shaded; a filter reconstructs the missing chrominance afterwards (P. Mavridis,
//! *Efficient Texture Representation and Sampling Algorithms for Real-time Rendering*, 2013,
//! chapter 4).
//!
//! | room | what is in it |
//! | --- | --- |
//! | [`settings`] | what a user chooses |
//! | [`reference`](mod@reference) | packing and reconstruction in plain Rust |

pub mod reference;
pub mod settings;

pub use settings::{MsaaResolve, PackedFormat, Reconstruction, YCoCgFrameBuffer};
