//! Packing and reconstruction in plain Rust: what the shaders are tested against.
