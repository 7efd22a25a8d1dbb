//! Whether a pipeline writes a format.

use bevy::{
    prelude::*,
    render::render_resource::{
        BlendFactor, BlendOperation, CachedRenderPipelineId, ColorTargetState, ColorWrites,
        PipelineCache, RenderPipelineDescriptor,
    },
};

use crate::{
    material::{
        detect::PackingShaders,
        pipeline::{has_format, pack, packs},
    },
    report::FallbackReason,
    settings::{FrameBufferFormat, PackedFormat},
};

/// Bevy's shader def of `AlphaMode::Multiply`, under which shaders pack what can be multiplied.
const MULTIPLY: &str = "BLEND_MULTIPLY";
/// The same of those of `AlphaMode::Add` and `AlphaMode::Premultiplied`.
const PREMULTIPLY: &str = "PREMULTIPLY_ALPHA";

/// Whether and how a pipeline can draw in a format.
#[derive(Clone, Debug)]
pub(super) enum Pipeline {
    /// The pipeline writes the format.
    Fits,
    /// This variant of the pipeline writes the format.
    Variant(CachedRenderPipelineId),
    /// The pipeline cannot write the format.
    Refused {
        reason: FallbackReason,
        /// The shader, if it is the cause.
        shader: Option<AssetId<Shader>>,
        /// Whether its target has the format, in which it would draw wrong colours.
        has_format: bool,
    },
}

/// What decides whether a pipeline writes a format.
pub(super) struct Classifier<'a> {
    pub shaders: &'a PackingShaders,
    pub cache: &'a mut PipelineCache,
    /// Whether the backend is WebGPU in a browser.
    pub is_web: bool,
}

impl Classifier<'_> {
    /// Whether the shader of a pipeline is still loading, so that nobody knows whether it packs, and nothing is drawn by
    /// it.
    pub(super) fn is_loading(&self, id: CachedRenderPipelineId) -> bool {
        let fragment = &self.cache.get_render_pipeline_descriptor(id).fragment;
        let shader = fragment.as_ref().map(|fragment| fragment.shader.id());
        shader.is_some_and(|shader| !self.shaders.is_inspected(shader))
    }

    /// Classifies a pipeline; one that is `replaceable` may be drawn by a variant.
    pub(super) fn classify(
        &self,
        id: CachedRenderPipelineId,
        format: FrameBufferFormat,
        replaceable: bool,
    ) -> Pipeline {
        let cache = &*self.cache;
        let descriptor = cache.get_render_pipeline_descriptor(id);
        let shader = descriptor.fragment.as_ref().map(|f| &f.shader);
        let refused = |reason: fn(String) -> FallbackReason, by_shader: bool| Pipeline::Refused {
            reason: reason(name(descriptor)),
            shader: shader.map(Handle::id).filter(|_| by_shader),
            has_format: has_format(descriptor, format),
        };
        // Neither format has an alpha channel. WebGPU refuses such pipelines, other backends do not.
        let multisample = &descriptor.multisample;
        if self.is_web && multisample.alpha_to_coverage_enabled && multisample.count > 1 {
            return refused(FallbackReason::AlphaToCoverage, false);
        }
        let FrameBufferFormat::Packed(packed) = format else {
            return if has_format(descriptor, format) {
                Pipeline::Fits
            } else if replaceable {
                let mut variant = descriptor.clone();
                if let Some(target) = first_target(&mut variant) {
                    target.format = format.texture_format();
                }
                Pipeline::Variant(cache.queue_render_pipeline(variant))
            } else {
                refused(FallbackReason::FixedFormat, false)
            };
        };
        if shader.is_some_and(|shader| !self.shaders.contains(shader.id())) {
            return refused(FallbackReason::UnpackedPipeline, true);
        }
        if !can_blend(descriptor, packed) {
            return refused(FallbackReason::UnpackableBlending, false);
        }
        if packs(descriptor, packed) {
            Pipeline::Fits
        } else if replaceable {
            let mut variant = descriptor.clone();
            pack(&mut variant, packed);
            Pipeline::Variant(cache.queue_render_pipeline(variant))
        } else {
            refused(FallbackReason::UnpackedPipeline, true)
        }
    }
}

fn first_target(descriptor: &mut RenderPipelineDescriptor) -> Option<&mut ColorTargetState> {
    descriptor.fragment.as_mut()?.targets.first_mut()?.as_mut()
}

/// Whether the blending of a pipeline and its write mask do the same to luminance and chrominance as to colours.
fn can_blend(descriptor: &RenderPipelineDescriptor, format: PackedFormat) -> bool {
    let Some(fragment) = &descriptor.fragment else {
        return true;
    };
    let Some(Some(target)) = fragment.targets.first() else {
        return true;
    };
    let written = target.write_mask & ColorWrites::COLOR;
    if written.is_empty() {
        return true;
    }
    let Some(blend) = &target.blend else {
        return written == ColorWrites::COLOR;
    };
    let is_linear = |factor| {
        matches!(
            factor,
            BlendFactor::Zero
                | BlendFactor::One
                | BlendFactor::SrcAlpha
                | BlendFactor::OneMinusSrcAlpha
        )
    };
    let is_multiplied = fragment.shader_defs.contains(&MULTIPLY.into());
    // The codes of `Unorm8` are no sums: those of a faint light would be added as those of a bright one.
    let adds = fragment.shader_defs.contains(&PREMULTIPLY.into());
    if adds && format == PackedFormat::Unorm8 {
        return false;
    }
    let color = blend.color;
    let has_linear_factors = is_linear(color.src_factor) && is_linear(color.dst_factor);
    let is_sum = color.operation == BlendOperation::Add;
    let is_difference = matches!(
        color.operation,
        BlendOperation::Subtract | BlendOperation::ReverseSubtract
    );
    written == ColorWrites::COLOR
        && (has_linear_factors || is_multiplied)
        && (is_sum || (is_difference && format != PackedFormat::Unorm8))
}

/// Path of the shader and label of the pipeline.
fn name(descriptor: &RenderPipelineDescriptor) -> String {
    let label = descriptor.label.as_deref().unwrap_or("unnamed pipeline");
    let shader = descriptor.fragment.as_ref().map(|f| &f.shader);
    match shader.and_then(|shader| shader.path()) {
        Some(path) => format!("{path} ({label})"),
        None => label.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use bevy::render::render_resource::{BlendComponent, BlendState, FragmentState};

    use super::*;

    fn with_target(target: ColorTargetState, defs: &[&'static str]) -> RenderPipelineDescriptor {
        RenderPipelineDescriptor {
            fragment: Some(FragmentState {
                shader: Handle::default(),
                shader_defs: defs.iter().map(|&def| def.into()).collect(),
                targets: vec![Some(target)],
                ..default()
            }),
            ..default()
        }
    }

    fn blended(color: BlendComponent, defs: &[&'static str], format: PackedFormat) -> bool {
        let target = ColorTargetState {
            format: format.texture_format(),
            blend: Some(BlendState {
                color,
                alpha: BlendComponent::REPLACE,
            }),
            write_mask: ColorWrites::ALL,
        };
        can_blend(&with_target(target, defs), format)
    }

    #[test]
    fn blending_by_alpha_is_linear_and_by_color_is_not() {
        let multiply = BlendComponent {
            src_factor: BlendFactor::Dst,
            dst_factor: BlendFactor::OneMinusSrcAlpha,
            operation: BlendOperation::Add,
        };
        let largest = BlendComponent {
            src_factor: BlendFactor::One,
            dst_factor: BlendFactor::One,
            operation: BlendOperation::Max,
        };
        let subtract = BlendComponent {
            operation: BlendOperation::ReverseSubtract,
            ..largest
        };
        for format in PackedFormat::ALL {
            assert!(blended(BlendComponent::OVER, &[], format));
            assert!(blended(BlendState::ALPHA_BLENDING.color, &[], format));
            assert!(!blended(multiply, &[], format));
            assert!(blended(multiply, &[MULTIPLY], format));
            let over = BlendComponent::OVER;
            let adds = blended(over, &[PREMULTIPLY], format);
            assert_eq!(adds, format != PackedFormat::Unorm8);
            assert!(!blended(largest, &[], format));
            assert_eq!(
                blended(subtract, &[], format),
                format != PackedFormat::Unorm8
            );
        }
    }

    #[test]
    fn all_colors_are_written_or_none() {
        for (write_mask, expected) in [
            (ColorWrites::ALL, true),
            (ColorWrites::COLOR, true),
            (ColorWrites::ALPHA, true),
            (ColorWrites::empty(), true),
            (ColorWrites::RED, false),
            (ColorWrites::GREEN | ColorWrites::BLUE, false),
        ] {
            let target = ColorTargetState {
                format: PackedFormat::Float16.texture_format(),
                blend: None,
                write_mask,
            };
            let actual = can_blend(&with_target(target, &[]), PackedFormat::Float16);
            assert_eq!(actual, expected, "{write_mask:?}");
        }
    }
}
