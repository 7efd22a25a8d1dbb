//! Tests of the `wavelet-tex` tool, run as its users run it.

mod batch;
mod errors;
mod gltf;
mod inputs;
mod measurements;
mod round_trips;
mod support;
