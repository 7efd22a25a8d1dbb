//! What moves that should not: the change of the error from a frame to the next.

use bevy_ewa::{
    EwaSettings,
    reference::{Texture, scenes::Surface},
};

use bevy_frugal_lab::lookups::{
    picture::{Pixels, computed_picture, linear_mse, mean, true_picture},
    scenes::{EwaScene, coordinates},
};

const FRAMES: u32 = 8;

/// Part of a frame in the history of temporal anti-aliasing, as in Bevy's.
const NEW_PART: f64 = 0.1;

/// Textures by which the camera moves in a frame.
const STEP: f64 = 0.013;

/// Flicker in squares of 8-bit units, of linear values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flicker {
    /// With a moving camera: mean squared change of the error against the truth.
    pub moving: f64,
    /// The same with a camera that stands still.
    pub still: f64,
    /// The same with a camera that stands still, under temporal anti-aliasing without jitter.
    pub still_with_taa: f64,
}

/// `frames` is the number of frames after which the method repeats, 1 where they are all the same.
pub fn flicker(
    scene: &EwaScene,
    truths: &[Pixels],
    size: u32,
    settings: &EwaSettings,
    frames: u32,
) -> Flicker {
    let (surface, texture) = ((scene.surface)(), (scene.texture)());
    let moved = |i: u32| computed(&texture, &at(&surface, i), size, settings, i);
    let errors: Vec<_> = (0..FRAMES)
        .zip(truths)
        .map(|(i, truth)| difference(&moved(i), truth))
        .collect();
    let changes = errors.windows(2).map(|pair| linear_mse(&pair[0], &pair[1]));
    let moving = changes.sum::<f64>() / f64::from(FRAMES - 1);

    let frames =
        (0..frames.max(2)).map(|frame| computed(&texture, &surface, size, settings, frame));
    let frames: Vec<_> = frames.collect();
    let changes = frames.windows(2).map(|pair| linear_mse(&pair[0], &pair[1]));
    let still = changes.sum::<f64>() / (frames.len() - 1) as f64;
    let mut history = mean(&frames);
    let mut still_with_taa = 0.0;
    // Long enough for the history to forget how it began.
    for frame in frames.iter().cycle().take(64) {
        let next = blended(&history, frame);
        still_with_taa = linear_mse(&history, &next);
        history = next;
    }
    Flicker {
        moving,
        still,
        still_with_taa,
    }
}

pub fn truths(scene: &EwaScene, size: u32, rate: u32) -> Vec<Pixels> {
    let texture = (scene.texture)();
    let frame = |i| true_picture(&texture, &at(&(scene.surface)(), i), size, rate);
    (0..FRAMES).map(frame).collect()
}

fn at(surface: &Surface, step: u32) -> Surface {
    surface.with_camera_moved_by(STEP * f64::from(step))
}

fn computed(
    texture: &Texture,
    surface: &Surface,
    size: u32,
    settings: &EwaSettings,
    frame: u32,
) -> Pixels {
    let coordinates = coordinates(surface, size);
    computed_picture(texture, &coordinates, size, settings, frame).0
}

fn difference(a: &Pixels, b: &Pixels) -> Pixels {
    let pairs = a.iter().zip(b);
    pairs.map(|(a, b)| [0, 1, 2].map(|c| a[c] - b[c])).collect()
}

fn blended(history: &Pixels, frame: &Pixels) -> Pixels {
    let pairs = history.iter().zip(frame);
    pairs
        .map(|(h, f)| [0, 1, 2].map(|c| h[c] + (f[c] - h[c]) * NEW_PART))
        .collect()
}
