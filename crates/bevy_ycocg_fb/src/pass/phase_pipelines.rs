//! Whether the pipelines in the phases of a view with another format write that format.
//!
//! The pipelines of materials do since they were specialized. Others, of gizmos and of other plugins, get a variant
//! with the format, and with the shader def if their shader packs. The variant replaces the original in the phases
//! that are sorted. What cannot be drawn is left out of this frame and refused: from the next frame on its camera has
//! another format.

use bevy::{
    core_pipeline::{
        core_3d::{Opaque3dBatchSetKey, Transparent3d},
        prepass::OpaqueNoLightmap3dBatchSetKey,
        skybox::SkyboxPipelineId,
    },
    ecs::{
        entity::{EntityHashMap, EntityHashSet},
        system::SystemParam,
    },
    pbr::Transmissive3d,
    platform::collections::HashMap,
    prelude::*,
    render::{
        render_phase::{
            BinnedPhaseItem, NonMeshEntities, SortedPhaseItem, UnbatchableBinnedEntities,
            ViewBinnedRenderPhases, ViewSortedRenderPhases,
        },
        render_resource::{
            BlendFactor, BlendOperation, CachedRenderPipelineId, ColorWrites, PipelineCache,
            RenderPipelineDescriptor,
        },
        renderer::RenderAdapterInfo,
        settings::Backends,
        sync_world::MainEntity,
        view::{ExtractedView, RetainedViewEntity},
    },
};

use crate::{
    material::{detect::PackingShaders, has_format, pack, packs},
    report::FallbackReason,
    settings::{FrameBufferFormat, PackedFormat},
    view::{
        conditions::Refusals,
        formatted::{Formatted, PackedView},
    },
};

/// Bevy's shader def of `AlphaMode::Multiply`, under which shaders pack what can be multiplied.
const MULTIPLY: &str = "BLEND_MULTIPLY";
/// The same of those of `AlphaMode::Add` and `AlphaMode::Premultiplied`.
const PREMULTIPLY: &str = "PREMULTIPLY_ALPHA";

/// The pipelines classified so far, and what this frame does not draw.
#[derive(Resource, Default)]
pub(super) struct PhasePipelines {
    known: HashMap<(CachedRenderPipelineId, FrameBufferFormat), Pipeline>,
    /// Generation of the shaders for which `known` is valid.
    generation: u64,
    /// The packed views whose phases have meshes with a target of another format.
    pub undrawable: EntityHashSet,
    /// The pipelines of the sky of packed views, where they pack.
    pub skyboxes: EntityHashMap<CachedRenderPipelineId>,
}

/// Whether and how a pipeline can draw in a format.
#[derive(Clone, Debug)]
enum Pipeline {
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

/// What is drawn of an item.
enum Drawn {
    /// The item with this pipeline.
    With(CachedRenderPipelineId),
    /// Nothing in this frame. The flag is whether drawing it would be no error, as where its target has the format.
    Not { has_format: bool },
}

/// What decides whether pipelines write a format, and what was found of them.
#[derive(SystemParam)]
pub(super) struct Inspector<'w> {
    pipelines: ResMut<'w, PhasePipelines>,
    refusals: ResMut<'w, Refusals>,
    shaders: Res<'w, PackingShaders>,
    cache: ResMut<'w, PipelineCache>,
    adapter: Res<'w, RenderAdapterInfo>,
}

impl Inspector<'_> {
    /// Classifies a pipeline, and refuses the format of a camera for one that cannot write it. One that is `replaceable`
    /// may be drawn by a variant.
    fn inspect(
        &mut self,
        camera: &MainEntity,
        packed: Option<&PackedView>,
        id: CachedRenderPipelineId,
        replaceable: bool,
    ) -> Drawn {
        let format = packed.map_or(FrameBufferFormat::Rg11b10Ufloat, |packed| {
            packed.format.into()
        });
        let key = (id, format);
        if !self.pipelines.known.contains_key(&key) {
            if self.cache.pipelines().nth(id.id()).is_none() {
                // It was queued in this frame.
                self.cache.process_queue();
            }
            let fragment = &self.cache.get_render_pipeline_descriptor(id).fragment;
            let shader = fragment.as_ref().map(|fragment| fragment.shader.id());
            // While it is loading, nobody knows whether it packs, and nothing is drawn by it.
            if shader.is_some_and(|shader| !self.shaders.is_inspected(shader)) {
                return Drawn::Not { has_format: true };
            }
            let pipeline = self.classify(id, format, replaceable);
            self.pipelines.known.insert(key, pipeline);
        }
        match &self.pipelines.known[&key] {
            Pipeline::Fits => Drawn::With(id),
            Pipeline::Variant(variant) => Drawn::With(*variant),
            Pipeline::Refused {
                reason,
                shader,
                has_format,
            } => {
                self.refusals
                    .add(camera.id(), format, reason.clone(), *shader);
                Drawn::Not {
                    has_format: *has_format,
                }
            }
        }
    }

    fn classify(
        &self,
        id: CachedRenderPipelineId,
        format: FrameBufferFormat,
        replaceable: bool,
    ) -> Pipeline {
        let descriptor = self.cache.get_render_pipeline_descriptor(id);
        let shader = descriptor.fragment.as_ref().map(|f| &f.shader);
        let refused = |reason: fn(String) -> FallbackReason, by_shader: bool| Pipeline::Refused {
            reason: reason(name(descriptor)),
            shader: shader.map(Handle::id).filter(|_| by_shader),
            has_format: has_format(descriptor, format),
        };
        let variant = |change: &dyn Fn(&mut RenderPipelineDescriptor)| {
            let mut variant = descriptor.clone();
            change(&mut variant);
            Pipeline::Variant(self.cache.queue_render_pipeline(variant))
        };
        // Neither format has an alpha channel. WebGPU refuses such pipelines, other backends do not.
        let is_web = Backends::from(self.adapter.backend) == Backends::BROWSER_WEBGPU;
        let multisample = &descriptor.multisample;
        if is_web && multisample.alpha_to_coverage_enabled && multisample.count > 1 {
            return refused(FallbackReason::AlphaToCoverage, false);
        }
        let FrameBufferFormat::Packed(packed) = format else {
            return if has_format(descriptor, format) {
                Pipeline::Fits
            } else if replaceable {
                variant(&|variant| {
                    let fragment = variant.fragment.as_mut();
                    let target = fragment.and_then(|fragment| fragment.targets.first_mut());
                    if let Some(Some(target)) = target {
                        target.format = format.texture_format();
                    }
                })
            } else {
                refused(FallbackReason::FixedFormat, false)
            };
        };
        if shader.is_some_and(|shader| !self.shaders.contains(shader.id())) {
            refused(FallbackReason::UnpackedPipeline, true)
        } else if !can_blend(descriptor, packed) {
            refused(FallbackReason::UnpackableBlending, false)
        } else if packs(descriptor, packed) {
            Pipeline::Fits
        } else if replaceable {
            variant(&|variant| pack(variant, packed))
        } else {
            refused(FallbackReason::UnpackedPipeline, true)
        }
    }
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

/// The keys of batches, and the items of phases that are sorted.
pub(super) trait HasPipeline {
    fn pipeline(&self) -> CachedRenderPipelineId;
    fn set_pipeline(&mut self, pipeline: CachedRenderPipelineId);
}

macro_rules! has_pipeline {
    ($($name:ty),*) => {
        $(impl HasPipeline for $name {
            fn pipeline(&self) -> CachedRenderPipelineId {
                self.pipeline
            }

            fn set_pipeline(&mut self, pipeline: CachedRenderPipelineId) {
                self.pipeline = pipeline;
            }
        })*
    };
}

has_pipeline!(
    Opaque3dBatchSetKey,
    OpaqueNoLightmap3dBatchSetKey,
    Transmissive3d,
    Transparent3d
);

/// What is put back after the frame, because phases may outlive it.
#[derive(Resource)]
pub(super) struct ReplacedItems<I> {
    items: Vec<(RetainedViewEntity, (Entity, MainEntity), I)>,
    pipelines: Vec<(
        RetainedViewEntity,
        (Entity, MainEntity),
        CachedRenderPipelineId,
    )>,
}

impl<I> Default for ReplacedItems<I> {
    fn default() -> Self {
        Self {
            items: Vec::new(),
            pipelines: Vec::new(),
        }
    }
}

/// The bins that are put back after the frame.
#[derive(Resource)]
pub(super) struct HiddenBins<I: BinnedPhaseItem> {
    unbatchable: Vec<(RetainedViewEntity, BinKeys<I>, UnbatchableBinnedEntities)>,
    others: Vec<(RetainedViewEntity, BinKeys<I>, NonMeshEntities)>,
}

type BinKeys<I> = (
    <I as BinnedPhaseItem>::BatchSetKey,
    <I as BinnedPhaseItem>::BinKey,
);

impl<I: BinnedPhaseItem> Default for HiddenBins<I> {
    fn default() -> Self {
        Self {
            unbatchable: Vec::new(),
            others: Vec::new(),
        }
    }
}

/// Forgets the last frame, and the results of former shaders. Variants are kept: Bevy rebuilds their pipelines itself.
pub(super) fn begin_inspection(
    shaders: Res<PackingShaders>,
    mut pipelines: ResMut<PhasePipelines>,
) {
    pipelines.undrawable.clear();
    if pipelines.generation != shaders.generation() {
        pipelines.generation = shaders.generation();
        let known = &mut pipelines.known;
        known.retain(|_, pipeline| matches!(pipeline, Pipeline::Variant(_)));
    }
}

/// The views whose phases are inspected, before they are batched.
type FormattedViews<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        &'static ExtractedView,
        &'static MainEntity,
        Option<&'static PackedView>,
    ),
    Formatted,
>;

/// Hides what cannot be drawn, and finds the views in which meshes are left that have not the format.
pub(super) fn inspect_bins<I: BinnedPhaseItem<BatchSetKey: HasPipeline>>(
    views: FormattedViews,
    mut phases: ResMut<ViewBinnedRenderPhases<I>>,
    mut hidden: ResMut<HiddenBins<I>>,
    mut inspector: Inspector,
) {
    for (entity, view, camera, packed) in &views {
        let id = view.retained_view_entity;
        let Some(phase) = phases.get_mut(&id) else {
            continue;
        };
        let mut inspect =
            |key: &I::BatchSetKey| inspector.inspect(camera, packed, key.pipeline(), false);
        let batches = phase.batchable_meshes.keys().map(|(key, _)| key);
        let drawable = phase
            .multidrawable_meshes
            .keys()
            .chain(batches)
            .map(&mut inspect)
            .all(|drawn| !matches!(drawn, Drawn::Not { has_format: false }));
        let mut cannot_be_drawn = |keys: &BinKeys<I>| matches!(inspect(&keys.0), Drawn::Not { .. });
        let bins = &mut phase.unbatchable_meshes;
        let bins = bins.extract_if(.., |keys, _| cannot_be_drawn(keys));
        let bins = bins.map(|(keys, entities)| (id, keys, entities));
        hidden.unbatchable.extend(bins);
        let bins = &mut phase.non_mesh_items;
        let bins = bins.extract_if(.., |keys, _| cannot_be_drawn(keys));
        let bins = bins.map(|(keys, entities)| (id, keys, entities));
        hidden.others.extend(bins);
        if !drawable {
            inspector.pipelines.undrawable.insert(entity);
        }
    }
}

/// Replaces what variants draw, and takes out what cannot be drawn.
pub(super) fn inspect_items<I: SortedPhaseItem + HasPipeline>(
    views: FormattedViews,
    mut phases: ResMut<ViewSortedRenderPhases<I>>,
    mut replaced: ResMut<ReplacedItems<I>>,
    mut inspector: Inspector,
) {
    let ReplacedItems { items, pipelines } = &mut *replaced;
    for (_, view, camera, packed) in &views {
        let id = view.retained_view_entity;
        let Some(phase) = phases.get_mut(&id) else {
            continue;
        };
        let removed = phase.items.extract_if(.., |key, item| {
            let original = item.pipeline();
            match inspector.inspect(camera, packed, original, true) {
                Drawn::With(pipeline) => {
                    if pipeline != original {
                        pipelines.push((id, *key, original));
                        item.set_pipeline(pipeline);
                    }
                    false
                }
                Drawn::Not { .. } => true,
            }
        });
        items.extend(removed.map(|(key, item)| (id, key, item)));
    }
}

/// Puts back what [`inspect_bins`] hid.
pub(super) fn restore_bins<I: BinnedPhaseItem>(
    mut phases: ResMut<ViewBinnedRenderPhases<I>>,
    mut hidden: ResMut<HiddenBins<I>>,
) {
    for (view, keys, entities) in hidden.unbatchable.drain(..) {
        if let Some(phase) = phases.get_mut(&view) {
            phase.unbatchable_meshes.insert(keys, entities);
        }
    }
    for (view, keys, entities) in hidden.others.drain(..) {
        if let Some(phase) = phases.get_mut(&view) {
            phase.non_mesh_items.insert(keys, entities);
        }
    }
}

/// Puts back what [`inspect_items`] replaced.
pub(super) fn restore_items<I: SortedPhaseItem + HasPipeline>(
    mut phases: ResMut<ViewSortedRenderPhases<I>>,
    mut replaced: ResMut<ReplacedItems<I>>,
) {
    for (view, key, original) in replaced.pipelines.drain(..) {
        let phase = phases.get_mut(&view);
        if let Some(item) = phase.and_then(|phase| phase.items.get_mut(&key)) {
            item.set_pipeline(original);
        }
    }
    for (view, key, item) in replaced.items.drain(..) {
        if let Some(phase) = phases.get_mut(&view) {
            phase.items.insert(key, item);
        }
    }
}

/// Finds the pipelines of the sky of packed views, which Bevy chooses after the phases.
pub(super) fn inspect_skyboxes(
    views: Query<(Entity, &MainEntity, &PackedView, &SkyboxPipelineId)>,
    mut inspector: Inspector,
) {
    inspector.pipelines.skyboxes.clear();
    for (entity, camera, packed, sky) in &views {
        if let Drawn::With(id) = inspector.inspect(camera, Some(packed), sky.0, true) {
            inspector.pipelines.skyboxes.insert(entity, id);
        }
    }
}

#[cfg(test)]
mod tests {
    use bevy::render::render_resource::{
        BlendComponent, BlendState, ColorTargetState, FragmentState,
    };

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
        let over = BlendComponent::OVER;
        // With the floats, and with the codes of `Unorm8`.
        for (color, defs, expected) in [
            (over, vec![], [true, true]),
            (BlendState::ALPHA_BLENDING.color, vec![], [true, true]),
            (multiply, vec![], [false, false]),
            (multiply, vec![MULTIPLY], [true, true]),
            (over, vec![PREMULTIPLY], [true, false]),
            (largest, vec![], [false, false]),
            (subtract, vec![], [true, false]),
        ] {
            for format in PackedFormat::ALL {
                let target = ColorTargetState {
                    blend: Some(BlendState {
                        color,
                        alpha: BlendComponent::REPLACE,
                    }),
                    ..format.texture_format().into()
                };
                let actual = can_blend(&with_target(target, &defs), format);
                let expected = expected[usize::from(format == PackedFormat::Unorm8)];
                assert_eq!(actual, expected, "{color:?} {defs:?} {format:?}");
            }
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
                write_mask,
                ..PackedFormat::Float16.texture_format().into()
            };
            let actual = can_blend(&with_target(target, &[]), PackedFormat::Float16);
            assert_eq!(actual, expected, "{write_mask:?}");
        }
    }
}
