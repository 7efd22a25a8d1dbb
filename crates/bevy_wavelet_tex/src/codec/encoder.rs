//! The encoder: from pixels to a [`WaveletImage`].

use rayon::prelude::*;
use thiserror::Error;

use super::{
    blocks::{BlockFormat, ChromaEncoder, Starts, decode_blocks},
    chroma,
    image::{ColorSpace, Content, PlaneGroup, WaveletImage},
    layout,
    packing::Packing,
    plane::Plane,
    planes::LevelPlanes,
    quality,
    quantizer::PlaneCoding,
    rate::Rate,
    search::{choose_coding, choose_thesis_coding},
    settings::{Effort, EncodeSettings, Method},
    source::{LinearLevel, Pixels, Source, level_pixels},
    wavelet::{CoefficientPlane, PackSettings, decode_plane, encode_plane},
};

/// The reason why an image cannot be encoded.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum EncodeError {
    /// A side of the image is 0 or larger than [`layout::MAX_SIZE`].
    #[error("an image of {} x {} pixels cannot be encoded: both sides must be 1 to {}", .0[0], .0[1], layout::MAX_SIZE)]
    Size([u32; 2]),
    /// A level does not have as many pixels as the size requires.
    #[error(
        "mip level {level} of an image of {} x {} pixels should have {wanted} pixels, it has \
         {pixels}",
        .size[0], .size[1]
    )]
    PixelCount {
        /// Width and height of the image in pixels.
        size: [u32; 2],
        /// The mip level; 0 is the image itself.
        level: usize,
        /// Number of pixels that the level should have.
        wanted: u64,
        /// Number of pixels that were given.
        pixels: usize,
    },
    /// The image has no mip level.
    #[error("an image without a mip level cannot be encoded")]
    NoLevel,
}

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

fn check(source: &Source<'_>) -> Result<(), EncodeError> {
    let size = source.size;
    if size.iter().any(|s| !(1..=layout::MAX_SIZE).contains(s)) {
        return Err(EncodeError::Size(size));
    }
    if source.levels.is_empty() {
        return Err(EncodeError::NoLevel);
    }
    for (level, pixels) in source.levels.iter().enumerate() {
        let wanted = level_pixels(size, level);
        if pixels.len() as u64 != wanted {
            return Err(EncodeError::PixelCount {
                size,
                level,
                wanted,
                pixels: pixels.len(),
            });
        }
    }
    Ok(())
}

/// The settings that all levels of an image share.
struct Job<'a> {
    settings: &'a EncodeSettings,
    rate: Rate,
    size: [u32; 2],
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

fn union([a, b]: [f32; 2], [c, d]: [f32; 2]) -> [f32; 2] {
    [a.min(c), b.max(d)]
}

impl Job<'_> {
    fn thesis(&self) -> bool {
        self.settings.method == Method::Thesis
    }

    fn chroma_packing(&self) -> Packing {
        if self.thesis() {
            Packing::Bc3
        } else {
            Packing::Bc1
        }
    }

    fn pack_settings(&self) -> PackSettings {
        PackSettings {
            effort: self.settings.effort,
            thesis: self.thesis(),
        }
    }

    /// Makes the groups and their first level, for which all parameters are chosen. `given` are the
    /// bounds of the given mips.
    fn first_level(&self, mut planes: LevelPlanes, given: &[Vec<[f32; 2]>; 2]) -> Vec<PlaneGroup> {
        let choose = |all: &[Plane], group: usize, packing: Packing| {
            let planes = all.iter().enumerate();
            planes
                .map(|(i, plane)| {
                    let bounds = plane.bounds();
                    let bounds = given[group].get(i).map_or(bounds, |b| union(bounds, *b));
                    self.choose(plane, bounds, packing)
                })
                .collect()
        };
        let chroma = self.rate.chroma_subsampling().map(|subsampling| {
            let small = self.reduced(&planes.chroma, subsampling);
            let packing = self.chroma_packing();
            let codings = choose(&small, 1, packing);
            let mut group = PlaneGroup {
                subsampling,
                packing,
                codings,
                textures: vec![Vec::new()],
            };
            self.add_chroma(&mut group, &mut planes, &small, 0);
            group
        });
        drop(std::mem::take(&mut planes.chroma));
        let mut best: Option<(f64, PlaneGroup)> = None;
        for &packing in self.luma_candidates() {
            let mut group = PlaneGroup {
                subsampling: 0,
                packing,
                codings: choose(&planes.luma, 0, packing),
                textures: vec![Vec::new(); packing.formats().len()],
            };
            let error = self.add_luma(&mut group, &planes.luma, 0);
            if best.as_ref().is_none_or(|(least, _)| error < *least) {
                best = Some((error, group));
            }
        }
        let (_, luma) = best.expect("a rate has a packing");
        std::iter::once(luma).chain(chroma).collect()
    }

    fn next_level(&self, mut planes: LevelPlanes, level: u32, groups: &mut [PlaneGroup]) {
        let [luma, chroma @ ..] = groups else {
            unreachable!("every image has a luma group")
        };
        if let [group] = chroma {
            let small = self.reduced(&planes.chroma, group.subsampling);
            self.add_chroma(group, &mut planes, &small, level);
        }
        self.add_luma(luma, &planes.luma, level);
    }

    fn luma_candidates(&self) -> &'static [Packing] {
        let all = self.rate.luma_packings();
        match self.settings.effort {
            Effort::Fast => &all[..1],
            Effort::Default | Effort::Best => all,
        }
    }

    fn choose(&self, plane: &Plane, [min, max]: [f32; 2], packing: Packing) -> PlaneCoding {
        // The interval is at least one 8-bit step wide, so that 0 and 1 stand for two values.
        let low_bounds = [min, max.max(min + 1.0 / 255.0)];
        if !packing.is_wavelet() {
            return PlaneCoding::linear(low_bounds);
        }
        let coefficients = CoefficientPlane::new(plane);
        let effort = self.settings.effort;
        match self.settings.method {
            Method::Thesis => choose_thesis_coding(&coefficients, low_bounds, packing, effort),
            Method::Best => choose_coding(&coefficients, low_bounds, packing, effort, true),
            Method::OneFetch => choose_coding(&coefficients, low_bounds, packing, effort, false),
        }
    }

    /// Downsamples chroma.
    fn reduced(&self, chroma: &[Plane], subsampling: u32) -> Vec<Plane> {
        let reduce = |plane: &Plane| {
            if self.thesis() {
                // The decoder repeats the value over its pixels, for which the mean is best.
                (0..subsampling).fold(plane.clone(), |p, _| p.halved())
            } else {
                chroma::reduced(plane, subsampling)
            }
        };
        chroma.iter().map(reduce).collect()
    }

    /// Appends a level of chroma, and corrects luma for the error of Cg.
    fn add_chroma(
        &self,
        group: &mut PlaneGroup,
        planes: &mut LevelPlanes,
        small: &[Plane],
        level: u32,
    ) {
        let texture = layout::mip_size(group.texture_size(self.size), level);
        if group.packing != Packing::Bc1 {
            for (coding, plane) in group.codings.iter().zip(small) {
                let settings = self.pack_settings();
                let blocks = encode_plane(group.packing, coding, plane, texture, settings);
                group.textures[0].extend(&blocks[0]);
            }
            return;
        }
        let blocks = self.chroma_blocks(&group.codings, small, texture);
        let texels = decode_blocks(BlockFormat::Bc1, &blocks, texture);
        let cg = Plane::from_fn(small[1].size, |x, y| {
            group.codings[1].load_low(texels[(y * texture[0] + x) as usize][1])
        });
        group.textures[0].extend(&blocks);
        let size = planes.luma[0].size;
        let wanted = &planes.chroma[1];
        planes.luma[0]
            .values
            .par_iter_mut()
            .enumerate()
            .for_each(|(i, luma)| {
                let (x, y) = (i as u32 % size[0], i as u32 / size[0]);
                let got = chroma::interpolated(&cg, group.subsampling, x, y);
                *luma += chroma::luma_correction(got - wanted.values[i]);
            });
    }

    fn chroma_blocks(
        &self,
        codings: &[PlaneCoding],
        small: &[Plane],
        texture: [u32; 2],
    ) -> Vec<u8> {
        let codings = [codings[0], codings[1]];
        let starts = match self.settings.effort {
            Effort::Fast => Starts::One,
            Effort::Default => Starts::Two,
            Effort::Best => Starts::Four,
        };
        let encoder = ChromaEncoder::new(&codings, chroma::WEIGHTS, starts);
        let columns = texture[0].div_ceil(4);
        let blocks: Vec<[u8; 8]> = (0..columns * texture[1].div_ceil(4))
            .into_par_iter()
            .map(|block| {
                encoder.block(&std::array::from_fn(|i| {
                    let x = block % columns * 4 + i as u32 % 4;
                    let y = block / columns * 4 + i as u32 / 4;
                    [small[0].clamped(x, y), small[1].clamped(x, y)]
                }))
            })
            .collect();
        blocks.into_flattened()
    }

    /// Appends a level of luma. Returns its squared error where the encoder chooses between
    /// packings by it, otherwise 0.
    fn add_luma(&self, group: &mut PlaneGroup, planes: &[Plane], level: u32) -> f64 {
        let texture = layout::mip_size(group.texture_size(self.size), level);
        let mut error = 0.0;
        for (coding, plane) in group.codings.iter().zip(planes) {
            let settings = self.pack_settings();
            let blocks = encode_plane(group.packing, coding, plane, texture, settings);
            if level == 0 && self.luma_candidates().len() > 1 {
                let slices: Vec<&[u8]> = blocks.iter().map(Vec::as_slice).collect();
                let size = plane.size;
                let decode = decode_blocks;
                let back = decode_plane(group.packing, coding, &slices, texture, size, decode);
                error += quality::squared_error(&plane.values, &back.values);
            }
            for (texture, blocks) in group.textures.iter_mut().zip(blocks) {
                texture.extend(blocks);
            }
        }
        error
    }
}
