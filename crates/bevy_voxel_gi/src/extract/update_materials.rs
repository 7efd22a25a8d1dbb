//! Keeps the material table in sync as materials, images and meshes change.

use std::any::TypeId;

use bevy::{
    ecs::entity::Entities,
    platform::collections::{HashMap, HashSet},
    prelude::*,
};

use super::{
    changed_rows::{KnownRows, for_each_changed_row, split},
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
    /// The session of the table for which this is.
    session: u64,
}

impl<M: Asset> Default for MaterialUpdates<M> {
    fn default() -> Self {
        Self {
            entities: HashSet::default(),
            waiting: HashSet::default(),
            users: HashMap::default(),
            means: HashMap::default(),
            tints: HashMap::default(),
            session: 0,
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
    all_entities: &Entities,
    mut material_events: MessageReader<AssetEvent<M>>,
    mut image_events: MessageReader<AssetEvent<Image>>,
    mut mesh_events: MessageReader<AssetEvent<Mesh>>,
    (materials, images, meshes): (Res<Assets<M>>, Res<Assets<Image>>, Res<Assets<Mesh>>),
    mut table: ResMut<MaterialTable>,
    (mut pending, mut known_rows): (Local<MaterialUpdates<M>>, Local<KnownRows>),
) {
    let is_new_session = pending.session != table.session;
    if is_new_session {
        // What is only on the GPU by now cannot be read again.
        let is_gone = |id: AssetId<Image>| images.get(id).is_some_and(|image| image.data.is_none());
        let mut means = std::mem::take(&mut pending.means);
        means.retain(|(id, _), _| is_gone(*id));
        *pending = MaterialUpdates {
            means,
            session: table.session,
            ..default()
        };
    }
    let MaterialUpdates {
        entities,
        waiting,
        users,
        means,
        tints,
        session: _,
    } = &mut *pending;
    let this = Some(TypeId::of::<M>());
    let mut moved = Vec::new();
    let tables = columns.contiguous_iter();
    let is_dense = tables.is_ok();
    for (rows, handles, mesh_handles, own) in tables.into_iter().flatten() {
        known_rows.update(rows, all_entities, &mut moved);
        let columns = [
            split(handles).1,
            split(mesh_handles).1,
            own.and_then(|own| split(own).1),
        ];
        for_each_changed_row(&columns, rows.len(), |row| {
            entities.insert(rows[row]);
        });
    }
    if is_new_session || !is_dense {
        entities.extend(all.iter().map(|(entity, ..)| entity));
    }
    if !is_dense {
        let rows: Vec<_> = all.iter().map(|(entity, ..)| entity).collect();
        known_rows.update(&rows, all_entities, &mut moved);
    }
    known_rows.finish(&mut moved);
    for entity in moved {
        if all.contains(entity) {
            entities.insert(entity);
        } else if let Ok(mut entity) = commands.get_entity(entity) {
            // It may be only disabled, or have another type of material by now, whose index it must keep.
            entity.queue_silenced(move |mut entity: EntityWorldMut| {
                let index = entity.get::<MaterialIndex>();
                let is_this = index.is_some_and(|index| index.material_type == this);
                if is_this && !entity.contains::<MeshMaterial3d<M>>() {
                    entity.remove::<MaterialIndex>();
                }
            });
        }
    }
    let mut of_other_colors = HashSet::new();
    for event in mesh_events.read() {
        match event {
            AssetEvent::Modified { id } => {
                let tint = meshes.get(*id).and_then(mean_vertex_color);
                if tint != tints.get(id).copied() {
                    tints.remove(id);
                    of_other_colors.insert(*id);
                }
            }
            AssetEvent::Removed { id } => {
                tints.remove(id);
            }
            _ => {}
        }
    }
    if !of_other_colors.is_empty() {
        let users = all.iter();
        let users = users.filter(|(_, _, mesh, ..)| of_other_colors.contains(&mesh.id()));
        entities.extend(users.map(|(entity, ..)| entity));
    }
    entities.retain(|&entity| {
        let Ok((_, material, mesh, override_, known)) = all.get(entity) else {
            return false;
        };
        let Some(asset) = meshes.get(mesh.id()) else {
            return true;
        };
        let tint = tints.get(&mesh.id()).copied();
        let tint = tint.or_else(|| mean_vertex_color(asset));
        if let Some(tint) = tint {
            tints.insert(mesh.id(), tint);
        }
        let variant = match (override_, tint) {
            (Some(&override_), _) => Variant::Overridden(override_),
            (None, Some(tint)) => Variant::Tinted(tint),
            (None, None) => Variant::Plain,
        };
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
        false
    });
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
                for materials in users.values_mut() {
                    materials.remove(id);
                }
            }
            _ => {}
        }
    }
    for event in image_events.read() {
        match event {
            AssetEvent::Modified { id } => {
                means.retain(|(image, _), _| image != id);
                waiting.extend(users.get(id).into_iter().flatten());
            }
            AssetEvent::Removed { id } => {
                means.retain(|(image, _), _| image != id);
                users.remove(id);
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
        table.set(id.untyped(), material);
        waits_for_images
    });
}
