//! Cameras that share a picture.
//!
//! Bevy draws cameras of the same target, format, usages and samples into the same textures. A camera that does not
//! clear them continues the picture that is in them, and so does a multisampled one to which Bevy's MSAA writeback
//! gives it, as it does to the second of two cameras that fill their target. Such cameras must have one format.

use bevy::{
    camera::{MsaaWriteback, NormalizedRenderTarget},
    prelude::*,
    render::render_resource::{TextureFormat, TextureUsages},
};

use super::conditions::CandidateItem;
use crate::report::FallbackReason;

/// What decides with which cameras of its target a camera shares its picture.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layer {
    pub entity: Entity,
    pub target: Option<NormalizedRenderTarget>,
    pub usages: TextureUsages,
    pub format: TextureFormat,
    pub samples: u32,
    pub order: isize,
    pub has_viewport: bool,
    pub has_no_clear: bool,
    pub writeback: MsaaWriteback,
}

impl Layer {
    pub(super) fn of(candidate: &CandidateItem) -> Self {
        Self {
            entity: candidate.entity,
            target: candidate.camera.target.clone(),
            usages: candidate.usages.0,
            format: candidate.view.target_format,
            samples: candidate.msaa.samples(),
            order: candidate.camera.order,
            has_viewport: candidate.camera.viewport.is_some(),
            has_no_clear: candidate.has_no_clear(),
            writeback: candidate.camera.msaa_writeback,
        }
    }

    /// Whether both have the same textures, if their formats are the same.
    pub(super) fn could_share(&self, other: &Self) -> bool {
        self.target == other.target && self.usages == other.usages && self.samples == other.samples
    }

    /// Whether Bevy draws both into the same textures.
    pub(super) fn shares(&self, other: &Self) -> bool {
        self.could_share(other) && self.format == other.format
    }

    /// Whether the camera continues the picture in its textures, if those of `others` have the same. Bevy leaves the
    /// order of cameras of the same order open, so that either may be the first.
    pub(super) fn continues<'a>(&self, mut others: impl Iterator<Item = &'a Self>) -> bool {
        let is_written_back = match self.writeback {
            MsaaWriteback::Off => false,
            MsaaWriteback::Always => true,
            MsaaWriteback::Auto => {
                !self.has_viewport
                    && others.any(|other| other.entity != self.entity && other.order <= self.order)
            }
        };
        self.has_no_clear || (self.samples > 1 && is_written_back)
    }
}

/// Whether any of these cameras, which have the same textures, continues a picture.
pub(super) fn is_continued<'a>(members: impl Iterator<Item = &'a Layer> + Clone) -> bool {
    members
        .clone()
        .any(|member| member.continues(members.clone()))
}

/// Returns the reason for which the camera cannot pack beside the other cameras of its target.
///
/// A packed camera writes a single-sampled `ViewTarget`, in which no later camera finds samples.
pub(super) fn packed_stack_reason(layer: &Layer, layers: &[Layer]) -> Option<FallbackReason> {
    let sharing = layers.iter().filter(|other| other.shares(layer));
    if layer.continues(sharing.clone()) {
        return Some(FallbackReason::MsaaWriteback);
    }
    let is_multisampled = layer.samples > 1;
    // A single-sampled camera that does not clear would find the picture of this one instead of its own.
    let would_be_continued = layers.iter().any(|other| {
        let single_sampled = Layer {
            samples: other.samples,
            ..layer.clone()
        };
        other.samples == 1 && other.has_no_clear && other.shares(&single_sampled)
    });
    (is_multisampled && (is_continued(sharing) || would_be_continued))
        .then_some(FallbackReason::ContinuedByMultisampled)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layer(index: u32, order: isize, samples: u32) -> Layer {
        Layer {
            entity: Entity::from_raw_u32(index).expect("an index"),
            target: None,
            usages: TextureUsages::RENDER_ATTACHMENT,
            format: TextureFormat::Rgba16Float,
            samples,
            order,
            has_viewport: false,
            has_no_clear: false,
            writeback: MsaaWriteback::Auto,
        }
    }

    #[test]
    fn the_later_of_two_multisampled_cameras_continues_unless_it_has_a_viewport() {
        for (samples, has_viewport, writeback, expected) in [
            (4, false, MsaaWriteback::Auto, true),
            (4, true, MsaaWriteback::Auto, false),
            (4, true, MsaaWriteback::Always, true),
            (4, false, MsaaWriteback::Off, false),
            (1, false, MsaaWriteback::Auto, false),
            (1, false, MsaaWriteback::Always, false),
        ] {
            let below = layer(1, 0, samples);
            let above = Layer {
                has_viewport,
                writeback,
                ..layer(2, 1, samples)
            };
            let both = [below, above];
            assert!(!both[0].continues(both.iter()));
            assert_eq!(both[1].continues(both.iter()), expected, "{:?}", both[1]);
        }
    }

    #[test]
    fn a_camera_without_clear_colour_continues() {
        let alone = Layer {
            has_no_clear: true,
            ..layer(1, 0, 1)
        };
        assert!(is_continued([alone].iter()));
        assert!(!is_continued([layer(1, 0, 4)].iter()));
    }

    #[test]
    fn cameras_of_other_formats_or_samples_share_nothing() {
        let hdr = layer(1, 0, 4);
        let ldr = Layer {
            format: TextureFormat::Rgba8UnormSrgb,
            ..layer(2, 1, 4)
        };
        assert!(!hdr.shares(&ldr) && hdr.could_share(&ldr));
        assert!(!hdr.could_share(&layer(2, 1, 1)));
        assert!(hdr.shares(&layer(2, 1, 4)));
    }
}
