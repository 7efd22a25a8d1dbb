//! Whether rays of direct light need occupancy masks of their own, as some meshes cast no shadow.

use bevy::{ecs::system::SystemParam, prelude::*, render::renderer::RenderDevice};

use super::{
    buffers::{BufferShape, most_bytes},
    mesh_batches::MeshBatches,
};

/// Decides it for a frame.
#[derive(SystemParam)]
pub(crate) struct ShadowMasks<'w> {
    batches: Res<'w, MeshBatches>,
    device: Res<'w, RenderDevice>,
}

/// The shader def of the passes that write or read these masks.
pub(crate) const SHADOW_MASKS: &str = "SHADOW_MASKS";

impl ShadowMasks<'_> {
    /// See [`are_needed`].
    pub(crate) fn are_needed(&self, shape: BufferShape) -> bool {
        are_needed(shape, &self.batches, &self.device)
    }

    /// The shader def, where they are.
    pub(crate) fn defs(&self, shape: BufferShape) -> Option<&'static str> {
        self.are_needed(shape).then_some(SHADOW_MASKS)
    }
}

/// Whether the masks of meshes that cast shadows are behind those of all meshes.
pub(crate) fn are_needed(shape: BufferShape, batches: &MeshBatches, device: &RenderDevice) -> bool {
    if shape.occlusion_only || !batches.have_mesh_without_shadow() {
        return false;
    }
    let most = most_bytes(device);
    let fits = shape.mask_bytes(true) <= most;
    if !fits {
        warn_once!(
            "voxel GI: `NotShadowCaster` takes a storage buffer of {} MiB, and this device binds {} MiB at most, so \
             such meshes cast shadows. Lower `resolution` or `cascades`",
            shape.mask_bytes(true) >> 20,
            most >> 20,
        );
    }
    fits
}
