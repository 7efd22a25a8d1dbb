//! The lab: what the examples, tests and benches of the plugins share.

pub mod metrics;
