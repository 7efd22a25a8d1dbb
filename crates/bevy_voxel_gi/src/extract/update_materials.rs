//! Keeps the material table in sync as materials, images and meshes change.

use std::any::TypeId;

use bevy::{
    ecs::entity::EntityHashMap,
    platform::collections::{HashMap, HashSet},
    prelude::*,
};

use super::{
    changed_rows::{for_each_changed_row, split},
    material_table::{MaterialIndex, MaterialTable, Variant},
    mean_color::{KnownMeans, MeanColors, mean_vertex_color},
    voxel_material::{AsVoxelMaterial, VoxelMaterial},
};
use crate::settings::MeshVoxelMaterial;

/// State of the table's updates for one type of material.
pub(crate) struct MaterialUpdates<M: Asset> {
    /// Entities whose table index is not known yet.
    entities: HashSet<Entity>,
    waiting: HashSet<AssetId<M>>,
    users: HashMap<AssetId<Image>, HashSet<AssetId<M>>>,
    means: KnownMeans,
    /// Mean vertex colours of those meshes that have vertex colours.
    tints: HashMap<AssetId<Mesh>, Vec3>,
    /// The overrides of entities.
    overrides: EntityHashMap<MeshVoxelMaterial>,
}

impl<M: Asset> Default for MaterialUpdates<M> {
    fn default() -> Self {
        Self {
            entities: HashSet::default(),
            waiting: HashSet::default(),
            users: HashMap::default(),
            means: HashMap::default(),
            tints: HashMap::default(),
            overrides: EntityHashMap::default(),
        }
    }
}

/// Keeps the table and the indices of meshes in sync with the materials of one type.
pub(crate) fn update_materials<M: AsVoxelMaterial>(
    mut commands: Commands,
    columns: Query<(
        Entity,
        Ref<MeshMaterial3d<M>>,
        Ref<Mesh3d>,
        Option<Ref<MeshVoxelMaterial>>,
    )>,
    all: Query<(
        Entity,
        &MeshMaterial3d<M>,
        &Mesh3d,
        Option<&MeshVoxelMaterial>,
        Option<&MaterialIndex>,
    )>,
    (mut without, mut without_override): (
        RemovedComponents<MeshMaterial3d<M>>,
        RemovedComponents<MeshVoxelMaterial>,
    ),
    mut material_events: MessageReader<AssetEvent<M>>,
    mut image_events: MessageReader<AssetEvent<Image>>,
    mut mesh_events: MessageReader<AssetEvent<Mesh>>,
    (materials, images, meshes): (Res<Assets<M>>, Res<Assets<Image>>, Res<Assets<Mesh>>),
    mut table: ResMut<MaterialTable>,
    mut pending: Local<MaterialUpdates<M>>,
) {
    let MaterialUpdates {
        entities,
        waiting,
        users,
        means,
        tints,
        overrides,
    } = &mut *pending;
    let this = Some(TypeId::of::<M>());
    // Skip entities that have such a material again.
    for entity in without.read().filter(|entity| !all.contains(*entity)) {
        if let Ok(mut entity) = commands.get_entity(entity) {
            // The entity may have another type of material by now, whose index it must keep.
            entity.queue(move |mut entity: EntityWorldMut| {
                if entity
                    .get::<MaterialIndex>()
                    .is_some_and(|index| index.material_type == this)
                {
                    entity.remove::<MaterialIndex>();
                }
            });
        }
    }
    let tables = columns.contiguous_iter();
    for table in tables.expect("none of these components is in a sparse set") {
        let (rows, handles, mesh_handles, own) = table;
        let columns = [
            split(handles).1,
            split(mesh_handles).1,
            own.and_then(|own| split(own).1),
        ];
        for_each_changed_row(&columns, rows.len(), |row| {
            entities.insert(rows[row]);
        });
    }
    for entity in without_override.read() {
        overrides.remove(&entity);
        table.remove_variant(Variant::Own(entity));
        entities.insert(entity);
    }
    for event in mesh_events.read() {
        match event {
            AssetEvent::Modified { id } if tints.remove(id).is_some() => {
                let users = all.iter().filter(|(_, _, mesh, ..)| mesh.id() == *id);
                entities.extend(users.map(|(entity, ..)| entity));
            }
            AssetEvent::Removed { id } if tints.remove(id).is_some() => {
                table.remove_variant(Variant::Colors(*id));
            }
            _ => {}
        }
    }
    entities.retain(|&entity| {
        let Ok((_, material, mesh, override_, known)) = all.get(entity) else {
            return false;
        };
        let Some(asset) = meshes.get(mesh.id()) else {
            return true;
        };
        if !tints.contains_key(&mesh.id())
            && let Some(tint) = mean_vertex_color(asset)
        {
            tints.insert(mesh.id(), tint);
        }
        let variant = if let Some(&override_) = override_ {
            overrides.insert(entity, override_);
            Variant::Own(entity)
        } else if tints.contains_key(&mesh.id()) {
            Variant::Colors(mesh.id())
        } else {
            Variant::Plain
        };
        let index = MaterialIndex {
            index: table.index_of(material.id().untyped(), variant),
            material_type: this,
        };
        waiting.insert(material.id());
        if known != Some(&index) {
            commands.entity(entity).insert(index);
        }
        false
    });
    for event in material_events.read() {
        match event {
            AssetEvent::Modified { id } if table.contains(id.untyped()) => {
                waiting.insert(*id);
            }
            AssetEvent::Removed { id } => {
                waiting.remove(id);
                table.remove(id.untyped());
            }
            _ => {}
        }
    }
    for event in image_events.read() {
        if let AssetEvent::Modified { id } = event {
            means.retain(|(image, _), _| image != id);
            waiting.extend(users.get(id).into_iter().flatten());
        }
    }
    waiting.retain(|&id| {
        let Some(material) = materials.get(id) else {
            return true;
        };
        let mut mean = MeanColors {
            images: &images,
            known: means,
            used: HashSet::default(),
            waiting: false,
        };
        let material = material.as_voxel_material(&mut mean);
        for image in mean.used {
            users.entry(image).or_default().insert(id);
        }
        let waits_for_images = mean.waiting;
        table.set(id.untyped(), material, |variant, material| match variant {
            Variant::Plain => material,
            Variant::Colors(mesh) => VoxelMaterial {
                albedo: material.albedo * tints.get(&mesh).copied().unwrap_or(Vec3::ONE),
                ..material
            },
            Variant::Own(entity) => overrides
                .get(&entity)
                .map_or(material, |override_| material.overridden_by(override_)),
        });
        waits_for_images
    });
}
