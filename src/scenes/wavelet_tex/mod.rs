//! A lit room with a picture, a brick wall, a wooden floor and a plant, or the picture at every rate
//! side by side: RGBA8 textures with mips before, wavelet textures after, or the error between them.

use bevy::{
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    prelude::*,
    render::renderer::RenderDevice,
};
use bevy_wavelet_tex::{
    WaveletFilter, WaveletStorage, WaveletTexPlugin,
    codec::{rate::Rate, settings::Effort},
    material::storage_on,
};

use crate::{
    runner::{Choice, MemoryFigures, Notes, Scene, SceneImage, SceneSetting, SceneSettings, Side},
    scenes::{
        error_view::{self, ErrorViewPlugin, ErrorViewSystems, Films},
        maps::{Role, WaveletMaterials, Wavelets},
        wavelet_tex::room::{Part, Sources, Surface},
    },
};

mod board;
mod room;

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
        "A lit room, or a picture at all rates: RGBA8 textures before, wavelet textures of 2 to 5 \
         bits per pixel after"
    }

    fn settings(&self) -> Vec<SceneSetting> {
        vec![
            PLACE.setting(),
            error_view::view_setting(),
            error_view::gain_setting(),
            SceneSetting::float(
                "zoom",
                "of rates: the part of the picture that is shown, magnified so often",
                1.0,
                1.0..=32.0,
                "",
            ),
            SceneSetting::float(
                "focus_x",
                "of rates: the middle of that part, from the left edge to the right one",
                0.5,
                0.0..=1.0,
                "",
            ),
            SceneSetting::float(
                "focus_y",
                "the same from the upper edge to the lower one",
                0.5,
                0.0..=1.0,
                "",
            ),
            FILTER.setting(),
            SceneSetting::choice(
                "color_rate",
                "of the room: bits per pixel of colours",
                1,
                &["color2.25", "color3", "color3.25", "color5"],
            ),
            EFFORT.setting(),
            SceneSetting::choice(
                "storage",
                "as BC blocks, or decoded on load as without BC",
                0,
                &["blocks", "decoded"],
            ),
            SceneSetting::float(
                "light_angle",
                "of the room: direction of the light",
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
        app.add_plugins((WaveletTexPlugin, ErrorViewPlugin))
            .insert_resource(board::FirstView(self.view()))
            .init_resource::<board::Textures>()
            .init_resource::<BytesBefore>()
            .add_systems(Startup, (load_sources, (room::spawn, board::spawn)).chain())
            .add_systems(
                Update,
                (
                    (
                        configure_before,
                        configure_after,
                        board::configure,
                        room::aim_lights,
                        room::show,
                    )
                        .chain()
                        .run_if(resource_changed::<SceneSettings>),
                    board::place,
                )
                    .before(ErrorViewSystems),
            )
            .add_systems(Update, map_tones.after(ErrorViewSystems));
    }

    fn configure_camera(&self, camera: &mut EntityCommands, side: Side) {
        // Dithering would hide how small an error is.
        camera.insert((Films(side), DebandDither::Disabled));
    }
}

/// The room is lit, and the board is there to be seen as it is.
fn map_tones(
    mut commands: Commands,
    settings: Res<SceneSettings>,
    cameras: Query<Entity, With<Films>>,
    new: Query<(), Added<Films>>,
) {
    if !settings.is_changed() && new.is_empty() {
        return;
    }
    for camera in &cameras {
        commands.entity(camera).insert(match PLACE.of(&settings) {
            Place::Room => Tonemapping::default(),
            Place::Rates => Tonemapping::None,
        });
    }
}

fn load_sources(mut commands: Commands, image: Res<SceneImage>) {
    commands.insert_resource(Sources::new(image.0.as_deref()));
}

/// The memory of the room's original textures in bytes.
#[derive(Resource, Default)]
struct BytesBefore(u64);

/// Materials with the original textures, once: they depend on no setting.
fn configure_before(
    mut commands: Commands,
    sources: Res<Sources>,
    mut before: ResMut<BytesBefore>,
    mut images: ResMut<Assets<Image>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    parts: Query<(Entity, &Side, &Part), Without<MeshMaterial3d<StandardMaterial>>>,
) {
    for (entity, side, part) in &parts {
        if *side == Side::After {
            continue;
        }
        let surface = part.surface();
        let mut add = |role| {
            let image = sources.uncompressed(surface, role, surface.repeats())?;
            before.0 += image.data.as_ref().map_or(0, Vec::len) as u64;
            Some(images.add(image))
        };
        let material = StandardMaterial {
            base_color_texture: add(Role::Color),
            normal_map_texture: add(Role::Normal),
            ..room::base_material(*part)
        };
        let material = materials.add(material);
        commands.entity(entity).insert(MeshMaterial3d(material));
    }
}

/// Materials with wavelet textures, again at each change of a setting.
fn configure_after(
    mut commands: Commands,
    settings: Res<SceneSettings>,
    before: Res<BytesBefore>,
    mut memory: ResMut<MemoryFigures>,
    mut notes: ResMut<Notes>,
    mut wavelet: WaveletMaterials<Surface>,
    parts: Query<(Entity, &Side, &Part)>,
    device: Res<RenderDevice>,
) {
    if PLACE.of(&settings) != Place::Room {
        return;
    }
    let with = Wavelets {
        color: Rate::from_name(settings.choice("color_rate")).unwrap_or(Rate::Color3),
        effort: EFFORT.of(&settings),
        storage: storage(&settings, &device),
        filter: FILTER.of(&settings),
    };
    let mut bytes = 0;
    for (entity, side, part) in &parts {
        if *side == Side::Before {
            continue;
        }
        let surface = part.surface();
        let base = room::base_material(*part);
        let (material, own) = wavelet.make(surface, surface.repeats(), base, with);
        bytes += own;
        commands.entity(entity).insert(MeshMaterial3d(material));
    }
    let mut figures = MemoryFigures::default();
    figures.0.insert("textures before".into(), before.0);
    figures.0.insert("textures after".into(), bytes);
    memory.set_if_neq(figures);
    notes.set_if_neq(Notes::default());
}

/// What there is to see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    Room,
    Rates,
}

static PLACE: Choice<Place, 2> = Choice::new(
    "place",
    "the lit room, or the picture at all rates side by side",
    0,
    [("room", Place::Room), ("rates", Place::Rates)],
);
static FILTER: Choice<WaveletFilter, 7> = Choice::new(
    "filter",
    "how decoded pixels are filtered",
    5,
    [
        ("nearest", WaveletFilter::Nearest),
        ("nearest_mip_linear", WaveletFilter::NearestMipLinear),
        ("stochastic", WaveletFilter::Stochastic),
        ("stochastic_quad", WaveletFilter::StochasticQuad),
        ("bilinear", WaveletFilter::Bilinear),
        ("trilinear", WaveletFilter::Trilinear),
        ("anisotropic", WaveletFilter::Anisotropic),
    ],
);
static EFFORT: Choice<Effort, 3> = Choice::new(
    "effort",
    "how hard the encoder searches",
    1,
    [
        ("fast", Effort::Fast),
        ("default", Effort::Default),
        ("best", Effort::Best),
    ],
);

fn storage(settings: &SceneSettings, device: &RenderDevice) -> WaveletStorage {
    match settings.choice("storage") {
        "decoded" => WaveletStorage::Decoded,
        _ => storage_on(device),
    }
}
