//! Deferred lighting with diffuse and specular light in one target (thesis 4.8, figure 4.12).
//!
//! A red and a green lamp shine onto a ball and a floor. Each lamp is drawn over the whole screen
//! and adds its light, as in a deferred renderer; then the surface is lit with the sums. Before:
//! diffuse and specular light in a target each. After: both in one, packed in two channels each; or
//! the usual shortcut, which keeps the luminance of specular light only: diffuse light is yellow
//! where both lamps shine, so both highlights turn yellow.
//!
//! | file | what is in it |
//! | --- | --- |
//! | [`settings`] | what a camera and its lamps are told |
//! | [`plugin`] | the passes in Bevy's renderer |
//! | `lamps`, `pipeline`, `pass` | buffers, pipelines, targets and draws |
//! | [`mod@reference`] | the same on the CPU |
//! | `light.wesl`, `combine.wesl` | the two passes |
//! | `surface.wesl`, `packing.wesl` | what they share |

mod lamps;
mod pass;
mod pipeline;
pub mod plugin;
pub mod reference;
pub mod settings;

use bevy::prelude::*;

use crate::runner::{Knob, Knobs, MemoryFigures, PictureArea, Scene, Side};

pub use plugin::LightAccumulationPlugin;
pub use settings::{Lamp, Lamps, LightAccumulation};

/// The example of light accumulation.
pub struct DeferredAccumulation;

impl Scene for DeferredAccumulation {
    fn name(&self) -> &'static str {
        "deferred_accumulation"
    }

    fn plugin(&self) -> &'static str {
        "bevy_ycocg_fb"
    }

    fn description(&self) -> &'static str {
        "A red and a green lamp: diffuse and specular light in two targets before, in one after"
    }

    fn knobs(&self) -> Vec<Knob> {
        vec![
            Knob::choice(
                "method",
                "how one target holds both kinds of light",
                0,
                &["packed", "specular_luminance"],
            ),
            Knob::float(
                "lamp_distance",
                "half the distance between the lamps",
                LAMP_DISTANCE,
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
            .add_systems(Update, apply_knobs.run_if(resource_changed::<Knobs>))
            .add_systems(Update, count_memory);
    }

    fn dress_camera(&self, camera: &mut EntityCommands, side: Side) {
        let way = match side {
            Side::Before => LightAccumulation::Exact,
            Side::After => LightAccumulation::Packed,
        };
        camera.insert((way, Msaa::Off));
    }
}

/// Half the distance between the lamps at the start, in metres.
pub const LAMP_DISTANCE: f32 = 1.5;

/// A red and a green lamp above and before the ball.
pub fn lamps(distance: f32) -> Lamps {
    let lamp = |x: f32, intensity: Vec3| Lamp {
        position: Vec3::new(x, 2.2, 1.6),
        intensity,
    };
    Lamps(vec![
        lamp(-distance, Vec3::new(6.0, 0.15, 0.1)),
        lamp(distance, Vec3::new(0.15, 4.5, 0.2)),
    ])
}

fn apply_knobs(
    knobs: Res<Knobs>,
    mut shown: ResMut<Lamps>,
    mut cameras: Query<(&Side, &mut LightAccumulation)>,
) {
    *shown = lamps(knobs.float("lamp_distance"));
    let after = match knobs.choice("method") {
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
