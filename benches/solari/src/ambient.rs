//! The constant ambient light that fits best: its mean in the picture is that of the indirect light.

use bevy::prelude::*;
use bevy_frugal_lab::{
    boxes::{TracedScene, block_means},
    headless::{HeadlessApp, HeadlessError},
};

use crate::picture::{difference, picture};

/// Sets the ambient light of an app that has none; `direct` is its picture.
///
/// # Errors
/// [`HeadlessError`] when a frame cannot be rendered.
pub fn fit(
    app: &mut HeadlessApp,
    truth: &TracedScene,
    direct: &[Vec3],
) -> Result<(), HeadlessError> {
    app.world_mut().insert_resource(ambient(Vec3::ONE));
    app.render_frames(2)?;
    let white = difference(&picture(app)?, direct);
    let white = block_means(&white, truth.scene.camera.width);
    let (mut added, mut wanted) = (Vec3::ZERO, Vec3::ZERO);
    for (white, indirect) in white.iter().zip(&truth.indirect) {
        if *indirect != Vec3::ZERO {
            added += white;
            wanted += indirect;
        }
    }
    let fitted = wanted / added.max(Vec3::splat(f32::MIN_POSITIVE));
    app.world_mut().insert_resource(ambient(fitted));
    Ok(())
}

fn ambient(luminance: Vec3) -> GlobalAmbientLight {
    let brightness = luminance.max_element();
    GlobalAmbientLight {
        color: LinearRgba::from_vec3(luminance / brightness).into(),
        brightness,
        ..default()
    }
}
