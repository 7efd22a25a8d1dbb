//! The edges of the plugins' domains, with all four in one app: sizes, magnitudes, geometry that is
//! none, values that are no numbers, and hundreds of switches. Whatever is put in, the picture is
//! finite, as near to Bevy's own as it should be, and nothing is left behind.
//!
//! What each plugin does at the edges that are its own is beside its other tests (`tests/it`,
//! `crates/*/tests`); `docs/extremes.md` lists all.

mod geometry;
mod magnitudes;
mod sizes;
mod stage;
mod switches;
