//! The volume: its placement, its buffers, and the work of a frame.

pub(crate) mod gpu;
pub(crate) mod placement;
pub(crate) mod plan;
pub(crate) mod probe;
pub(crate) mod scroll;
mod texture;

/// Factor of all stored light, so that 16-bit floats cover the range of a sunlit scene: up to
/// 65504 · 64 = 4.2 million cd/m², down to 64 · 6·10⁻⁸ = 4·10⁻⁶ cd/m².
pub(crate) const STORAGE_SCALE: f32 = 1.0 / 64.0;
