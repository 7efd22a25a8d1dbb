//! Encoding of the levels of an image, which share their parameters.

use rayon::prelude::*;

use super::{
    axes::ColorAxes,
    blocks::{BlockFormat, ChromaEncoder, decode_blocks, map_blocks},
    chroma,
    decoder::stored_chroma,
    image::{Payload, PlaneGroup, WaveletImage, WaveletPlanes},
    interpolation::{Interpolation, NormalEquations},
    layout,
    pack::{PlaneValues, encode_plane, error_of},
    packing::Packing,
    plain,
    plane::Plane,
    quality::level_weight,
    quantizer::PlaneCoding,
    rate::Rate,
    search::{choose_coding, choose_thesis_coding},
    settings::{Effort, EncodeSettings, Method},
    source::{LevelPlanes, Pixels, Source},
};

/// A packing is encoded where the estimate of its squared error is at most this factor of the least.
const DOUBT: f64 = 1.06;

/// The settings that all levels of an image share.
#[derive(Clone, Copy)]
pub(super) struct Job<'a> {
    pub(super) settings: &'a EncodeSettings,
    pub(super) rate: Rate,
    pub(super) size: [u32; 2],
    pub(super) axes: ColorAxes,
}

impl<'a> Job<'a> {
    pub(super) fn new(
        source: &Source<'_>,
        settings: &'a EncodeSettings,
        rate: Rate,
        axes: ColorAxes,
    ) -> Self {
        Self {
            settings,
            rate,
            size: source.size,
            axes,
        }
    }

    fn thesis(&self) -> bool {
        self.settings.method == Method::Thesis
    }

    /// Encodes all levels by a wavelet.
    pub(super) fn planes(&self, levels: &[LevelPlanes<'_>]) -> WaveletPlanes {
        let (chroma, first) = match self.rate.chroma_subsampling() {
            Some(subsampling) => {
                let (group, luma) = self.chroma_group(levels, subsampling);
                (Some(group), luma)
            }
            None => (None, levels.iter().map(|level| level.luma(0)).collect()),
        };
        let planes = levels[0].content.luma_planes();
        let others = (1..planes).map(|plane| levels.iter().map(|l| l.luma(plane)).collect());
        WaveletPlanes {
            axes: self.axes,
            luma: self.luma_group(std::iter::once(first).chain(others)),
            chroma,
        }
    }

    /// Encodes chroma, and returns it with luma that is corrected for its error.
    fn chroma_group(
        &self,
        levels: &[LevelPlanes<'_>],
        subsampling: u32,
    ) -> (PlaneGroup, Vec<Plane>) {
        let packing = match self.thesis() {
            true => Packing::Bc3,
            false => Packing::Bc1,
        };
        let small: Vec<[Plane; 2]> = levels
            .iter()
            .map(|level| self.reduced(level, subsampling))
            .collect();
        let coding = |plane: usize| {
            let planes = small.iter().map(|level| &level[plane]);
            let bounds = bounds(planes.clone());
            let values = planes.map(|plane| PlaneValues::new(packing, plane.clone()));
            self.choose(&values.collect::<Vec<_>>(), bounds, packing).0
        };
        let mut group = PlaneGroup {
            subsampling,
            packing,
            codings: vec![coding(0), coding(1)],
            textures: vec![Vec::new()],
        };
        let pairs = levels.iter().zip(&small).enumerate();
        let luma = pairs
            .map(|(i, (level, small))| self.add_chroma(&mut group, level, small, i as u32))
            .collect();
        (group, luma)
    }

    /// Encodes planes of luma, all of whose levels are given, in the packing that has the least error.
    fn luma_group(&self, planes: impl Iterator<Item = Vec<Plane>>) -> PlaneGroup {
        struct Trial {
            packing: Packing,
            codings: Vec<PlaneCoding>,
            estimate: f64,
        }
        let candidates = match (self.rate.luma_packings(), self.settings.effort) {
            (all, Effort::Fast) => &all[..1],
            (all, Effort::Default | Effort::Best) => all,
        };
        let mut trials = Vec::from_iter(candidates.iter().map(|&packing| Trial {
            packing,
            codings: Vec::new(),
            estimate: 0.0,
        }));
        let values: Vec<Vec<PlaneValues>> = planes
            .map(|levels| {
                let bounds = bounds(levels.iter());
                let values = levels.into_iter();
                let values = values.map(|plane| PlaneValues::new(candidates[0], plane));
                let values: Vec<PlaneValues> = values.collect();
                for trial in &mut trials {
                    let (coding, estimate) = self.choose(&values, bounds, trial.packing);
                    trial.codings.push(coding);
                    trial.estimate += estimate;
                }
                values
            })
            .collect();
        let least = trials
            .iter()
            .map(|t| t.estimate)
            .fold(f64::INFINITY, f64::min);
        trials.retain(|trial| trial.estimate <= DOUBT * least);
        let is_measured = trials.len() > 1;
        let mut best: Option<(f64, PlaneGroup)> = None;
        for Trial {
            packing, codings, ..
        } in trials
        {
            let mut group = PlaneGroup {
                subsampling: 0,
                packing,
                codings,
                textures: vec![Vec::new(); packing.formats().len()],
            };
            let mut error = 0.0;
            for level in 0..values[0].len() {
                let planes: Vec<&PlaneValues> = values.iter().map(|plane| &plane[level]).collect();
                error += self.add_luma(&mut group, &planes, level as u32, is_measured);
            }
            if best.as_ref().is_none_or(|(least, _)| error < *least) {
                best = Some((error, group));
            }
        }
        best.expect("a rate has a packing").1
    }

    /// Appends the next level of an image.
    pub(super) fn add_level(&self, image: &mut WaveletImage, level: u32, pixels: Pixels<'_>) {
        let size = layout::mip_size(self.size, level);
        let content = image.content;
        let WaveletPlanes { luma, chroma, .. } = match &mut image.payload {
            Payload::Wavelet(planes) => planes,
            Payload::Plain(plain) => {
                let channels = plain::Channels {
                    size,
                    pixels,
                    content,
                };
                plain::add_level(plain, level, self.size, &channels, self.settings.effort);
                return;
            }
        };
        let planes = LevelPlanes::new(pixels, size, content, self.axes);
        let first = match chroma {
            Some(group) => {
                let small = self.reduced(&planes, group.subsampling);
                self.add_chroma(group, &planes, &small, level)
            }
            None => planes.luma(0),
        };
        let others = (1..content.luma_planes()).map(|plane| planes.luma(plane));
        let all = std::iter::once(first).chain(others);
        let all: Vec<_> = all
            .map(|plane| PlaneValues::new(luma.packing, plane))
            .collect();
        self.add_luma(luma, &all.iter().collect::<Vec<_>>(), level, false);
    }

    /// The parameters of a plane, all of whose levels are given, and an estimate of their error, which is 0 where there
    /// is none.
    fn choose(
        &self,
        levels: &[PlaneValues],
        [min, max]: [f32; 2],
        packing: Packing,
    ) -> (PlaneCoding, f64) {
        // The interval is at least one 8-bit step wide, so that 0 and 1 stand for two values.
        let low_bounds = [min, max.max(min + 1.0 / 255.0)];
        let levels: Option<Vec<_>> = levels.iter().map(PlaneValues::coefficients).collect();
        let Some(levels) = levels else {
            return (PlaneCoding::linear(low_bounds), 0.0);
        };
        let effort = self.settings.effort;
        match self.settings.method {
            Method::Thesis => {
                let coding = choose_thesis_coding(&levels, low_bounds, packing, effort);
                (coding, 0.0)
            }
            Method::Best => choose_coding(&levels, low_bounds, packing, effort, true),
            Method::OneFetch => choose_coding(&levels, low_bounds, packing, effort, false),
        }
    }

    /// Downsamples chroma.
    fn reduced(&self, level: &LevelPlanes<'_>, subsampling: u32) -> [Plane; 2] {
        [0, 1].map(|plane| {
            if self.thesis() {
                // The decoder repeats the value over its pixels, for which the mean is best.
                let width = level.size[0];
                let all = Plane::from_fn(level.size, |x, y| {
                    level.chroma(plane, (y * width + x) as usize)
                });
                (0..subsampling).fold(all, |p, _| p.halved())
            } else {
                chroma::reduced(level.size, subsampling, |i| level.chroma(plane, i))
            }
        })
    }

    /// Appends a level of chroma, and returns luma, corrected for its error.
    fn add_chroma(
        &self,
        group: &mut PlaneGroup,
        planes: &LevelPlanes<'_>,
        small: &[Plane; 2],
        level: u32,
    ) -> Plane {
        let mut luma = planes.luma(0);
        let texture = group.texture_level_size(self.size, level);
        if group.packing != Packing::Bc1 {
            for (coding, plane) in group.codings.iter().zip(small) {
                let values = PlaneValues::new(group.packing, plane.clone());
                let blocks = encode_plane(group.packing, coding, &values, texture, self.settings);
                group.textures[0].extend(&blocks[0]);
            }
            return luma;
        }
        let blocks = self.chroma_blocks(&group.codings, planes, small, texture, group.subsampling);
        let corrections = [0, 1].map(|c: usize| self.axes.luma_correction(c));
        if corrections.iter().any(|c| is_correction(*c)) {
            let texels = decode_blocks(BlockFormat::Bc1, &blocks, texture);
            let interpolation = Interpolation::new(chroma::axes(luma.size, group.subsampling));
            for (c, correction) in corrections.into_iter().enumerate() {
                if !is_correction(correction) {
                    continue;
                }
                let decoded = Plane::from_fn(small[c].size, |x, y| {
                    let texel = texels[(y * texture[0] + x) as usize];
                    group.codings[c].load_low(stored_chroma(c, texel))
                });
                let width = luma.size[0] as usize;
                let rows = luma.values.par_chunks_mut(width).enumerate();
                rows.for_each(|(y, row)| {
                    let mut got = vec![0.0; width];
                    interpolation.fill(&decoded, y as u32, &mut got);
                    for (x, (luma, got)) in row.iter_mut().zip(got).enumerate() {
                        *luma += correction * (got - planes.chroma(c, y * width + x));
                    }
                });
            }
        }
        group.textures[0].extend(&blocks);
        luma
    }

    fn chroma_blocks(
        &self,
        codings: &[PlaneCoding],
        planes: &LevelPlanes<'_>,
        small: &[Plane; 2],
        texture: [u32; 2],
        subsampling: u32,
    ) -> Vec<u8> {
        let codings = [codings[0], codings[1]];
        let effort = self.settings.effort;
        let encoder = ChromaEncoder::new(&codings, self.axes.chroma_weights(), effort.starts());
        let values = |(x, y)| small.each_ref().map(|plane| plane.clamped(x, y));
        let mut blocks = map_blocks(texture, |at| encoder.block(&at.map(values)));
        if effort != Effort::Fast {
            let axes = chroma::axes(planes.size, subsampling);
            let equations = NormalEquations::new(axes, |plane, i| planes.chroma(plane, i));
            let columns = texture[0].div_ceil(4) as usize;
            encoder.refine(&mut blocks, equations, small[0].size, columns);
        }
        blocks.into_flattened()
    }

    /// Appends a level of the luma group. Returns its mean squared error in a pixel, by how much the level is used,
    /// where that is measured.
    fn add_luma(
        &self,
        group: &mut PlaneGroup,
        planes: &[&PlaneValues],
        level: u32,
        is_measured: bool,
    ) -> f64 {
        let texture = group.texture_level_size(self.size, level);
        let mut error = 0.0;
        for (coding, values) in group.codings.iter().zip(planes) {
            let blocks = encode_plane(group.packing, coding, values, texture, self.settings);
            if let (true, Some(coefficients)) = (is_measured, values.coefficients()) {
                let weight = level_weight(level as usize) / coefficients.details.len() as f64;
                error += weight * error_of(group.packing, coding, coefficients, &blocks, texture);
            }
            for (texture, blocks) in group.textures.iter_mut().zip(blocks) {
                texture.extend(blocks);
            }
        }
        error
    }
}

/// Returns whether luma is corrected at all. Of YCoCg, Cg alone is not orthogonal to luma.
fn is_correction(correction: f32) -> bool {
    correction.abs() >= 1e-6
}

/// The bounds of all levels of a plane.
fn bounds<'a>(levels: impl Iterator<Item = &'a Plane>) -> [f32; 2] {
    let none = [f32::INFINITY, f32::NEG_INFINITY];
    let bounds = levels.map(Plane::bounds);
    bounds.fold(none, |[a, b], [min, max]| [a.min(min), b.max(max)])
}
