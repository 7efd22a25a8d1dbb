//! Elliptical filtering on the GPU.

mod exact;
