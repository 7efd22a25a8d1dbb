//! All four plugins in one game: a hall with wavelet textures, EWA on its floor, light that bounces,
//! drawn into a packed frame buffer. Before is Bevy alone; each plugin of after has a switch.

use bevy::{
    camera::{Exposure, Hdr, visibility::RenderLayers},
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    light::CascadeShadowConfigBuilder,
    mesh::VertexAttributeValues,
    prelude::*,
};
use bevy_ewa::{EwaPlugin, EwaStandardMaterial};
use bevy_voxel_gi::{
    NotVoxelized, VoxelGiPlugin, VoxelGiReport, VoxelGiSettings, VoxelGiState, VoxelGiVolume,
    VoxelMaterialPlugin,
};
use bevy_wavelet_tex::{WaveletStandardMaterial, WaveletTexPlugin};
use bevy_ycocg_fb::{
    CameraState, FrameBufferQuality, FrameBufferReport, YCoCgFrameBuffer, YCoCgFrameBufferPlugin,
};

use crate::{
    headless::AwaitedWork,
    runner::{
        AFTER_LAYER, BEFORE_LAYER, Choice, MemoryFigures, Notes, Scene, SceneSetting,
        SceneSettings, Side,
    },
    scenes::{Sun, TONE_MAPPED, UNGRADED, clear_sky, move_sun},
};

mod textures;

pub struct AllTogether;

/// The switches, one a plugin, in the order of the panel.
pub const SWITCHES: [&str; 4] = ["wavelet_tex", "ycocg_fb", "ewa", "voxel_gi"];

impl Scene for AllTogether {
    fn name(&self) -> &'static str {
        "all_together"
    }

    fn plugin(&self) -> &'static str {
        "bevy_frugal"
    }

    fn description(&self) -> &'static str {
        "A hall: Bevy alone before; compressed textures, a packed frame buffer, elliptical filtering \
         of the floor and bouncing light after, each with a switch"
    }

    fn settings(&self) -> Vec<SceneSetting> {
        let [wavelet_tex, ycocg_fb, ewa, voxel_gi] = SWITCHES;
        vec![
            SceneSetting::toggle(
                wavelet_tex,
                "walls, crates, pictures and plants from wavelet textures",
                true,
            ),
            SceneSetting::toggle(ycocg_fb, "a frame buffer of two channels", true),
            SceneSetting::toggle(ewa, "the floor filtered by ellipses", true),
            SceneSetting::toggle(
                voxel_gi,
                "light that bounces, instead of an ambient light that is the same everywhere",
                true,
            ),
            SceneSetting::choice(
                "color_rate",
                "bits per pixel of the wavelet textures' colours",
                1,
                &["color2.25", "color3", "color3.25", "color5"],
            ),
            textures::EWA_METHOD.setting(),
            SceneSetting::choice(
                "resolution",
                "voxels along an edge of the volume",
                1,
                &["16", "32", "64"],
            ),
            TONE_MAPPING.setting(),
            SceneSetting::toggle("sun_motion", "the sun wanders", true),
        ]
    }

    fn view(&self) -> Transform {
        view()
    }

    fn build(&self, app: &mut App) {
        app.world_mut()
            .resource_mut::<AwaitedWork>()
            .0
            .insert(LIGHT);
        app.add_plugins((
            WaveletTexPlugin,
            YCoCgFrameBufferPlugin,
            EwaPlugin::OPT_IN,
            VoxelGiPlugin,
            // What bounces off the floor is known, whichever of its materials it has.
            VoxelMaterialPlugin::<EwaStandardMaterial>::default(),
            VoxelMaterialPlugin::<WaveletStandardMaterial>::default(),
        ))
        .insert_resource(GlobalAmbientLight::NONE)
        .insert_resource(ClearColor(background()))
        .insert_resource(textures::maps())
        .init_resource::<textures::PlainMaterials>()
        .init_resource::<TextureBytes>()
        .add_systems(Startup, spawn)
        .add_systems(
            Update,
            (
                (
                    textures::before,
                    textures::after,
                    place_volume,
                    configure_cameras,
                )
                    .chain()
                    .run_if(resource_changed::<SceneSettings>),
                move_sun,
                show,
            )
                .chain(),
        );
    }

    fn configure_camera(&self, camera: &mut EntityCommands, _: Side) {
        camera.insert((Hdr, DebandDither::Disabled, Exposure { ev100: EV100 }));
    }
}

static TONE_MAPPING: Choice<(Tonemapping, DebandDither), 2> = Choice::new(
    "tone_mapping",
    "of both cameras; none, and dark, for comparisons of light",
    0,
    [("tony_mc_mapface", TONE_MAPPED), ("none", UNGRADED)],
);

/// Spawns, changes or despawns the volume. Only the camera of after sees its light.
fn place_volume(
    mut commands: Commands,
    settings: Res<SceneSettings>,
    mut light: ResMut<VoxelGiSettings>,
    volumes: Query<(Entity, &VoxelGiVolume)>,
) {
    let (center, size) = volume();
    light.resolution = settings.choice("resolution").parse().unwrap_or(32);
    let requested = settings.toggle("voxel_gi").then(|| VoxelGiVolume {
        sky: Some(clear_sky()),
        ..VoxelGiVolume::fixed(size)
    });
    match (volumes.iter().next(), requested) {
        (Some((_, volume)), Some(requested)) if *volume == requested => {}
        (Some((entity, _)), Some(requested)) => {
            commands.entity(entity).insert(requested);
        }
        (Some((entity, _)), None) => commands.entity(entity).despawn(),
        (None, Some(requested)) => {
            let pose = Transform::from_translation(center);
            commands.spawn((requested, pose, Side::After.layers()));
        }
        (None, None) => {}
    }
}

/// Gives the cameras their frame buffer, their ambient light and their tone mapping.
fn configure_cameras(
    mut commands: Commands,
    settings: Res<SceneSettings>,
    cameras: Query<(Entity, &Side), With<Camera>>,
) {
    for (camera, side) in &cameras {
        let on = |switch| *side == Side::After && settings.toggle(switch);
        let mut camera = commands.entity(camera);
        camera.insert(if on("ycocg_fb") {
            FrameBufferQuality::from(YCoCgFrameBuffer::default())
        } else {
            FrameBufferQuality::Exact
        });
        camera.insert(AmbientLight {
            color: Color::linear_rgb(1.0, 0.97, 0.92),
            brightness: if on("voxel_gi") { 0.0 } else { AMBIENT },
            ..default()
        });
        camera.insert(TONE_MAPPING.of(&settings));
    }
}

/// What a picture waits for, as it is called in messages: the light has settled.
pub const LIGHT: &str = "the light";

/// Bytes of the textures of each side, on the GPU.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct TextureBytes {
    pub before: u64,
    pub after: u64,
}

/// Fills in what the plugins report.
fn show(
    settings: Res<SceneSettings>,
    textures: Res<TextureBytes>,
    light: Res<VoxelGiReport>,
    cameras: Query<(&FrameBufferReport, &Side), With<Camera>>,
    mut memory: ResMut<MemoryFigures>,
    mut notes: ResMut<Notes>,
    mut work: ResMut<AwaitedWork>,
) {
    let mut figures = memory.clone();
    let mut texts = notes.clone();
    let mut figure = |name: &str, bytes| figures.0.insert(name.into(), bytes);
    figure("textures before", textures.before);
    figure("textures after", textures.after);
    figure("volume before", 0);
    figure("volume after", light.memory);
    for (report, side) in &cameras {
        if report.state == CameraState::Pending {
            continue;
        }
        let taken = report.memory.total();
        figure(&format!("frame buffer {}", side.name()), taken);
        if *side == Side::After {
            let text = match &report.state {
                CameraState::Rg11b10Ufloat => "three small floats".into(),
                CameraState::Packed(_) => "packed".into(),
                CameraState::Fallback(reason) => format!("as Bevy draws it: {reason}"),
                _ => "Bevy's".into(),
            };
            texts.0.insert("frame buffer:".into(), text);
        }
    }
    let on = settings.toggle("voxel_gi");
    let state = match light.state {
        _ if !on => "off",
        VoxelGiState::Absent => "getting ready",
        VoxelGiState::Running => "computed each frame",
        VoxelGiState::Settled => "settled: nothing is computed until something changes",
    };
    texts.0.insert("light that bounces:".into(), state.into());
    memory.set_if_neq(figures);
    notes.set_if_neq(texts);

    if on && light.state != VoxelGiState::Settled {
        work.0.insert(LIGHT);
    } else {
        work.0.remove(LIGHT);
    }
}

#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct HasMatter(pub Matter);

/// Spawns everything. Parts with textures are there twice, one for each side; light meets those of
/// after.
fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) -> Result {
    for part in parts() {
        let mesh = Mesh3d(meshes.add(mesh(&part)?));
        let pose = Transform::from_translation(part.center)
            .with_rotation(Quat::from_rotation_y(part.turned));
        if let Some(color) = plain_color(part.matter) {
            let material = materials.add(StandardMaterial {
                base_color: color,
                perceptual_roughness: 1.0,
                reflectance: 0.1,
                ..default()
            });
            commands.spawn((mesh, pose, MeshMaterial3d(material)));
            continue;
        }
        for side in Side::BOTH {
            let mut entity = commands.spawn((
                HasMatter(part.matter),
                side,
                side.layers(),
                mesh.clone(),
                pose,
            ));
            if side == Side::Before {
                entity.insert(NotVoxelized);
            }
        }
    }
    commands.spawn((
        Sun {
            direction: SUN,
            swing: 0.25,
        },
        RenderLayers::from_layers(&[0, BEFORE_LAYER, AFTER_LAYER]),
        DirectionalLight {
            color: Color::linear_rgb(1.0, 0.94, 0.84),
            illuminance: SUN_LUX,
            shadow_maps_enabled: true,
            ..default()
        },
        CascadeShadowConfigBuilder {
            num_cascades: 2,
            first_cascade_far_bound: 7.0,
            maximum_distance: 26.0,
            ..default()
        }
        .build(),
        Transform::default().looking_to(SUN, Vec3::Y),
    ));
    Ok(())
}

fn plain_color(matter: Matter) -> Option<Color> {
    match matter {
        Matter::Cloth(Cloth::Red) => Some(Color::linear_rgb(0.62, 0.04, 0.03)),
        Matter::Cloth(Cloth::Blue) => Some(Color::linear_rgb(0.03, 0.12, 0.5)),
        Matter::Ground => Some(Color::linear_rgb(0.36, 0.34, 0.24)),
        _ => None,
    }
}

/// A box with coordinates in metres times the repetitions, or a card.
fn mesh(part: &HallPart) -> Result<Mesh> {
    let mut mesh = if part.size.z == 0.0 {
        Rectangle::from_size(part.size.truncate()).into()
    } else {
        Mesh::from(Cuboid::from_size(part.size))
    };
    if let Some(repeats) = part.repeats() {
        let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION);
        let normals = mesh.attribute(Mesh::ATTRIBUTE_NORMAL);
        if let (
            Some(VertexAttributeValues::Float32x3(positions)),
            Some(VertexAttributeValues::Float32x3(normals)),
        ) = (positions, normals)
        {
            let uvs: Vec<[f32; 2]> = positions
                .iter()
                .zip(normals)
                .map(|(p, n)| {
                    let at = Vec3::from(*p) + part.center;
                    let uv = match Vec3::from(*n).abs().max_position() {
                        0 => Vec2::new(at.z, -at.y),
                        1 => Vec2::new(at.x, at.z),
                        _ => Vec2::new(at.x, -at.y),
                    };
                    (uv * repeats).to_array()
                })
                .collect();
            mesh.insert_attribute(Mesh::ATTRIBUTE_UV_0, uvs);
        }
    }
    Ok(mesh.with_generated_tangents()?)
}

// The hall in numbers: metres, lux and cd/m², Y up. It is long and low in front of the camera, so
// that most of its floor is seen at grazing angles; the sun comes in between columns at the right.

/// Exposure of the cameras: the walls in bounced light are in the middle of the scale.
const EV100: f32 = 11.5;
/// Direction of the sunlight at time 0.
const SUN: Vec3 = Vec3::new(-0.72, -0.62, -0.3);
/// Illuminance of a plane that faces the sun, in lux.
const SUN_LUX: f32 = 80_000.0;
/// Brightness of the ambient light where nothing computes it, in cd/m²: about the mean of what
/// bounces in the hall.
const AMBIENT: f32 = 1500.0;

/// Half the width, the height, and the two ends of the hall.
const HALF_WIDTH: f32 = 2.6;
const HEIGHT: f32 = 3.8;
const BACK: f32 = -15.0;
const FRONT: f32 = 4.0;
const WALL: f32 = 0.6;
/// Distance of the columns, and half their thickness.
const COLUMNS: f32 = 2.7;
const COLUMN: f32 = 0.3;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Matter {
    Bricks,
    Planks,
    Stone,
    Picture,
    Leaves,
    Tiles,
    /// A cloth of one colour, without textures.
    Cloth(Cloth),
    Ground,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cloth {
    Red,
    Blue,
}

/// A box, or a card where it has no depth.
#[derive(Clone, Copy, Debug)]
struct HallPart {
    matter: Matter,
    center: Vec3,
    /// Its edges; a depth of 0 makes a card that faces +Z before it is turned.
    size: Vec3,
    /// Turned about the vertical, in radians.
    turned: f32,
}

impl HallPart {
    /// Repetitions of the texture a metre; none stretches the texture over the part.
    fn repeats(&self) -> Option<f32> {
        match self.matter {
            Matter::Picture | Matter::Leaves => None,
            Matter::Tiles => Some(0.25),
            Matter::Stone => Some(0.6),
            Matter::Bricks | Matter::Planks => Some(0.7),
            Matter::Cloth(_) | Matter::Ground => Some(1.0),
        }
    }
}

/// Where the cameras are at the start.
fn view() -> Transform {
    Transform::from_xyz(0.7, 1.5, 3.2).looking_at(Vec3::new(-0.7, 1.15, -8.0), Vec3::Y)
}

fn background() -> Color {
    let exposure = bevy::camera::Exposure { ev100: EV100 }.exposure();
    (clear_sky().horizon * exposure).with_alpha(1.0).into()
}

/// Middle and edge of the volume in which light bounces.
fn volume() -> (Vec3, f32) {
    let center = Vec3::new(0.0, 0.5 * HEIGHT, 0.5 * (BACK + FRONT));
    (center, FRONT - BACK + 2.0 * WALL + 1.0)
}

fn parts() -> Vec<HallPart> {
    let mut parts = vec![
        // Floor and ceiling.
        span(
            Matter::Tiles,
            [-HALF_WIDTH - WALL, -WALL, BACK - WALL],
            [HALF_WIDTH + WALL, 0.0, FRONT + WALL],
        ),
        span(
            Matter::Planks,
            [-HALF_WIDTH - WALL, HEIGHT, BACK - WALL],
            [HALF_WIDTH + WALL, HEIGHT + WALL, FRONT + WALL],
        ),
        // Left, at the back and in front.
        span(
            Matter::Bricks,
            [-HALF_WIDTH - WALL, 0.0, BACK - WALL],
            [-HALF_WIDTH, HEIGHT, FRONT + WALL],
        ),
        span(
            Matter::Bricks,
            [-HALF_WIDTH, 0.0, BACK - WALL],
            [HALF_WIDTH + WALL, HEIGHT, BACK],
        ),
        span(
            Matter::Bricks,
            [-HALF_WIDTH, 0.0, FRONT],
            [HALF_WIDTH + WALL, HEIGHT, FRONT + WALL],
        ),
        // Right: a low wall, columns and what they bear.
        span(
            Matter::Stone,
            [HALF_WIDTH, 0.0, BACK],
            [HALF_WIDTH + WALL, 0.5, FRONT],
        ),
        span(
            Matter::Stone,
            [HALF_WIDTH, HEIGHT - 0.7, BACK],
            [HALF_WIDTH + WALL, HEIGHT, FRONT],
        ),
        // Cloth at the left wall and at the back.
        span(
            Matter::Cloth(Cloth::Red),
            [-HALF_WIDTH, 0.9, -6.3],
            [-HALF_WIDTH + 0.06, 3.3, -4.9],
        ),
        span(
            Matter::Cloth(Cloth::Blue),
            [-HALF_WIDTH, 0.9, -11.7],
            [-HALF_WIDTH + 0.06, 3.3, -10.3],
        ),
        span(
            Matter::Cloth(Cloth::Red),
            [-1.1, 0.7, BACK],
            [1.1, 3.2, BACK + 0.06],
        ),
        // Outside.
        span(Matter::Ground, [-60.0, -1.6, -70.0], [60.0, -0.9, 50.0]),
    ];
    let columns = ((FRONT - BACK) / COLUMNS) as u32;
    for i in 0..=columns {
        let z = BACK + COLUMN + i as f32 * COLUMNS;
        parts.push(span(
            Matter::Stone,
            [HALF_WIDTH, 0.5, z - COLUMN],
            [HALF_WIDTH + WALL, HEIGHT - 0.7, z + COLUMN],
        ));
    }
    for (center, edge, turned) in [
        (Vec3::new(-1.75, 0.45, -2.1), 0.9, 0.3),
        (Vec3::new(-1.7, 1.2, -2.15), 0.6, -0.25),
        (Vec3::new(-1.9, 0.35, -0.85), 0.7, 0.1),
        (Vec3::new(1.7, 0.4, -7.6), 0.8, 0.6),
    ] {
        parts.push(HallPart {
            matter: Matter::Planks,
            center,
            size: Vec3::splat(edge),
            turned,
        });
    }
    for z in [-3.7, -8.3] {
        parts.push(HallPart {
            matter: Matter::Picture,
            center: Vec3::new(-HALF_WIDTH + 0.03, 1.9, z),
            size: Vec3::new(1.8, 1.2, 0.0),
            turned: std::f32::consts::FRAC_PI_2,
        });
    }
    for (center, turned) in [
        (Vec3::new(1.75, 0.55, -1.7), 0.5),
        (Vec3::new(1.85, 0.55, -4.4), -0.4),
        (Vec3::new(-1.9, 0.55, -6.9), 0.8),
    ] {
        for quarter in [0.0, std::f32::consts::FRAC_PI_2] {
            parts.push(HallPart {
                matter: Matter::Leaves,
                center,
                size: Vec3::new(1.0, 1.1, 0.0),
                turned: turned + quarter,
            });
        }
    }
    parts
}

/// A box from corner to corner.
fn span(matter: Matter, low: [f32; 3], high: [f32; 3]) -> HallPart {
    let (low, high) = (Vec3::from(low), Vec3::from(high));
    HallPart {
        matter,
        center: 0.5 * (low + high),
        size: high - low,
        turned: 0.0,
    }
}
