//! The integration tests of the lab, in one binary.

mod headless;
mod knobs;
mod runner;
mod support;
