//! A tunnel without end and a game's floor, filtered by one method on each side of the line.
//!
//! | file | contents |
//! | --- | --- |
//! | `stage` | the tunnel and the floor |
//! | `settings` | the settings of the plugin |
//! | `view`, `view.wesl` | ellipses, and the regions that are too anisotropic for texture units |

mod settings;
mod stage;
mod view;

use bevy::{pbr::MaterialPlugin, prelude::*};
use bevy_ewa::EwaPlugin;

use crate::runner::{Scene, SceneSetting};

/// The example of `bevy_ewa`.
pub struct Ewa;

impl Scene for Ewa {
    fn name(&self) -> &'static str {
        "ewa"
    }

    fn plugin(&self) -> &'static str {
        "bevy_ewa"
    }

    fn description(&self) -> &'static str {
        "Texture filtering: a tunnel or a floor, by any method before and any after"
    }

    fn settings(&self) -> Vec<SceneSetting> {
        vec![
            SceneSetting::choice("place", "what there is to see", 0, &["tunnel", "floor"]),
            SceneSetting::choice(
                "view",
                "the picture; the ellipse of every 16th pixel in its texture; red where the \
                 anisotropy exceeds spatial_threshold",
                0,
                &["picture", "ellipses", "regions"],
            ),
            SceneSetting::choice(
                "before",
                "method left of the line; hardware is the sampler as it is, anisotropic with 16x",
                settings::HARDWARE,
                &settings::METHODS,
            ),
            SceneSetting::choice(
                "after",
                "method right of the line",
                settings::LINEAR,
                &settings::METHODS,
            ),
            SceneSetting::choice(
                "probes",
                "of the approximate, spatial and temporal methods",
                1,
                &["3", "5", "7", "by_aspect"],
            ),
            SceneSetting::choice(
                "kernel",
                "of the exact methods",
                2,
                &["box", "tent", "gaussian", "mitchell_netravali", "lanczos"],
            ),
            SceneSetting::float(
                "sigma",
                "standard deviation of the Gaussian",
                0.5,
                0.2..=1.5,
                "pixels",
            ),
            SceneSetting::float(
                "max_anisotropy",
                "longest ellipse, in widths",
                32.0,
                1.0..=128.0,
                "",
            ),
            SceneSetting::float(
                "minor_radius",
                "least minor radius in the chosen mip level",
                1.5,
                0.5..=4.0,
                "texels",
            ),
            SceneSetting::choice(
                "level_of_detail",
                "what the mip level is chosen by",
                0,
                &["minor_radius", "hardware"],
            ),
            SceneSetting::float(
                "level_blend",
                "part of the way to the next mip level in which both are blended",
                0.25,
                0.0..=1.0,
                "",
            ),
            SceneSetting::integer(
                "max_fetches",
                "most fetches of a lookup of the exact methods",
                2048,
                16..=4096,
                "",
            ),
            SceneSetting::float(
                "spatial_threshold",
                "anisotropy above which spatial works",
                16.0,
                2.0..=64.0,
                "",
            ),
            SceneSetting::integer(
                "sampler_anisotropy",
                "of the samplers: 1 computes probes, more leaves them to the texture unit",
                1,
                1..=16,
                "",
            ),
            SceneSetting::toggle("motion", "the texture drifts", true),
        ]
    }

    fn view(&self) -> Transform {
        Transform::from_xyz(0.0, 0.0, 0.0).looking_to(Vec3::new(0.12, -0.08, -1.0), Vec3::Y)
    }

    fn build(&self, app: &mut App) {
        view::embed(app);
        app.add_plugins((
            EwaPlugin::OPT_IN,
            MaterialPlugin::<view::ViewMaterial>::default(),
        ))
        .init_resource::<stage::Textures>()
        .add_systems(Startup, stage::spawn)
        .add_systems(
            Update,
            (
                stage::show_place,
                stage::configure.run_if(resource_changed::<crate::runner::SceneSettings>),
                stage::drift,
            )
                .chain(),
        );
    }
}
