//! What the switches make of materials.

use std::collections::HashMap;

use bevy::{ecs::system::SystemParam, prelude::*};
use bevy_ewa::{EwaMethod, EwaProbes, EwaSettings, EwaStandardMaterial};
use bevy_voxel_gi::MeshVoxelMaterial;
use bevy_wavelet_tex::{
    WaveletAddressMode, WaveletExtension, WaveletFilter, WaveletStandardMaterial, WaveletStorage,
    WaveletTexture, codec::rate::Rate,
};

use super::{
    figures::TextureBytes,
    hall::Matter,
    stage::Dressed,
    textures::{Role, Textures},
};
use crate::runner::{Knobs, Side};

/// Bevy's own materials, by matter, with the bytes of their textures.
#[derive(Resource, Default)]
pub struct PlainMaterials(HashMap<Matter, (Handle<StandardMaterial>, u64)>);

/// Makes Bevy's own materials and gives them to before: they hang on no switch.
pub fn before(
    mut commands: Commands,
    textures: Res<Textures>,
    mut plain: ResMut<PlainMaterials>,
    mut images: ResMut<Assets<Image>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    parts: Query<(Entity, &Side, &Dressed)>,
) {
    for (entity, side, &Dressed(matter)) in &parts {
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

/// The materials of after, again whenever a knob changes.
pub fn after(
    mut commands: Commands,
    knobs: Res<Knobs>,
    plain: Res<PlainMaterials>,
    materials: Res<Assets<StandardMaterial>>,
    mut bytes: ResMut<TextureBytes>,
    mut wavelet: WaveletMaterials,
    mut ewa: ResMut<Assets<EwaStandardMaterial>>,
    parts: Query<(Entity, &Side, &Dressed)>,
) {
    let rate = Rate::from_name(knobs.choice("color_rate")).unwrap_or(Rate::Color3);
    let mut dresses: HashMap<Matter, Dress> = HashMap::new();
    *bytes = TextureBytes::default();
    for (&matter, (material, plain_bytes)) in &plain.0 {
        let (dress, dress_bytes) = if matter == Matter::Tiles && knobs.toggle("ewa") {
            let base = materials.get(material).cloned().unwrap_or_default();
            let extension = ewa_settings(&knobs).into();
            let material = ewa.add(EwaStandardMaterial { base, extension });
            (Dress::Ewa(material), *plain_bytes)
        } else if matter != Matter::Tiles && knobs.toggle("wavelet_tex") {
            let (material, bytes) = wavelet.make(matter, rate);
            (Dress::Wavelet(material), bytes)
        } else {
            (Dress::Plain(material.clone()), *plain_bytes)
        };
        dresses.insert(matter, dress);
        bytes.before += plain_bytes;
        bytes.after += dress_bytes;
    }
    for (entity, side, Dressed(matter)) in &parts {
        let Some(dress) = dresses.get(matter).filter(|_| *side == Side::After) else {
            continue;
        };
        let mut entity = commands.entity(entity);
        // Nobody can read the mean of compressed blocks: who encoded them tells it.
        match dress {
            Dress::Wavelet(_) => entity.insert(wavelet.sources.surface(*matter)),
            Dress::Plain(_) | Dress::Ewa(_) => entity.remove::<MeshVoxelMaterial>(),
        };
        entity.remove::<(
            MeshMaterial3d<StandardMaterial>,
            MeshMaterial3d<WaveletStandardMaterial>,
            MeshMaterial3d<EwaStandardMaterial>,
        )>();
        match dress.clone() {
            Dress::Plain(material) => entity.insert(MeshMaterial3d(material)),
            Dress::Wavelet(material) => entity.insert(MeshMaterial3d(material)),
            Dress::Ewa(material) => entity.insert(MeshMaterial3d(material)),
        };
    }
}

/// A material of one of three types.
#[derive(Clone)]
enum Dress {
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
}

impl WaveletMaterials<'_> {
    /// The material, and the bytes of its textures.
    fn make(&mut self, matter: Matter, rate: Rate) -> (Handle<WaveletStandardMaterial>, u64) {
        let mut bytes = 0;
        let mut add = |role| {
            let image = self.sources.encoded(matter, role, rate)?;
            let storage = WaveletStorage::Blocks;
            let texture = WaveletTexture::add(image, storage, &mut self.textures, &mut self.images);
            bytes += self.textures.get(&texture).map_or(0, |t| t.gpu_bytes) as u64;
            Some(texture)
        };
        let extension = WaveletExtension {
            base_color: add(Role::Color),
            normal: add(Role::Normal),
            mask: add(Role::Mask),
            emissive: None,
            metallic_roughness: None,
            occlusion: None,
            filter: WaveletFilter::Trilinear,
            address_mode: match matter {
                Matter::Picture | Matter::Leaves => WaveletAddressMode::ClampToEdge,
                _ => WaveletAddressMode::Repeat,
            },
        };
        let base = base(matter);
        (
            self.materials
                .add(WaveletStandardMaterial { base, extension }),
            bytes,
        )
    }
}

fn ewa_settings(knobs: &Knobs) -> EwaSettings {
    EwaSettings::with_method(match knobs.choice("ewa_method") {
        "reference" => EwaMethod::Reference,
        "bilinear" => EwaMethod::Bilinear,
        "approximate" => EwaMethod::Approximate {
            probes: EwaProbes::Five,
        },
        _ => EwaMethod::Linear,
    })
}

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
