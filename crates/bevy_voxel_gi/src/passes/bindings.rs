//! The bindings that several passes share, with the numbers of `bindings.wesl`.

use bevy::{
    ecs::system::SystemParam,
    prelude::*,
    render::{
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupEntry, BindGroupLayoutDescriptor,
            BindGroupLayoutEntries, BindGroupLayoutEntryBuilder, BindingResource,
            IntoIndexedBindGroupLayoutEntryBuilderArray, IntoIndexedBindingArray, PipelineCache,
            SamplerBindingType, ShaderStages, StorageTextureAccess, TextureFormat,
            TextureSampleType,
            binding_types::{
                sampler, storage_buffer_read_only_sized, storage_buffer_sized, texture_cube,
                texture_storage_3d, uniform_buffer,
            },
        },
        renderer::RenderDevice,
    },
};

use crate::{
    gpu_types::{Changes, Volume},
    prepare::{buffers::VolumeBuffers, plan::FramePlan, uniforms::VolumeUniforms},
};

// Group 0.
pub(crate) const VOLUME: u32 = 0;
pub(crate) const MASKS: u32 = 1;
pub(crate) const PACKED_SURFACES: u32 = 2;
pub(crate) const FACE_SLOTS: u32 = 3;
pub(crate) const REPROJECTED_ALBEDO: u32 = 4;
pub(crate) const SUMS: u32 = 5;
// Group 1.
pub(crate) const WORK: u32 = 0;
pub(crate) const RADIANCE: u32 = 2;
pub(crate) const IRRADIANCE: u32 = 3;
pub(crate) const COLORS: u32 = 4;
pub(crate) const LIGHTS: u32 = 5;
pub(crate) const LIGHT_TEXTURE: u32 = 6;
/// No pass binds both tiles and changes, so they have one number.
pub(crate) const TILES: u32 = 7;
pub(crate) const CHANGES: u32 = 7;
pub(crate) const DIRTY: u32 = 8;
pub(crate) const VISIBLE: u32 = 10;
pub(crate) const SKY_MAP: u32 = 11;
pub(crate) const SKY_SAMPLER: u32 = 12;
pub(crate) const SLOT_LISTS: u32 = 13;

pub(crate) fn read_only() -> BindGroupLayoutEntryBuilder {
    storage_buffer_read_only_sized(false, None)
}

pub(super) fn read_write() -> BindGroupLayoutEntryBuilder {
    storage_buffer_sized(false, None)
}

pub(super) fn light_texture() -> BindGroupLayoutEntryBuilder {
    texture_storage_3d(TextureFormat::Rgba16Float, StorageTextureAccess::WriteOnly)
}

pub(crate) fn volume_uniform() -> BindGroupLayoutEntryBuilder {
    uniform_buffer::<Volume>(false)
}

pub(super) fn changes_uniform() -> BindGroupLayoutEntryBuilder {
    uniform_buffer::<Changes>(false)
}

pub(super) fn sky_map() -> BindGroupLayoutEntryBuilder {
    texture_cube(TextureSampleType::Float { filterable: true })
}

pub(super) fn sky_sampler() -> BindGroupLayoutEntryBuilder {
    sampler(SamplerBindingType::Filtering)
}

/// Layout of a bind group of compute shaders, each entry with its number.
pub(super) fn group_layout<const N: usize>(
    label: &'static str,
    entries: impl IntoIndexedBindGroupLayoutEntryBuilderArray<N>,
) -> BindGroupLayoutDescriptor {
    let entries = BindGroupLayoutEntries::with_indices(ShaderStages::COMPUTE, entries);
    BindGroupLayoutDescriptor::new(label, &entries)
}

/// Creates bind groups; their layouts are in the pipeline cache.
#[derive(SystemParam)]
pub(crate) struct BindGroups<'w> {
    pub cache: Res<'w, PipelineCache>,
    pub device: Res<'w, RenderDevice>,
}

impl BindGroups<'_> {
    /// Creates a bind group with the label of its layout, each entry with its number.
    pub fn create<'b, const N: usize>(
        &self,
        layout: &BindGroupLayoutDescriptor,
        entries: impl IntoIndexedBindingArray<'b, N>,
    ) -> BindGroup {
        self.device.create_bind_group(
            layout.label.as_ref(),
            &self.cache.get_bind_group_layout(layout),
            &BindGroupEntries::with_indices(entries),
        )
    }

    /// The same with as many entries as are given.
    pub fn create_of(
        &self,
        layout: &BindGroupLayoutDescriptor,
        entries: Vec<(u32, BindingResource)>,
    ) -> BindGroup {
        let entry = |(binding, resource)| BindGroupEntry { binding, resource };
        let entries: Vec<_> = entries.into_iter().map(entry).collect();
        self.device.create_bind_group(
            layout.label.as_ref(),
            &self.cache.get_bind_group_layout(layout),
            &entries,
        )
    }
}

/// Layout of group 0 in passes that read the voxels, with reprojected albedo or without.
pub(crate) fn voxels_layout(
    label: &'static str,
    stages: ShaderStages,
    reprojects_albedo: bool,
) -> BindGroupLayoutDescriptor {
    let voxels = (
        (VOLUME, volume_uniform()),
        (MASKS, read_only()),
        (PACKED_SURFACES, read_only()),
        (FACE_SLOTS, read_only()),
    );
    let mut entries = BindGroupLayoutEntries::with_indices(stages, voxels).to_vec();
    if reprojects_albedo {
        entries.push(read_only().build(REPROJECTED_ALBEDO, stages));
    }
    BindGroupLayoutDescriptor::new(label, &entries)
}

/// Creates group 0 for one of the bounces.
pub(crate) fn voxels_bind_group(
    layout: &BindGroupLayoutDescriptor,
    bounce: usize,
    uniforms: &VolumeUniforms,
    buffers: &VolumeBuffers,
    groups: &BindGroups,
) -> Option<BindGroup> {
    let mut entries = vec![
        (VOLUME, uniforms.bounces[bounce].binding()?),
        (MASKS, buffers.masks()),
        (PACKED_SURFACES, buffers.packed_surfaces.as_entire_binding()),
        (FACE_SLOTS, buffers.face_slots()),
    ];
    if buffers.shape.reprojects_albedo {
        let albedo = buffers.reprojected_albedo.as_entire_binding();
        entries.push((REPROJECTED_ALBEDO, albedo));
    }
    Some(groups.create_of(layout, entries))
}

/// Group 0 of the passes that compute light.
#[derive(Resource)]
pub(crate) struct VoxelBindGroups {
    /// One for each of [`VolumeUniforms::bounces`].
    pub bounces: [BindGroup; 3],
}

/// Layout of group 0 of the passes that compute light.
pub(super) fn light_voxels_layout(reprojects_albedo: bool) -> BindGroupLayoutDescriptor {
    voxels_layout("voxel_gi_volume", ShaderStages::COMPUTE, reprojects_albedo)
}

/// Creates group 0 of the passes that compute light.
pub(crate) fn prepare_voxel_bind_groups(
    mut commands: Commands,
    plan: Res<FramePlan>,
    buffers: Option<Res<VolumeBuffers>>,
    uniforms: Res<VolumeUniforms>,
    groups: BindGroups,
) {
    let (Some(_), Some(buffers)) = (plan.work, buffers) else {
        commands.remove_resource::<VoxelBindGroups>();
        return;
    };
    let layout = light_voxels_layout(buffers.shape.reprojects_albedo);
    let group = |bounce| voxels_bind_group(&layout, bounce, &uniforms, &buffers, &groups);
    if let (Some(a), Some(b), Some(c)) = (group(0), group(1), group(2)) {
        commands.insert_resource(VoxelBindGroups { bounces: [a, b, c] });
    }
}
