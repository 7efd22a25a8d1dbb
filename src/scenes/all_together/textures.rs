//! The textures of the hall, as they are and encoded, and the materials that the switches select.

use std::collections::{HashMap, hash_map::Entry};

use bevy::{ecs::system::SystemParam, prelude::*, render::renderer::RenderDevice};
use bevy_ewa::{EwaMethod, EwaProbes, EwaSettings, EwaStandardMaterial};
use bevy_voxel_gi::MeshVoxelMaterial;
use bevy_wavelet_tex::{
    WaveletAddressMode, WaveletExtension, WaveletFilter, WaveletStandardMaterial, WaveletTexture,
    codec::{
        image::{ColorSpace, Content, WaveletImage},
        rate::Rate,
    },
    material::storage_on,
};
use image::{DynamicImage, Rgb, RgbImage, RgbaImage};

use crate::{
    content,
    runner::{Choice, SceneSettings, Side},
    scenes::all_together::{HasMatter, Matter, TextureBytes},
    wavelets::{encoded, wavelets},
};

/// Side of the generated materials in pixels.
const SIZE: u32 = 512;
const SEED: u64 = 3;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    Color,
    Normal,
    /// Where it is.
    Mask,
}

#[derive(Resource)]
pub struct Textures {
    maps: HashMap<(Matter, Role), RgbaImage>,
    /// Colours with the mask as their alpha, as a `StandardMaterial` wants them.
    masked: HashMap<Matter, RgbaImage>,
    encoded: HashMap<(Matter, Role, Rate), WaveletImage>,
}

impl Default for Textures {
    fn default() -> Self {
        let mut maps = HashMap::new();
        let mut masked = HashMap::new();
        for (matter, generate) in [
            (
                Matter::Bricks,
                content::bricks as fn(u32, u32, u64) -> content::Material,
            ),
            (Matter::Planks, content::wood),
            (Matter::Stone, content::noise),
            (Matter::Leaves, content::foliage),
        ] {
            let material = generate(SIZE, SIZE, SEED);
            if matter == Matter::Leaves {
                masked.insert(matter, material.masked_color());
                let mask = DynamicImage::from(material.mask).into_rgba8();
                maps.insert((matter, Role::Mask), mask);
            }
            maps.insert((matter, Role::Color), rgba(material.color));
            maps.insert((matter, Role::Normal), rgba(material.normal));
        }
        let picture = content::photo_like(768, 512, SEED);
        maps.insert((Matter::Picture, Role::Color), rgba(picture));
        maps.insert((Matter::Tiles, Role::Color), rgba(tiles()));
        Self {
            maps,
            masked,
            encoded: HashMap::new(),
        }
    }
}

impl Textures {
    /// A texture with mips as Bevy has it; none where a matter has no such texture.
    pub fn uncompressed(&self, matter: Matter, role: Role) -> Option<Image> {
        let pixels = match role {
            Role::Color => self.masked.get(&matter),
            Role::Normal | Role::Mask => None,
        };
        let pixels = pixels.or_else(|| self.maps.get(&(matter, role)))?;
        Some(content::mipped_texture(pixels, role == Role::Color))
    }

    /// Mean of the colours that a mask leaves, linear, and how much it leaves.
    pub fn surface(&self, matter: Matter) -> MeshVoxelMaterial {
        let Some(colors) = self.maps.get(&(matter, Role::Color)) else {
            return MeshVoxelMaterial::default();
        };
        let mask = self.maps.get(&(matter, Role::Mask));
        let is_there = |x, y| mask.is_none_or(|mask| mask.get_pixel(x, y)[0] >= 128);
        let mut sum = Vec3::ZERO;
        let mut count = 0.0;
        for (_, _, pixel) in colors
            .enumerate_pixels()
            .filter(|(x, y, _)| is_there(*x, *y))
        {
            sum += LinearRgba::from(Srgba::rgb_u8(pixel[0], pixel[1], pixel[2])).to_vec3();
            count += 1.0;
        }
        MeshVoxelMaterial {
            albedo: (count > 0.0).then(|| sum / count),
            coverage: Some(count / colors.pixels().len() as f32),
            ..default()
        }
    }

    /// The same encoded, colours at this rate.
    pub fn encoded(&mut self, matter: Matter, role: Role, color: Rate) -> Option<&WaveletImage> {
        let pixels = self.maps.get(&(matter, role))?;
        let (rate, color_space) = match role {
            Role::Color => (color, ColorSpace::Srgb),
            Role::Normal => (Rate::usual(Content::Normal), ColorSpace::Linear),
            Role::Mask => (Rate::usual(Content::Gray), ColorSpace::Linear),
        };
        match self.encoded.entry((matter, role, rate)) {
            Entry::Occupied(known) => Some(known.into_mut()),
            Entry::Vacant(vacant) => {
                let encoded = encoded(pixels, &wavelets(rate, color_space));
                let encoded = encoded.inspect_err(|error| error!("{error}"));
                Some(vacant.insert(encoded.ok()?))
            }
        }
    }
}

fn rgba(image: RgbImage) -> RgbaImage {
    DynamicImage::from(image).into_rgba8()
}

/// Tiles of two kinds of polished stone, with joints.
fn tiles() -> RgbImage {
    const TILE: u32 = SIZE / 8;
    const JOINT: u32 = 2;
    let grain = content::noise(SIZE, SIZE, SEED + 1).color;
    RgbImage::from_fn(SIZE, SIZE, |x, y| {
        let in_joint = x % TILE < JOINT || y % TILE < JOINT;
        let light = (x / TILE + y / TILE).is_multiple_of(2);
        let tint = match (in_joint, light) {
            (true, _) => [40.0, 37.0, 34.0],
            (false, true) => [226.0, 216.0, 196.0],
            (false, false) => [84.0, 52.0, 44.0],
        };
        let Rgb(grain) = grain.get_pixel(x, y);
        let shade = 0.82 + 0.3 * f32::from(grain[1]) / 255.0;
        Rgb(tint.map(|level: f32| (level * shade).clamp(0.0, 255.0) as u8))
    })
}

/// Bevy's own materials, by matter, with the bytes of their textures.
#[derive(Resource, Default)]
pub struct PlainMaterials(HashMap<Matter, (Handle<StandardMaterial>, u64)>);

/// Makes Bevy's own materials and gives them to before: they depend on no switch.
pub fn before(
    mut commands: Commands,
    textures: Res<Textures>,
    mut plain: ResMut<PlainMaterials>,
    mut images: ResMut<Assets<Image>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    parts: Query<(Entity, &Side, &HasMatter)>,
) {
    for (entity, side, &HasMatter(matter)) in &parts {
        let (material, _) = plain.0.entry(matter).or_insert_with(|| {
            let mut bytes = 0;
            let mut add = |role| {
                let image = textures.uncompressed(matter, role)?;
                bytes += image.data.as_ref().map_or(0, Vec::len) as u64;
                Some(images.add(image))
            };
            let material = StandardMaterial {
                base_color_texture: add(Role::Color),
                normal_map_texture: add(Role::Normal),
                ..base(matter)
            };
            (materials.add(material), bytes)
        });
        if *side == Side::Before {
            commands
                .entity(entity)
                .insert(MeshMaterial3d(material.clone()));
        }
    }
}

/// The materials of after, again whenever a setting changes.
pub fn after(
    mut commands: Commands,
    settings: Res<SceneSettings>,
    plain: Res<PlainMaterials>,
    materials: Res<Assets<StandardMaterial>>,
    mut bytes: ResMut<TextureBytes>,
    mut wavelet: WaveletMaterials,
    mut ewa: ResMut<Assets<EwaStandardMaterial>>,
    parts: Query<(Entity, &Side, &HasMatter)>,
) {
    let rate = Rate::from_name(settings.choice("color_rate")).unwrap_or(Rate::Color3);
    let mut selected: HashMap<Matter, SelectedMaterial> = HashMap::new();
    *bytes = TextureBytes::default();
    for (&matter, (material, plain_bytes)) in &plain.0 {
        let (material, selected_bytes) = if matter == Matter::Tiles && settings.toggle("ewa") {
            let base = materials.get(material).cloned().unwrap_or_default();
            let extension = EwaSettings::with_method(EWA_METHOD.of(&settings)).into();
            let material = ewa.add(EwaStandardMaterial { base, extension });
            (SelectedMaterial::Ewa(material), *plain_bytes)
        } else if matter != Matter::Tiles && settings.toggle("wavelet_tex") {
            let (material, bytes) = wavelet.make(matter, rate);
            (SelectedMaterial::Wavelet(material), bytes)
        } else {
            (SelectedMaterial::Plain(material.clone()), *plain_bytes)
        };
        selected.insert(matter, material);
        bytes.before += plain_bytes;
        bytes.after += selected_bytes;
    }
    for (entity, side, HasMatter(matter)) in &parts {
        let Some(material) = selected.get(matter).filter(|_| *side == Side::After) else {
            continue;
        };
        let mut entity = commands.entity(entity);
        // A sampler cannot read the coefficients of wavelet textures, so voxels have their mean; and with images the same,
        // so that the light is.
        entity.insert(wavelet.sources.surface(*matter));
        entity.remove::<(
            MeshMaterial3d<StandardMaterial>,
            MeshMaterial3d<WaveletStandardMaterial>,
            MeshMaterial3d<EwaStandardMaterial>,
        )>();
        match material.clone() {
            SelectedMaterial::Plain(material) => entity.insert(MeshMaterial3d(material)),
            SelectedMaterial::Wavelet(material) => entity.insert(MeshMaterial3d(material)),
            SelectedMaterial::Ewa(material) => entity.insert(MeshMaterial3d(material)),
        };
    }
}

#[derive(Clone)]
enum SelectedMaterial {
    Plain(Handle<StandardMaterial>),
    Wavelet(Handle<WaveletStandardMaterial>),
    Ewa(Handle<EwaStandardMaterial>),
}

/// What it takes to make a material of wavelet textures.
#[derive(SystemParam)]
pub struct WaveletMaterials<'w> {
    sources: ResMut<'w, Textures>,
    images: ResMut<'w, Assets<Image>>,
    textures: ResMut<'w, Assets<WaveletTexture>>,
    materials: ResMut<'w, Assets<WaveletStandardMaterial>>,
    device: Res<'w, RenderDevice>,
}

impl WaveletMaterials<'_> {
    /// The material, and the bytes of its textures.
    fn make(&mut self, matter: Matter, rate: Rate) -> (Handle<WaveletStandardMaterial>, u64) {
        let mut bytes = 0;
        let mut add = |role| {
            let image = self.sources.encoded(matter, role, rate)?;
            let storage = storage_on(&self.device);
            let texture = WaveletTexture::add(image, storage, &mut self.textures, &mut self.images);
            bytes += self.textures.get(&texture).map_or(0, |t| t.gpu_bytes) as u64;
            Some(texture)
        };
        let extension = WaveletExtension {
            base_color: add(Role::Color),
            normal: add(Role::Normal),
            mask: add(Role::Mask),
            filter: WaveletFilter::Trilinear,
            address_mode: match matter {
                Matter::Picture | Matter::Leaves => WaveletAddressMode::ClampToEdge,
                _ => WaveletAddressMode::Repeat,
            },
            ..default()
        };
        let base = base(matter);
        (
            self.materials
                .add(WaveletStandardMaterial { base, extension }),
            bytes,
        )
    }
}

pub static EWA_METHOD: Choice<EwaMethod, 4> = Choice::new(
    "ewa_method",
    "of the floor",
    0,
    [
        ("linear", EwaMethod::Linear),
        ("reference", EwaMethod::Reference),
        ("bilinear", EwaMethod::Bilinear),
        (
            "approximate",
            EwaMethod::Approximate {
                probes: EwaProbes::Five,
            },
        ),
    ],
);

/// What all materials of a matter have in common.
fn base(matter: Matter) -> StandardMaterial {
    let leaves = matter == Matter::Leaves;
    StandardMaterial {
        perceptual_roughness: match matter {
            Matter::Tiles => 0.55,
            Matter::Picture => 0.8,
            _ => 0.9,
        },
        reflectance: 0.3,
        alpha_mode: if leaves {
            AlphaMode::Mask(0.5)
        } else {
            AlphaMode::Opaque
        },
        double_sided: leaves,
        cull_mode: if leaves {
            None
        } else {
            StandardMaterial::default().cull_mode
        },
        ..default()
    }
}
