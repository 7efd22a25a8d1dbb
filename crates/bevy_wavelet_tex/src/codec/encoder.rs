//! The encoder: from pixels to a [`WaveletImage`].

pub use super::check::EncodeError;
use super::{
    check::check,
    image::{ColorSpace, Content, PlaneGroup, WaveletImage},
    job::Job,
    layout,
    plane::union,
    planes::LevelPlanes,
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
    let content = rate.content(settings.alpha);
    let color_space = match content {
        Content::Normal => ColorSpace::Linear,
        _ => settings.color_space,
    };
    let job = Job {
        settings,
        rate,
        size: source.size,
    };
    let mut layouts = vec![(rate.luma_packings()[0], 0)];
    if let Some(subsampling) = rate.chroma_subsampling() {
        layouts.push((job.chroma_packing(), subsampling));
    }
    let most = layout::max_level_count(source.size, &layouts) as usize;
    let levels = match source.levels.len() {
        1 if settings.mips => most,
        given => given.min(most),
    };
    let mut groups: Vec<PlaneGroup> = Vec::new();
    let mut linear: Option<LinearLevel> = None;
    for level in 0..levels {
        let planes = match source.levels.get(level) {
            Some(pixels) => {
                LevelPlanes::given(pixels, layout::mip_size(source.size, level as u32), content)
            }
            None => {
                linear = Some(match &linear {
                    Some(linear) => linear.next(),
                    None => LinearLevel::below(
                        &source.levels[0],
                        source.size,
                        color_space,
                        content == Content::ColorAlpha,
                    ),
                });
                let linear = linear.as_ref().expect("just made");
                LevelPlanes::filtered(linear, content, color_space)
            }
        };
        if level == 0 {
            groups = job.first_level(planes, &given_bounds(source, content, levels));
        } else {
            job.next_level(planes, level as u32, &mut groups);
        }
        progress(level + 1, levels);
    }
    WaveletImage {
        content,
        color_space,
        size: source.size,
        levels: levels as u32,
        groups,
    }
}

/// Bounds of the luma and chroma planes over the given mips. Mips that are not filtered from the
/// first level can exceed its bounds.
fn given_bounds(source: &Source<'_>, content: Content, levels: usize) -> [Vec<[f32; 2]>; 2] {
    let mut all: [Vec<[f32; 2]>; 2] = [Vec::new(), Vec::new()];
    for (level, pixels) in source.levels.iter().enumerate().take(levels).skip(1) {
        let size = layout::mip_size(source.size, level as u32);
        let planes = LevelPlanes::given(pixels, size, content);
        for (all, planes) in all.iter_mut().zip([&planes.luma, &planes.chroma]) {
            all.resize(planes.len(), [f32::INFINITY, f32::NEG_INFINITY]);
            for (all, plane) in all.iter_mut().zip(planes) {
                *all = union(*all, plane.bounds());
            }
        }
    }
    all
}
