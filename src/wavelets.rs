//! Pictures as wavelet textures, and these in a world.

use bevy::prelude::*;
use bevy_wavelet_tex::{
    WaveletStorage, WaveletTexture,
    codec::{
        encoder::{EncodeError, encode_rgb8},
        image::{ColorSpace, WaveletImage},
        rate::Rate,
        settings::{EncodeSettings, Formats},
    },
};
use image::{ImageBuffer, Pixel};

/// Settings that encode by a wavelet, even where a plain texture has less error.
pub fn wavelets(rate: Rate, color_space: ColorSpace) -> EncodeSettings {
    EncodeSettings {
        rate,
        color_space,
        formats: Formats::Wavelet,
        ..EncodeSettings::default()
    }
}

/// Encodes the colours of a picture.
pub fn encoded<P: Pixel<Subpixel = u8>>(
    picture: &ImageBuffer<P, Vec<u8>>,
    settings: &EncodeSettings,
) -> Result<WaveletImage, EncodeError> {
    let pixels: Vec<[u8; 3]> = picture.pixels().map(|pixel| pixel.to_rgb().0).collect();
    encode_rgb8(&pixels, picture.dimensions().into(), settings)
}

/// Adds a texture to a world.
pub fn add_texture(
    world: &mut World,
    image: &WaveletImage,
    storage: WaveletStorage,
) -> Handle<WaveletTexture> {
    world.resource_scope(|world, mut textures: Mut<Assets<WaveletTexture>>| {
        let mut images = world.resource_mut::<Assets<Image>>();
        WaveletTexture::add(image, storage, &mut textures, &mut images)
    })
}
