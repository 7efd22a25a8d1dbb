//! The surfaces of all materials in use, kept while materials, images and meshes change.

use std::any::TypeId;

use bevy::{
    asset::UntypedAssetId,
    ecs::entity::EntityHashMap,
    platform::collections::{HashMap, HashSet},
    prelude::*,
};

use super::{
    mean::{KnownMeans, MeanColors, mean_vertex_color},
    surface::{VoxelMaterial, VoxelSurface, finite},
};

/// What a mesh is in the voxels, in the place of what its material says.
///
/// For materials whose textures the plugin cannot read, such as compressed ones, and for shaders of
/// one's own. Emission and transparency stay the material's; where that has no
/// [`VoxelMaterialPlugin`](crate::VoxelMaterialPlugin), it emits nothing and is opaque.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component)]
pub struct MeshSurface {
    /// Diffuse reflectance, the mean over the mesh: linear, 0 to 1. Default: the material's.
    pub albedo: Option<Vec3>,
    /// Share of it that is there, 0 to 1: below 1 where a mask cuts holes. Default: the material's.
    pub coverage: Option<f32>,
}

impl MeshSurface {
    /// A surface with this in the place of its own.
    pub(super) fn over(&self, surface: VoxelSurface) -> VoxelSurface {
        let coverage = self.coverage.filter(|share| share.is_finite());
        VoxelSurface {
            albedo: self.albedo.map_or(surface.albedo, |albedo| {
                finite(albedo).clamp(Vec3::ZERO, Vec3::ONE)
            }),
            coverage: coverage.map_or(surface.coverage, |share| share.clamp(0.0, 1.0)),
            ..surface
        }
    }
}

/// What meshes of a material differ in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Variant {
    /// In nothing.
    Plain,
    /// In the vertex colours of this mesh.
    Colors(AssetId<Mesh>),
    /// In the [`MeshSurface`] of this entity.
    Own(Entity),
}

/// The surfaces of all materials in use; 0 is [`VoxelSurface::NEUTRAL`].
#[derive(Resource, Clone)]
pub(crate) struct Surfaces {
    table: Vec<VoxelSurface>,
    /// Places of each material.
    index: HashMap<UntypedAssetId, HashMap<Variant, u32>>,
    /// Places of materials that are gone.
    free: Vec<u32>,
    /// Grows with each change.
    pub(crate) version: u64,
}

impl Default for Surfaces {
    fn default() -> Self {
        Self {
            table: vec![VoxelSurface::NEUTRAL],
            index: HashMap::default(),
            free: Vec::new(),
            version: 0,
        }
    }
}

impl Surfaces {
    /// A voxel has 12 bits for its surface.
    const MOST: usize = 4096;

    pub(crate) fn table(&self) -> &[VoxelSurface] {
        &self.table
    }

    /// The place of a material on such a mesh, which it keeps; the neutral one if there is no more
    /// room.
    pub(super) fn place(&mut self, id: UntypedAssetId, variant: Variant) -> u32 {
        let places = self.index.entry(id).or_default();
        if let Some(&place) = places.get(&variant) {
            return place;
        }
        let place = if let Some(place) = self.free.pop() {
            self.table[place as usize] = VoxelSurface::NEUTRAL;
            self.version += 1;
            place
        } else if self.table.len() >= Self::MOST {
            warn_once!(
                "voxel GI: more than {} materials (times meshes with vertex colours); the others \
                 count as neutral gray",
                Self::MOST - 1
            );
            return 0;
        } else {
            self.table.push(VoxelSurface::NEUTRAL);
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

    /// Of all places of a material, each with what its mesh makes of the material's surface.
    pub(super) fn set(
        &mut self,
        id: UntypedAssetId,
        surface: VoxelSurface,
        of_mesh: impl Fn(Variant, VoxelSurface) -> VoxelSurface,
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

/// The place of a mesh's material in the table.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct SurfaceIndex {
    pub place: u32,
    /// Type of the material, `None` where nothing is known of it.
    pub material: Option<TypeId>,
}

/// What the table has still to learn about one type of material.
pub(crate) struct Pending<M: Asset> {
    /// Entities whose place is not known.
    entities: HashSet<Entity>,
    waiting: HashSet<AssetId<M>>,
    users: HashMap<AssetId<Image>, HashSet<AssetId<M>>>,
    means: KnownMeans,
    /// Mean vertex colours of meshes that have some.
    tints: HashMap<AssetId<Mesh>, Vec3>,
    /// What entities have in the place of their material's.
    own: EntityHashMap<MeshSurface>,
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

/// Keeps the table and the places of meshes in step with the materials of one type.
pub(crate) fn update_surfaces<M: VoxelMaterial>(
    mut commands: Commands,
    changed: Query<
        Entity,
        (
            With<Mesh3d>,
            Or<(
                Changed<MeshMaterial3d<M>>,
                Changed<Mesh3d>,
                Changed<MeshSurface>,
            )>,
        ),
    >,
    all: Query<(
        Entity,
        &MeshMaterial3d<M>,
        &Mesh3d,
        Option<&MeshSurface>,
        Option<&SurfaceIndex>,
    )>,
    (mut without, mut without_own): (
        RemovedComponents<MeshMaterial3d<M>>,
        RemovedComponents<MeshSurface>,
    ),
    mut material_events: MessageReader<AssetEvent<M>>,
    mut image_events: MessageReader<AssetEvent<Image>>,
    mut mesh_events: MessageReader<AssetEvent<Mesh>>,
    (materials, images, meshes): (Res<Assets<M>>, Res<Assets<Image>>, Res<Assets<Mesh>>),
    mut surfaces: ResMut<Surfaces>,
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
    // Unless it has one again.
    for entity in without.read().filter(|entity| !all.contains(*entity)) {
        if let Ok(mut entity) = commands.get_entity(entity) {
            // It may have another material by now, whose place it keeps.
            entity.queue(move |mut entity: EntityWorldMut| {
                if entity
                    .get::<SurfaceIndex>()
                    .is_some_and(|index| index.material == this)
                {
                    entity.remove::<SurfaceIndex>();
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
        let index = SurfaceIndex {
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
            Variant::Colors(mesh) => VoxelSurface {
                albedo: surface.albedo * tints.get(&mesh).copied().unwrap_or(Vec3::ONE),
                ..surface
            },
            Variant::Own(entity) => own.get(&entity).map_or(surface, |own| own.over(surface)),
        });
        again
    });
}
