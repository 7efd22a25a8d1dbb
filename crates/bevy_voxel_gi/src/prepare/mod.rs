//! Plans what a frame computes, and prepares what the passes share.
//!
//! | module | what it contains |
//! | --- | --- |
//! | [`asset_notes`] | what Bevy's assets on the GPU do not keep |
//! | [`materials`], [`tiles`] | materials as the voxelisers read them, and small copies of their textures and of those of lights |
//! | [`mesh_instance`] | a mesh in the levels and in the GPU's buffers, as the voxelisers read it |
//! | [`mesh_group`] | meshes that share their buffers |
//! | [`mesh_batches`] | the meshes, grouped for dispatch |
//! | [`voxelization`] | the voxels that are voxelised anew, and whether these are all |
//! | [`settling`] | the clock that says when the light has settled |
//! | [`level_table`] | the placement of the levels, for pixels |
//! | [`plan`] | what this frame computes, and whether anything has changed that the light depends on |
//! | [`uniforms`] | the uniforms of the volume, and the lights |
//! | [`buffers`] | the buffers of the volume, and what is counted in them |

pub(crate) mod asset_notes;
pub(crate) mod buffers;
mod level_table;
pub(crate) mod materials;
pub(crate) mod mesh_batches;
pub(crate) mod mesh_group;
mod mesh_instance;
pub(crate) mod plan;
mod settling;
pub(crate) mod tiles;
pub(crate) mod uniforms;
pub(crate) mod voxelization;
