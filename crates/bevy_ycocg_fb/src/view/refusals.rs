//! The formats that drawing a camera has shown to be impossible.

use bevy::{platform::collections::HashMap, prelude::*};

use super::candidate::Candidate;
use crate::{
    fallback::FallbackReason,
    material::detect::PackingShaders,
    settings::{FrameBufferFormat, FrameBufferQuality},
};

/// What was refused, by camera in the main world. A camera is tried again when its quality changes, and when the
/// shader that did not pack does.
#[derive(Resource, Debug, Default)]
pub(crate) struct Refusals {
    found: HashMap<(Entity, FrameBufferFormat), Refusal>,
    /// Generation of the shaders for which `found` is valid.
    generation: u64,
}

#[derive(Debug)]
struct Refusal {
    reason: FallbackReason,
    /// The shader that does not pack.
    shader: Option<AssetId<Shader>>,
    /// Quality of the camera, once it is known.
    quality: Option<Option<FrameBufferQuality>>,
}

impl Refusals {
    pub(crate) fn add(
        &mut self,
        camera: Entity,
        format: FrameBufferFormat,
        reason: FallbackReason,
        shader: Option<AssetId<Shader>>,
    ) {
        self.found.entry((camera, format)).or_insert(Refusal {
            reason,
            shader,
            quality: None,
        });
    }

    pub(super) fn get(&self, camera: Entity, format: FrameBufferFormat) -> Option<FallbackReason> {
        self.found
            .get(&(camera, format))
            .map(|refusal| refusal.reason.clone())
    }

    pub(super) fn keep_current(&mut self, candidates: &Query<Candidate>, shaders: &PackingShaders) {
        if self.found.is_empty() {
            return;
        }
        let is_new = self.generation != shaders.generation();
        self.generation = shaders.generation();
        self.found.retain(|&(camera, _), refusal| {
            let mut cameras = candidates.iter();
            let Some(candidate) = cameras.find(|c| c.main_entity.id() == camera) else {
                return false;
            };
            let quality = candidate.quality.copied();
            let packs_now = is_new
                && refusal
                    .shader
                    .is_some_and(|shader| shaders.contains(shader));
            *refusal.quality.get_or_insert(quality) == quality && !packs_now
        });
    }
}
