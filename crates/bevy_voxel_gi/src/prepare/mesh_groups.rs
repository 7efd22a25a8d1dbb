//! All groups of meshes, found by the slabs of the meshes' buffers.

use bevy::{
    asset::AssetId,
    math::{Vec3, Vec3A},
    mesh::Mesh,
    platform::collections::HashMap,
    render::{mesh::allocator::MeshSlabId, render_resource::Buffer},
};

use super::{
    dirty_voxels::Bounds,
    mesh_group::{LevelMask, MeshGroup},
};
use crate::gpu_types::{MESH_NOT_SHADOW_CASTER, MESH_SKINNED, MeshInstance};

/// The slabs of vertices, indices and morph targets.
pub(super) type Slabs = [Option<MeshSlabId>; 3];

/// A mesh that is on the GPU and reaches into a level.
pub(super) struct LocatedMesh {
    pub slabs: Slabs,
    /// The buffers of the slabs.
    pub buffers: [Option<Buffer>; 3],
    pub instance: MeshInstance,
    pub mesh: AssetId<Mesh>,
    /// Bounds in the world, if they are known.
    pub bounds: Option<Bounds>,
    pub hash: u64,
}

/// The place of a mesh in the groups.
pub(super) struct PlacedMesh {
    slabs: Slabs,
    mesh: AssetId<Mesh>,
    pub material: u32,
    pub levels: LevelMask,
    pub bounds: Option<Bounds>,
    /// World position of the mesh's origin.
    pub position: Vec3,
    group: usize,
    instance: usize,
    pub hash: u64,
}

fn position(instance: &MeshInstance) -> Vec3 {
    instance.world_from_local.w_axis.truncate()
}

/// Groups by their slabs.
#[derive(Default)]
pub(super) struct MeshGroups {
    /// A group without a mesh is replaced by the next new one.
    groups: Vec<MeshGroup>,
    by_slabs: HashMap<Slabs, usize>,
    /// Number of triangles of all meshes.
    pub triangles: u64,
    /// Number of meshes with each material.
    materials: HashMap<u32, usize>,
    /// Number of meshes that do not shadow direct light.
    without_shadow: usize,
}

impl MeshGroups {
    pub(super) fn iter_mut(&mut self) -> impl Iterator<Item = &mut MeshGroup> {
        self.groups.iter_mut().filter(|group| !group.is_empty())
    }

    /// Whether a mesh has this material.
    pub(super) fn uses(&self, material: u32) -> bool {
        self.materials.contains_key(&material)
    }

    /// Whether a mesh does not shadow direct light.
    pub(super) fn has_mesh_without_shadow(&self) -> bool {
        self.without_shadow > 0
    }

    /// Counts a mesh that is in the groups now.
    fn count(&mut self, mesh: &MeshInstance) {
        self.triangles += u64::from(mesh.triangle_count);
        self.without_shadow += usize::from(mesh.flags & MESH_NOT_SHADOW_CASTER != 0);
        *self.materials.entry(mesh.material).or_default() += 1;
    }

    /// Counts a mesh that is not in the groups any more.
    fn uncount(&mut self, mesh: &MeshInstance) {
        self.triangles -= u64::from(mesh.triangle_count);
        self.without_shadow -= usize::from(mesh.flags & MESH_NOT_SHADOW_CASTER != 0);
        if let Some(users) = self.materials.get_mut(&mesh.material) {
            *users -= 1;
            if *users == 0 {
                self.materials.remove(&mesh.material);
            }
        }
    }

    /// Adds a mesh; the bounds in the world of one that is deformed are those of its triangles, too.
    pub(super) fn add(&mut self, mesh: LocatedMesh) -> PlacedMesh {
        self.count(&mesh.instance);
        let group = *self.by_slabs.entry(mesh.slabs).or_insert_with(|| {
            let new = MeshGroup::new(mesh.buffers);
            let empty = self.groups.iter().position(MeshGroup::is_empty);
            match empty {
                Some(place) => self.groups[place] = new,
                None => self.groups.push(new),
            }
            empty.unwrap_or(self.groups.len() - 1)
        });
        let is_deformed = mesh.instance.flags & MESH_SKINNED != 0 || mesh.instance.weight_count > 0;
        let everywhere = (Vec3A::ZERO, Vec3A::INFINITY);
        let bounds = is_deformed.then(|| mesh.bounds.unwrap_or(everywhere));
        PlacedMesh {
            slabs: mesh.slabs,
            mesh: mesh.mesh,
            material: mesh.instance.material,
            levels: mesh.instance.levels,
            bounds: mesh.bounds,
            position: position(&mesh.instance),
            group,
            instance: self.groups[group].add(mesh.instance, bounds),
            hash: mesh.hash,
        }
    }

    /// Changes a rigid mesh in place if its triangles stay in the same batches, and returns whether they do. `is_edited`
    /// says whether these are others in the same asset.
    pub(super) fn replace(
        &mut self,
        placed: &mut PlacedMesh,
        mesh: &LocatedMesh,
        is_edited: bool,
    ) -> bool {
        if mesh.slabs != placed.slabs {
            return false;
        }
        let is_same_mesh = mesh.mesh == placed.mesh && !is_edited;
        let group = &mut self.groups[placed.group];
        let Some(former) = group.replace(placed.instance, mesh.instance, is_same_mesh) else {
            return false;
        };
        self.uncount(&former);
        self.count(&mesh.instance);
        *placed = PlacedMesh {
            slabs: placed.slabs,
            mesh: mesh.mesh,
            material: mesh.instance.material,
            levels: mesh.instance.levels,
            bounds: mesh.bounds,
            position: position(&mesh.instance),
            group: placed.group,
            instance: placed.instance,
            hash: mesh.hash,
        };
        true
    }

    pub(super) fn remove(&mut self, placed: &PlacedMesh) {
        let group = &mut self.groups[placed.group];
        let removed = group.remove(placed.instance);
        if group.is_empty() {
            // It would keep the slabs' buffers alive.
            *group = MeshGroup::new([const { None }; 3]);
            self.by_slabs.remove(&placed.slabs);
        }
        self.uncount(&removed);
    }
}
