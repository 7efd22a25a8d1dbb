//! Light that bounces: a sunlit room in which everything may move, and the Cornell box beside its
//! path-traced picture. Before is what Bevy shows of the same lights.
//!
//! | file | contents |
//! | --- | --- |
//! | `settings` | the settings of the volume |
//! | `cornell` | the Cornell box before the cameras |
//! | `room` | the room in numbers |
//! | `stage` | the chosen scene, and the cameras before it |
//! | `motion` | the sun and the door |
//! | `drag` | objects that follow the mouse |
//! | `truth` | the path-traced picture, and how far the live one is from it |
//! | `figures` | the plugin's report as figures and notes |

mod cornell;
mod drag;
mod figures;
mod motion;
pub mod room;
mod settings;
mod stage;
mod truth;

use bevy::{camera::Hdr, core_pipeline::tonemapping::DebandDither, prelude::*};
use bevy_voxel_gi::VoxelGiPlugin;

use crate::{
    headless::AwaitedWork,
    runner::{Scene, SceneSetting, Side},
};

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
            SceneSetting::choice(
                "voxelizer",
                "how triangles become voxels",
                0,
                &[
                    "conservative",
                    "fragment_clipping",
                    "geometry_clipping",
                    "stochastic",
                ],
            ),
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
            SceneSetting::choice(
                "receiver",
                "a pixel reads all eight voxels around it, or those that it sees",
                0,
                &["interpolated", "per_pixel"],
            ),
            SceneSetting::toggle("sun_motion", "the sun of the room wanders", true),
            SceneSetting::choice(
                "debug",
                "what the voxels hold, instead of the picture of after",
                0,
                &[
                    "off",
                    "occupancy",
                    "albedo",
                    "normal",
                    "radiance",
                    "irradiance",
                ],
            ),
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
        room::view()
    }

    fn build(&self, app: &mut App) {
        app.world_mut()
            .resource_mut::<AwaitedWork>()
            .0
            .insert(figures::LIGHT);
        app.add_plugins(VoxelGiPlugin)
            .insert_resource(GlobalAmbientLight::NONE)
            .init_resource::<stage::Stage>()
            .init_resource::<truth::Truth>()
            .add_systems(
                Update,
                (
                    stage::change,
                    settings::apply,
                    settings::apply_debug,
                    motion::move_sun,
                    motion::swing_door,
                    drag::drag,
                    truth::receive,
                    truth::place_picture,
                    truth::compare,
                    figures::show,
                )
                    .chain(),
            );
    }

    fn configure_camera(&self, camera: &mut EntityCommands, _: Side) {
        camera.insert((Hdr, DebandDither::Disabled));
    }
}
