//! The codings of planes as bytes.

use crate::codec::{haar::Transform, quantizer::PlaneCoding};

/// The reason why codings are refused.
pub(super) const INVALID_CODINGS: &str = "its key wtex.codings is out of range";

/// Key of the planes' codings, which plain textures lack. For each plane the value has ten `f32`, little-endian: low_min,
/// low_max, range, gamma, the zero points of R, G and B, the predictor, the transform (0 Haar, 1
/// partially inverted Haar) and its w (0 for Haar).
pub(super) const CODINGS_KEY: &str = "wtex.codings";
const CODING_FLOATS: usize = 10;
pub(super) const CODING_BYTES: usize = 4 * CODING_FLOATS;

pub(super) fn coding_bytes(coding: &PlaneCoding) -> [u8; CODING_BYTES] {
    let (kind, w) = match coding.transform {
        Transform::Haar => (0.0, 0.0),
        Transform::PartiallyInvertedHaar { w } => (1.0, w),
    };
    let [r, g, b] = coding.zero_point;
    let fields: [f32; CODING_FLOATS] = [
        coding.low_min,
        coding.low_max,
        coding.range,
        coding.gamma,
        r,
        g,
        b,
        coding.predictor,
        kind,
        w,
    ];
    let mut bytes = [0; CODING_BYTES];
    bytes
        .as_chunks_mut::<4>()
        .0
        .iter_mut()
        .zip(fields)
        .for_each(|(b, f)| *b = f.to_le_bytes());
    bytes
}

pub(super) fn read_coding(bytes: &[u8]) -> Option<PlaneCoding> {
    let (fields, []) = bytes.as_chunks::<4>() else {
        return None;
    };
    let fields: Vec<f32> = fields.iter().map(|b| f32::from_le_bytes(*b)).collect();
    let &[low_min, low_max, range, gamma, r, g, b, predictor, kind, w] = fields.as_slice() else {
        return None;
    };
    let transform = match kind {
        0.0 => Transform::Haar,
        1.0 => Transform::PartiallyInvertedHaar { w },
        _ => return None,
    };
    Some(PlaneCoding {
        low_min,
        low_max,
        range,
        gamma,
        zero_point: [r, g, b],
        predictor,
        transform,
    })
}
