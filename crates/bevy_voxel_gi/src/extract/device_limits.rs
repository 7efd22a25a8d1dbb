//! Limits of the device: the resolution that fits its buffers and textures, and whether it runs the passes.

use bevy::{
    prelude::*,
    render::{settings::WgpuLimits, slab_allocator::SlabAllocatorSettings},
};

use super::probe::texture_size;
use crate::{
    prepare::buffers::{largest_buffer, most_bytes},
    settings::{VoxelAlbedo, VoxelGiSettings},
};

/// The resolution of the settings, or the highest one below it whose buffers the device can bind and whose texture it
/// can hold.
pub(super) fn allocatable_resolution(
    settings: &VoxelGiSettings,
    levels: u64,
    patched: bool,
    limits: &WgpuLimits,
) -> u32 {
    let most_bytes = most_bytes(limits);
    let most_texels = limits.max_texture_dimension_3d;
    let bytes = |resolution| largest_buffer(settings, resolution, levels);
    let depth = |resolution| {
        let settings = VoxelGiSettings {
            resolution,
            ..settings.clone()
        };
        texture_size(&settings, levels as usize, patched).depth_or_array_layers
    };
    let mut resolution = settings.resolution;
    while resolution > 8 && (bytes(resolution) > most_bytes || depth(resolution) > most_texels) {
        resolution -= 4;
    }
    if resolution < settings.resolution {
        warn_once!(
            "voxel GI: {levels} cubes of {}³ voxels need a storage buffer of {} MiB and a 3D texture of {} \
             slices, and this device has {} MiB and {most_texels} at most, so {resolution}³ voxels are used. \
             Lower `resolution` or `cascades`",
            settings.resolution,
            bytes(settings.resolution) >> 20,
            depth(settings.resolution),
            most_bytes >> 20,
        );
    }
    resolution
}

/// Keeps Bevy's mesh buffers as small as shaders of this device can read: they grow to 512 MiB by default. Only a mesh
/// that is larger itself cannot be read then.
pub(crate) fn keep_readable(slabs: &mut SlabAllocatorSettings, limits: &WgpuLimits) {
    // By less than this a slab may exceed its largest size, as it has whole vertices.
    const VERTEX: u64 = 1 << 16;
    let most = most_bytes(limits).saturating_sub(VERTEX);
    slabs.max_slab_size = slabs.max_slab_size.min(most);
    slabs.large_threshold = slabs.large_threshold.min(slabs.max_slab_size);
}

/// Storage buffers that the pass with the most of them binds: as many as every WebGPU device has.
const STORAGE_BUFFERS: u32 = 8;

/// The albedo of the settings, or that of materials where the device cannot bind the reprojected one, too.
pub(super) fn bindable_albedo(albedo: VoxelAlbedo, limits: &WgpuLimits) -> VoxelAlbedo {
    let available = limits.max_storage_buffers_per_shader_stage;
    if albedo == VoxelAlbedo::Reprojected && available <= STORAGE_BUFFERS {
        warn_once!(
            "voxel GI: `VoxelAlbedo::Reprojected` takes {} storage buffers in a shader, and this device has \
             {available}, so `VoxelAlbedo::Material` is used",
            STORAGE_BUFFERS + 1
        );
        return VoxelAlbedo::Material;
    }
    albedo
}

/// Whether the device can run the passes, and Bevy reads their light.
pub(crate) fn is_supported(limits: &WgpuLimits) -> bool {
    // Bevy has no irradiance volumes on the web.
    !cfg!(target_arch = "wasm32") && has_compute(limits)
}

fn has_compute(limits: &WgpuLimits) -> bool {
    limits.max_compute_workgroup_size_x >= 64
        && limits.max_storage_textures_per_shader_stage >= 1
        && limits.max_storage_buffers_per_shader_stage >= STORAGE_BUFFERS
}

/// Says once why nothing is lit where this is not supported.
pub(super) fn warn_of_unsupported(limits: &WgpuLimits) {
    if cfg!(target_arch = "wasm32") {
        warn_once!(
            "voxel GI: Bevy reads no irradiance volumes on the web, so nothing is lit by a VoxelGiVolume"
        );
    } else {
        warn_once!(
            "voxel GI: this device runs no compute shaders with {STORAGE_BUFFERS} storage buffers and a storage \
             texture (it has workgroups of {}, {} buffers and {} textures), so nothing is lit by a VoxelGiVolume",
            limits.max_compute_workgroup_size_x,
            limits.max_storage_buffers_per_shader_stage,
            limits.max_storage_textures_per_shader_stage,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{Solver, VoxelLight};

    #[test]
    fn buffers_and_the_texture_stay_within_the_limits_of_the_device() {
        let traced = VoxelGiSettings {
            resolution: 128,
            ..default()
        };
        let propagated = VoxelGiSettings {
            light: VoxelLight::GlobalIllumination {
                solver: Solver::Propagate { iterations: 8 },
                bounces: default(),
            },
            ..traced.clone()
        };
        let limits = |mebibytes: u64, texels| WgpuLimits {
            max_storage_buffer_binding_size: mebibytes << 20,
            max_buffer_size: 1 << 30,
            max_texture_dimension_3d: texels,
            ..default()
        };
        for (settings, mebibytes, texels, levels, expected) in [
            // 8 bytes per voxel: 16 MiB.
            (&traced, 16, 2048, 1, 128),
            (&traced, 15, 2048, 1, 124),
            // 96 bytes per voxel: 192 MiB.
            (&propagated, 192, 2048, 1, 128),
            (&propagated, 128, 2048, 1, 108),
            (&traced, 0, 2048, 1, 8),
            // Three slices and a quarter per voxel.
            (&traced, 128, 2048, 4, 128),
            (&traced, 128, 2048, 5, 124),
            (&traced, 128, 2048, 8, 76),
            (&traced, 128, 256, 1, 76),
        ] {
            let limits = limits(mebibytes, texels);
            let found = allocatable_resolution(settings, levels, true, &limits);
            assert_eq!(
                found, expected,
                "{mebibytes} MiB, {texels} texels, {levels} levels"
            );
        }
    }

    #[test]
    fn buffers_of_meshes_are_as_large_as_shaders_can_read() {
        let kept = |mebibytes: u64| {
            let mut slabs = SlabAllocatorSettings::default();
            let limits = WgpuLimits {
                max_storage_buffer_binding_size: mebibytes << 20,
                max_buffer_size: 1 << 40,
                ..default()
            };
            keep_readable(&mut slabs, &limits);
            (slabs.max_slab_size, slabs.large_threshold)
        };
        assert_eq!(kept(4096), (512 << 20, 256 << 20));
        let (largest, alone) = kept(128);
        assert!(largest < 128 << 20 && largest > 127 << 20 && alone <= largest);
    }

    #[test]
    fn reprojected_albedo_needs_one_more_buffer() {
        let with = |buffers| WgpuLimits {
            max_storage_buffers_per_shader_stage: buffers,
            ..default()
        };
        let reprojected = VoxelAlbedo::Reprojected;
        assert_eq!(bindable_albedo(reprojected, &with(9)), reprojected);
        assert_eq!(
            bindable_albedo(reprojected, &with(8)),
            VoxelAlbedo::Material
        );
        let neutral = VoxelAlbedo::Neutral;
        assert_eq!(bindable_albedo(neutral, &with(8)), neutral);
    }

    #[test]
    fn devices_without_compute_are_left_alone() {
        assert!(has_compute(&WgpuLimits {
            max_storage_buffers_per_shader_stage: STORAGE_BUFFERS,
            ..default()
        }));
        assert!(!has_compute(&WgpuLimits::downlevel_webgl2_defaults()));
    }
}
