//! The study of `bevy_ewa`.

pub mod lookup;
