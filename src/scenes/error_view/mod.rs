//! The error between before and after, live: for scenes with the knobs `view` and `error_gain`.
//!
//! | file | what is in it |
//! | --- | --- |
//! | `view` | two cameras off screen and a quad that shows their difference |
//! | `material`, `error.wesl` | what the quad is painted with |

mod material;
mod view;

use bevy::{prelude::*, sprite_render::Material2dPlugin};

use crate::runner::{Knob, Side};
use material::ErrorMaterial;

/// A camera that shows a side: that of the split (if the scene says so), or one off screen.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct Films(pub Side);

/// The systems in `Update` that open and close the view; what dresses its cameras comes after.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ErrorViewSystems;

/// Whether the picture or the error is shown.
pub fn view_knob() -> Knob {
    Knob::choice(
        "view",
        "the picture, or the absolute error of after, from black to pale yellow",
        0,
        &["picture", "error"],
    )
}

/// How strongly the error is shown.
pub fn gain_knob() -> Knob {
    Knob::integer(
        "error_gain",
        "error times this: pale yellow is 255 levels divided by it",
        8,
        1..=32,
        "",
    )
}

/// Adds the view to a scene that has both knobs.
pub struct ErrorViewPlugin;

impl Plugin for ErrorViewPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(Material2dPlugin::<ErrorMaterial>::default());
        material::embed(app);
        app.init_resource::<view::ErrorView>()
            .add_systems(
                Update,
                (view::open_or_close, view::hide_split)
                    .chain()
                    .in_set(ErrorViewSystems),
            )
            .add_systems(
                PostUpdate,
                view::follow_pose.before(TransformSystems::Propagate),
            );
    }
}
