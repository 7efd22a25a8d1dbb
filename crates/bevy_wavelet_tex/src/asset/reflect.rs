//! Reflection of the types of the codec, which does without Bevy, as values without fields.

use bevy::reflect::impl_reflect_opaque;

use crate::codec::{
    axes::ColorAxes,
    blocks::BlockFormat,
    image::{ColorSpace, Content},
    packing::Packing,
    quantizer::PlaneCoding,
};

impl_reflect_opaque!((in bevy_wavelet_tex::codec::axes) ColorAxes(Clone, Debug, PartialEq));
impl_reflect_opaque!((in bevy_wavelet_tex::codec::blocks) BlockFormat(Clone, Debug, PartialEq));
impl_reflect_opaque!((in bevy_wavelet_tex::codec::image) ColorSpace(Clone, Debug, PartialEq));
impl_reflect_opaque!((in bevy_wavelet_tex::codec::image) Content(Clone, Debug, PartialEq));
impl_reflect_opaque!((in bevy_wavelet_tex::codec::packing) Packing(Clone, Debug, PartialEq));
impl_reflect_opaque!((in bevy_wavelet_tex::codec::quantizer) PlaneCoding(Clone, Debug, PartialEq));
