//! A lit room with a picture, a brick wall, a wooden floor and a plant: RGBA8 textures with mips
//! before, wavelet textures after.

mod room;
mod textures;

use bevy::prelude::*;
use bevy_wavelet_tex::{
    WaveletAddressMode, WaveletExtension, WaveletFilter, WaveletStandardMaterial, WaveletStorage,
    WaveletTexPlugin, WaveletTexture,
    codec::{rate::Rate, search::Effort},
};

use crate::runner::{Knob, Knobs, MemoryFigures, Scene, SceneImage, Side};
use room::{Part, Surface};
use textures::{SourceMap, Sources};

/// The example of `bevy_wavelet_tex`.
pub struct WaveletTex;

impl Scene for WaveletTex {
    fn name(&self) -> &'static str {
        "wavelet_tex"
    }

    fn plugin(&self) -> &'static str {
        "bevy_wavelet_tex"
    }

    fn description(&self) -> &'static str {
        "A lit room: RGBA8 textures before, wavelet textures of 2 to 5 bits per pixel after"
    }

    fn knobs(&self) -> Vec<Knob> {
        vec![
            Knob::choice(
                "filter",
                "how decoded pixels are filtered",
                4,
                &[
                    "nearest",
                    "nearest_mip_linear",
                    "bilinear",
                    "one_fetch_trilinear",
                    "trilinear",
                    "anisotropic",
                ],
            ),
            Knob::choice(
                "color_rate",
                "bits per pixel of colours",
                1,
                &["color2.25", "color3", "color3.25", "color5"],
            ),
            Knob::choice(
                "effort",
                "how hard the encoder searches",
                1,
                &["fast", "default", "best"],
            ),
            Knob::choice(
                "storage",
                "as BC blocks, or decoded on load as without BC",
                0,
                &["blocks", "decoded"],
            ),
            Knob::float(
                "light_angle",
                "direction of the lamp",
                25.0,
                -80.0..=80.0,
                "degrees",
            ),
        ]
    }

    fn view(&self) -> Transform {
        Transform::from_xyz(0.0, 1.35, 3.1).looking_at(Vec3::new(0.0, 1.2, 0.0), Vec3::Y)
    }

    fn build(&self, app: &mut App) {
        app.add_plugins(WaveletTexPlugin)
            .add_systems(Startup, (load_sources, room::spawn).chain())
            .add_systems(
                Update,
                (dress_before, dress_after, room::aim_lamps).run_if(resource_changed::<Knobs>),
            );
    }
}

fn load_sources(mut commands: Commands, image: Res<SceneImage>) {
    commands.insert_resource(Sources::new(image.0.as_deref()));
}

/// Materials with the original textures, once: they hang on no knob.
fn dress_before(
    mut commands: Commands,
    sources: Res<Sources>,
    mut memory: ResMut<MemoryFigures>,
    mut images: ResMut<Assets<Image>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    parts: Query<(Entity, &Side, &Part), Without<MeshMaterial3d<StandardMaterial>>>,
) {
    let mut bytes = 0;
    for (entity, side, part) in &parts {
        if *side == Side::After {
            continue;
        }
        let surface = part.surface();
        let mut add = |map: &SourceMap| {
            let image = map.uncompressed();
            bytes += image.data.as_ref().map_or(0, Vec::len) as u64;
            images.add(image)
        };
        let material = StandardMaterial {
            base_color_texture: Some(add(sources.base_color_with_mask(surface))),
            normal_map_texture: sources.normal(surface).map(&mut add),
            ..room::base_material(*part)
        };
        let material = materials.add(material);
        commands.entity(entity).insert(MeshMaterial3d(material));
    }
    if bytes > 0 {
        memory.0.insert("textures before".into(), bytes);
    }
}

/// Materials with wavelet textures, again at each change of a knob.
fn dress_after(
    mut commands: Commands,
    knobs: Res<Knobs>,
    mut sources: ResMut<Sources>,
    mut memory: ResMut<MemoryFigures>,
    mut images: ResMut<Assets<Image>>,
    mut textures: ResMut<Assets<WaveletTexture>>,
    mut materials: ResMut<Assets<WaveletStandardMaterial>>,
    parts: Query<(Entity, &Side, &Part)>,
) {
    let filter = match knobs.choice("filter") {
        "nearest" => WaveletFilter::Nearest,
        "nearest_mip_linear" => WaveletFilter::NearestMipLinear,
        "one_fetch_trilinear" => WaveletFilter::OneFetchTrilinear,
        "anisotropic" => WaveletFilter::Anisotropic,
        "bilinear" => WaveletFilter::Bilinear,
        _ => WaveletFilter::Trilinear,
    };
    let effort = match knobs.choice("effort") {
        "fast" => Effort::Fast,
        "best" => Effort::Best,
        _ => Effort::Default,
    };
    let storage = match knobs.choice("storage") {
        "decoded" => WaveletStorage::Decoded,
        _ => WaveletStorage::Blocks,
    };
    let color = Rate::from_name(knobs.choice("color_rate")).unwrap_or(Rate::Color3);
    sources.encode(effort, color);
    let mut bytes = 0;
    for (entity, side, part) in &parts {
        if *side == Side::Before {
            continue;
        }
        let surface = part.surface();
        let mut add = |map: &SourceMap| {
            let texture = WaveletTexture::add(map.encoded(), storage, &mut textures, &mut images);
            bytes += textures.get(&texture).map_or(0, |t| t.gpu_bytes) as u64;
            texture
        };
        let extension = WaveletExtension {
            base_color: Some(add(sources.base_color(surface))),
            normal: sources.normal(surface).map(&mut add),
            mask: sources.mask(surface).map(&mut add),
            emissive: None,
            metallic_roughness: None,
            occlusion: None,
            filter,
            address_mode: match surface {
                Surface::Picture | Surface::Plant => WaveletAddressMode::ClampToEdge,
                Surface::Bricks | Surface::Floor => WaveletAddressMode::Repeat,
            },
        };
        let base = room::base_material(*part);
        let material = materials.add(WaveletStandardMaterial { base, extension });
        commands.entity(entity).insert(MeshMaterial3d(material));
    }
    memory.0.insert("textures after".into(), bytes);
}
