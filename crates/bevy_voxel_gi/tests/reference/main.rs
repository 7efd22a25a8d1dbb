//! Tests of the CPU reference against analytic results and against path tracing.

mod curved;
mod extremes;
mod march;
mod propagate;
mod support;
mod truth;
mod voxelize;
