//! The integration tests of the lab, in one binary.

mod headless;
mod support;
