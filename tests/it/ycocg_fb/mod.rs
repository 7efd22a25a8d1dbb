//! Packed frame buffers: pictures against those of Bevy's own.

mod cameras;
mod effects;
mod exact;
mod extremes;
mod fallback;
mod flashes;
mod flat;
mod formats;
mod games;
mod materials;
mod rg11b10ufloat;
mod scene;
mod stacks;
mod switching;
