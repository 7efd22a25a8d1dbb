//! The receiver: what Bevy's irradiance volumes call where the texture is that of a
//! [`VoxelGiVolume`](crate::VoxelGiVolume).

pub(crate) mod features;
mod patch;

pub(crate) use patch::{LIGHTMAP_PATCH, RECEIVER_PATCH, lightmap_patch, receiver_patch};
