//! Light that bounces: a sunlit room in which everything may move, and the Cornell box beside its
//! path-traced picture. Before is what Bevy shows of the same lights.

use bevy::{
    camera::Hdr, core_pipeline::tonemapping::DebandDither, prelude::*, window::PrimaryWindow,
};
use bevy_voxel_gi::{
    Bounces, DebugField, Receiver, Sky, Solver, VoxelGiDebug, VoxelGiPlugin, VoxelGiReport,
    VoxelGiSettings, VoxelGiState, VoxelGiVolume, VoxelLight, Voxelizer,
};

use crate::{
    headless::AwaitedWork,
    runner::{
        Choice, MemoryFigures, Notes, PictureArea, Scene, SceneSetting, SceneSettings, Side, Split,
    },
    scenes::{
        move_sun,
        voxel_gi::{stage::Stage, truth::Truth},
    },
};

pub mod stage;
mod truth;

/// The example of `bevy_voxel_gi`.
pub struct VoxelGi;

impl Scene for VoxelGi {
    fn name(&self) -> &'static str {
        "voxel_gi"
    }

    fn plugin(&self) -> &'static str {
        "bevy_voxel_gi"
    }

    fn description(&self) -> &'static str {
        "Global illumination: direct light alone before, the light that bounces and the sky's after. \
         Drag the red box and the ball with the mouse"
    }

    fn settings(&self) -> Vec<SceneSetting> {
        vec![
            SceneSetting::choice(
                "scene",
                "a room with a window and a door, or the Cornell box beside a path-traced picture",
                0,
                &["sunlit_room", "cornell"],
            ),
            SceneSetting::choice(
                "light",
                "light that bounces, or the sky alone where nothing nearby is in its way",
                0,
                &["global_illumination", "ambient_occlusion"],
            ),
            SceneSetting::choice(
                "solver",
                "rays through the voxels, or from voxel to voxel",
                0,
                &["trace", "propagate"],
            ),
            SceneSetting::integer(
                "rays",
                "from each side of a voxel with a surface, for `trace` and ambient occlusion",
                32,
                4..=256,
                "",
            ),
            SceneSetting::integer("iterations", "steps of `propagate`", 96, 1..=512, ""),
            SceneSetting::choice(
                "bounces",
                "of `trace`: one a frame fed back, or so many in each frame",
                0,
                &["endless", "1", "2", "4", "8"],
            ),
            SceneSetting::choice(
                "resolution",
                "voxels along an edge of the volume",
                2,
                &["8", "16", "32", "64", "128"],
            ),
            VOXELIZER.setting(),
            SceneSetting::integer(
                "shadow_samples",
                "points of a voxel that are tested for shadow, per light",
                16,
                1..=16,
                "",
            ),
            SceneSetting::integer(
                "cascades",
                "volumes around each other, each twice as large; the first is half the scene then",
                1,
                1..=4,
                "",
            ),
            RECEIVER.setting(),
            SceneSetting::toggle("sun_motion", "the sun of the room wanders", true),
            DEBUG.setting(),
            SceneSetting::choice("door", "of the room", 0, &["swinging", "closed", "open"]),
            SceneSetting::integer(
                "paths",
                "from each pixel of the path-traced picture",
                1024,
                16..=4096,
                "",
            ),
        ]
    }

    fn view(&self) -> Transform {
        stage::room_view()
    }

    fn build(&self, app: &mut App) {
        app.world_mut()
            .resource_mut::<AwaitedWork>()
            .0
            .insert(LIGHT);
        app.add_plugins(VoxelGiPlugin)
            .insert_resource(GlobalAmbientLight::NONE)
            .init_resource::<Stage>()
            .init_resource::<Truth>()
            .add_systems(
                Update,
                (
                    stage::change,
                    apply,
                    apply_debug,
                    move_sun,
                    stage::swing_door,
                    drag,
                    truth::receive,
                    truth::place_picture,
                    truth::compare,
                    show,
                )
                    .chain(),
            );
    }

    fn configure_camera(&self, camera: &mut EntityCommands, _: Side) {
        camera.insert((Hdr, DebandDither::Disabled));
    }
}

static VOXELIZER: Choice<Voxelizer, 4> = Choice::new(
    "voxelizer",
    "how triangles become voxels",
    0,
    [
        ("conservative", Voxelizer::Conservative),
        ("fragment_clipping", Voxelizer::FragmentClipping),
        ("geometry_clipping", Voxelizer::GeometryClipping),
        ("stochastic", Voxelizer::Stochastic { points: 1024 }),
    ],
);
static RECEIVER: Choice<Receiver, 2> = Choice::new(
    "receiver",
    "a pixel reads all eight voxels around it, or those that it sees",
    0,
    [
        ("interpolated", Receiver::Interpolated),
        ("per_pixel", Receiver::PerPixel),
    ],
);
static DEBUG: Choice<Option<DebugField>, 6> = Choice::new(
    "debug",
    "what the voxels hold, instead of the picture of after",
    0,
    [
        ("off", None),
        ("occupancy", Some(DebugField::Occupancy)),
        ("albedo", Some(DebugField::Albedo)),
        ("normal", Some(DebugField::Normal)),
        ("radiance", Some(DebugField::Radiance)),
        ("irradiance", Some(DebugField::Irradiance)),
    ],
);
/// What is further away than this does not occlude, in parts of the scene's size.
const OCCLUSION_RADIUS: f32 = 0.2;

/// Renews the volume when a setting or the scene changes; only the camera of "after" sees its light.
fn apply(
    mut commands: Commands,
    settings: Res<SceneSettings>,
    stage: Res<Stage>,
    volumes: Query<Entity, With<VoxelGiVolume>>,
) {
    if !settings.is_changed() && !stage.is_changed() {
        return;
    }
    let Some((center, size, sky)) = stage.volume(resolution(&settings)) else {
        return;
    };
    commands.insert_resource(light_settings(&settings, size));
    let volume = (
        volume(&settings, size, sky),
        Transform::from_translation(center),
    );
    match volumes.iter().next() {
        Some(entity) => {
            commands.entity(entity).insert(volume);
        }
        None => {
            commands.spawn((volume, Side::After.layers()));
        }
    }
}

/// Shows the chosen field to the camera of "after".
fn apply_debug(
    mut commands: Commands,
    settings: Res<SceneSettings>,
    cameras: Query<(Entity, &Side, Has<VoxelGiDebug>), With<Camera>>,
) {
    let field = DEBUG.of(&settings);
    for (camera, side, has_field) in &cameras {
        let mut camera = commands.entity(camera);
        match field.filter(|_| *side == Side::After) {
            Some(field) if !has_field || settings.is_changed() => {
                camera.insert(VoxelGiDebug { field });
            }
            None if has_field => {
                camera.remove::<VoxelGiDebug>();
            }
            _ => {}
        }
    }
}

/// Voxels along an edge of the volume.
fn resolution(settings: &SceneSettings) -> u32 {
    settings.choice("resolution").parse().unwrap_or(32)
}

fn volume(settings: &SceneSettings, size: f32, sky: Sky) -> VoxelGiVolume {
    let cascades = settings.integer("cascades");
    VoxelGiVolume {
        // The first of several cascades is about the middle of the scene.
        size: if cascades > 1 { 0.5 * size } else { size },
        sky: Some(sky),
        cascades,
        ..VoxelGiVolume::fixed(size)
    }
}

fn light_settings(settings: &SceneSettings, size: f32) -> VoxelGiSettings {
    let rays = settings.integer("rays");
    let light = match settings.choice("light") {
        "ambient_occlusion" => VoxelLight::AmbientOcclusion {
            radius: OCCLUSION_RADIUS * size,
            rays,
        },
        _ => VoxelLight::GlobalIllumination {
            solver: match settings.choice("solver") {
                "propagate" => Solver::Propagate {
                    iterations: settings.integer("iterations"),
                },
                _ => Solver::Trace { rays },
            },
            bounces: match settings.choice("bounces").parse() {
                Ok(count) => Bounces::Count(count),
                Err(_) => Bounces::Endless,
            },
        },
    };
    VoxelGiSettings {
        resolution: resolution(settings),
        light,
        voxelizer: VOXELIZER.of(settings),
        receiver: RECEIVER.of(settings),
        shadow_samples: settings.integer("shadow_samples"),
        ..default()
    }
}

/// What a picture waits for, as it is called in messages: the light has settled.
const LIGHT: &str = "the light";
/// The same of the path-traced picture and of the comparison with it.
const TRUTH: &str = "the path-traced picture";

/// Fills in what the plugin reports.
fn show(
    report: Res<VoxelGiReport>,
    truth: Res<Truth>,
    mut memory: ResMut<MemoryFigures>,
    mut notes: ResMut<Notes>,
    mut work: ResMut<AwaitedWork>,
) {
    let mut figures = MemoryFigures::default();
    figures.0.insert("volume before".into(), 0);
    figures.0.insert("volume after".into(), report.memory);
    memory.set_if_neq(figures);

    let state = match report.state {
        VoxelGiState::Absent => "getting ready",
        VoxelGiState::Running => "computed each frame",
        VoxelGiState::Settled => "settled: nothing is computed until something changes",
    };
    let receiver = if report.receiver_patched {
        "by the plugin's shader"
    } else {
        "as a plain irradiance volume of Bevy"
    };
    let mut texts = Notes::default();
    for (name, text) in [
        ("volume:", state.into()),
        ("triangles in it:", report.triangles.to_string()),
        ("read:", receiver.into()),
    ] {
        texts.0.insert(name.into(), text);
    }
    if let Some(text) = truth.note() {
        texts.0.insert("path tracing:".into(), text);
    }
    notes.set_if_neq(texts);

    for (name, is_waiting) in [
        (LIGHT, report.state != VoxelGiState::Settled),
        (TRUTH, truth.is_waiting()),
    ] {
        if is_waiting {
            work.0.insert(name);
        } else {
            work.0.remove(name);
        }
    }
}

/// Distance from the split line in logical pixels at which the mouse is the line's.
const LINE: f32 = 10.0;

/// An object that can be dragged.
#[derive(Component)]
struct Draggable {
    /// Half its edge, or its radius, in metres.
    half: f32,
}

/// What is being dragged.
#[derive(Clone, Copy)]
struct Grip {
    object: Entity,
    /// From where it was grabbed to its centre.
    offset: Vec3,
}

/// Follows the mouse while its left button is down.
fn drag(
    buttons: Option<Res<ButtonInput<MouseButton>>>,
    windows: Query<&Window, With<PrimaryWindow>>,
    cameras: Query<(&Camera, &GlobalTransform), With<Side>>,
    (area, split): (Res<PictureArea>, Res<Split>),
    mut grip: Local<Option<Grip>>,
    mut objects: Query<(Entity, &Draggable, &mut Transform)>,
) {
    let (Some(buttons), Ok(window)) = (buttons, windows.single()) else {
        return;
    };
    if !buttons.pressed(MouseButton::Left) {
        *grip = None;
        return;
    }
    let Some(cursor) = window.cursor_position() else {
        return;
    };
    let camera = cameras.iter().find(|(camera, _)| {
        let view = camera.logical_viewport_rect();
        camera.is_active && view.is_some_and(|view| view.contains(cursor))
    });
    let Some((camera, pose)) = camera else {
        return;
    };
    let Ok(ray) = camera.viewport_to_world(pose, cursor) else {
        return;
    };
    if buttons.just_pressed(MouseButton::Left) {
        let line = area.0.min.x + area.split_width(*split);
        if (cursor.x - line as f32 / window.scale_factor()).abs() > LINE {
            let at = |pose: &Transform| pose.translation;
            let hits = objects.iter().filter_map(|(object, body, pose)| {
                let distance = sphere_hit(ray, at(pose), body.half)?;
                let grabbed = over_floor(ray, at(pose).y)?;
                let offset = at(pose) - grabbed;
                Some((distance, Grip { object, offset }))
            });
            *grip = hits
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .map(|(_, grip)| grip);
        }
    }
    let Some(Grip { object, offset }) = *grip else {
        return;
    };
    let Ok((_, body, mut pose)) = objects.get_mut(object) else {
        *grip = None;
        return;
    };
    if let Some(at) = over_floor(ray, pose.translation.y) {
        let target = kept_inside(at + offset, body.half);
        if target.distance(pose.translation) > 1e-4 {
            pose.translation = target;
        }
    }
}

/// Distance to a sphere in front of the ray's origin.
pub fn sphere_hit(ray: Ray3d, center: Vec3, radius: f32) -> Option<f32> {
    let along = (center - ray.origin).dot(*ray.direction);
    let aside = (center - ray.origin).length_squared() - along * along;
    (along > 0.0 && aside <= radius * radius).then_some(along)
}

/// Where the ray comes down to a height.
pub fn over_floor(ray: Ray3d, height: f32) -> Option<Vec3> {
    let down = -ray.direction.y;
    let distance = (ray.origin.y - height) / down;
    (down > 1e-3 && distance > 0.0).then(|| ray.origin + distance * ray.direction)
}

/// At most at the walls.
pub fn kept_inside(at: Vec3, half: f32) -> Vec3 {
    let [low, high] = stage::INSIDE;
    let free = at.clamp(low + half, high - half);
    Vec3::new(free.x, at.y, free.z)
}
