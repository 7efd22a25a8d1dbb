//! Noise on flat walls while a light moves.

use bevy::prelude::*;
use bevy_voxel_gi::{VoxelGiSettings, VoxelGiVolume};

use super::picture::{difference, picture};
use crate::{
    boxes::{BoxScene, picture_noise},
    headless::{HeadlessApp, HeadlessError},
};

/// Frames in which the lights move, at 60 a second.
const FRAMES: u16 = 60;
/// Speed of the lights in metres a second.
const SPEED: f32 = 1.0;

/// The noise of the light of a settled volume after the point lights have moved for a second, along X and
/// through their places in the middle of it. They are back at the end.
///
/// # Errors
/// [`HeadlessError`] when a frame cannot be rendered.
pub fn in_motion(
    app: &mut HeadlessApp,
    scene: &BoxScene,
    volume: Entity,
) -> Result<Option<f64>, HeadlessError> {
    let step = SPEED / 60.0;
    let half = 0.5 * step * f32::from(FRAMES);
    move_lights(app.world_mut(), -half);
    for _ in 0..FRAMES {
        move_lights(app.world_mut(), step);
        app.render_frames(1)?;
    }
    let with = picture(app)?;
    let world = app.world_mut();
    let parts = world.entity_mut(volume).take::<VoxelGiVolume>();
    // The frame in which the volume ends may still show it.
    app.render_frames(2)?;
    let without = picture(app)?;
    let world = app.world_mut();
    let resolution = world.resource::<VoxelGiSettings>().resolution;
    world.entity_mut(volume).insert(parts.unwrap_or_default());
    move_lights(world, -half);
    Ok(picture_noise(
        &difference(&with, &without),
        scene,
        resolution,
    ))
}

fn move_lights(world: &mut World, by: f32) {
    let mut lights = world.query_filtered::<&mut Transform, With<PointLight>>();
    for mut pose in lights.iter_mut(world) {
        pose.translation.x += by;
    }
}
