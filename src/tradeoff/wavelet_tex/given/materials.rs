//! The memory and the lit picture of whole materials, beside BC textures.

use std::{
    collections::{BTreeMap, btree_map::Entry},
    fmt::Write,
    fs,
    path::Path,
};

use bevy_wavelet_tex::codec::{
    angle::normal_blue,
    blocks::BlockFormat,
    decoder::decode,
    image::{ColorSpace, Content},
    rate::Rate,
    settings::EncodeSettings,
};
use gltf::{Gltf, buffer, image::Source};
use image::{DynamicImage, Rgb, Rgb32FImage, RgbImage, buffer::ConvertBuffer};

use super::{super::baselines::through, encoded::encoded, lit_material::Material};
use crate::{
    metrics::error::{mse, psnr_db},
    tradeoff::study::TradeoffError,
};

/// What is in the maps of a material, in the order of [`Material::maps`]. Where an image has two roles (occlusion
/// is often a channel of metallic-roughness), the first decides.
const ROLES: [(Content, ColorSpace); 5] = [
    (Content::Color, ColorSpace::Srgb),
    (Content::Color, ColorSpace::Srgb),
    (Content::Normal, ColorSpace::Linear),
    (Content::Color, ColorSpace::Linear),
    (Content::Gray, ColorSpace::Linear),
];

/// An image before and after it was encoded.
struct Map {
    content: Content,
    original: RgbImage,
    decoded: RgbImage,
    /// Bits of the largest level.
    bits: f64,
}

/// A row for each material: the bits of the largest levels of all maps for each pixel of the largest map, and the
/// PSNR of its picture. BC7 stands for BC7 of colour and data, BC5 of normals and BC4 of one channel, at full size,
/// BC1 for the same with BC1 of colour and data.
pub(super) fn table(path: &Path, min_psnr_db: Option<f64>) -> Result<String, TradeoffError> {
    let model = Gltf::open(path).map_err(TradeoffError::file(path))?;
    let materials: Vec<_> = model
        .materials()
        .map(|material| Material::new(&material))
        .collect();
    let mut maps = BTreeMap::new();
    for (i, role) in ROLES.into_iter().enumerate() {
        for image in materials.iter().filter_map(|material| material.maps[i]) {
            if let Entry::Vacant(entry) = maps.entry(image) {
                let source = model.images().nth(image).expect("a valid index").source();
                let image_file = bytes(&model, source, path)?;
                let picture = image::load_from_memory(&image_file);
                let picture = picture.map_err(TradeoffError::file(path))?;
                entry.insert(Map::new(&picture, role, min_psnr_db)?);
            }
        }
    }
    let mut text = String::from(
        "| material | bpp | lit, dB | BC1, bpp | lit, dB | BC7, bpp | lit, dB |\n\
         | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for material in materials {
        let used = material.maps.into_iter().flatten();
        let used: BTreeMap<_, _> = used.map(|image| (image, &maps[&image])).collect();
        if !used.is_empty() {
            let _ = writeln!(text, "| {} | {} |", material.name, cells(&material, &used)?);
        }
    }
    Ok(text)
}

fn cells(material: &Material, maps: &BTreeMap<usize, &Map>) -> Result<String, TradeoffError> {
    let longest = |side: fn(&RgbImage) -> u32| {
        let sides = maps.values().map(|map| side(&map.original));
        sides.max().unwrap_or(1)
    };
    let size = [longest(RgbImage::width), longest(RgbImage::height)];
    let pixels = f64::from(size[0]) * f64::from(size[1]);
    let original = material.render(size, |image| &maps[&image].original);
    let cell = |bits: f64, lit: &RgbImage| {
        let psnr = psnr_db(mse(&original, lit)?);
        Ok::<_, TradeoffError>(format!("{:.2} | {psnr:.2}", bits / pixels))
    };
    let bits = maps.values().map(|map| map.bits).sum();
    let here = cell(bits, &material.render(size, |image| &maps[&image].decoded))?;
    let blocks = |color: BlockFormat| {
        let encoded = maps.iter().map(|(image, map)| (*image, map.through(color)));
        let encoded: BTreeMap<_, _> = encoded.collect();
        let bytes: usize = maps.values().map(|map| map.block_bytes(color)).sum();
        let lit = material.render(size, |image| &encoded[&image]);
        cell(8.0 * bytes as f64, &lit)
    };
    let (bc1, bc7) = (blocks(BlockFormat::Bc1)?, blocks(BlockFormat::Bc7)?);
    Ok([here, bc1, bc7].join(" | "))
}

impl Map {
    fn new(
        image: &DynamicImage,
        (content, color_space): (Content, ColorSpace),
        min_psnr_db: Option<f64>,
    ) -> Result<Self, TradeoffError> {
        let settings = EncodeSettings {
            rate: Rate::usual(content),
            min_psnr_db,
            color_space,
            mips: false,
            ..EncodeSettings::default()
        };
        let (texture, _) = encoded(image, &settings)?;
        let pixels = decode(&texture, 0).to_rgba8(content);
        let mut decoded = image.to_rgb8();
        for (pixel, [r, g, b, _]) in decoded.pixels_mut().zip(pixels) {
            *pixel = Rgb([r, g, b]);
        }
        let pixels = f64::from(image.width()) * f64::from(image.height());
        Ok(Self {
            content,
            original: image.to_rgb8(),
            decoded,
            bits: texture.bits_per_pixel() * pixels,
        })
    }

    fn format(&self, color: BlockFormat) -> BlockFormat {
        match self.content {
            Content::Gray => BlockFormat::Bc4,
            Content::Normal => BlockFormat::Bc5,
            Content::Color | Content::ColorAlpha => color,
        }
    }

    fn block_bytes(&self, color: BlockFormat) -> usize {
        self.format(color)
            .level_bytes(self.original.dimensions().into())
    }

    /// Encodes and decodes the original as BC blocks.
    fn through(&self, color: BlockFormat) -> RgbImage {
        let original: Rgb32FImage = self.original.convert();
        let through = |format, picture| -> RgbImage { through(format, picture).decoded.convert() };
        if self.content != Content::Normal {
            return through(self.format(color), &original);
        }
        let mut green = original.clone();
        for pixel in green.pixels_mut() {
            pixel.0 = [pixel.0[1]; 3];
        }
        let mut decoded = through(BlockFormat::Bc4, &original);
        let green = through(BlockFormat::Bc4, &green);
        for (pixel, green) in decoded.pixels_mut().zip(green.pixels()) {
            let [r, g] = [pixel.0[0], green.0[1]];
            *pixel = Rgb([r, g, normal_blue([r, g])]);
        }
        decoded
    }
}

/// The bytes of an image file: in a file of its own, in the model or in a file of buffers.
fn bytes(model: &Gltf, source: Source, path: &Path) -> Result<Vec<u8>, TradeoffError> {
    let file = |uri: &str| {
        let file = path.with_file_name(uri);
        fs::read(&file).map_err(TradeoffError::file(&file))
    };
    let view = match source {
        Source::Uri { uri, .. } => return file(uri),
        Source::View { view, .. } => view,
    };
    let buffer = match view.buffer().source() {
        buffer::Source::Uri(uri) => file(uri)?,
        buffer::Source::Bin => model.blob.clone().unwrap_or_default(),
    };
    let bytes = buffer.get(view.offset()..view.offset() + view.length());
    let bytes = bytes
        .ok_or("a buffer is cut short")
        .map_err(TradeoffError::file(path))?;
    Ok(bytes.into())
}
