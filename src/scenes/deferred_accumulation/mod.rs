//! Deferred lighting with diffuse and specular light in one target (thesis 4.8, figure 4.12).
//!
//! A red and a green light shine onto a ball and a floor. Each light is drawn over the whole screen
//! and adds its light, as in a deferred renderer; then the surface is lit with the sums. Before:
//! diffuse and specular light in a target each. After: both in one, packed in two channels each; or
//! the usual shortcut, which keeps the luminance of specular light only: diffuse light is yellow
//! where both lights shine, so both highlights turn yellow.
//!
//! | file | contents |
//! | --- | --- |
//! | [`settings`] | the settings of a camera and its lights |
//! | [`plugin`] | the passes in Bevy's renderer |
//! | `sources`, `pipeline`, `pass` | buffers, pipelines, targets and draws |
//! | [`mod@reference`] | the same on the CPU |
//! | `light.wesl`, `combine.wesl` | the two passes |
//! | `surface.wesl`, `packing.wesl` | what they share |

mod pass;
mod pipeline;
pub mod plugin;
pub mod reference;
pub mod settings;
mod sources;

use bevy::prelude::*;

use crate::runner::{MemoryFigures, PictureArea, Scene, SceneSetting, SceneSettings, Side};

pub use plugin::LightAccumulationPlugin;
pub use settings::{LightAccumulation, LightSource, LightSources};

pub struct DeferredAccumulation;

impl Scene for DeferredAccumulation {
    fn name(&self) -> &'static str {
        "deferred_accumulation"
    }

    fn plugin(&self) -> &'static str {
        "bevy_ycocg_fb"
    }

    fn description(&self) -> &'static str {
        "A red and a green light: diffuse and specular light in two targets before, in one after"
    }

    fn settings(&self) -> Vec<SceneSetting> {
        vec![
            SceneSetting::choice(
                "method",
                "how one target holds both kinds of light",
                0,
                &["packed", "specular_luminance"],
            ),
            SceneSetting::float(
                "light_distance",
                "half the distance between the lights",
                LIGHT_DISTANCE,
                0.1..=4.0,
                "m",
            ),
        ]
    }

    fn view(&self) -> Transform {
        Transform::from_xyz(0.0, 1.25, 2.3).looking_at(Vec3::new(0.0, 0.5, 0.0), Vec3::Y)
    }

    fn build(&self, app: &mut App) {
        app.add_plugins(LightAccumulationPlugin)
            .insert_resource(ClearColor(Color::BLACK))
            .add_systems(
                Update,
                apply_settings.run_if(resource_changed::<SceneSettings>),
            )
            .add_systems(Update, count_memory);
    }

    fn configure_camera(&self, camera: &mut EntityCommands, side: Side) {
        let way = match side {
            Side::Before => LightAccumulation::Exact,
            Side::After => LightAccumulation::Packed,
        };
        camera.insert((way, Msaa::Off));
    }
}

/// Half the distance between the lights at the start, in metres.
pub const LIGHT_DISTANCE: f32 = 1.5;

/// A red and a green light above and before the ball.
pub fn sources(distance: f32) -> LightSources {
    let source = |x: f32, intensity: Vec3| LightSource {
        position: Vec3::new(x, 2.2, 1.6),
        intensity,
    };
    LightSources(vec![
        source(-distance, Vec3::new(6.0, 0.15, 0.1)),
        source(distance, Vec3::new(0.15, 4.5, 0.2)),
    ])
}

fn apply_settings(
    settings: Res<SceneSettings>,
    mut shown: ResMut<LightSources>,
    mut cameras: Query<(&Side, &mut LightAccumulation)>,
) {
    *shown = sources(settings.float("light_distance"));
    let after = match settings.choice("method") {
        "specular_luminance" => LightAccumulation::SpecularLuminance,
        _ => LightAccumulation::Packed,
    };
    for (side, mut way) in &mut cameras {
        if *side == Side::After {
            way.set_if_neq(after);
        }
    }
}

fn count_memory(
    area: Res<PictureArea>,
    mut memory: ResMut<MemoryFigures>,
    cameras: Query<(&Side, &LightAccumulation)>,
) {
    let pixels = u64::from(area.0.width()) * u64::from(area.0.height());
    for (side, way) in &cameras {
        let name = match side {
            Side::Before => "accumulated light before",
            Side::After => "accumulated light after",
        };
        let bytes = pixels * way.bytes_per_pixel();
        if memory.0.get(name) != Some(&bytes) {
            memory.0.insert(name.into(), bytes);
        }
    }
}
