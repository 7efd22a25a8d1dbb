//! All groups of meshes, found by the slabs of the meshes' buffers.

use bevy::{
    math::Vec3,
    platform::collections::HashMap,
    render::{mesh::allocator::MeshSlabId, render_resource::Buffer},
};

use super::mesh_group::{LevelMask, MeshGroup};
use crate::gpu_types::{MESH_NOT_SHADOW_CASTER, MeshInstance};

/// The slabs of vertices, indices and morph targets.
pub(super) type Slabs = [Option<MeshSlabId>; 3];

/// A mesh that is on the GPU and reaches into a level.
pub(super) struct LocatedMesh {
    pub slabs: Slabs,
    /// The buffers of the slabs.
    pub buffers: [Option<Buffer>; 3],
    pub instance: MeshInstance,
    pub levels: LevelMask,
    pub hash: u64,
}

/// The place of a mesh in the groups.
pub(super) struct PlacedMesh {
    slabs: Slabs,
    pub levels: LevelMask,
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
        PlacedMesh {
            slabs: mesh.slabs,
            levels: mesh.levels,
            position: position(&mesh.instance),
            group,
            instance: self.groups[group].add(mesh.instance, mesh.levels),
            hash: mesh.hash,
        }
    }

    /// Changes a mesh in place if its triangles stay in the same batches, and returns whether they do.
    pub(super) fn replace(&mut self, placed: &mut PlacedMesh, mesh: &LocatedMesh) -> bool {
        if (mesh.slabs, mesh.levels) != (placed.slabs, placed.levels) {
            return false;
        }
        let group = &mut self.groups[placed.group];
        let Some(former) = group.replace(placed.instance, mesh.instance) else {
            return false;
        };
        self.uncount(&former);
        self.count(&mesh.instance);
        placed.hash = mesh.hash;
        placed.position = position(&mesh.instance);
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
