//! Which images get mip levels and why others do not, and the levels of a texture on the GPU, from its finest one.
//!
//! Each level is drawn from the means of the finer one, which are kept in floats until all levels are there, so that
//! rounding does not add up. The pipelines are created when the first texture needs them, and at once: a texture is
//! never seen without its levels.

use bevy::{
    prelude::*,
    render::{
        render_resource::{
            CommandEncoder, Extent3d, TextureDescriptor, TextureDimension, TextureFormat,
            TextureSampleType, TextureUsages, TextureView, WgpuFeatures,
        },
        renderer::{RenderAdapter, RenderDevice},
    },
};

use super::{
    chain::MipContent,
    coverage::{CoveragePipelines, MaskLevels},
    downsample::{Draw, DrawPipelines, Levels, draw_level, view},
};

/// Why a texture has no generated mip levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Reflect)]
#[reflect(Debug, PartialEq, Hash)]
#[non_exhaustive]
pub enum NoMips {
    /// The image is not loaded yet, or was removed.
    NotLoaded,
    /// The app excluded the image, or limited its levels to one.
    Excluded,
    /// The image has a single texel.
    OneTexel,
    /// The sampler chooses the nearest texel, as for pixel art. [`EwaImage::use_nearest`] changes this.
    ///
    /// [`EwaImage::use_nearest`]: crate::EwaImage::use_nearest
    NearestSampler,
    /// Cameras draw to the image or shaders write it, and the app did not ask for levels after each draw.
    /// [`EwaImage::after_draws`] does so.
    ///
    /// [`EwaImage::after_draws`]: crate::EwaImage::after_draws
    WrittenOnGpu,
    /// The image has one or three dimensions, or several samples a texel.
    Dimension,
    /// The device cannot draw to the format: compressed formats, signed normalized formats and RGB9E5, on some devices
    /// 16-bit normalized formats. Such images need levels of their own, which tools of these formats write.
    Format(#[reflect(ignore, default = "unknown_format")] TextureFormat),
    /// Nothing renders.
    NoRenderer,
}

fn unknown_format() -> TextureFormat {
    TextureFormat::Rgba8Unorm
}

/// The device that decides for which formats levels can be generated.
pub(crate) struct MipSupport<'a> {
    pub device: &'a RenderDevice,
    pub adapter: &'a RenderAdapter,
}

impl MipSupport<'_> {
    fn can_draw_to(&self, format: TextureFormat) -> bool {
        let features = self.device.features();
        let adapters_own = WgpuFeatures::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES;
        let format_features = if features.contains(adapters_own) {
            self.adapter.get_texture_format_features(format)
        } else {
            format.guaranteed_format_features(features)
        };
        let usages = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
        let is_float = matches!(
            format.sample_type(None, Some(features)),
            Some(TextureSampleType::Float { .. })
        );
        is_float && format_features.allowed_usages.contains(usages)
    }

    /// The number of levels that a texture without levels of its own could have.
    pub(crate) fn levels(&self, descriptor: &TextureDescriptor) -> Result<u32, NoMips> {
        if descriptor.dimension != TextureDimension::D2 || descriptor.sample_count != 1 {
            return Err(NoMips::Dimension);
        }
        if !self.can_draw_to(descriptor.format) {
            return Err(NoMips::Format(descriptor.format));
        }
        match descriptor.size.max_mips(descriptor.dimension) {
            1 => Err(NoMips::OneTexel),
            levels => Ok(levels),
        }
    }
}

/// Whether cameras draw to a texture, or shaders write it.
pub(crate) fn is_written_on_gpu(descriptor: &TextureDescriptor) -> bool {
    let written = TextureUsages::RENDER_ATTACHMENT | TextureUsages::STORAGE_BINDING;
    descriptor.usage.intersects(written)
}

/// The pipelines that generate mip levels, which are created when a texture needs them first.
#[derive(Resource, Default)]
pub(crate) struct MipGenerator {
    drawing: Option<DrawPipelines>,
    coverage: Option<CoveragePipelines>,
}

impl MipGenerator {
    /// Generates all levels of a texture but the finest one, from that.
    pub(crate) fn generate(
        &mut self,
        device: &RenderDevice,
        encoder: &mut CommandEncoder,
        levels: &Levels,
        content: MipContent,
    ) {
        // What 8 bits hold is exact in half floats to a quarter of a step, unless short normals are made longer.
        let channels = levels.format.components();
        let has_bytes = levels.format.block_copy_size(None) == Some(u32::from(channels));
        let mean = if has_bytes && content != MipContent::Normals {
            TextureFormat::Rgba16Float
        } else {
            TextureFormat::Rgba32Float
        };
        let draw = Draw::Downsample {
            to: levels.format,
            mean,
            content: match content {
                MipContent::Normals if channels > 2 => 1,
                MipContent::Values | MipContent::Normals => 0,
                MipContent::Transparent | MipContent::Mask { .. } => 2,
            },
        };
        let [width, height] = levels.size(1);
        let means = device.create_texture(&TextureDescriptor {
            label: Some("bevy_ewa_mips_means"),
            size: Extent3d {
                width,
                height,
                depth_or_array_layers: 1,
            },
            mip_level_count: levels.count - 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: mean,
            usage: TextureUsages::TEXTURE_BINDING | TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        let means: Vec<_> = (0..levels.count - 1)
            .map(|level| view(&means, None, level, 0))
            .collect();
        for layer in 0..levels.texture.depth_or_array_layers() {
            let finest = levels.view(0, layer);
            for level in 1..levels.count {
                let source = match level {
                    1 => &finest,
                    _ => &means[level as usize - 2],
                };
                let to = levels.view(level, layer);
                self.draw(
                    device,
                    encoder,
                    draw,
                    source,
                    &[&to, &means[level as usize - 1]],
                );
            }
            if let MipContent::Mask { cutoff } = content
                && channels == 4
            {
                let mask = MaskLevels {
                    levels,
                    layer,
                    cutoff,
                    finest: &finest,
                    means: &means,
                };
                self.keep_coverage(device, encoder, &mask);
            }
        }
    }

    /// Copies the finest level of a texture to another one of the same size.
    pub(crate) fn copy(
        &mut self,
        device: &RenderDevice,
        encoder: &mut CommandEncoder,
        from: &Levels,
        to: &Levels,
    ) {
        if from.texture.usage().contains(TextureUsages::COPY_SRC) {
            let (from, to) = (from.texture, to.texture);
            encoder.copy_texture_to_texture(from.as_image_copy(), to.as_image_copy(), from.size());
            return;
        }
        for layer in 0..from.texture.depth_or_array_layers() {
            let draw = Draw::Copy { to: to.format };
            let (from, to) = (from.view(0, layer), to.view(0, layer));
            self.draw(device, encoder, draw, &from, &[&to]);
        }
    }

    fn draw(
        &mut self,
        device: &RenderDevice,
        encoder: &mut CommandEncoder,
        draw: Draw,
        source: &TextureView,
        targets: &[&TextureView],
    ) {
        let drawing = self
            .drawing
            .get_or_insert_with(|| DrawPipelines::new(device));
        let bind_group = drawing.bind_group(device, source);
        let pipeline = drawing.pipeline(device, draw, None);
        draw_level(encoder, &pipeline, &bind_group, targets);
    }

    /// Scales the alpha of all levels of a mask but the finest one, where the device has compute shaders.
    fn keep_coverage(
        &mut self,
        device: &RenderDevice,
        encoder: &mut CommandEncoder,
        mask: &MaskLevels,
    ) {
        if self.coverage.is_none() {
            self.coverage = CoveragePipelines::new(device);
        }
        let (Some(drawing), Some(coverage)) = (&mut self.drawing, &self.coverage) else {
            return;
        };
        let to = mask.levels.format;
        let fragment = (&coverage.shader, &coverage.pipeline_layout);
        let pipeline = drawing.pipeline(device, Draw::ScaleAlpha { to }, Some(fragment));
        coverage.scale_alpha(device, encoder, mask, &pipeline);
    }
}
