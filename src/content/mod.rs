//! Procedural test content: materials and a photograph, made from a seed.
//!
//! Examples, tests and benches need images with the detail of real ones, but a repository should
//! not carry binary assets of several licences. So every image is computed: a pure function of
//! size and seed, the same bytes for the same arguments, at any size from 1x1 upwards (none at all
//! for a side of 0). A different seed gives another image of the same kind.
//!
//! | function | material | tiles | what it tests |
//! | --- | --- | --- | --- |
//! | [`bricks()`] | brick wall | yes | regular edges, fine grain, strong relief |
//! | [`wood()`] | plank floor | yes | directional detail |
//! | [`foliage()`] | leaves with gaps | yes | opacity, saturated greens, sharp veins |
//! | [`noise()`] | fractal rock | yes | detail of all scales at once |
//! | [`text()`] | printed page | no | thin strokes, hard edges |
//! | [`gradients()`] | smooth ramps | no | banding, dark tones, saturated hues |
//! | [`decals()`] | painted signs | yes | saturated edges of equal luma, thin coloured lines, flat colour |
//! | [`packed_maps()`] | occlusion, roughness, metallic | yes | uncorrelated channels |
//! | [`photo_like()`] | landscape | no | the statistics of a photograph |
//!
//! Surfaces are described as functions of a point (colour, height and coverage) in units of the
//! image's short side, sampled four times a pixel; normals are the central differences of the
//! heights. Sizes of details are thus relative to the image, and its resolution only sharpens it.
//!
//! [`mipped_texture`] makes a texture of an image, [`label`] one of a line of text.

pub use crate::content::{
    bricks::bricks,
    foliage::foliage,
    material::Material,
    patterns::{decals, gradients, noise},
    photo::photo_like,
    text::text,
    texture::{label, mipped_texture, packed_maps},
    wood::wood,
};

mod bricks;
mod foliage;
mod lattice;
mod material;
mod patterns;
mod photo;
mod text;
mod texture;
mod wood;

#[cfg(test)]
mod tests;
