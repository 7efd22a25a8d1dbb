//! The images that are encoded.

use bevy_wavelet_tex::codec::{
    color::ycocg_from_rgb, image::Content, rate::Rate, settings::Effort,
};
use image::{Rgb, RgbImage};
use indicatif::ProgressBar;

use crate::{kodak, plan::Plan, study::TradeoffError};
use bevy_frugal_lab::content;

pub(super) const EFFORTS: [(Effort, &str); 3] = [
    (Effort::Fast, "fast"),
    (Effort::Default, "default"),
    (Effort::Best, "best"),
];

pub(super) const DEFAULT_EFFORT: &[(Effort, &str)] = &[EFFORTS[1]];

pub(super) const SEED: u64 = 7;

/// An image to encode.
pub(super) struct Input {
    pub(super) scene: String,
    pub(super) image: RgbImage,
    pub(super) content: Content,
    pub(super) rates: Vec<Rate>,
    /// The efforts of the encoder for the first rate; the others have the default one.
    pub(super) efforts: &'static [(Effort, &'static str)],
}

/// All images, each once for every content that it is encoded as.
pub(super) fn inputs(
    plan: &Plan,
    photo: &RgbImage,
    progress: &ProgressBar,
) -> Result<Vec<Input>, TradeoffError> {
    let [width, height] = plan.tile;
    let bricks = content::bricks(width, height, SEED);
    let mut colors = vec![
        ("photo".into(), photo.clone()),
        ("bricks".into(), bricks.color),
        (
            "foliage".into(),
            content::foliage(width, height, SEED).color,
        ),
    ];
    let generated = colors.len();
    colors.extend(kodak::photographs(plan, &plan.kodak, progress)?);
    let mut inputs = Vec::new();
    for (i, (scene, image)) in colors.into_iter().enumerate() {
        let in_full = i < generated || plan.kodak_in_full;
        let efforts = if in_full { &EFFORTS } else { DEFAULT_EFFORT };
        if in_full {
            inputs.push(Input {
                scene: format!("{scene} gray"),
                image: gray(&image),
                content: Content::Gray,
                rates: wavelet_rates(Content::Gray).collect(),
                efforts,
            });
        }
        inputs.push(Input {
            scene,
            image,
            content: Content::Color,
            rates: wavelet_rates(Content::Color).collect(),
            efforts,
        });
    }
    inputs.push(Input {
        scene: "bricks normal".into(),
        image: bricks.normal,
        content: Content::Normal,
        rates: vec![Rate::Normal4],
        efforts: &EFFORTS,
    });
    Ok(inputs)
}

/// The luma of an image, in all three channels.
fn gray(image: &RgbImage) -> RgbImage {
    let mut gray = image.clone();
    for pixel in gray.pixels_mut() {
        let luma = ycocg_from_rgb(pixel.0.map(f32::from)).y;
        *pixel = Rgb([luma.round() as u8; 3]);
    }
    gray
}

/// The rates of a content that have a wavelet of their own; the others are those of plain textures.
pub(super) fn wavelet_rates(content: Content) -> impl Iterator<Item = Rate> {
    Rate::of(content).filter(|rate| rate.wavelet() == *rate)
}
