//! What voxels need to know of materials: a table of surfaces, kept while materials change.

use bevy::{
    asset::UntypedAssetId,
    pbr::{ExtendedMaterial, MaterialExtension},
    platform::collections::{HashMap, HashSet},
    prelude::*,
    render::render_resource::{Face, ShaderType},
};

/// What light meets where a mesh is.
#[derive(ShaderType, Clone, Copy, Debug, PartialEq)]
pub struct VoxelSurface {
    /// Diffuse reflectance per channel, 0 to 1.
    pub albedo: Vec3,
    /// How much of the exposure applies to the emission, 0 to 1; as
    /// `StandardMaterial::emissive_exposure_weight`.
    pub emissive_exposure_weight: f32,
    /// Emission; as `StandardMaterial::emissive`.
    pub emissive: Vec3,
    /// 1 if both sides are drawn, else 0.
    pub double_sided: u32,
    /// 1 if it lets light pass and is not voxelised, else 0.
    pub transparent: u32,
}

impl VoxelSurface {
    /// Where nothing is known of a material: neutral gray (thesis section 6.5.2).
    pub const NEUTRAL: Self = Self {
        albedo: Vec3::splat(0.5),
        emissive_exposure_weight: 0.0,
        emissive: Vec3::ZERO,
        double_sided: 0,
        transparent: 0,
    };
}

/// A material whose meshes have a known surface in the voxels.
///
/// `StandardMaterial` and its extensions are such materials. For others implement this and add
/// [`VoxelMaterialPlugin`](crate::VoxelMaterialPlugin); without, their meshes are neutral gray.
pub trait VoxelMaterial: Material {
    /// Its surface. `mean` gives the mean colour of an image, `None` while that is not loaded.
    fn surface(&self, mean: &mut MeanColors) -> VoxelSurface;
}

impl VoxelMaterial for StandardMaterial {
    fn surface(&self, mean: &mut MeanColors) -> VoxelSurface {
        let mut texture = |image: &Option<Handle<Image>>| match image {
            Some(image) => mean.of(image),
            None => LinearRgba::WHITE,
        };
        let texel = texture(&self.base_color_texture);
        let base = self.base_color.to_linear();
        let metallic = self.metallic * texture(&self.metallic_roughness_texture).blue;
        let emissive = self.emissive.to_vec3() * texture(&self.emissive_texture).to_vec3();
        let transparent = matches!(
            self.alpha_mode,
            AlphaMode::Blend | AlphaMode::Premultiplied | AlphaMode::Add | AlphaMode::Multiply
        ) || self.specular_transmission > 0.5;
        let albedo = if self.unlit {
            Vec3::ZERO
        } else {
            base.to_vec3() * texel.to_vec3() * (1.0 - metallic)
        };
        VoxelSurface {
            albedo: finite(albedo).clamp(Vec3::ZERO, Vec3::ONE),
            emissive_exposure_weight: self.emissive_exposure_weight.clamp(0.0, 1.0),
            emissive: finite(emissive).max(Vec3::ZERO),
            double_sided: u32::from(self.cull_mode != Some(Face::Back)),
            transparent: u32::from(transparent),
        }
    }
}

impl<E: MaterialExtension> VoxelMaterial for ExtendedMaterial<StandardMaterial, E> {
    fn surface(&self, mean: &mut MeanColors) -> VoxelSurface {
        self.base.surface(mean)
    }
}

fn finite(v: Vec3) -> Vec3 {
    if v.is_finite() { v } else { Vec3::ZERO }
}

/// The surfaces of all materials in use; 0 is [`VoxelSurface::NEUTRAL`].
#[derive(Resource, Clone)]
pub(crate) struct Surfaces {
    table: Vec<VoxelSurface>,
    index: HashMap<UntypedAssetId, u32>,
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

    /// The place of a material, which it keeps; the neutral one if there is no more room.
    fn place(&mut self, id: UntypedAssetId) -> u32 {
        if let Some(&place) = self.index.get(&id) {
            return place;
        }
        if let Some(place) = self.free.pop() {
            self.table[place as usize] = VoxelSurface::NEUTRAL;
            self.index.insert(id, place);
            return place;
        }
        if self.table.len() >= Self::MOST {
            warn_once!(
                "voxel GI: more than {} materials; the others count as neutral gray",
                Self::MOST - 1
            );
            return 0;
        }
        let place = u32::try_from(self.table.len()).unwrap_or(0);
        self.table.push(VoxelSurface::NEUTRAL);
        self.index.insert(id, place);
        place
    }

    fn remove(&mut self, id: UntypedAssetId) {
        self.free.extend(self.index.remove(&id));
    }

    fn set(&mut self, place: u32, surface: VoxelSurface) {
        if let Some(entry) = self.table.get_mut(place as usize).filter(|_| place > 0)
            && *entry != surface
        {
            *entry = surface;
            self.version += 1;
        }
    }
}

/// The place of a mesh's material in the table.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct SurfaceIndex(pub u32);

/// Mean colours of images, linear; computed once each.
pub struct MeanColors<'a> {
    images: &'a Assets<Image>,
    known: &'a mut HashMap<AssetId<Image>, LinearRgba>,
    /// The images asked for.
    used: Vec<AssetId<Image>>,
    /// Some of them are not loaded yet.
    waiting: bool,
}

impl MeanColors<'_> {
    /// Of this image; mid gray while it is not loaded and where it cannot be read (compressed
    /// blocks, or data that only the GPU has).
    pub fn of(&mut self, handle: &Handle<Image>) -> LinearRgba {
        const UNKNOWN: LinearRgba = LinearRgba::rgb(0.5, 0.5, 0.5);
        let id = handle.id();
        self.used.push(id);
        if let Some(&mean) = self.known.get(&id) {
            return mean;
        }
        let Some(image) = self.images.get(id) else {
            self.waiting = true;
            return UNKNOWN;
        };
        let mean = mean_color(image).unwrap_or(UNKNOWN);
        self.known.insert(id, mean);
        mean
    }
}

/// Mean of at most 64 x 64 texels, spread evenly; `None` if texels cannot be read.
fn mean_color(image: &Image) -> Option<LinearRgba> {
    const MOST: u32 = 64;
    let size = image.size();
    let count = size.min(UVec2::splat(MOST));
    let mut sum = Vec4::ZERO;
    for y in 0..count.y {
        for x in 0..count.x {
            let at = (UVec2::new(x, y) * size + size / 2) / count;
            let at = at.min(size - 1);
            sum += image.get_color_at(at.x, at.y).ok()?.to_linear().to_vec4();
        }
    }
    let mean = sum / (count.x * count.y) as f32;
    mean.is_finite().then(|| LinearRgba::from_vec4(mean))
}

/// What the table has still to learn about one type of material.
pub(crate) struct Pending<M: Asset> {
    waiting: HashSet<AssetId<M>>,
    users: HashMap<AssetId<Image>, HashSet<AssetId<M>>>,
    means: HashMap<AssetId<Image>, LinearRgba>,
}

impl<M: Asset> Default for Pending<M> {
    fn default() -> Self {
        Self {
            waiting: HashSet::default(),
            users: HashMap::default(),
            means: HashMap::default(),
        }
    }
}

/// Keeps the table and the places of meshes in step with the materials of one type.
pub(crate) fn update_surfaces<M: VoxelMaterial>(
    mut commands: Commands,
    meshes: Query<(Entity, &MeshMaterial3d<M>, Option<&SurfaceIndex>), Changed<MeshMaterial3d<M>>>,
    mut without: RemovedComponents<MeshMaterial3d<M>>,
    mut material_events: MessageReader<AssetEvent<M>>,
    mut image_events: MessageReader<AssetEvent<Image>>,
    materials: Res<Assets<M>>,
    images: Res<Assets<Image>>,
    mut surfaces: ResMut<Surfaces>,
    mut pending: Local<Pending<M>>,
) {
    let pending = &mut *pending;
    for entity in without.read() {
        if let Ok(mut entity) = commands.get_entity(entity) {
            entity.remove::<SurfaceIndex>();
        }
    }
    for (entity, material, known) in &meshes {
        let place = surfaces.place(material.id().untyped());
        pending.waiting.insert(material.id());
        if known != Some(&SurfaceIndex(place)) {
            commands.entity(entity).insert(SurfaceIndex(place));
        }
    }
    for event in material_events.read() {
        match event {
            AssetEvent::Modified { id } if surfaces.index.contains_key(&id.untyped()) => {
                pending.waiting.insert(*id);
            }
            AssetEvent::Removed { id } => {
                pending.waiting.remove(id);
                surfaces.remove(id.untyped());
            }
            _ => {}
        }
    }
    for event in image_events.read() {
        if let AssetEvent::Modified { id } = event {
            pending.means.remove(id);
            pending
                .waiting
                .extend(pending.users.get(id).into_iter().flatten());
        }
    }
    let Pending {
        waiting,
        users,
        means,
    } = pending;
    waiting.retain(|&id| {
        let Some(material) = materials.get(id) else {
            return true;
        };
        let mut mean = MeanColors {
            images: &images,
            known: means,
            used: Vec::new(),
            waiting: false,
        };
        let surface = material.surface(&mut mean);
        for image in mean.used {
            users.entry(image).or_default().insert(id);
        }
        let again = mean.waiting;
        let place = surfaces.place(id.untyped());
        surfaces.set(place, surface);
        again
    });
}
