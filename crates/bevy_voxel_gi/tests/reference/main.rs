//! Tests of the CPU reference against analytic results and against path tracing.

mod area;
mod curved;
mod emitters;
mod extremes;
mod noise;
mod propagate;
mod ray_tracing;
mod specular;
mod stochastic;
mod support;
mod truth;
mod voxelize;
mod walls;
