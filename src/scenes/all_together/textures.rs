//! The textures of the hall, as they are and encoded, and the materials that the switches select.

use std::collections::HashMap;

use bevy::{prelude::*, render::renderer::RenderDevice};
use bevy_ewa::{EwaMethod, EwaProbes, EwaSettings, EwaStandardMaterial};
use bevy_voxel_gi::MeshVoxelMaterial;
use bevy_wavelet_tex::{
    WaveletFilter, WaveletStandardMaterial, codec::rate::Rate, material::storage_on,
};
use image::{Rgb, RgbImage, buffer::ConvertBuffer};

use crate::{
    content,
    runner::{Choice, SceneSettings, Side},
    scenes::{
        all_together::{HasMatter, Matter, TextureBytes},
        maps::{Maps, Role, WaveletMaterials, Wavelets},
    },
};

/// Side of the generated materials in pixels.
const SIZE: u32 = 512;
const SEED: u64 = 3;

/// The maps of the hall.
pub fn maps() -> Maps<Matter> {
    let mut maps = Maps::empty();
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
        maps.add_material(matter, material, matter == Matter::Leaves);
    }
    let picture = content::photo_like(768, 512, SEED);
    maps.add(Matter::Picture, Role::Color, picture.convert());
    maps.add(Matter::Tiles, Role::Color, tiles().convert());
    maps
}

/// Mean of the colours that a mask leaves, linear, and how much it leaves.
fn surface(maps: &Maps<Matter>, matter: Matter) -> MeshVoxelMaterial {
    let Some(colors) = maps.get(matter, Role::Color) else {
        return MeshVoxelMaterial::default();
    };
    let mask = maps.get(matter, Role::Mask);
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
    maps: Res<Maps<Matter>>,
    mut plain: ResMut<PlainMaterials>,
    mut images: ResMut<Assets<Image>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    parts: Query<(Entity, &Side, &HasMatter)>,
) {
    for (entity, side, &HasMatter(matter)) in &parts {
        let (material, _) = plain.0.entry(matter).or_insert_with(|| {
            let mut bytes = 0;
            let mut add = |role| {
                let image = maps.uncompressed(matter, role, true)?;
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
    mut wavelet: WaveletMaterials<Matter>,
    device: Res<RenderDevice>,
    mut ewa: ResMut<Assets<EwaStandardMaterial>>,
    parts: Query<(Entity, &Side, &HasMatter)>,
) {
    let with = Wavelets {
        color: Rate::from_name(settings.choice("color_rate")).unwrap_or(Rate::Color3),
        effort: default(),
        storage: storage_on(&device),
        filter: WaveletFilter::Trilinear,
    };
    let mut selected: HashMap<Matter, SelectedMaterial> = HashMap::new();
    *bytes = TextureBytes::default();
    for (&matter, (material, plain_bytes)) in &plain.0 {
        let (material, selected_bytes) = if matter == Matter::Tiles && settings.toggle("ewa") {
            let base = materials.get(material).cloned().unwrap_or_default();
            let extension = EwaSettings::with_method(EWA_METHOD.of(&settings)).into();
            let material = ewa.add(EwaStandardMaterial { base, extension });
            (SelectedMaterial::Ewa(material), *plain_bytes)
        } else if matter != Matter::Tiles && settings.toggle("wavelet_tex") {
            let repeats = !matches!(matter, Matter::Picture | Matter::Leaves);
            let (material, bytes) = wavelet.make(matter, repeats, base(matter), with);
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
        entity.insert(surface(&wavelet.maps, *matter));
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
