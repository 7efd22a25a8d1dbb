//! Light that is received at points, for what is baked.

use bevy::math::{Vec2, Vec3};
use rayon::prelude::*;

use super::{
    random::{Random, Spread},
    surfaces::{Hit, Surfaces},
    tracer::{TraceSettings, Tracer},
};
use crate::stage::Stage;

/// A point that receives light on one side.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// The point, in metres.
    pub position: Vec3,
    /// The direction of the side, a unit vector.
    pub normal: Vec3,
}

/// The indirect light of a number of receivers, traced on all cores: irradiance over pi, which is the radiance that a
/// white surface reflects, of all light but that of point and directional lights without detours.
///
/// `receiver` gives the position of one of them for a point of the unit square, so that it may have an area; `None`
/// where it receives nothing there, and the mean is that of its other points. A receiver without any has no light.
pub fn trace_receivers(
    surfaces: &impl Surfaces,
    stage: &Stage,
    settings: &TraceSettings,
    count: u32,
    receiver: impl Fn(u32, Vec2) -> Option<Receiver> + Sync,
) -> Vec<Option<Vec3>> {
    let tracer = Tracer::new(surfaces, stage, settings);
    let settings = tracer.settings;
    let light = |index: u32| {
        let spread = Spread::new(index, settings.seed);
        let (mut sum, mut points) = (Vec3::ZERO, 0);
        for sample in 0..settings.samples {
            let mut random = Random::new(index, sample, settings.seed);
            let Some(Receiver { position, normal }) = receiver(index, random.point()) else {
                continue;
            };
            let hit = Hit {
                distance: 0.0,
                position,
                face_normal: normal,
                normal,
                albedo: Vec3::ONE,
                emission: Vec3::ZERO,
            };
            sum += tracer.indirect(hit, spread.point(sample), &mut random);
            points += 1;
        }
        (points > 0).then(|| sum / points as f32)
    };
    (0..count).into_par_iter().map(light).collect()
}
