//! Packed frame buffers: pictures against those of Bevy's own.

mod basics;
mod scene;
