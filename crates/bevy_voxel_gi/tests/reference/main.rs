//! The plugin in plain Rust, against analysis and against path tracing.

mod curved;
mod extremes;
mod march;
mod propagate;
mod support;
mod truth;
mod voxelize;
