//! Encoding of the levels of an image: the parameters are chosen for the first one.

use rayon::prelude::*;

use super::{
    axes::ColorAxes,
    blocks::{BlockFormat, ChromaEncoder, Starts, decode_blocks},
    chroma,
    decoder::stored_chroma,
    image::{PlaneGroup, WaveletImage},
    layout,
    pack::{PackSettings, encode_plane},
    packing::Packing,
    plain,
    plane::{Plane, union},
    planes::LevelPlanes,
    quality,
    quantizer::PlaneCoding,
    rate::Rate,
    search::{choose_coding, choose_thesis_coding},
    settings::{Effort, EncodeSettings, Method},
    wavelet::{CoefficientPlane, decode_plane},
};

/// The settings that all levels of an image share.
#[derive(Clone, Copy)]
pub(super) struct Job<'a> {
    pub(super) settings: &'a EncodeSettings,
    pub(super) rate: Rate,
    pub(super) size: [u32; 2],
    pub(super) axes: ColorAxes,
}

impl Job<'_> {
    fn thesis(&self) -> bool {
        self.settings.method == Method::Thesis
    }

    pub(super) fn chroma_packing(&self) -> Packing {
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
    pub(super) fn first_level(
        &self,
        mut planes: LevelPlanes,
        given: &[Vec<[f32; 2]>; 2],
    ) -> Vec<PlaneGroup> {
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

    /// Appends the next level of an image, whose pixels `pixel` returns.
    pub(super) fn add_level(
        &self,
        image: &mut WaveletImage,
        level: u32,
        pixel: impl Fn(usize) -> [f32; 4] + Sync,
    ) {
        let content = image.content;
        match &mut image.plain {
            Some(plain) => {
                plain::add_level(
                    plain,
                    level,
                    self.size,
                    pixel,
                    content,
                    self.settings.effort,
                );
            }
            None => {
                let size = layout::mip_size(self.size, level);
                let planes = LevelPlanes::new(size, content, self.axes, pixel);
                self.next_level(planes, level, &mut image.groups);
            }
        }
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

    /// Appends a level of chroma, and corrects luma for its error.
    fn add_chroma(
        &self,
        group: &mut PlaneGroup,
        planes: &mut LevelPlanes,
        small: &[Plane],
        level: u32,
    ) {
        let texture = group.texture_level_size(self.size, level);
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
        group.textures[0].extend(&blocks);
        for (c, small) in small.iter().enumerate() {
            let correction = self.axes.luma_correction(c);
            // Only Cg of YCoCg is not orthogonal to luma.
            if correction.abs() < 1e-6 {
                continue;
            }
            let decoded = Plane::from_fn(small.size, |x, y| {
                let texel = texels[(y * texture[0] + x) as usize];
                group.codings[c].load_low(stored_chroma(c, texel))
            });
            let got = chroma::interpolated(&decoded, group.subsampling, planes.luma[0].size);
            let pairs = got.values.iter().zip(&planes.chroma[c].values);
            for (luma, (got, wanted)) in planes.luma[0].values.iter_mut().zip(pairs) {
                *luma += correction * (got - wanted);
            }
        }
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
        let encoder = ChromaEncoder::new(&codings, self.axes.chroma_weights(), starts);
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
        let texture = group.texture_level_size(self.size, level);
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
