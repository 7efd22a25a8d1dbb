//! Tests of the CPU reference against analytic results and against path tracing.

mod curved;
mod emitters;
mod extremes;
mod noise;
mod propagate;
mod ray_tracing;
mod specular;
mod support;
mod truth;
mod voxelize;
mod walls;
