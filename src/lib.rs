//! The lab: what the examples, tests and benches of the plugins share.

pub mod content;
pub mod headless;
pub mod metrics;
pub mod record;
