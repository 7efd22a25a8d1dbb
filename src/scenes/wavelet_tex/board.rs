//! The picture at every rate, side by side: a board of panels, each with a label below it.

use bevy::{
    image::{ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor},
    math::Affine2,
    prelude::*,
    render::renderer::RenderDevice,
};
use bevy_wavelet_tex::{
    WaveletAddressMode, WaveletExtension, WaveletFilter, WaveletStandardMaterial, WaveletStorage,
    WaveletTexture,
    codec::{
        encoder::encode,
        image::{Content, WaveletImage},
        quality::psnr_db,
        rate::Rate,
        settings::{Effort, EncodeSettings, Formats, Method},
    },
};

use crate::{
    content,
    runner::{MemoryFigures, Notes, PictureArea, SceneSettings, Side},
    scenes::wavelet_tex::{
        self,
        room::{Sources, gray},
    },
};

/// Panels in a row.
const COLUMNS: usize = 4;
/// Size of a panel with its label and the gap around them, in metres.
const CELL: Vec2 = Vec2::new(0.9, 0.72);
/// Size of the largest picture on a panel, in metres.
const PANEL: Vec2 = Vec2::new(0.87, 0.6);
/// Height of a label, in metres.
const LABEL: f32 = 0.06;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Shown {
    Original,
    Encoded(Rate, Method),
}

impl Shown {
    fn name(self) -> String {
        let Self::Encoded(rate, method) = self else {
            return "rgba8".into();
        };
        let by = match method {
            Method::Thesis => " (thesis)",
            Method::OneFetch => " (one fetch)",
            Method::Best => "",
        };
        format!("{}{by}", rate.name())
    }

    fn is_gray(self) -> bool {
        matches!(self, Self::Encoded(rate, _) if rate.content(false) == Content::Gray)
    }
}

/// The panels, from the top left.
const PANELS: [Shown; 8] = [
    Shown::Original,
    Shown::Encoded(Rate::Color5, Method::Best),
    Shown::Encoded(Rate::Color3_25, Method::Best),
    Shown::Encoded(Rate::Color3, Method::Best),
    Shown::Encoded(Rate::Color3, Method::Thesis),
    Shown::Encoded(Rate::Color2_25, Method::Best),
    Shown::Encoded(Rate::Gray3, Method::Best),
    Shown::Encoded(Rate::Gray2, Method::Best),
];

/// The parent of all panels, at the distance at which the board fills the picture of the camera's first pose.
#[derive(Component)]
pub struct Board;

/// A panel of a side, by its place in [`PANELS`].
#[derive(Component)]
pub struct Panel(usize);

#[derive(Component)]
pub struct Label(usize);

/// The textures of the panels, once they are asked for.
#[derive(Resource, Default)]
pub struct Textures {
    /// RGBA8, of colour and of gray.
    originals: Option<[Handle<Image>; 2]>,
    /// Of one of them, with its mips.
    original_bytes: u64,
    encoded: Vec<WaveletImage>,
    encoded_with: Option<(Effort, WaveletStorage)>,
}

/// Spawns the panels for both sides, and their labels.
pub fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, sources: Res<Sources>) {
    let (width, height) = sources.picture().dimensions();
    let picture = Vec2::new(width as f32, height as f32);
    let size = picture * (PANEL / picture).min_element();
    let mesh = Mesh3d(meshes.add(Rectangle::from_size(size)));
    let board = commands.spawn((Board, Transform::default(), Visibility::Hidden));
    let board = board.id();
    for index in 0..PANELS.len() {
        let place = Vec2::new((index % COLUMNS) as f32, (index / COLUMNS) as f32);
        let rows = PANELS.len().div_ceil(COLUMNS) as f32;
        let middle = (place - 0.5 * Vec2::new(COLUMNS as f32 - 1.0, rows - 1.0)) * CELL;
        let at = |y: f32| Transform::from_xyz(middle.x, -middle.y + y, 0.0);
        for side in Side::BOTH {
            commands.spawn((
                Panel(index),
                side,
                side.layers(),
                mesh.clone(),
                at(0.5 * LABEL),
                ChildOf(board),
            ));
        }
        let below = 0.5 * LABEL - 0.5 * size.y - 0.6 * LABEL;
        commands.spawn((Label(index), at(below), ChildOf(board)));
    }
}

/// The pose of the cameras at the start, which the board faces.
#[derive(Resource)]
pub struct FirstView(pub Transform);

/// Shows the board or the room, and moves the board to where it fills the picture.
pub fn place(
    settings: Res<SceneSettings>,
    area: Res<PictureArea>,
    view: Res<FirstView>,
    mut board: Single<(&mut Transform, &mut Visibility), With<Board>>,
) {
    if !settings.is_changed() && !area.is_changed() {
        return;
    }
    let (transform, visibility) = &mut *board;
    visibility.set_if_neq(
        if wavelet_tex::PLACE.of(&settings) == wavelet_tex::Place::Rates {
            Visibility::Visible
        } else {
            Visibility::Hidden
        },
    );
    let picture = area.0.size().as_vec2().max(Vec2::ONE);
    let rows = PANELS.len().div_ceil(COLUMNS) as f32;
    let whole = CELL * Vec2::new(COLUMNS as f32, rows);
    // Of the picture, one metre before the camera.
    let high = 2.0 * (0.5 * PerspectiveProjection::default().fov).tan();
    let seen = Vec2::new(high * picture.x / picture.y, high);
    let distance = (whole / seen).max_element();
    let pose = view.0 * Transform::from_xyz(0.0, 0.0, -distance);
    transform.set_if_neq(pose);
}

pub fn configure(
    mut commands: Commands,
    settings: Res<SceneSettings>,
    sources: Res<Sources>,
    mut own: ResMut<Textures>,
    mut memory: ResMut<MemoryFigures>,
    mut notes: ResMut<Notes>,
    mut images: ResMut<Assets<Image>>,
    mut textures: ResMut<Assets<WaveletTexture>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut wavelet: ResMut<Assets<WaveletStandardMaterial>>,
    mut meshes: ResMut<Assets<Mesh>>,
    panels: Query<(Entity, &Side, &Panel)>,
    labels: Query<(Entity, &Label)>,
    device: Res<RenderDevice>,
) {
    if wavelet_tex::PLACE.of(&settings) != wavelet_tex::Place::Rates {
        return;
    }
    let filter = wavelet_tex::FILTER.of(&settings);
    let [color, luma] = own.originals(&sources, &mut images);
    let storage = wavelet_tex::storage(&settings, &device);
    let relabel = own.encode(&sources, wavelet_tex::EFFORT.of(&settings), storage);
    let base = StandardMaterial {
        unlit: true,
        uv_transform: zoom(&settings),
        ..default()
    };
    let originals = [&color, &luma].map(|image| {
        if let Some(mut image) = images.get_mut(image) {
            image.sampler = sampler(filter);
        }
        materials.add(StandardMaterial {
            base_color_texture: Some(image.clone()),
            ..base.clone()
        })
    });
    let mut figures = MemoryFigures::default();
    let mut quality = Notes::default();
    let mut handles = Vec::new();
    let mut texts = Vec::new();
    for (index, shown) in PANELS.into_iter().enumerate() {
        let name = shown.name();
        let mut text = name.clone();
        let mut bytes = own.original_bytes;
        let mut handle = None;
        if shown != Shown::Original {
            let encoded = &own.encoded[index - 1];
            let texture = WaveletTexture::add(encoded, storage, &mut textures, &mut images);
            bytes = textures.get(&texture).map_or(0, |t| t.gpu_bytes) as u64;
            handle = Some(texture);
            let db = format!("{:.1} dB", psnr_db(&sources.picture_source(), encoded));
            text = format!("{text}  {db}");
            quality.0.insert(format!("{name}:"), db);
        }
        figures
            .0
            .insert(format!("{name} before"), own.original_bytes);
        figures.0.insert(format!("{name} after"), bytes);
        texts.push(format!("{text}  {} KiB", (bytes + 512) / 1024));
        handles.push(handle);
    }
    memory.set_if_neq(figures);
    notes.set_if_neq(quality);
    for (entity, side, Panel(index)) in &panels {
        let gray = PANELS[*index].is_gray();
        let mut panel = commands.entity(entity);
        match (side, &handles[*index]) {
            (Side::After, Some(texture)) => {
                let extension = WaveletExtension {
                    base_color: Some(texture.clone()),
                    filter,
                    address_mode: WaveletAddressMode::ClampToEdge,
                    ..default()
                };
                let material = wavelet.add(WaveletStandardMaterial {
                    base: base.clone(),
                    extension,
                });
                panel.insert(MeshMaterial3d(material));
            }
            (Side::Before, _) | (Side::After, None) => {
                panel.insert(MeshMaterial3d(originals[usize::from(gray)].clone()));
            }
        }
    }
    if relabel {
        for (entity, Label(index)) in &labels {
            let picture = content::label(&texts[*index], 40);
            let (width, height) = picture.dimensions();
            let size = Vec2::new(width as f32 / height as f32, 1.0) * LABEL;
            let material = StandardMaterial {
                base_color_texture: Some(images.add(content::mipped_texture(&picture, true))),
                alpha_mode: AlphaMode::Blend,
                unlit: true,
                ..default()
            };
            commands.entity(entity).insert((
                Mesh3d(meshes.add(Rectangle::from_size(size))),
                MeshMaterial3d(materials.add(material)),
            ));
        }
    }
}

impl Textures {
    fn originals(&mut self, sources: &Sources, images: &mut Assets<Image>) -> [Handle<Image>; 2] {
        let original_bytes = &mut self.original_bytes;
        let make = || {
            let color = sources.picture();
            [color.clone(), gray(color)].map(|pixels| {
                let image = content::mipped_texture(&pixels, true);
                *original_bytes = image.data.as_ref().map_or(0, Vec::len) as u64;
                images.add(image)
            })
        };
        self.originals.get_or_insert_with(make).clone()
    }

    /// Encodes the picture for every panel, unless it is; whether it was not, and labels change.
    fn encode(&mut self, sources: &Sources, effort: Effort, storage: WaveletStorage) -> bool {
        if self.encoded_with == Some((effort, storage)) {
            return false;
        }
        let encoded = PANELS.into_iter().filter_map(|shown| match shown {
            Shown::Original => None,
            Shown::Encoded(rate, method) => {
                let settings = EncodeSettings {
                    rate,
                    effort,
                    method,
                    formats: Formats::Wavelet,
                    ..EncodeSettings::default()
                };
                // Its size was found to be good when the room's was encoded.
                encode(&sources.picture_source(), &settings, &|_, _| {}).ok()
            }
        });
        self.encoded = encoded.collect();
        self.encoded_with = Some((effort, storage));
        true
    }
}

fn zoom(settings: &SceneSettings) -> Affine2 {
    let part = 1.0 / settings.float("zoom");
    let corner = |name| (settings.float(name) - 0.5 * part).clamp(0.0, 1.0 - part);
    let corner = Vec2::new(corner("focus_x"), corner("focus_y"));
    Affine2::from_scale_angle_translation(Vec2::splat(part), 0.0, corner)
}

/// The hardware's filter that is most similar to one of the plugin's.
fn sampler(filter: WaveletFilter) -> ImageSampler {
    let within = match filter {
        WaveletFilter::Nearest | WaveletFilter::NearestMipLinear => ImageFilterMode::Nearest,
        _ => ImageFilterMode::Linear,
    };
    ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::ClampToEdge,
        address_mode_v: ImageAddressMode::ClampToEdge,
        mag_filter: within,
        min_filter: within,
        mipmap_filter: match filter {
            WaveletFilter::Nearest | WaveletFilter::Bilinear => ImageFilterMode::Nearest,
            _ => ImageFilterMode::Linear,
        },
        ..default()
    })
}
