//! The materials that the switches select.

use std::collections::HashMap;

use bevy::{ecs::system::SystemParam, prelude::*, render::renderer::RenderDevice};
use bevy_ewa::{EwaMethod, EwaProbes, EwaSettings, EwaStandardMaterial};
use bevy_voxel_gi::MeshVoxelMaterial;
use bevy_wavelet_tex::{
    WaveletAddressMode, WaveletExtension, WaveletFilter, WaveletStandardMaterial, WaveletTexture,
    codec::rate::Rate, material::storage_on,
};

use super::{
    figures::TextureBytes,
    hall::Matter,
    stage::HasMatter,
    textures::{Role, Textures},
};
use crate::runner::{SceneSettings, Side};

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
            let extension = ewa_settings(&settings).into();
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
        // The mean of compressed blocks cannot be read back, so it is set by the code that encoded them.
        match material {
            SelectedMaterial::Wavelet(_) => entity.insert(wavelet.sources.surface(*matter)),
            SelectedMaterial::Plain(_) | SelectedMaterial::Ewa(_) => {
                entity.remove::<MeshVoxelMaterial>()
            }
        };
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

fn ewa_settings(settings: &SceneSettings) -> EwaSettings {
    EwaSettings::with_method(match settings.choice("ewa_method") {
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
