//! The mip levels of a texture on the GPU, from its finest level.
//!
//! Each level is drawn from the means of the finer one, which are kept in floats until all levels are there, so that
//! rounding does not add up. The pipelines are created when the first texture needs them, and at once: a texture is
//! never seen without its levels.

use bevy::{
    prelude::*,
    render::{
        render_resource::{
            CommandEncoder, Extent3d, TextureDescriptor, TextureDimension, TextureFormat,
            TextureUsages, TextureView,
        },
        renderer::RenderDevice,
    },
};

use super::{
    MipContent,
    drawing::{Draw, DrawPipelines, draw_level},
    levels::{Levels, view},
    masks::{CoveragePipelines, MaskLevels},
};

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
