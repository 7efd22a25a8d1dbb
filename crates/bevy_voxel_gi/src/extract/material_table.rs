//! The table of the voxel materials in use.

use std::any::TypeId;

use bevy::{asset::UntypedAssetId, platform::collections::HashMap, prelude::*};

use super::voxel_material::VoxelMaterial;
#[cfg(doc)]
use crate::settings::MeshVoxelMaterial;

/// Distinguishes meshes of one material whose voxel materials differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Variant {
    /// The material's own.
    Plain,
    /// Times the mean vertex colour of this mesh.
    Colors(AssetId<Mesh>),
    /// With the [`MeshVoxelMaterial`] of this entity.
    Own(Entity),
}

/// The voxel materials in use; entry 0 is [`VoxelMaterial::NEUTRAL`].
#[derive(Resource, Clone)]
pub(crate) struct MaterialTable {
    table: Vec<VoxelMaterial>,
    /// Table indices of each material.
    index: HashMap<UntypedAssetId, HashMap<Variant, u32>>,
    /// Table indices of materials that were removed.
    free: Vec<u32>,
    /// Increases with each change.
    pub(crate) version: u64,
}

impl Default for MaterialTable {
    fn default() -> Self {
        Self {
            table: vec![VoxelMaterial::NEUTRAL],
            index: HashMap::default(),
            free: Vec::new(),
            version: 0,
        }
    }
}

impl MaterialTable {
    /// The packed surface of a voxel's face has 12 bits for the table index.
    const MAX_MATERIALS: usize = 4096;

    pub(crate) fn materials(&self) -> &[VoxelMaterial] {
        &self.table
    }

    /// Returns the table index of a material on such a mesh, which does not change afterwards; 0 if the
    /// table is full.
    pub(super) fn index_of(&mut self, id: UntypedAssetId, variant: Variant) -> u32 {
        let entries = self.index.entry(id).or_default();
        if let Some(&index) = entries.get(&variant) {
            return index;
        }
        let index = if let Some(index) = self.free.pop() {
            self.table[index as usize] = VoxelMaterial::NEUTRAL;
            self.version += 1;
            index
        } else if self.table.len() >= Self::MAX_MATERIALS {
            warn_once!(
                "voxel GI: more than {} materials (times meshes with vertex colours); the others \
                 are treated as neutral gray. Use fewer materials",
                Self::MAX_MATERIALS - 1
            );
            return 0;
        } else {
            self.table.push(VoxelMaterial::NEUTRAL);
            self.version += 1;
            u32::try_from(self.table.len() - 1).unwrap_or(0)
        };
        entries.insert(variant, index);
        index
    }

    /// Whether any mesh has this material.
    pub(super) fn contains(&self, id: UntypedAssetId) -> bool {
        self.index.contains_key(&id)
    }

    pub(super) fn remove(&mut self, id: UntypedAssetId) {
        let entries = self.index.remove(&id).into_iter().flatten();
        self.free.extend(entries.map(|(_, index)| index));
    }

    pub(super) fn remove_variant(&mut self, variant: Variant) {
        let materials = self.index.values_mut();
        self.free
            .extend(materials.filter_map(|entries| entries.remove(&variant)));
    }

    /// Updates all entries of a material, where `of_mesh` applies what differs by mesh.
    pub(super) fn set(
        &mut self,
        id: UntypedAssetId,
        material: VoxelMaterial,
        of_mesh: impl Fn(Variant, VoxelMaterial) -> VoxelMaterial,
    ) {
        for (&variant, &index) in self.index.get(&id).into_iter().flatten() {
            let material = of_mesh(variant, material);
            if let Some(entry) = self.table.get_mut(index as usize)
                && *entry != material
            {
                *entry = material;
                self.version += 1;
            }
        }
    }
}

/// The index of a mesh's voxel material in the table.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[component(summary_tick)]
pub(crate) struct MaterialIndex {
    pub index: u32,
    /// Type of the material, `None` if it has no [`AsVoxelMaterial`].
    pub material_type: Option<TypeId>,
}
