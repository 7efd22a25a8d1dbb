//! The volume: where it is, what it stores, and what is computed in a frame.

pub(crate) mod gpu;
pub(crate) mod placement;
pub(crate) mod plan;
pub(crate) mod probe;
pub(crate) mod scroll;
mod texture;

/// Factor of all stored light, so that 16-bit floats hold what a sunlit scene has: up to
/// 65504 · 64 = 4.2 million cd/m², down to 64 · 6·10⁻⁸ = 4·10⁻⁶ cd/m².
pub(crate) const STORAGE_SCALE: f32 = 1.0 / 64.0;
