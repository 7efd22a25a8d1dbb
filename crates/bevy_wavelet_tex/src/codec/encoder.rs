//! The encoder: from pixels to a [`WaveletImage`].

pub use super::check::EncodeError;
use super::{
    check::check,
    choice::{Choice, choose},
    coverage::CutOut,
    decoder::decode,
    image::{Content, WaveletImage},
    job::Job,
    prepare::Prepared,
    quality,
    rate::Rate,
    settings::EncodeSettings,
    source::{LinearLevel, Pixels, Source},
};

/// Encodes an image.
///
/// Gray is the luma of YCoCg, as in the thesis; normals are X and Y of the unit vector. The result
/// does not depend on the number of threads. `progress` is called after each part with the number
/// of finished parts and their total.
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
    let source = &prepared.source();
    let content = settings.rate.content(settings.alpha);
    let Some(wanted) = settings.min_psnr_db else {
        return Ok(encode_at(source, settings, settings.rate, progress));
    };
    let mut rates = Rate::of(content).peekable();
    while let Some(rate) = rates.next() {
        // The PSNR of the largest level decides. Mips are made only for the rate that is chosen.
        let first = Source::new(source.size, source.levels[0]);
        let trial = EncodeSettings {
            mips: false,
            ..*settings
        };
        let last = rates.peek().is_none();
        if last || quality::psnr_db(&first, &encode_at(&first, &trial, rate, &|_, _| {})) >= wanted
        {
            return Ok(encode_at(source, settings, rate, progress));
        }
    }
    unreachable!("every content has a rate")
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

fn encode_at(
    source: &Source<'_>,
    settings: &EncodeSettings,
    rate: Rate,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> WaveletImage {
    let Choice { job, mut image } = choose(source, settings, rate);
    let (content, color_space) = (image.content, image.color_space);
    let has_alpha = content == Content::ColorAlpha;
    let cut_out = CutOut::of(source, settings, content);
    progress(1, image.levels as usize);
    let mut linear: Option<LinearLevel> = None;
    for level in 1..image.levels {
        if let Some(given) = source.levels.get(level as usize) {
            job.add_level(&mut image, level, |i| given.get(i));
        } else {
            let filtered = match &linear {
                Some(linear) => linear.next(),
                None => LinearLevel::below(&source.levels[0], source.size, color_space, has_alpha),
            };
            match &cut_out {
                Some(cut_out) => add_cut_out(&job, &mut image, level, &filtered, cut_out),
                None => job.add_level(&mut image, level, |i| {
                    filtered.get(i, color_space, has_alpha)
                }),
            }
            linear = Some(filtered);
        }
        progress(level as usize + 1, image.levels as usize);
    }
    image
}

/// How far from the cutoff the alpha of all pixels of a level is kept, one after the other until its encoding moves
/// few enough over the cutoff.
const MARGINS: [f32; 6] = [0.0, 0.02, 0.04, 0.08, 0.16, 0.3];

/// Appends a level that covers as much as the first one.
fn add_cut_out(
    job: &Job<'_>,
    image: &mut WaveletImage,
    level: u32,
    filtered: &LinearLevel,
    cut_out: &CutOut,
) {
    let before = image.lengths();
    let (channels, scaled) = cut_out.scaled(filtered);
    let encoded = |image: &mut WaveletImage, margin: f32| {
        let (color_space, has_alpha) = (image.color_space, image.content == Content::ColorAlpha);
        job.add_level(image, level, |i| {
            let mut pixel = filtered.get(i, color_space, has_alpha);
            pixel[channels.clone()].fill(cut_out.apart(scaled[i], margin));
            pixel
        });
        cut_out.excess(&decode(image, level))
    };
    let mut best = (f64::INFINITY, 0.0);
    for margin in MARGINS {
        let excess = encoded(image, margin);
        if excess == 0.0 {
            return;
        }
        if excess < best.0 {
            best = (excess, margin);
        }
        image.truncate(&before);
    }
    encoded(image, best.1);
}
