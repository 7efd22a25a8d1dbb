//! A live map of the error between the two pictures: for scenes with the settings `view` and `error_gain`.
//!
//! | file | contents |
//! | --- | --- |
//! | `view` | two cameras off screen and a quad that shows their difference |
//! | `material`, `error.wesl` | what the quad is painted with |

mod material;
mod view;

use bevy::{prelude::*, sprite_render::Material2dPlugin};

use crate::runner::SceneSetting;
use material::ErrorMaterial;
pub use view::Films;

/// The systems in `Update` that open and close the view; what configures its cameras comes after.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ErrorViewSystems;

pub fn view_setting() -> SceneSetting {
    SceneSetting::choice(
        "view",
        "the picture, or a live map of the absolute error between the two pictures, from black to pale yellow",
        0,
        &["picture", "error"],
    )
}

pub fn gain_setting() -> SceneSetting {
    SceneSetting::integer(
        "error_gain",
        "error times this: pale yellow is 255 levels divided by it",
        8,
        1..=32,
        "",
    )
}

/// Adds the view to a scene that has both settings.
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
