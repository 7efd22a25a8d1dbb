//! The receiver: what Bevy's irradiance volumes call where the texture is that of a
//! [`VoxelGiVolume`](crate::VoxelGiVolume).

pub(crate) mod features;
mod patch;

pub(crate) use patch::{
    ENVIRONMENT_PATCH, LIGHTING_PATCH, RECEIVER_PATCH, environment_patch, lighting_patch,
    receiver_patch,
};
