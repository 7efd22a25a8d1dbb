//! The encoder: from pixels to a [`WaveletImage`].

pub use super::check::EncodeError;
use super::{
    check::check,
    choice::{Choice, choose},
    decoder::decode,
    image::WaveletImage,
    prepare::Prepared,
    quality,
    rate::Rate,
    settings::EncodeSettings,
    source::{Pixels, Source},
};

/// Encodes an image.
///
/// Gray is the luma of YCoCg, as in the thesis; normals are X and Y of the unit vector. The result
/// does not depend on the number of threads. `progress` is called after each part with the number
/// of finished parts and their total: the mips are made, and the image is encoded.
///
/// # Errors
/// Returns an error when the size is out of range or does not match the number of pixels.
pub fn encode(
    source: &Source<'_>,
    settings: &EncodeSettings,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<WaveletImage, EncodeError> {
    check(source)?;
    let prepared = Prepared::new(source, settings);
    progress(1, 2);
    let source = &prepared.source();
    let content = settings.rate.content(settings.alpha);
    let choice = match settings.min_psnr_db {
        None => choose(source, settings, settings.rate),
        Some(wanted) => {
            // The PSNR of the largest level decides.
            let is_enough = |choice: &Choice<'_>| quality::psnr_db(source, &choice.image) >= wanted;
            let mut choices = Rate::of(content).map(|rate| choose(source, settings, rate));
            let mut choice = choices.next().expect("every content has a rate");
            while !is_enough(&choice)
                && let Some(next) = choices.next()
            {
                choice = next;
            }
            choice
        }
    };
    let image = with_coverage(choice, &prepared);
    progress(2, 2);
    Ok(image)
}

/// Encodes RGB pixels of 8 bits a channel, row by row from the top.
///
/// # Errors
/// Returns the errors of [`encode`].
pub fn encode_rgb8(
    pixels: &[[u8; 3]],
    size: [u32; 2],
    settings: &EncodeSettings,
) -> Result<WaveletImage, EncodeError> {
    encode(
        &Source::new(size, Pixels::Rgb8(pixels)),
        settings,
        &|_, _| {},
    )
}

/// How far from the cutoff the alpha of all pixels of a level is kept, one after the other until its encoding moves
/// few enough over the cutoff.
const MARGINS: [f32; 5] = [0.02, 0.04, 0.08, 0.16, 0.3];

/// The image with mips that cover as much as the first level, where something is cut out.
fn with_coverage(choice: Choice<'_>, prepared: &Prepared<'_>) -> WaveletImage {
    let Choice { job, mut image } = choice;
    let Some(cut_out) = prepared.cut_out() else {
        return image;
    };
    let excess: Vec<f64> = (0..image.levels)
        .map(|level| cut_out.excess(&decode(&image, level)))
        .collect();
    let Some(first) = (1..image.levels).find(|level| excess[*level as usize] > 0.0) else {
        return image;
    };
    image.truncate_levels(first);
    for level in first..image.levels {
        let pixels = prepared
            .made(level)
            .expect("mips are made for what is cut out");
        let before = image.lengths();
        let mut best = (excess[level as usize], 0.0);
        let margins = MARGINS
            .into_iter()
            .take(if best.0 > 0.0 { MARGINS.len() } else { 0 });
        for margin in margins {
            let apart = cut_out.apart(pixels, margin);
            job.add_level(&mut image, level, Pixels::Rgba16(&apart));
            let excess = cut_out.excess(&decode(&image, level));
            if excess < best.0 {
                best = (excess, margin);
            }
            image.truncate(&before);
            if excess == 0.0 {
                break;
            }
        }
        let apart = cut_out.apart(pixels, best.1);
        job.add_level(&mut image, level, Pixels::Rgba16(&apart));
    }
    image
}
