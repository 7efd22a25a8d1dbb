//! Plans what a frame computes, and prepares what the passes share.
//!
//! | module | what it contains |
//! | --- | --- |
//! | [`pipelines`] | whether all pipelines of a frame are ready |
//! | [`asset_notes`] | what Bevy's assets on the GPU do not keep |
//! | [`materials`], [`tiles`] | materials as the voxelisers read them, and small copies of their textures |
//! | [`light_tiles`] | the same of the textures of lights |
//! | [`mesh_instance`] | a mesh in the levels and in the GPU's buffers, as the voxelisers read it |
//! | [`mesh_group`] | meshes that share their buffers |
//! | [`mesh_batches`] | the meshes, grouped for dispatch |
//! | [`dirty_voxels`], [`voxelization`] | the voxels that are voxelised anew, and whether these are all |
//! | [`fingerprint`] | whether anything has changed that the light depends on |
//! | [`settling`] | the clock that says when the light has settled |
//! | [`level_table`] | the placement of the levels, for pixels |
//! | [`plan`] | what this frame computes |
//! | [`uniforms`] | the uniforms of the volume |
//! | [`buffers`] | the buffers of the volume |
//! | [`shadow_masks`] | whether some meshes cast no shadow, which takes more of them |
//! | [`scene_buffers`] | lights on the GPU |

pub(crate) mod asset_notes;
pub(crate) mod buffers;
mod dirty_voxels;
pub(crate) mod fingerprint;
mod level_table;
pub(crate) mod light_tiles;
pub(crate) mod materials;
pub(crate) mod mesh_batches;
pub(crate) mod mesh_group;
mod mesh_instance;
pub(crate) mod pipelines;
pub(crate) mod plan;
pub(crate) mod scene_buffers;
mod settling;
pub(crate) mod shadow_masks;
pub(crate) mod tiles;
pub(crate) mod uniforms;
pub(crate) mod voxelization;
