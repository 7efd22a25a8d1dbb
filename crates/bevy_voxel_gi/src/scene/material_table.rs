//! The table of the surfaces of all materials in use, updated as materials, images and meshes change.

use std::any::TypeId;

use bevy::{
    asset::UntypedAssetId,
    ecs::entity::EntityHashMap,
    platform::collections::{HashMap, HashSet},
    prelude::*,
};

use super::{
    mean_color::{KnownMeans, MeanColors, mean_vertex_color},
    voxel_material::{AsVoxelMaterial, VoxelMaterial, finite},
};

/// Overrides the surface that a mesh gets from its material.
///
/// This is for materials whose textures the plugin cannot read, such as compressed ones, and for custom
/// shaders. Emission and transparency remain those of the material; a material without a
/// [`VoxelMaterialPlugin`](crate::VoxelMaterialPlugin) emits nothing and is opaque.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component)]
pub struct MeshVoxelMaterial {
    /// Mean diffuse reflectance of the mesh, linear, 0 to 1. Default `None`: the material's.
    pub albedo: Option<Vec3>,
    /// Opaque fraction of its area, 0 to 1: below 1 where an alpha mask cuts holes. Default `None`: the
    /// material's.
    pub coverage: Option<f32>,
}

impl MeshVoxelMaterial {
    /// Returns the surface with these overrides.
    pub(super) fn over(&self, surface: VoxelMaterial) -> VoxelMaterial {
        let coverage = self.coverage.filter(|share| share.is_finite());
        VoxelMaterial {
            albedo: self.albedo.map_or(surface.albedo, |albedo| {
                finite(albedo).clamp(Vec3::ZERO, Vec3::ONE)
            }),
            coverage: coverage.map_or(surface.coverage, |share| share.clamp(0.0, 1.0)),
            ..surface
        }
    }
}

/// Distinguishes meshes of one material whose surfaces differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Variant {
    /// The material's own surface.
    Plain,
    /// The surface times the mean vertex colour of this mesh.
    Colors(AssetId<Mesh>),
    /// The surface with the [`MeshVoxelMaterial`] of this entity.
    Own(Entity),
}

/// The surfaces of all materials in use; entry 0 is [`VoxelMaterial::NEUTRAL`].
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
    const MOST: usize = 4096;

    pub(crate) fn table(&self) -> &[VoxelMaterial] {
        &self.table
    }

    /// Returns the table index of a material on such a mesh, which does not change afterwards; 0 if the
    /// table is full.
    pub(super) fn place(&mut self, id: UntypedAssetId, variant: Variant) -> u32 {
        let places = self.index.entry(id).or_default();
        if let Some(&place) = places.get(&variant) {
            return place;
        }
        let place = if let Some(place) = self.free.pop() {
            self.table[place as usize] = VoxelMaterial::NEUTRAL;
            self.version += 1;
            place
        } else if self.table.len() >= Self::MOST {
            warn_once!(
                "voxel GI: more than {} materials (times meshes with vertex colours); the others \
                 are treated as neutral gray. Use fewer materials",
                Self::MOST - 1
            );
            return 0;
        } else {
            self.table.push(VoxelMaterial::NEUTRAL);
            self.version += 1;
            u32::try_from(self.table.len() - 1).unwrap_or(0)
        };
        places.insert(variant, place);
        place
    }

    fn remove(&mut self, id: UntypedAssetId) {
        let places = self.index.remove(&id).into_iter().flatten();
        self.free.extend(places.map(|(_, place)| place));
    }

    fn remove_variant(&mut self, variant: Variant) {
        let places = self.index.values_mut();
        self.free
            .extend(places.filter_map(|places| places.remove(&variant)));
    }

    /// Updates all entries of a material, where `of_mesh` applies what differs by mesh.
    pub(super) fn set(
        &mut self,
        id: UntypedAssetId,
        surface: VoxelMaterial,
        of_mesh: impl Fn(Variant, VoxelMaterial) -> VoxelMaterial,
    ) {
        for (&variant, &place) in self.index.get(&id).into_iter().flatten() {
            let surface = of_mesh(variant, surface);
            if let Some(entry) = self.table.get_mut(place as usize)
                && *entry != surface
            {
                *entry = surface;
                self.version += 1;
            }
        }
    }
}

/// The index of a mesh's surface in the table.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct MaterialIndex {
    pub place: u32,
    /// Type of the material, `None` if it has no [`AsVoxelMaterial`].
    pub material: Option<TypeId>,
}

/// State of the table's updates for one type of material.
pub(crate) struct Pending<M: Asset> {
    /// Entities whose table index is not known yet.
    entities: HashSet<Entity>,
    waiting: HashSet<AssetId<M>>,
    users: HashMap<AssetId<Image>, HashSet<AssetId<M>>>,
    means: KnownMeans,
    /// Mean vertex colours of those meshes that have vertex colours.
    tints: HashMap<AssetId<Mesh>, Vec3>,
    /// The overrides of entities.
    own: EntityHashMap<MeshVoxelMaterial>,
}

impl<M: Asset> Default for Pending<M> {
    fn default() -> Self {
        Self {
            entities: HashSet::default(),
            waiting: HashSet::default(),
            users: HashMap::default(),
            means: HashMap::default(),
            tints: HashMap::default(),
            own: EntityHashMap::default(),
        }
    }
}

/// Keeps the table and the indices of meshes in sync with the materials of one type.
pub(crate) fn update_materials<M: AsVoxelMaterial>(
    mut commands: Commands,
    changed: Query<
        Entity,
        (
            With<Mesh3d>,
            Or<(
                Changed<MeshMaterial3d<M>>,
                Changed<Mesh3d>,
                Changed<MeshVoxelMaterial>,
            )>,
        ),
    >,
    all: Query<(
        Entity,
        &MeshMaterial3d<M>,
        &Mesh3d,
        Option<&MeshVoxelMaterial>,
        Option<&MaterialIndex>,
    )>,
    (mut without, mut without_own): (
        RemovedComponents<MeshMaterial3d<M>>,
        RemovedComponents<MeshVoxelMaterial>,
    ),
    mut material_events: MessageReader<AssetEvent<M>>,
    mut image_events: MessageReader<AssetEvent<Image>>,
    mut mesh_events: MessageReader<AssetEvent<Mesh>>,
    (materials, images, meshes): (Res<Assets<M>>, Res<Assets<Image>>, Res<Assets<Mesh>>),
    mut surfaces: ResMut<MaterialTable>,
    mut pending: Local<Pending<M>>,
) {
    let Pending {
        entities,
        waiting,
        users,
        means,
        tints,
        own,
    } = &mut *pending;
    let this = Some(TypeId::of::<M>());
    // Skip entities that have such a material again.
    for entity in without.read().filter(|entity| !all.contains(*entity)) {
        if let Ok(mut entity) = commands.get_entity(entity) {
            // The entity may have another type of material by now, whose index it must keep.
            entity.queue(move |mut entity: EntityWorldMut| {
                if entity
                    .get::<MaterialIndex>()
                    .is_some_and(|index| index.material == this)
                {
                    entity.remove::<MaterialIndex>();
                }
            });
        }
    }
    entities.extend(&changed);
    for entity in without_own.read() {
        own.remove(&entity);
        surfaces.remove_variant(Variant::Own(entity));
        entities.insert(entity);
    }
    for event in mesh_events.read() {
        match event {
            AssetEvent::Modified { id } if tints.remove(id).is_some() => {
                let users = all.iter().filter(|(_, _, mesh, ..)| mesh.id() == *id);
                entities.extend(users.map(|(entity, ..)| entity));
            }
            AssetEvent::Removed { id } if tints.remove(id).is_some() => {
                surfaces.remove_variant(Variant::Colors(*id));
            }
            _ => {}
        }
    }
    entities.retain(|&entity| {
        let Ok((_, material, mesh, surface, known)) = all.get(entity) else {
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
        let variant = if let Some(&surface) = surface {
            own.insert(entity, surface);
            Variant::Own(entity)
        } else if tints.contains_key(&mesh.id()) {
            Variant::Colors(mesh.id())
        } else {
            Variant::Plain
        };
        let index = MaterialIndex {
            place: surfaces.place(material.id().untyped(), variant),
            material: this,
        };
        waiting.insert(material.id());
        if known != Some(&index) {
            commands.entity(entity).insert(index);
        }
        false
    });
    for event in material_events.read() {
        match event {
            AssetEvent::Modified { id } if surfaces.index.contains_key(&id.untyped()) => {
                waiting.insert(*id);
            }
            AssetEvent::Removed { id } => {
                waiting.remove(id);
                surfaces.remove(id.untyped());
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
        let surface = material.surface(&mut mean);
        for image in mean.used {
            users.entry(image).or_default().insert(id);
        }
        let again = mean.waiting;
        surfaces.set(id.untyped(), surface, |variant, surface| match variant {
            Variant::Plain => surface,
            Variant::Colors(mesh) => VoxelMaterial {
                albedo: surface.albedo * tints.get(&mesh).copied().unwrap_or(Vec3::ONE),
                ..surface
            },
            Variant::Own(entity) => own.get(&entity).map_or(surface, |own| own.over(surface)),
        });
        again
    });
}
