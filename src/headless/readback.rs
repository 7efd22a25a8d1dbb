//! The picture, from the GPU to memory.

use std::sync::mpsc;

use bevy::{
    prelude::*,
    render::{
        RenderApp,
        render_asset::RenderAssets,
        renderer::{RenderDevice, RenderQueue},
        texture::GpuImage,
    },
};
use image::RgbImage;

use super::{HeadlessApp, HeadlessError, TargetFormat};

/// A picture of linear floats.
#[derive(Clone, Debug, PartialEq)]
pub struct Rgba32FImage {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Red, green, blue and alpha of the pixels, row after row from the top left.
    pub pixels: Vec<[f32; 4]>,
}

impl HeadlessApp {
    /// The last rendered frame as a display would show it, without alpha.
    pub fn capture_rgb8(&mut self) -> Result<RgbImage, HeadlessError> {
        let actual = self.settings.format;
        if actual != TargetFormat::Srgb8 {
            let wanted = TargetFormat::Srgb8;
            return Err(HeadlessError::Format { actual, wanted });
        }
        self.wait_for_pipelines();
        let bytes = self.read_target(4)?;
        let mut rgb = bytes.chunks_exact(4).flat_map(|texel| &texel[..3]);
        Ok(RgbImage::from_fn(
            self.settings.width,
            self.settings.height,
            |_, _| image::Rgb(std::array::from_fn(|_| *rgb.next().unwrap_or(&0))),
        ))
    }

    /// The last rendered frame as linear floats.
    pub fn capture_f32(&mut self) -> Result<Rgba32FImage, HeadlessError> {
        self.wait_for_pipelines();
        let actual = self.settings.format;
        let pixels = match actual {
            TargetFormat::Float32 => texels(&self.read_target(16)?, f32::from_le_bytes),
            TargetFormat::Float16 => texels(&self.read_target(8)?, |bytes| {
                half::f16::from_le_bytes(bytes).to_f32()
            }),
            TargetFormat::Srgb8 => {
                let wanted = TargetFormat::Float32;
                return Err(HeadlessError::Format { actual, wanted });
            }
        };
        Ok(Rgba32FImage {
            width: self.settings.width,
            height: self.settings.height,
            pixels,
        })
    }

    fn read_target(&self, texel_bytes: u32) -> Result<Vec<u8>, HeadlessError> {
        Ok(self.read_texture(&self.target, texel_bytes)?.1)
    }

    /// The size and the texels of an image on the GPU, slice by slice and row by row without padding. A
    /// texel has `texel_bytes` bytes.
    pub fn read_texture(
        &self,
        image: &Handle<Image>,
        texel_bytes: u32,
    ) -> Result<(wgpu::Extent3d, Vec<u8>), HeadlessError> {
        self.read_level(image, 0, texel_bytes)
    }

    /// The size and the texels of a mip level of an image, as of [`Self::read_texture`].
    pub fn read_level(
        &self,
        image: &Handle<Image>,
        level: u32,
        texel_bytes: u32,
    ) -> Result<(wgpu::Extent3d, Vec<u8>), HeadlessError> {
        let world = self.app.sub_app(RenderApp).world();
        let device = world.resource::<RenderDevice>().wgpu_device();
        let image = world
            .resource::<RenderAssets<GpuImage>>()
            .get(image)
            .ok_or(HeadlessError::NoTarget)?;

        let size = image.texture.size();
        let size = size.mip_level_size(level, image.texture.dimension());
        let row = size.width * texel_bytes;
        let padded_row = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let rows = u64::from(size.height) * u64::from(size.depth_or_array_layers);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("lab_readback_buffer"),
            size: u64::from(padded_row) * rows,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor {
            label: Some("lab_readback"),
        });
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo {
                mip_level: level,
                ..image.texture.as_image_copy()
            },
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(padded_row),
                    rows_per_image: Some(size.height),
                },
            },
            size,
        );
        world.resource::<RenderQueue>().submit([encoder.finish()]);

        let (sender, receiver) = mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver is gone only when the wait has failed already.
            let _ = sender.send(result);
        });
        self.wait_for_gpu()?;
        match receiver.recv_timeout(self.settings.gpu_timeout) {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(self.readback_error(error)),
            Err(error) => return Err(self.readback_error(error)),
        }
        let mapped = buffer.slice(..).get_mapped_range();
        let mapped = mapped.map_err(|error| self.readback_error(error))?;
        let rows = mapped.chunks_exact(padded_row as usize);
        let texels = rows.flat_map(|padded| &padded[..row as usize]).copied();
        Ok((size, texels.collect()))
    }
}

/// Texels of four channels of `N` little-endian bytes.
fn texels<const N: usize>(bytes: &[u8], decode: impl Fn([u8; N]) -> f32) -> Vec<[f32; 4]> {
    bytes
        .chunks_exact(4 * N)
        .map(|texel| {
            std::array::from_fn(|channel| {
                decode(std::array::from_fn(|byte| texel[channel * N + byte]))
            })
        })
        .collect()
}
