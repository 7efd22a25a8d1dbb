//! The memory and the lit picture of whole materials, beside BC textures.

use bevy_wavelet_tex::codec::{
    angle::normal_blue,
    blocks::{BlockFormat, BlockQuality, decode_blocks, encode_bc1, encode_bc4, encode_bc7},
    image::Content,
};
use serde::Serialize;

use crate::{
    lit_material::{Material, psnr},
    picture::Picture,
};

/// An image of a glTF file before and after it was encoded.
pub struct EncodedMap {
    /// The textures that use the image.
    pub textures: Vec<usize>,
    pub content: Content,
    pub original: Picture,
    pub decoded: Picture,
    /// Bits per pixel of the largest level.
    pub bpp: f64,
}

/// The bits and the error of one material. A PSNR is of its picture under lights, infinite where that is the
/// original's (which JSON writes as null).
#[derive(Serialize)]
pub struct MaterialRow {
    material: String,
    /// Bits of the largest levels of all maps for each pixel of the largest map.
    bpp: f64,
    lit_psnr_db: f64,
    /// BC7 for colour and data, BC5 for normals, BC4 for one channel, at full size.
    bc7_bpp: f64,
    bc7_lit_psnr_db: f64,
    /// The same with BC1 for colour and data.
    bc1_bpp: f64,
    bc1_lit_psnr_db: f64,
}

impl MaterialRow {
    /// Measures a material, or returns `None` where it has no map.
    pub fn new(material: &Material, all: &[EncodedMap]) -> Option<Self> {
        let of = |texture| all.iter().position(|map| map.textures.contains(&texture));
        let is_used = |i: &usize| material.textures().any(|texture| of(texture) == Some(*i));
        let used: Vec<usize> = (0..all.len()).filter(is_used).collect();
        let longest = |axis: usize| used.iter().map(|i| all[*i].original.size[axis]).max();
        let size = [longest(0)?, longest(1)?];
        let pixels = f64::from(size[0]) * f64::from(size[1]);
        let bpp = |bits: &dyn Fn(usize) -> f64| used.iter().map(|i| bits(*i)).sum::<f64>() / pixels;
        let render = |maps: &[&Picture]| {
            material.render(size, |texture| {
                let index = of(texture).expect("an image for each texture");
                maps[index]
            })
        };
        let originals: Vec<&Picture> = all.iter().map(|map| &map.original).collect();
        let decoded: Vec<&Picture> = all.iter().map(|map| &map.decoded).collect();
        let original = render(&originals);
        let rival = |color: BlockFormat| {
            let mut maps = originals.clone();
            let blocks: Vec<(usize, Picture)> = used
                .iter()
                .map(|i| (*i, through(&all[*i], color)))
                .collect();
            blocks.iter().for_each(|(i, picture)| maps[*i] = picture);
            let bits = |i: usize| {
                let bytes = format(all[i].content, color).level_bytes(all[i].original.size);
                8.0 * bytes as f64
            };
            (bpp(&bits), psnr(&original, &render(&maps)))
        };
        let (bc7_bpp, bc7_lit_psnr_db) = rival(BlockFormat::Bc7);
        let (bc1_bpp, bc1_lit_psnr_db) = rival(BlockFormat::Bc1);
        Some(Self {
            material: material.name.clone(),
            bpp: bpp(&|i| all[i].bpp * all[i].original.pixels.len() as f64),
            lit_psnr_db: psnr(&original, &render(&decoded)),
            bc7_bpp,
            bc7_lit_psnr_db,
            bc1_bpp,
            bc1_lit_psnr_db,
        })
    }

    pub fn text(&self) -> String {
        let one = |bpp: f64, db: f64| match db.is_finite() {
            true => format!("{bpp:.2} bpp, {db:.2} dB lit"),
            false => format!("{bpp:.2} bpp, identical"),
        };
        format!(
            "{}: all maps {}; BC7 and BC5 {}; BC1 and BC5 {}",
            self.material,
            one(self.bpp, self.lit_psnr_db),
            one(self.bc7_bpp, self.bc7_lit_psnr_db),
            one(self.bc1_bpp, self.bc1_lit_psnr_db),
        )
    }
}

fn format(content: Content, color: BlockFormat) -> BlockFormat {
    match content {
        Content::Gray => BlockFormat::Bc4,
        Content::Normal => BlockFormat::Bc5,
        Content::Color | Content::ColorAlpha => color,
    }
}

/// Encodes and decodes the original as BC blocks.
fn through(map: &EncodedMap, color: BlockFormat) -> Picture {
    let Picture { size, pixels, .. } = &map.original;
    let format = format(map.content, color);
    let channel = |c: usize| {
        let values: Vec<f32> = pixels.iter().map(|p| f32::from(p[c]) / 255.0).collect();
        let blocks = encode_bc4(&values, *size, BlockQuality::High);
        decode_blocks(BlockFormat::Bc4, &blocks, *size)
            .into_iter()
            .map(|texel| byte(texel[0]))
    };
    let texels: Vec<[u8; 4]> = match format {
        BlockFormat::Bc4 => channel(0).map(|v| [v, v, v, 255]).collect(),
        BlockFormat::Bc5 => {
            let pairs = channel(0).zip(channel(1));
            pairs
                .map(|(r, g)| [r, g, normal_blue([r, g]), 255])
                .collect()
        }
        _ => {
            let blocks = if format == BlockFormat::Bc7 {
                encode_bc7(*size, [1; 3], |x, y| {
                    let [r, g, b, _] = pixels[(y * size[0] + x) as usize];
                    [r, g, b].map(|v| f32::from(v) / 255.0)
                })
            } else {
                encode_bc1(&opaque(pixels), *size, BlockQuality::High)
            };
            let texels = decode_blocks(format, &blocks, *size);
            texels.into_iter().map(|texel| texel.map(byte)).collect()
        }
    };
    map.original.with_pixels(texels)
}

fn opaque(pixels: &[[u8; 4]]) -> Vec<[u8; 4]> {
    pixels
        .iter()
        .map(|[r, g, b, _]| [*r, *g, *b, 255])
        .collect()
}

fn byte(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0).round() as u8
}
