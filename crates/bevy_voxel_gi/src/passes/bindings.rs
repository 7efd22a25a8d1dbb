//! The resources that several passes bind, with the numbers of `bindings.wesl`.

use bevy::{
    ecs::system::SystemParam,
    prelude::*,
    render::{
        render_asset::RenderAssets,
        render_resource::{
            BindGroup, BindGroupEntry, BindGroupLayoutDescriptor, BindGroupLayoutEntries,
            BindGroupLayoutEntryBuilder, BindingResource, IntoBinding,
            IntoIndexedBindGroupLayoutEntryBuilderArray, PipelineCache, SamplerBindingType,
            ShaderStages, StorageTextureAccess, TextureFormat, TextureSampleType,
            binding_types::{
                sampler, storage_buffer_read_only_sized, storage_buffer_sized, texture_2d,
                texture_cube, texture_storage_3d, uniform_buffer,
            },
        },
        renderer::RenderDevice,
        texture::GpuImage,
    },
};

use super::draw_sky::SkyCube;
use crate::{
    extract::place_volume::ExtractedVolume,
    gpu_types,
    prepare::{
        buffers::VolumeBuffers, plan::FramePlan, tiles::LightTiles, uniforms::VolumeUniforms,
    },
};

/// A resource that passes bind. Some that no pass binds together have the same number.
#[derive(Clone, Copy)]
pub(crate) enum Binding {
    // Group 0.
    /// One of [`VolumeUniforms::bounces`].
    Volume(usize),
    Masks,
    PackedSurfaces,
    FaceSlots,
    /// The slots with the masks, which follow behind them.
    FaceSlotsAndMasks,
    ReprojectedAlbedo,
    Sums,
    // Group 1.
    Work,
    Radiance,
    Irradiance,
    Colors,
    Lights,
    LightTexture,
    LightTiles,
    Changes,
    Dirty,
    Visible,
    SkyMap,
    SkySampler,
    SlotLists,
    /// Propagated light before a step and after it, in one of the two buffers, and the light that has arrived.
    Before(usize),
    After(usize),
    Arrived,
}

/// How a pass accesses a storage buffer.
#[derive(Clone, Copy)]
pub(crate) enum Access {
    Read,
    Write,
}

impl Binding {
    pub(super) const fn number(self) -> u32 {
        match self {
            Self::Volume(_) | Self::Work => 0,
            Self::Masks => 1,
            Self::PackedSurfaces | Self::Radiance => 2,
            Self::FaceSlots | Self::FaceSlotsAndMasks | Self::Irradiance => 3,
            Self::ReprojectedAlbedo | Self::Colors => 4,
            Self::Sums | Self::Lights => 5,
            Self::LightTexture => 6,
            Self::LightTiles | Self::Changes | Self::Before(_) => 7,
            Self::Dirty | Self::After(_) => 8,
            Self::Arrived => 9,
            Self::Visible => 10,
            Self::SkyMap => 11,
            Self::SkySampler => 12,
            Self::SlotLists => 13,
        }
    }

    fn layout(self, access: Access) -> BindGroupLayoutEntryBuilder {
        match self {
            Self::Volume(_) => uniform_buffer::<gpu_types::Volume>(false),
            Self::Changes => uniform_buffer::<gpu_types::Changes>(false),
            Self::LightTexture => {
                texture_storage_3d(TextureFormat::Rgba16Float, StorageTextureAccess::WriteOnly)
            }
            Self::LightTiles => texture_2d(TextureSampleType::Uint),
            Self::SkyMap => texture_cube(TextureSampleType::Float { filterable: true }),
            Self::SkySampler => sampler(SamplerBindingType::Filtering),
            _ => storage(access),
        }
    }
}

pub(super) fn storage(access: Access) -> BindGroupLayoutEntryBuilder {
    match access {
        Access::Read => storage_buffer_read_only_sized(false, None),
        Access::Write => storage_buffer_sized(false, None),
    }
}

/// The resources of a bind group, and its layout.
pub(crate) struct Group {
    bindings: Vec<Binding>,
    pub layout: BindGroupLayoutDescriptor,
}

impl Group {
    pub(crate) fn of_stages(
        stages: ShaderStages,
        label: &'static str,
        reads: &[Binding],
        writes: &[Binding],
    ) -> Self {
        let entry = |binding: &Binding, access| {
            let layout = binding.layout(access);
            layout.build(binding.number(), stages)
        };
        let read = reads.iter().map(|binding| entry(binding, Access::Read));
        let written = writes.iter().map(|binding| entry(binding, Access::Write));
        let entries: Vec<_> = read.chain(written).collect();
        Self {
            bindings: [reads, writes].concat(),
            layout: BindGroupLayoutDescriptor::new(label, &entries),
        }
    }

    pub(super) fn new(label: &'static str, reads: &[Binding], writes: &[Binding]) -> Self {
        Self::of_stages(ShaderStages::COMPUTE, label, reads, writes)
    }

    /// Group 0 of passes that read the voxels, with reprojected albedo or without.
    pub(crate) fn of_voxels(
        stages: ShaderStages,
        label: &'static str,
        bounce: usize,
        reprojects_albedo: bool,
    ) -> Self {
        let bindings = [
            Binding::Volume(bounce),
            Binding::Masks,
            Binding::PackedSurfaces,
            Binding::FaceSlots,
            Binding::ReprojectedAlbedo,
        ];
        let count = bindings.len() - usize::from(!reprojects_albedo);
        Self::of_stages(stages, label, &bindings[..count], &[])
    }

    /// The same for passes that compute light.
    pub(super) fn of_light(bounce: usize, reprojects_albedo: bool) -> Self {
        let stages = ShaderStages::COMPUTE;
        Self::of_voxels(stages, "voxel_gi_volume", bounce, reprojects_albedo)
    }
}

/// Layout of a bind group of compute shaders that is created entry by entry, each with its number.
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
    pub buffers: Option<Res<'w, VolumeBuffers>>,
    pub volume: Res<'w, ExtractedVolume>,
    pub images: Res<'w, RenderAssets<GpuImage>>,
    uniforms: Res<'w, VolumeUniforms>,
    light_tiles: Res<'w, LightTiles>,
    sky: Res<'w, SkyCube>,
}

impl BindGroups<'_> {
    fn resource(&self, binding: Binding) -> Option<BindingResource<'_>> {
        let buffers = self.buffers.as_deref()?;
        Some(match binding {
            Binding::Volume(bounce) => self.uniforms.bounces[bounce].binding()?,
            Binding::Masks => buffers.masks(),
            Binding::PackedSurfaces => buffers.packed_surfaces.as_entire_binding(),
            Binding::FaceSlots => buffers.face_slots(),
            Binding::FaceSlotsAndMasks => buffers.voxels.as_entire_binding(),
            Binding::ReprojectedAlbedo => buffers.reprojected_albedo.as_entire_binding(),
            Binding::Sums => buffers.sums.as_entire_binding(),
            Binding::Work | Binding::Dirty => buffers.work.as_entire_binding(),
            Binding::Radiance => buffers.radiance(),
            Binding::Irradiance => buffers.irradiance.as_entire_binding(),
            Binding::Colors => buffers.colors(),
            Binding::Lights => self.uniforms.lights.binding()?,
            Binding::LightTexture => {
                let volume = self.volume.0.as_ref()?;
                (self.images.get(&volume.texture)?.texture_view).into_binding()
            }
            Binding::LightTiles => self.light_tiles.tiles.view()?.into_binding(),
            Binding::Changes => self.uniforms.changes.binding()?,
            Binding::Visible => buffers.visible.as_entire_binding(),
            Binding::SkyMap => self.sky.cube.as_ref()?.view.into_binding(),
            Binding::SkySampler => self.sky.cube.as_ref()?.sampler.into_binding(),
            Binding::SlotLists => buffers.slot_lists.as_entire_binding(),
            Binding::Before(buffer) | Binding::After(buffer) => {
                buffers.intensity[buffer].as_entire_binding()
            }
            Binding::Arrived => buffers.arrived.as_entire_binding(),
        })
    }

    /// Creates a bind group, if all of its resources are there.
    pub fn bind(&self, group: &Group) -> Option<BindGroup> {
        let entry = |binding: &Binding| {
            Some(BindGroupEntry {
                binding: binding.number(),
                resource: self.resource(*binding)?,
            })
        };
        let entries: Option<Vec<_>> = group.bindings.iter().map(entry).collect();
        Some(self.create(&group.layout, &entries?))
    }

    pub(super) fn bind_both(&self, [a, b]: &[Group; 2]) -> Option<[BindGroup; 2]> {
        Some([self.bind(a)?, self.bind(b)?])
    }

    /// Creates a bind group of these entries with the label of its layout.
    pub fn create(
        &self,
        layout: &BindGroupLayoutDescriptor,
        entries: &[BindGroupEntry],
    ) -> BindGroup {
        let label = layout.label.as_ref();
        let layout = self.cache.get_bind_group_layout(layout);
        self.device.create_bind_group(label, &layout, entries)
    }
}

/// Group 0 of the passes that compute light.
#[derive(Resource)]
pub(crate) struct VoxelBindGroups {
    /// One for each of [`VolumeUniforms::bounces`].
    pub bounces: [BindGroup; 3],
}

pub(crate) fn prepare_voxel_bind_groups(
    mut commands: Commands,
    plan: Res<FramePlan>,
    groups: BindGroups,
) {
    let (Some(_), Some(buffers)) = (plan.work, &groups.buffers) else {
        commands.remove_resource::<VoxelBindGroups>();
        return;
    };
    let albedo = buffers.shape.reprojects_albedo;
    let group = |bounce| groups.bind(&Group::of_light(bounce, albedo));
    if let (Some(a), Some(b), Some(c)) = (group(0), group(1), group(2)) {
        commands.insert_resource(VoxelBindGroups { bounces: [a, b, c] });
    }
}
