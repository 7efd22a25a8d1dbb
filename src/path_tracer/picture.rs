//! Traced pictures.

use bevy::math::{Vec2, Vec3};
use rayon::prelude::*;

use super::{
    random::{Random, Spread},
    surfaces::Surfaces,
    tracer::{TraceSettings, Tracer},
    view::View,
};
use crate::stage::Stage;

/// Radiance of each pixel, row after row from the top left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TracedPicture {
    /// Width in pixels.
    pub width: u32,
    /// All light.
    pub total: Vec<Vec3>,
    /// What visible surfaces reflect of point and directional lights, without detours.
    pub direct: Vec<Vec3>,
    /// All else that visible surfaces reflect: light of other surfaces, those that emit included, and of the
    /// sky. What visible surfaces emit themselves is only in `total`; 0 where no surface is seen.
    pub indirect: Vec<Vec3>,
}

/// The scene as its camera sees it, traced on all cores.
pub fn trace(surfaces: &impl Surfaces, stage: &Stage, settings: &TraceSettings) -> TracedPicture {
    let tracer = Tracer::new(surfaces, stage, settings);
    let view = View::new(&stage.camera);
    let (width, height) = (stage.camera.width, stage.camera.height);
    let pixels: Vec<Pixel> = (0..width * height)
        .into_par_iter()
        .map(|index| pixel(&tracer, &view, index))
        .collect();
    TracedPicture {
        width,
        total: pixels.iter().map(|p| p.total).collect(),
        direct: pixels.iter().map(|p| p.direct).collect(),
        indirect: pixels.iter().map(|p| p.indirect).collect(),
    }
}

#[derive(Clone, Copy, Default)]
struct Pixel {
    total: Vec3,
    direct: Vec3,
    indirect: Vec3,
}

fn pixel<S: Surfaces>(tracer: &Tracer<S>, view: &View, index: u32) -> Pixel {
    let (stage, settings) = (tracer.stage, &tracer.settings);
    let corner = Vec2::new(
        (index % stage.camera.width) as f32,
        (index / stage.camera.width) as f32,
    );
    let spread = Spread::new(index, settings.seed);
    let mut sum = Pixel::default();
    for sample in 0..settings.samples {
        let mut random = Random::new(index, sample, settings.seed);
        let at = corner + random.point();
        let Some(hit) = tracer.surfaces.closest(view.ray(at)) else {
            sum.total += stage.sky_radiance;
            continue;
        };
        let direct = tracer.direct(&hit);
        let indirect = tracer.indirect(hit, spread.point(sample), &mut random);
        sum.direct += direct;
        sum.indirect += indirect;
        sum.total += hit.emission + direct + indirect;
    }
    let scale = 1.0 / settings.samples as f32;
    Pixel {
        total: scale * sum.total,
        direct: scale * sum.direct,
        indirect: scale * sum.indirect,
    }
}
