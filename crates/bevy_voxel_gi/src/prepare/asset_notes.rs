//! What Bevy's assets on the GPU do not keep, and voxelisation needs.

use bevy::{
    image::{ImageAddressMode, ImageSampler},
    mesh::morph::MorphAttributes,
    platform::collections::{HashMap, HashSet},
    prelude::*,
    render::{
        mesh::RenderMesh, render_asset::ExtractedAssets,
        render_resource::DefaultImageSamplerDescriptor, texture::GpuImage,
    },
    shape::BoundingVolume,
};

/// The bounds to which packed vertices of a mesh are relative.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PackedRanges {
    pub position_center: Vec3,
    pub position_half_size: Vec3,
    /// Least coordinates and their range, of both channels.
    pub uvs: [Vec4; 2],
}

/// Least and greatest displacement of a vertex by a morph target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Displacement {
    pub least: Vec3,
    pub greatest: Vec3,
}

impl Displacement {
    fn of(target: &[MorphAttributes]) -> Self {
        let zero = Self {
            least: Vec3::ZERO,
            greatest: Vec3::ZERO,
        };
        target.iter().fold(zero, |all, vertex| Self {
            least: all.least.min(vertex.position),
            greatest: all.greatest.max(vertex.position),
        })
    }
}

/// Notes of the assets as they come.
#[derive(Resource, Default)]
pub(crate) struct AssetNotes {
    /// Address modes of the images with a sampler of their own.
    addresses: HashMap<AssetId<Image>, [ImageAddressMode; 2]>,
    default_address: [ImageAddressMode; 2],
    /// The images that were uploaded in this frame.
    pub uploaded: HashSet<AssetId<Image>>,
    /// The meshes with packed vertices.
    packed: HashMap<AssetId<Mesh>, PackedRanges>,
    /// Of the meshes with morph targets, those of each target.
    displacements: HashMap<AssetId<Mesh>, Vec<Displacement>>,
}

impl AssetNotes {
    pub(super) fn address(&self, image: AssetId<Image>) -> [ImageAddressMode; 2] {
        self.addresses
            .get(&image)
            .copied()
            .unwrap_or(self.default_address)
    }

    pub(super) fn packed_ranges(&self, mesh: AssetId<Mesh>) -> PackedRanges {
        self.packed.get(&mesh).copied().unwrap_or_default()
    }

    /// How far each morph target displaces vertices; `None` before the mesh is on the GPU.
    pub(crate) fn displacements(&self, mesh: AssetId<Mesh>) -> Option<&[Displacement]> {
        self.displacements.get(&mesh).map(Vec::as_slice)
    }
}

/// Takes notes before the assets are uploaded.
pub(crate) fn note_assets(
    mut notes: ResMut<AssetNotes>,
    images: Res<ExtractedAssets<GpuImage>>,
    meshes: Res<ExtractedAssets<RenderMesh>>,
    default_sampler: Option<Res<DefaultImageSamplerDescriptor>>,
) {
    let notes = &mut *notes;
    if let Some(sampler) = default_sampler {
        notes.default_address = [sampler.0.address_mode_u, sampler.0.address_mode_v];
    }
    notes.uploaded.clear();
    for id in &images.removed {
        notes.addresses.remove(id);
    }
    for (id, image) in &images.extracted {
        notes.uploaded.insert(*id);
        match &image.sampler {
            ImageSampler::Default => notes.addresses.remove(id),
            ImageSampler::Descriptor(sampler) => notes
                .addresses
                .insert(*id, [sampler.address_mode_u, sampler.address_mode_v]),
        };
    }
    for id in &meshes.removed {
        notes.packed.remove(id);
        notes.displacements.remove(id);
    }
    for (id, mesh) in &meshes.extracted {
        match mesh.get_morph_targets() {
            Some(targets) => {
                let targets = targets.chunks(mesh.count_vertices().max(1));
                let displacements = targets.map(Displacement::of).collect();
                notes.displacements.insert(*id, displacements);
            }
            None => _ = notes.displacements.remove(id),
        }
        let bounds = mesh.final_aabb;
        let ranges = PackedRanges {
            position_center: bounds.map_or(Vec3::ZERO, |bounds| bounds.center().into()),
            position_half_size: bounds.map_or(Vec3::ZERO, |bounds| bounds.half_size().into()),
            uvs: mesh.final_uv_ranges.map(|range| {
                range.map_or(Vec4::ZERO, |range| {
                    let size = range.max - range.min;
                    Vec4::new(range.min.x, range.min.y, size.x, size.y)
                })
            }),
        };
        if ranges == PackedRanges::default() {
            notes.packed.remove(id);
        } else {
            notes.packed.insert(*id, ranges);
        }
    }
}
