//! The scenes of the study of `bevy_ycocg_fb` live: Bevy's own camera before, a packed one after,
//! or the error between them.

use std::f32::consts::TAU;

use bevy::{camera::Hdr, core_pipeline::tonemapping::DebandDither, prelude::*};
use bevy_ycocg_fb::{
    CameraState, FrameBufferQuality, FrameBufferReport, MsaaResolve, PackedFormat, Reconstruction,
    YCoCgFrameBuffer, YCoCgFrameBufferPlugin,
};

use crate::{
    runner::{Choice, MemoryFigures, Notes, PictureArea, Scene, SceneSetting, SceneSettings, Side},
    scenes::{
        despawn_all,
        error_view::{self, ErrorViewPlugin, ErrorViewSystems, Films},
        place_cameras,
        ycocg_fb::scenes::SCENES,
    },
};

pub mod scenes;

/// The example of `bevy_ycocg_fb`.
pub struct YCoCgFb;

impl Scene for YCoCgFb {
    fn name(&self) -> &'static str {
        "ycocg_fb"
    }

    fn plugin(&self) -> &'static str {
        "bevy_ycocg_fb"
    }

    fn description(&self) -> &'static str {
        "The frame buffer: Bevy's own before, in fewer bytes after, or the error between them"
    }

    fn settings(&self) -> Vec<SceneSetting> {
        const SCENE_NAMES: [&str; SCENES.len()] = {
            let mut names = [""; SCENES.len()];
            let mut i = 0;
            while i < SCENES.len() {
                names[i] = SCENES[i].name;
                i += 1;
            }
            names
        };
        vec![
            SceneSetting::choice("scene", "what there is to see", 0, &SCENE_NAMES),
            error_view::view_setting(),
            error_view::gain_setting(),
            SceneSetting::toggle(
                "hdr",
                "`Hdr` on the camera; without it, a packed camera blends before it tone-maps as \
                 one with `Hdr` does, so before keeps it, except beside unorm8",
                false,
            ),
            MSAA.setting(),
            SceneSetting::choice(
                "format",
                "of the colours: three of two channels, unorm8 for cameras without `Hdr`, and one of three",
                0,
                &["float16", "float32", "unorm8", "rg11b10ufloat"],
            ),
            RECONSTRUCTION.setting(),
            MSAA_RESOLVE.setting(),
            SceneSetting::toggle(
                "motion",
                "the sun wanders; scenes without one drift by pixels",
                true,
            ),
        ]
    }

    fn view(&self) -> Transform {
        SCENES[0].camera(UVec2::ONE).1
    }

    fn build(&self, app: &mut App) {
        app.add_plugins((YCoCgFrameBufferPlugin, ErrorViewPlugin))
            .init_resource::<Stage>()
            .add_systems(
                Update,
                (
                    (show, change, drift).chain().before(ErrorViewSystems),
                    apply_settings.after(ErrorViewSystems),
                ),
            );
    }

    fn configure_camera(&self, camera: &mut EntityCommands, side: Side) {
        // Dithering would hide how small an error is.
        camera.insert((Films(side), DebandDither::Disabled));
    }
}

static MSAA: Choice<Msaa, 2> = Choice::new(
    "msaa",
    "samples a pixel, of both cameras",
    1,
    [("off", Msaa::Off), ("4x", Msaa::Sample4)],
);
static RECONSTRUCTION: Choice<Reconstruction, 6> = Choice::new(
    "reconstruction",
    "how the missing chrominance is found",
    4,
    [
        ("nearest", Reconstruction::Nearest),
        ("bilinear", Reconstruction::Bilinear),
        ("edge_directed", Reconstruction::EdgeDirected),
        ("guided", Reconstruction::Guided),
        ("wide", Reconstruction::Wide),
        ("quad", Reconstruction::Quad),
    ],
);
static MSAA_RESOLVE: Choice<MsaaResolve, 2> = Choice::new(
    "msaa_resolve",
    "how the samples of a pixel become one",
    0,
    [
        ("box", MsaaResolve::Box),
        ("tone_map_weighted", MsaaResolve::ToneMapWeighted),
    ],
);

/// Gives all cameras, new ones too, what the settings say.
pub fn apply_settings(
    mut commands: Commands,
    settings: Res<SceneSettings>,
    cameras: Query<(Entity, &Films)>,
    new: Query<(), Added<Films>>,
) {
    if !settings.is_changed() && new.is_empty() {
        return;
    }
    let quality = quality(&settings);
    let hdr = settings.toggle("hdr");
    for (entity, Films(side)) in &cameras {
        let mut camera = commands.entity(entity);
        camera.insert(MSAA.of(&settings));
        let hdr = match side {
            // What a packed camera without `Hdr` is to look like: it blends scene-linear values.
            Side::Before => {
                camera.insert(FrameBufferQuality::Exact);
                hdr || settings.choice("format") != "unorm8"
            }
            Side::After => {
                camera.insert(quality);
                hdr
            }
        };
        if hdr {
            camera.insert(Hdr);
        } else {
            camera.remove::<Hdr>();
        }
    }
}

fn quality(settings: &SceneSettings) -> FrameBufferQuality {
    let format = match settings.choice("format") {
        "float32" => PackedFormat::Float32,
        "unorm8" => PackedFormat::Unorm8,
        "rg11b10ufloat" => return FrameBufferQuality::Compact,
        _ => PackedFormat::Float16,
    };
    FrameBufferQuality::Packed(YCoCgFrameBuffer {
        format,
        reconstruction: RECONSTRUCTION.of(settings),
        msaa_resolve: MSAA_RESOLVE.of(settings),
    })
}

/// Name of the note on what became of the packed camera.
const STATE: &str = "after:";
/// Name of the note on what the figures count.
const COUNTED: &str = "memory:";

/// Fills in what the cameras at the split took in the last frame. A camera that the line leaves no
/// room keeps its figures until a setting changes.
pub fn show(
    settings: Res<SceneSettings>,
    cameras: Query<(&FrameBufferReport, &Side), With<Camera>>,
    mut memory: ResMut<MemoryFigures>,
    mut notes: ResMut<Notes>,
) {
    let mut figures = memory.clone();
    let mut texts = notes.clone();
    if settings.is_changed() {
        figures.0.clear();
        texts.0.clear();
    }
    for (report, side) in &cameras {
        if report.state == CameraState::Pending {
            continue;
        }
        let name = side.name();
        let taken = report.memory;
        for (row, bytes) in [
            ("main", taken.main),
            ("main MSAA", taken.main_multisampled),
            ("packed", taken.packed),
            ("packed MSAA", taken.packed_multisampled),
            ("total", taken.total()),
        ] {
            figures.0.insert(format!("{row} {name}"), bytes);
        }
        let text = match &report.state {
            CameraState::Packed(_) => "packed".into(),
            CameraState::Rg11b10Ufloat => "drawn by Bevy in Rg11b10Ufloat".into(),
            CameraState::Fallback(reason) => format!("as Bevy draws it: {reason}"),
            _ => continue,
        };
        texts.0.insert(STATE.into(), text);
    }
    texts.0.insert(
        COUNTED.into(),
        "colour of the whole target; a camera alone would take as much, and two with the same \
         settings share Bevy's main textures"
            .into(),
    );
    memory.set_if_neq(figures);
    notes.set_if_neq(texts);
}

/// Seconds of a movement there and back.
const PERIOD: f32 = 20.0;
/// How far the sun wanders to each side, in radians.
const SUN: f32 = 0.4;
/// How far scenes in pixels drift to each side, in pixels.
const DRIFT: f32 = 6.0;

/// Which scene is on stage, and for which size of the picture where it depends on that.
#[derive(Resource, Default)]
pub struct Stage(Option<(&'static str, UVec2)>);

/// A part of the scene, where it belongs.
#[derive(Component)]
pub struct Part(Transform);

/// Puts the chosen scene on stage, and the cameras before it.
pub fn change(world: &mut World) {
    let area = world.resource::<PictureArea>().0.size();
    if area.min_element() == 0 {
        return;
    }
    let name = world.resource::<SceneSettings>().choice("scene");
    let Some(scene) = SCENES.iter().find(|scene| scene.name == name) else {
        return;
    };
    let size = if scene.is_in_pixels() {
        area
    } else {
        UVec2::ZERO
    };
    let now = world.resource::<Stage>().0;
    if now == Some((name, size)) {
        return;
    }
    world.resource_mut::<Stage>().0 = Some((name, size));
    despawn_all::<Part>(world);
    for part in scene.spawn_content(world, area) {
        let mut part = world.entity_mut(part);
        let pose = part.get::<Transform>().copied().unwrap_or_default();
        part.insert(Part(pose));
    }
    place_cameras::<With<Films>>(world, scene.camera(area));
}

/// Moves the sun, or everything where there is none. At time 0 all is where it belongs.
pub fn drift(
    settings: Res<SceneSettings>,
    time: Res<Time>,
    mut parts: Query<(&Part, &mut Transform, Has<DirectionalLight>)>,
) {
    let phase = if settings.toggle("motion") {
        (time.elapsed_secs() * TAU / PERIOD).sin()
    } else {
        0.0
    };
    let has_sun = parts.iter().any(|(_, _, is_sun)| is_sun);
    for (Part(home), mut pose, is_sun) in &mut parts {
        let mut moved = *home;
        if is_sun {
            moved.rotate_around(Vec3::ZERO, Quat::from_rotation_y(phase * SUN));
        } else if !has_sun {
            moved.translation.x += phase * DRIFT;
        }
        pose.set_if_neq(moved);
    }
}
