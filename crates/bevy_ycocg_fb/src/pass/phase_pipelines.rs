//! Whether the pipelines in the phases of a packed view pack.
//!
//! The pipelines of materials pack since they were specialized. Others, of gizmos and of other plugins,
//! get a variant with the packed format and the shader def if their shader packs. The variant replaces the
//! original in the transparent phase. A pipeline that cannot pack is reported, and from the next frame on
//! its camera draws as Bevy does.

use bevy::{
    core_pipeline::{
        core_3d::{AlphaMask3d, Opaque3d, Transparent3d},
        skybox::SkyboxPipelineId,
    },
    pbr::Transmissive3d,
    platform::collections::HashMap,
    prelude::*,
    render::{
        render_phase::{
            BinnedPhaseItem, BinnedRenderPhase, ViewBinnedRenderPhases, ViewSortedRenderPhases,
        },
        render_resource::{CachedRenderPipelineId, PipelineCache},
        renderer::ViewQuery,
        sync_world::MainEntity,
        view::ExtractedView,
    },
};

use crate::{
    material::{
        detect::PackingShaders,
        pipeline::{has_packed_format, pack, packs},
    },
    settings::PackedFormat,
    view::packed::{PackedView, UnpackedPipelines},
};

/// Whether and how a pipeline can draw packed colours.
#[derive(Clone, Debug)]
enum Pipeline {
    /// The pipeline packs.
    Packs,
    /// The shader of the pipeline can pack; this variant of it does.
    Variant(CachedRenderPipelineId),
    /// The pipeline does not pack.
    Unpacked {
        /// Path of the shader and label of the pipeline.
        name: String,
        /// Whether its target has the packed format, in which it would draw wrong colours.
        has_packed_format: bool,
    },
}

/// The pipelines classified so far, and the results for the view that is being drawn.
#[derive(Resource, Default)]
pub(crate) struct PhasePipelines {
    known: HashMap<(CachedRenderPipelineId, PackedFormat), Pipeline>,
    /// Generation of the shaders for which `known` is valid.
    generation: u64,
    /// Whether all pipelines in the phases have the packed format as their target.
    pub all_have_packed_format: bool,
    /// The pipeline of the sky, if it packs.
    pub skybox: Option<CachedRenderPipelineId>,
    /// The pipelines that variants replaced. They are restored after the pass, because phases may outlive
    /// a frame.
    replaced: Vec<(ItemKey, CachedRenderPipelineId)>,
}

type ItemKey = (Entity, MainEntity);

pub(super) fn pack_phase_pipelines(
    view: ViewQuery<(
        &PackedView,
        &ExtractedView,
        &MainEntity,
        Option<&SkyboxPipelineId>,
    )>,
    opaque: Res<ViewBinnedRenderPhases<Opaque3d>>,
    alpha_mask: Res<ViewBinnedRenderPhases<AlphaMask3d>>,
    transmissive: Res<ViewSortedRenderPhases<Transmissive3d>>,
    mut transparent: ResMut<ViewSortedRenderPhases<Transparent3d>>,
    mut pipelines: ResMut<PhasePipelines>,
    mut unpacked: ResMut<UnpackedPipelines>,
    shaders: Res<PackingShaders>,
    cache: Res<PipelineCache>,
) {
    let (packed, extracted, main_entity, sky) = view.into_inner();
    let id = extracted.retained_view_entity;
    let format = packed.format;
    let pipelines = &mut *pipelines;
    pipelines.remove_outdated(shaders.generation());
    pipelines.all_have_packed_format = true;
    pipelines.skybox = None;

    let mut found_unpacked = None;
    let mut inspect = |pipeline, replaceable| {
        let found = pipelines
            .known
            .entry((pipeline, format))
            .or_insert_with(|| classify(pipeline, format, replaceable, &shaders, &cache));
        match found {
            Pipeline::Packs => Some(pipeline),
            Pipeline::Variant(variant) => Some(*variant),
            Pipeline::Unpacked {
                name,
                has_packed_format,
            } => {
                pipelines.all_have_packed_format &= *has_packed_format;
                found_unpacked.get_or_insert_with(|| name.clone());
                None
            }
        }
    };

    for key in opaque.get(&id).into_iter().flat_map(batch_set_keys) {
        inspect(key.pipeline, false);
    }
    for key in alpha_mask.get(&id).into_iter().flat_map(batch_set_keys) {
        inspect(key.pipeline, false);
    }
    for item in transmissive
        .get(&id)
        .into_iter()
        .flat_map(|p| p.items.values())
    {
        inspect(item.pipeline, false);
    }
    for (key, item) in transparent
        .get_mut(&id)
        .into_iter()
        .flat_map(|p| &mut p.items)
    {
        if let Some(pipeline) = inspect(item.pipeline, true)
            && pipeline != item.pipeline
        {
            pipelines.replaced.push((*key, item.pipeline));
            item.pipeline = pipeline;
        }
    }
    pipelines.skybox = sky.and_then(|sky| inspect(sky.0, true));

    if let Some(name) = found_unpacked {
        unpacked
            .by_camera
            .entry(main_entity.id())
            .or_insert((packed.settings, name));
    }
}

/// Restores the pipelines that variants replaced in the transparent phase.
pub(super) fn restore_phase_pipelines(
    view: ViewQuery<&ExtractedView, With<PackedView>>,
    mut transparent: ResMut<ViewSortedRenderPhases<Transparent3d>>,
    mut pipelines: ResMut<PhasePipelines>,
) {
    let phase = transparent.get_mut(&view.into_inner().retained_view_entity);
    let Some(phase) = phase else {
        return;
    };
    for (key, pipeline) in pipelines.replaced.drain(..) {
        if let Some(item) = phase.items.get_mut(&key) {
            item.pipeline = pipeline;
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

/// Returns the batch set keys of all items in a phase.
fn batch_set_keys<I: BinnedPhaseItem>(
    phase: &BinnedRenderPhase<I>,
) -> impl Iterator<Item = &I::BatchSetKey> {
    let batchable = phase.batchable_meshes.keys().map(|(key, _)| key);
    let unbatchable = phase.unbatchable_meshes.keys().map(|(key, _)| key);
    let others = phase.non_mesh_items.keys().map(|(key, _)| key);
    phase
        .multidrawable_meshes
        .keys()
        .chain(batchable)
        .chain(unbatchable)
        .chain(others)
}

fn classify(
    id: CachedRenderPipelineId,
    format: PackedFormat,
    replaceable: bool,
    shaders: &PackingShaders,
    cache: &PipelineCache,
) -> Pipeline {
    let descriptor = cache.get_render_pipeline_descriptor(id);
    let shader = descriptor.fragment.as_ref().map(|f| &f.shader);
    let shader_packs = shader.is_none_or(|shader| shaders.contains(shader.id()));
    if shader_packs && packs(descriptor, format) {
        return Pipeline::Packs;
    }
    if shader_packs && replaceable {
        let mut variant = descriptor.clone();
        pack(&mut variant, format);
        return Pipeline::Variant(cache.queue_render_pipeline(variant));
    }
    let label = descriptor.label.as_deref().unwrap_or("unnamed pipeline");
    let name = match shader.and_then(|shader| shader.path()) {
        Some(path) => format!("{path} ({label})"),
        None => label.to_owned(),
    };
    Pipeline::Unpacked {
        name,
        has_packed_format: has_packed_format(descriptor, format),
    }
}
