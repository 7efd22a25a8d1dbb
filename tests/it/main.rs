//! The integration tests of the lab and of the plugins, in one binary.

mod headless;
mod support;
mod wavelet_tex;
