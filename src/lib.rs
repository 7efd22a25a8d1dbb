//! The lab: what the examples, tests and benches of the plugins share.

pub mod content;
pub mod metrics;
