//! The scenes of the study of `bevy_ycocg_fb` live: Bevy's own camera before, a packed one after,
//! or the error between them.
//!
//! | file | contents |
//! | --- | --- |
//! | `cameras` | what the settings make of the cameras |
//! | [`scenes`] | the scenes |
//! | `stage` | the chosen scene, and its slow motion |
//! | `memory` | the reports of the plugin as figures and notes |

mod cameras;
mod memory;
pub mod scenes;
mod stage;

use bevy::{core_pipeline::tonemapping::DebandDither, prelude::*};
use bevy_ycocg_fb::YCoCgFrameBufferPlugin;

use crate::{
    runner::{Scene, SceneSetting, Side},
    scenes::error_view::{self, ErrorViewPlugin, ErrorViewSystems, Films},
};

use self::scenes::SCENES;

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
            SceneSetting::choice(
                "msaa",
                "samples a pixel, of both cameras",
                1,
                &["off", "4x"],
            ),
            SceneSetting::choice(
                "format",
                "of the colours: three of two channels, unorm8 for cameras without `Hdr`, and one of three",
                0,
                &["float16", "float32", "unorm8", "rg11b10ufloat"],
            ),
            SceneSetting::choice(
                "reconstruction",
                "how the missing chrominance is found",
                4,
                &[
                    "nearest",
                    "bilinear",
                    "edge_directed",
                    "guided",
                    "wide",
                    "quad",
                ],
            ),
            SceneSetting::choice(
                "msaa_resolve",
                "how the samples of a pixel become one",
                0,
                &["box", "tone_map_weighted"],
            ),
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
            .init_resource::<stage::Stage>()
            .add_systems(
                Update,
                (
                    (memory::show, stage::change, stage::drift)
                        .chain()
                        .before(ErrorViewSystems),
                    cameras::apply_settings.after(ErrorViewSystems),
                ),
            );
    }

    fn configure_camera(&self, camera: &mut EntityCommands, side: Side) {
        // Dithering would hide how small an error is.
        camera.insert((Films(side), DebandDither::Disabled));
    }
}
