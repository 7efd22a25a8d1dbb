//! Whether the pipelines in the phases of a view with another format write that format.
//!
//! The pipelines of materials do since they were specialized. Others, of gizmos and of other plugins, get a variant
//! with the format, and with the shader def if their shader packs. The variant replaces the original in the phases
//! that are sorted. What cannot be drawn is left out of this frame and refused: from the next frame on its camera has
//! another format.

use bevy::{
    core_pipeline::{
        core_3d::{AlphaMask3d, Opaque3d, Transparent3d},
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
            BinnedPhaseItem, BinnedRenderPhase, CachedRenderPipelinePhaseItem, NonMeshEntities,
            SortedPhaseItem, SortedRenderPhase, UnbatchableBinnedEntities, ViewBinnedRenderPhases,
            ViewSortedRenderPhases,
        },
        render_resource::{CachedRenderPipelineId, PipelineCache},
        renderer::RenderAdapterInfo,
        settings::Backends,
        sync_world::MainEntity,
        view::{ExtractedView, RetainedViewEntity},
    },
};

use super::classify::{Classifier, Pipeline};
use crate::{
    material::detect::PackingShaders,
    settings::FrameBufferFormat,
    view::{
        formatted::{Formatted, PackedView},
        refusals::Refusals,
    },
};

/// The pipelines classified so far, and what this frame does not draw.
#[derive(Resource, Default)]
pub(crate) struct PhasePipelines {
    known: HashMap<(CachedRenderPipelineId, FrameBufferFormat), Pipeline>,
    /// Generation of the shaders for which `known` is valid.
    generation: u64,
    /// The packed views whose phases have meshes with a target of another format.
    pub undrawable: EntityHashSet,
    /// The pipelines of the sky of packed views, where they pack.
    pub skyboxes: EntityHashMap<CachedRenderPipelineId>,
}

/// What is put back after the frame, because phases may outlive it.
#[derive(Resource)]
pub(crate) struct ReplacedItems<I> {
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
pub(crate) struct HiddenBins<I: BinnedPhaseItem> {
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

/// Bevy's phases of the main pass, and what is replaced in them.
#[derive(SystemParam)]
pub(super) struct Phases<'w> {
    opaque: ResMut<'w, ViewBinnedRenderPhases<Opaque3d>>,
    alpha_mask: ResMut<'w, ViewBinnedRenderPhases<AlphaMask3d>>,
    transmissive: ResMut<'w, ViewSortedRenderPhases<Transmissive3d>>,
    transparent: ResMut<'w, ViewSortedRenderPhases<Transparent3d>>,
    hidden_opaque: ResMut<'w, HiddenBins<Opaque3d>>,
    hidden_alpha_mask: ResMut<'w, HiddenBins<AlphaMask3d>>,
    replaced_transmissive: ResMut<'w, ReplacedItems<Transmissive3d>>,
    replaced_transparent: ResMut<'w, ReplacedItems<Transparent3d>>,
}

/// Classifies pipelines, and refuses the format of a view for those that cannot write it.
struct Inspector<'a> {
    pipelines: &'a mut PhasePipelines,
    refusals: &'a mut Refusals,
    classifier: Classifier<'a>,
    camera: Entity,
    format: FrameBufferFormat,
}

/// What is drawn of an item.
enum Drawn {
    /// The item with this pipeline.
    With(CachedRenderPipelineId),
    /// Nothing in this frame. The flag is whether drawing it would be no error, as where its target has the format.
    Not { has_format: bool },
}

impl Inspector<'_> {
    fn inspect(&mut self, id: CachedRenderPipelineId, replaceable: bool) -> Drawn {
        let key = (id, self.format);
        if !self.pipelines.known.contains_key(&key) {
            let cache = &mut *self.classifier.cache;
            if cache.pipelines().nth(id.id()).is_none() {
                // It was queued in this frame.
                cache.process_queue();
            }
            if self.classifier.is_loading(id) {
                return Drawn::Not { has_format: true };
            }
            let pipeline = self.classifier.classify(id, self.format, replaceable);
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
                    .add(self.camera, self.format, reason.clone(), *shader);
                Drawn::Not {
                    has_format: *has_format,
                }
            }
        }
    }
}

/// Inspects the phases of all views with another format, before they are batched.
pub(super) fn inspect_phases(
    views: Query<(Entity, &ExtractedView, &MainEntity, Option<&PackedView>), Formatted>,
    mut phases: Phases,
    mut pipelines: ResMut<PhasePipelines>,
    mut refusals: ResMut<Refusals>,
    shaders: Res<PackingShaders>,
    mut cache: ResMut<PipelineCache>,
    adapter: Res<RenderAdapterInfo>,
) {
    pipelines.undrawable.clear();
    if views.is_empty() {
        return;
    }
    pipelines.remove_outdated(shaders.generation());
    for (entity, view, main_entity, packed) in &views {
        let id = view.retained_view_entity;
        let mut inspector = Inspector {
            pipelines: &mut pipelines,
            refusals: &mut refusals,
            classifier: Classifier {
                shaders: &shaders,
                cache: &mut cache,
                is_web: Backends::from(adapter.backend) == Backends::BROWSER_WEBGPU,
            },
            camera: main_entity.id(),
            format: packed.map_or(FrameBufferFormat::Rg11b10Ufloat, |packed| {
                packed.format.into()
            }),
        };
        let mut drawable = true;
        if let Some(phase) = phases.opaque.get_mut(&id) {
            let pipeline = |key: &<Opaque3d as BinnedPhaseItem>::BatchSetKey| key.pipeline;
            drawable &= inspect_bins(
                id,
                phase,
                pipeline,
                &mut phases.hidden_opaque,
                &mut inspector,
            );
        }
        if let Some(phase) = phases.alpha_mask.get_mut(&id) {
            let pipeline = |key: &<AlphaMask3d as BinnedPhaseItem>::BatchSetKey| key.pipeline;
            drawable &= inspect_bins(
                id,
                phase,
                pipeline,
                &mut phases.hidden_alpha_mask,
                &mut inspector,
            );
        }
        if let Some(phase) = phases.transmissive.get_mut(&id) {
            inspect_items(
                id,
                phase,
                |item| &mut item.pipeline,
                &mut phases.replaced_transmissive,
                &mut inspector,
            );
        }
        if let Some(phase) = phases.transparent.get_mut(&id) {
            inspect_items(
                id,
                phase,
                |item| &mut item.pipeline,
                &mut phases.replaced_transparent,
                &mut inspector,
            );
        }
        if !drawable {
            pipelines.undrawable.insert(entity);
        }
    }
}

/// Hides what cannot be drawn. Returns whether the meshes that are left have the format.
fn inspect_bins<I: BinnedPhaseItem>(
    view: RetainedViewEntity,
    phase: &mut BinnedRenderPhase<I>,
    pipeline: impl Fn(&I::BatchSetKey) -> CachedRenderPipelineId,
    hidden: &mut HiddenBins<I>,
    inspector: &mut Inspector,
) -> bool {
    let batches = phase.batchable_meshes.keys().map(|(key, _)| key);
    let drawable = phase
        .multidrawable_meshes
        .keys()
        .chain(batches)
        .map(|key| inspector.inspect(pipeline(key), false))
        .all(|drawn| !matches!(drawn, Drawn::Not { has_format: false }));
    let mut cannot_be_drawn = |keys: &BinKeys<I>| {
        matches!(
            inspector.inspect(pipeline(&keys.0), false),
            Drawn::Not { .. }
        )
    };
    let keys: Vec<_> = phase.unbatchable_meshes.keys().cloned().collect();
    for keys in keys.into_iter().filter(&mut cannot_be_drawn) {
        if let Some(entities) = phase.unbatchable_meshes.shift_remove(&keys) {
            hidden.unbatchable.push((view, keys, entities));
        }
    }
    let keys: Vec<_> = phase.non_mesh_items.keys().cloned().collect();
    for keys in keys.into_iter().filter(&mut cannot_be_drawn) {
        if let Some(entities) = phase.non_mesh_items.shift_remove(&keys) {
            hidden.others.push((view, keys, entities));
        }
    }
    drawable
}

fn inspect_items<I: SortedPhaseItem + CachedRenderPipelinePhaseItem>(
    view: RetainedViewEntity,
    phase: &mut SortedRenderPhase<I>,
    pipeline: impl Fn(&mut I) -> &mut CachedRenderPipelineId,
    replaced: &mut ReplacedItems<I>,
    inspector: &mut Inspector,
) {
    let mut removed = Vec::new();
    for (key, item) in &mut phase.items {
        let original = item.cached_pipeline();
        match inspector.inspect(original, true) {
            Drawn::With(id) if id == original => {}
            Drawn::With(id) => {
                replaced.pipelines.push((view, *key, original));
                *pipeline(item) = id;
            }
            Drawn::Not { .. } => removed.push(*key),
        }
    }
    for key in removed {
        if let Some(item) = phase.items.shift_remove(&key) {
            replaced.items.push((view, key, item));
        }
    }
}

/// Puts back what [`inspect_phases`] replaced.
pub(super) fn restore_phases(mut phases: Phases) {
    restore_bins(&mut phases.opaque, &mut phases.hidden_opaque);
    restore_bins(&mut phases.alpha_mask, &mut phases.hidden_alpha_mask);
    restore_items(
        &mut phases.transmissive,
        |item| &mut item.pipeline,
        &mut phases.replaced_transmissive,
    );
    restore_items(
        &mut phases.transparent,
        |item| &mut item.pipeline,
        &mut phases.replaced_transparent,
    );
}

fn restore_bins<I: BinnedPhaseItem>(
    phases: &mut ResMut<ViewBinnedRenderPhases<I>>,
    hidden: &mut HiddenBins<I>,
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

fn restore_items<I: SortedPhaseItem>(
    phases: &mut ResMut<ViewSortedRenderPhases<I>>,
    pipeline: impl Fn(&mut I) -> &mut CachedRenderPipelineId,
    replaced: &mut ReplacedItems<I>,
) {
    for (view, key, original) in replaced.pipelines.drain(..) {
        let phase = phases.get_mut(&view);
        if let Some(item) = phase.and_then(|phase| phase.items.get_mut(&key)) {
            *pipeline(item) = original;
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
    mut pipelines: ResMut<PhasePipelines>,
    mut refusals: ResMut<Refusals>,
    shaders: Res<PackingShaders>,
    mut cache: ResMut<PipelineCache>,
) {
    pipelines.skyboxes.clear();
    for (entity, main_entity, packed, sky) in &views {
        let mut inspector = Inspector {
            pipelines: &mut pipelines,
            refusals: &mut refusals,
            classifier: Classifier {
                shaders: &shaders,
                cache: &mut cache,
                is_web: false,
            },
            camera: main_entity.id(),
            format: packed.format.into(),
        };
        if let Drawn::With(id) = inspector.inspect(sky.0, true) {
            pipelines.skyboxes.insert(entity, id);
        }
    }
}

impl PhasePipelines {
    /// Removes the results of former shaders. Variants are kept: Bevy rebuilds their pipelines itself.
    fn remove_outdated(&mut self, generation: u64) {
        if self.generation != generation {
            self.generation = generation;
            self.known
                .retain(|_, pipeline| matches!(pipeline, Pipeline::Variant(_)));
        }
    }
}
