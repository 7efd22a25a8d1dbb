//! The table of the voxel materials in use, and what keeps it in sync as materials and meshes change.

use std::{
    any::TypeId,
    hash::{Hash, Hasher},
};

use bevy::{
    asset::{UntypedAssetId, uuid::Uuid},
    platform::collections::{HashMap, HashSet},
    prelude::*,
};
use bevy_frugal_hooks::MaterialImages;

use super::{
    changed_rows::{MovedMeshes, for_each_changed_row, split},
    voxel_material::{AsVoxelMaterial, VoxelMaterial},
};
use crate::settings::MeshVoxelMaterial;

/// Distinguishes meshes of one material whose voxel materials differ. Equal ones share an entry of the table.
#[derive(Clone, Copy, Debug)]
enum Variant {
    /// The material's own.
    Plain,
    /// With this override of the mesh.
    Overridden(MeshVoxelMaterial),
}

impl Variant {
    /// The material on such a mesh.
    fn applied(self, material: VoxelMaterial) -> VoxelMaterial {
        match self {
            Self::Plain => material,
            Self::Overridden(mesh) => material.overridden_by(&mesh),
        }
    }

    /// The override's floats by their bits, so that NaN equals itself.
    fn bits(self) -> Option<[Option<[u32; 3]>; 4]> {
        let Self::Overridden(mesh) = self else {
            return None;
        };
        let of_vector = |vector: Vec3| vector.to_array().map(f32::to_bits);
        let of_float = |float| of_vector(Vec3::splat(float));
        Some([
            mesh.albedo.map(of_vector),
            mesh.coverage.map(of_float),
            mesh.emissive.map(|color| of_vector(color.to_vec3())),
            mesh.emission_factor.map(of_float),
        ])
    }
}

impl PartialEq for Variant {
    fn eq(&self, other: &Self) -> bool {
        self.bits() == other.bits()
    }
}

impl Eq for Variant {}

impl Hash for Variant {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.bits().hash(state);
    }
}

/// The voxel materials in use; entry 0 is [`VoxelMaterial::NEUTRAL`].
#[derive(Resource)]
pub(crate) struct MaterialTable {
    table: Vec<VoxelMaterial>,
    /// Materials as they are without what differs by mesh, and their table indices.
    known: HashMap<UntypedAssetId, (VoxelMaterial, HashMap<Variant, u32>)>,
    /// Table indices that no mesh has.
    free: Vec<u32>,
    /// Number of entries in use at which those that no mesh has are looked for.
    crowded: usize,
    /// Increases with each change.
    pub(crate) version: u64,
    /// Increases when a first volume comes: what happened without one is not in the table.
    session: u64,
}

impl Default for MaterialTable {
    fn default() -> Self {
        Self {
            table: vec![VoxelMaterial::NEUTRAL],
            known: HashMap::default(),
            free: Vec::new(),
            crowded: Self::LEAST_CROWDED,
            version: 0,
            session: 0,
        }
    }
}

impl MaterialTable {
    const LEAST_CROWDED: usize = 256;

    pub(crate) fn materials(&self) -> &[VoxelMaterial] {
        &self.table
    }

    /// Returns the table index of a material on such a mesh.
    fn index_of(&mut self, id: UntypedAssetId, variant: Variant) -> u32 {
        let unknown = || (VoxelMaterial::NEUTRAL, HashMap::default());
        let (material, entries) = self.known.entry(id).or_insert_with(unknown);
        let material = variant.applied(*material);
        *entries.entry(variant).or_insert_with(|| {
            self.version += 1;
            let index = self.free.pop().unwrap_or_else(|| {
                self.table.push(material);
                u32::try_from(self.table.len() - 1).unwrap_or(0)
            });
            self.table[index as usize] = material;
            index
        })
    }

    /// Whether any mesh has this material.
    fn contains(&self, id: UntypedAssetId) -> bool {
        self.known.contains_key(&id)
    }

    /// Updates all entries of a material.
    fn set(&mut self, id: UntypedAssetId, material: VoxelMaterial) {
        let Some((known, entries)) = self.known.get_mut(&id) else {
            return;
        };
        *known = material;
        for (variant, index) in entries {
            let material = variant.applied(material);
            let entry = &mut self.table[*index as usize];
            if *entry != material {
                *entry = material;
                self.version += 1;
            }
        }
    }

    /// Removes the entries that no mesh has, where there are many more than there were.
    fn remove_unused(&mut self, used: impl Iterator<Item = MaterialIndex>) {
        if self.table.len() - self.free.len() <= self.crowded {
            return;
        }
        let used: HashSet<_> = used.map(|used| used.index).collect();
        self.known.retain(|_, (_, entries)| {
            entries.retain(|_, index| {
                let is_used = used.contains(index);
                if !is_used {
                    // Not one more value to tell apart.
                    self.table[*index as usize] = VoxelMaterial::NEUTRAL;
                    self.free.push(*index);
                    self.version += 1;
                }
                is_used
            });
            !entries.is_empty()
        });
        let left = self.table.len() - self.free.len();
        self.crowded = Self::LEAST_CROWDED.max(2 * left);
    }
}

/// The index of a mesh's voxel material in the table.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[component(summary_tick)]
pub(crate) struct MaterialIndex {
    pub index: u32,
    /// Type of the material, `None` if it has no [`AsVoxelMaterial`](crate::AsVoxelMaterial).
    pub material_type: Option<TypeId>,
}

/// Begins a session where there is a volume and was none.
pub(crate) fn begin_session(
    volumes: Query<(), With<crate::VoxelGiVolume>>,
    mut had_volume: Local<bool>,
    mut table: ResMut<MaterialTable>,
) {
    let has_volume = !volumes.is_empty();
    if has_volume && !*had_volume {
        table.session += 1;
    }
    *had_volume = has_volume;
}

pub(crate) fn remove_unused(mut table: ResMut<MaterialTable>, used: Query<&MaterialIndex>) {
    table
        .bypass_change_detection()
        .remove_unused(used.iter().copied());
}

/// State of the table's updates for one type of material: entities whose table index is not known yet, materials that are
/// not loaded or have changed, and the session of the table for which this is.
type MaterialUpdates<M> = (HashSet<Entity>, HashSet<AssetId<M>>, u64);

/// Keeps the table and the indices of meshes in sync with the materials of one type.
pub(crate) fn update_materials<M: AsVoxelMaterial>(
    mut commands: Commands,
    columns: Query<
        (
            Entity,
            Ref<MeshMaterial3d<M>>,
            Option<Ref<MeshVoxelMaterial>>,
        ),
        With<Mesh3d>,
    >,
    all: Query<
        (
            Entity,
            &MeshMaterial3d<M>,
            Option<&MeshVoxelMaterial>,
            Option<&MaterialIndex>,
        ),
        With<Mesh3d>,
    >,
    (moved, indices): (Res<MovedMeshes>, Query<&MaterialIndex>),
    mut material_events: MessageReader<AssetEvent<M>>,
    (materials, images): (Res<Assets<M>>, Res<MaterialImages>),
    mut table: ResMut<MaterialTable>,
    mut pending: Local<MaterialUpdates<M>>,
) {
    let is_new_session = pending.2 != table.session;
    if is_new_session {
        *pending = (default(), default(), table.session);
    }
    let (entities, waiting, _) = &mut *pending;
    let this = Some(TypeId::of::<M>());
    let tables = columns.contiguous_iter();
    if is_new_session || tables.is_err() {
        entities.extend(all.iter().map(|(entity, ..)| entity));
    }
    for (rows, handles, own) in tables.into_iter().flatten() {
        let columns = [split(handles).1, own.and_then(|own| split(own).1)];
        for_each_changed_row(&columns, rows.len(), |row| {
            entities.insert(rows[row]);
        });
    }
    for &entity in &moved.entities {
        if all.contains(entity) {
            entities.insert(entity);
        } else if indices
            .get(entity)
            .is_ok_and(|index| index.material_type == this)
        {
            forget_index::<MeshMaterial3d<M>>(&mut commands, entity, this);
        }
    }
    for entity in entities.drain() {
        let Ok((_, material, override_, known)) = all.get(entity) else {
            continue;
        };
        let variant = override_.map_or(Variant::Plain, |mesh| Variant::Overridden(*mesh));
        let id = material.id().untyped();
        if !table.contains(id) || is_new_session {
            waiting.insert(material.id());
        }
        let index = MaterialIndex {
            index: table.index_of(id, variant),
            material_type: this,
        };
        if known != Some(&index) {
            commands.entity(entity).insert(index);
        }
    }
    for event in material_events.read() {
        match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id }
                if table.contains(id.untyped()) =>
            {
                waiting.insert(*id);
            }
            AssetEvent::Removed { id } if table.contains(id.untyped()) => {
                table.set(id.untyped(), VoxelMaterial::NEUTRAL);
                waiting.insert(*id);
            }
            _ => {}
        }
    }
    waiting.retain(|&id| {
        if !table.contains(id.untyped()) {
            return false;
        }
        let Some(material) = materials.get(id) else {
            return true;
        };
        let voxel_material = match images.0.get(&id.untyped()) {
            Some(images) => material.as_voxel_material().with_images(images),
            None => material.as_voxel_material(),
        };
        table.set(id.untyped(), voxel_material);
        false
    });
}

/// Resets the index of a mesh that has lost the component that gave it.
fn forget_index<C: Component>(
    commands: &mut Commands,
    entity: Entity,
    material_type: Option<TypeId>,
) {
    commands
        .entity(entity)
        .queue_silenced(move |mut entity: EntityWorldMut| {
            // By now it may have another type of material, whose index it must keep.
            let index = entity.get::<MaterialIndex>();
            let is_of_this = index.is_some_and(|index| index.material_type == material_type);
            if is_of_this && !entity.contains::<C>() {
                entity.insert(MaterialIndex::default());
            }
        });
}

/// A material id that no asset has; all of these meshes share it in the table.
fn unknown() -> UntypedAssetId {
    const UNKNOWN: Uuid = Uuid::from_u128(0x9f0b_5a4e_31c6_4d7b_8a52_77e1_0c3d_6b94);
    AssetId::<StandardMaterial>::Uuid { uuid: UNKNOWN }.untyped()
}

/// Assigns table indices to meshes of unknown materials, whose voxel material is defined only by their
/// [`MeshVoxelMaterial`]; runs after the systems of the known materials.
pub(crate) fn update_unknown_materials(
    mut commands: Commands,
    columns: Query<(Entity, Ref<MeshVoxelMaterial>), With<Mesh3d>>,
    all: Query<(&MeshVoxelMaterial, Option<&MaterialIndex>), With<Mesh3d>>,
    moved: Res<MovedMeshes>,
    indices: Query<&MaterialIndex>,
    mut table: ResMut<MaterialTable>,
    mut session: Local<u64>,
) {
    let mut changed: HashSet<_> = moved.entities.iter().copied().collect();
    let tables = columns.contiguous_iter();
    if tables.is_err() || *session != table.session {
        changed.extend(columns.iter().map(|(entity, _)| entity));
        *session = table.session;
    }
    for (rows, overrides) in tables.into_iter().flatten() {
        for_each_changed_row(&[split(overrides).1], rows.len(), |row| {
            changed.insert(rows[row]);
        });
    }
    for entity in changed {
        let Ok((&override_, known)) = all.get(entity) else {
            if indices
                .get(entity)
                .is_ok_and(|index| index.material_type.is_none())
            {
                forget_index::<MeshVoxelMaterial>(&mut commands, entity, None);
            }
            continue;
        };
        if known.is_some_and(|known| known.material_type.is_some()) {
            continue;
        }
        let index = MaterialIndex {
            index: table.index_of(unknown(), Variant::Overridden(override_)),
            material_type: None,
        };
        if known != Some(&index) {
            commands.entity(entity).insert(index);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn material(number: u128) -> UntypedAssetId {
        let uuid = bevy::asset::uuid::Uuid::from_u128(number);
        AssetId::<StandardMaterial>::Uuid { uuid }.untyped()
    }

    fn overridden(albedo: f32) -> Variant {
        Variant::Overridden(MeshVoxelMaterial {
            albedo: Some(Vec3::splat(albedo)),
            ..default()
        })
    }

    #[test]
    fn equal_variants_share_an_entry() {
        let mut table = MaterialTable::default();
        let id = material(1);
        let index = table.index_of(id, overridden(0.3));
        for _ in 0..10_000 {
            assert_eq!(table.index_of(id, overridden(0.3)), index);
        }
        assert_eq!(table.materials().len(), 2);
        let white = VoxelMaterial {
            base_color: LinearRgba::WHITE,
            ..VoxelMaterial::NEUTRAL
        };
        table.set(id, white);
        let gray = LinearRgba::rgb(0.3, 0.3, 0.3);
        assert_eq!(table.materials()[index as usize].base_color, gray);
        // A variant that comes later has the material, too.
        let plain = table.index_of(id, Variant::Plain);
        assert_eq!(table.materials()[plain as usize], white);
    }

    #[test]
    fn an_animated_override_does_not_fill_the_table() {
        let mut table = MaterialTable::default();
        for frame in 0..100_000 {
            let index = table.index_of(material(1), overridden(frame as f32 * 1e-5));
            let used = MaterialIndex {
                index,
                material_type: None,
            };
            table.remove_unused([used].into_iter());
        }
        assert!(table.materials().len() < 300, "{}", table.materials().len());
    }
}
