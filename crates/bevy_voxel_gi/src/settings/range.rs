//! How values are brought into their ranges.

/// Returns a value within its range, or `otherwise` if it is not finite.
pub(super) fn clamped_or(value: f32, least: f32, most: f32, otherwise: f32) -> f32 {
    if value.is_finite() {
        value.clamp(least, most)
    } else {
        otherwise
    }
}
