//! Tests of the `wavelet-tex` tool, run as its users run it.

mod alpha;
mod batch;
mod errors;
mod files;
mod gltf;
mod inputs;
mod measurements;
mod roles;
mod round_trips;
mod support;
