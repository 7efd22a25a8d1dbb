//! The main pass of a packed camera. It draws the phases of Bevy's main passes, in their order, into the
//! packed texture, which it clears first, and then resolves that into the view's main texture.
//!
//! A pass of Bevy is a system that queries the components of the current view and is skipped where there are none.
//! So the current view is a placeholder from the end of the packed main pass to the end of Bevy's main passes.

use std::ops::Range;

use bevy::{
    asset::load_embedded_asset,
    camera::ClearColorConfig,
    core_pipeline::{
        FullscreenShader,
        core_3d::{AlphaMask3d, CORE_3D_DEPTH_FORMAT, Opaque3d, Transparent3d},
        skybox::SkyboxBindGroup,
    },
    ecs::{entity::EntityHashMap, query::QueryData},
    pbr::{ScreenSpaceTransmission, Transmissive3d, ViewTransmissionTexture},
    prelude::*,
    render::{
        camera::ExtractedCamera,
        diagnostic::RecordDiagnostics,
        render_phase::{
            DrawError, TrackedRenderPass, ViewBinnedRenderPhases, ViewSortedRenderPhases,
        },
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries,
            CachedPipelineState, CachedRenderPipelineId, CompareFunction, DepthStencilState,
            FragmentState, LoadOp, MultisampleState, Operations, PipelineCache, PipelineDescriptor,
            RenderPassColorAttachment, RenderPassDescriptor, RenderPipelineDescriptor,
            ShaderStages, SpecializedRenderPipeline, SpecializedRenderPipelines, StoreOp,
            UniformBuffer, binding_types::uniform_buffer,
        },
        renderer::{CurrentView, RenderContext, RenderDevice, RenderQueue, ViewQuery},
        sync_world::MainEntity,
        view::{ExtractedView, ViewDepthStencilTexture, ViewTarget, ViewUniformOffset},
    },
};

use super::{
    draw_fullscreen,
    phase_pipelines::PhasePipelines,
    resolve::{PackedResolve, ResolveBindGroup},
};
use crate::{
    settings::PackedFormat,
    view::{
        eligibility::SwitchedViews,
        formatted::{PackedTextures, PackedView},
    },
};

#[derive(Resource)]
pub(crate) struct ClearPipeline {
    layout: BindGroupLayoutDescriptor,
    fullscreen: FullscreenShader,
    shader: Handle<Shader>,
}

pub(super) fn init_clear_pipeline(
    mut commands: Commands,
    fullscreen: Res<FullscreenShader>,
    asset_server: Res<AssetServer>,
) {
    commands.insert_resource(ClearPipeline {
        layout: BindGroupLayoutDescriptor::new(
            "packed_ycocg_clear",
            &BindGroupLayoutEntries::single(ShaderStages::FRAGMENT, uniform_buffer::<Vec4>(false)),
        ),
        fullscreen: fullscreen.clone(),
        shader: load_embedded_asset!(asset_server.as_ref(), "clear.wesl"),
    });
}

impl SpecializedRenderPipeline for ClearPipeline {
    /// Format and number of samples per pixel.
    type Key = (PackedFormat, u32);

    fn specialize(&self, (format, samples): Self::Key) -> RenderPipelineDescriptor {
        RenderPipelineDescriptor {
            label: Some("packed_ycocg_clear".into()),
            layout: vec![self.layout.clone()],
            vertex: self.fullscreen.to_vertex_state(),
            // It is drawn in the pass of the scene and must not write its depth.
            depth_stencil: Some(DepthStencilState {
                format: CORE_3D_DEPTH_FORMAT,
                depth_write_enabled: Some(false),
                depth_compare: Some(CompareFunction::Always),
                stencil: default(),
                bias: default(),
            }),
            multisample: MultisampleState {
                count: samples,
                ..default()
            },
            fragment: Some(FragmentState {
                shader: self.shader.clone(),
                shader_defs: format.shader_defs(),
                entry_point: Some("clear".into()),
                targets: vec![Some(format.texture_format().into())],
                ..default()
            }),
            ..default()
        }
    }
}

/// Uniform buffers of the clear colours by camera, which are kept from frame to frame.
#[derive(Resource, Default)]
pub(crate) struct ClearUniforms(EntityHashMap<(LinearRgba, UniformBuffer<Vec4>)>);

/// The operation that clears a view. A gray one is set by the load operation; any other one has a chrominance that
/// depends on the pixel, so a full-screen triangle draws it.
#[derive(Component)]
pub(crate) enum PackedClear {
    /// The load operation clears to this luminance, with a chrominance of 0.
    Gray(f32),
    /// A full-screen triangle clears to a colour.
    Colored {
        pipeline: CachedRenderPipelineId,
        bind_group: BindGroup,
    },
}

pub(super) fn prepare_clear(
    mut commands: Commands,
    views: Query<(Entity, &MainEntity, &PackedView, &ExtractedCamera)>,
    global: Res<ClearColor>,
    mut uniforms: ResMut<ClearUniforms>,
    pipeline: Res<ClearPipeline>,
    mut pipelines: ResMut<SpecializedRenderPipelines<ClearPipeline>>,
    cache: Res<PipelineCache>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
) {
    let uniforms = &mut uniforms.0;
    uniforms.retain(|&camera, _| views.iter().any(|(_, main, ..)| main.id() == camera));
    for (entity, main_entity, packed, camera) in &views {
        let color = match camera.clear_color {
            ClearColorConfig::Custom(color) => color,
            ClearColorConfig::Default | ClearColorConfig::None => global.0,
        }
        .to_linear();
        let format = packed.format;
        // `Unorm8` has a bias, so a chrominance of 0 is not stored as 0.
        if color.red == color.green && color.green == color.blue && format != PackedFormat::Unorm8 {
            let luminance = color.green.clamp(0.0, 65504.0);
            commands.entity(entity).insert(PackedClear::Gray(luminance));
            continue;
        }
        let (previous_color, buffer) = uniforms
            .entry(main_entity.id())
            .or_insert_with(|| (LinearRgba::NONE, UniformBuffer::from(Vec4::ZERO)));
        if *previous_color != color {
            *previous_color = color;
            buffer.set(color.to_vec4());
            buffer.write_buffer(&device, &queue);
        }
        let Some(binding) = buffer.binding() else {
            continue;
        };
        let bind_group = device.create_bind_group(
            "packed_ycocg_clear",
            &cache.get_bind_group_layout(&pipeline.layout),
            &BindGroupEntries::single(binding),
        );
        let pipeline = pipelines.specialize(&cache, &pipeline, (format, packed.samples));
        commands.entity(entity).insert(PackedClear::Colored {
            pipeline,
            bind_group,
        });
    }
}

/// The components of the view that the pass uses.
#[derive(QueryData)]
pub(super) struct MainPassView {
    entity: Entity,
    view: &'static ExtractedView,
    camera: &'static ExtractedCamera,
    target: &'static ViewTarget,
    depth: &'static ViewDepthStencilTexture,
    uniform_offset: &'static ViewUniformOffset,
    textures: &'static PackedTextures,
    clear: &'static PackedClear,
    resolve: &'static PackedResolve,
    resolve_bind_group: &'static ResolveBindGroup,
    skybox: Option<&'static SkyboxBindGroup>,
    transmission: Option<(
        &'static ScreenSpaceTransmission,
        &'static ViewTransmissionTexture,
    )>,
}

pub(super) fn packed_main_pass(
    world: &World,
    view: ViewQuery<MainPassView, With<PackedView>>,
    opaque: Res<ViewBinnedRenderPhases<Opaque3d>>,
    alpha_mask: Res<ViewBinnedRenderPhases<AlphaMask3d>>,
    transmissive: Res<ViewSortedRenderPhases<Transmissive3d>>,
    transparent: Res<ViewSortedRenderPhases<Transparent3d>>,
    pipelines: Res<PhasePipelines>,
    cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let view = view.into_inner();
    let entity = view.entity;
    let id = view.view.retained_view_entity;
    let transmissive = transmissive
        .get(&id)
        .filter(|phase| !phase.items.is_empty());
    let ranges = transmissive.map_or_else(Vec::new, |phase| {
        let steps = view.transmission.map_or(0, |(settings, _)| settings.steps);
        transmission_ranges(phase.items.len(), steps)
    });
    // Without transmissive objects there is a single pass.
    let passes = ranges.len() + 1;
    for pass_index in 0..passes {
        let first = pass_index == 0;
        let last = pass_index + 1 == passes;
        if !first {
            resolve_to_transmission(&view, &cache, &mut ctx);
        }
        let diagnostics = ctx.diagnostic_recorder();
        let diagnostics = diagnostics.as_deref();
        let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
            label: Some("packed_ycocg_main_pass"),
            color_attachments: &[attachment(&view, first, last)],
            depth_stencil_attachment: Some(view.depth.get_attachment(StoreOp::Store)),
            ..default()
        });
        let span = diagnostics.pass_span(&mut pass, "packed_ycocg_main_pass");
        if let Some(viewport) = &view.camera.viewport {
            pass.set_camera_viewport(viewport);
        }
        if first {
            draw_clear(view.clear, &cache, &mut pass);
        }
        // A pipeline with another target format would be a validation error. Bevy draws this camera from
        // the next frame on.
        if !pipelines.undrawable.contains(&entity) {
            if first {
                if let Some(phase) = opaque.get(&id) {
                    log_draw_error(phase.render(&mut pass, world, entity), "opaque");
                }
                if let Some(phase) = alpha_mask.get(&id) {
                    log_draw_error(phase.render(&mut pass, world, entity), "alpha mask");
                }
                let skybox = pipelines.skyboxes.get(&entity).copied();
                draw_skybox(&view, skybox, &cache, &mut pass);
            } else if let Some(phase) = transmissive {
                let range = ranges[pass_index - 1].clone();
                let drawn = phase.render_range(&mut pass, world, entity, range);
                log_draw_error(drawn, "transmissive");
            }
            if last
                && let Some(phase) = transparent.get(&id)
                && !phase.items.is_empty()
            {
                log_draw_error(phase.render(&mut pass, world, entity), "transparent");
            }
        }
        span.end(&mut pass);
    }
    // While the pipeline is not ready, the view is only cleared.
    let target = view.target.get_color_attachment();
    draw_resolve(&view, view.resolve.to_view, target, &cache, &mut ctx);
}

/// Returns the attachment of the packed texture, which the first pass clears and the later ones load.
fn attachment<'a>(
    view: &MainPassViewItem<'a, '_>,
    first: bool,
    last: bool,
) -> Option<RenderPassColorAttachment<'a>> {
    let PackedTextures {
        single_sampled,
        multisampled,
        samples_are_read,
    } = view.textures;
    let luminance = match view.clear {
        PackedClear::Gray(luminance) => *luminance,
        PackedClear::Colored { .. } => 0.0,
    };
    let load = if first {
        LoadOp::Clear(LinearRgba::new(luminance, 0.0, 0.0, 0.0).into())
    } else {
        LoadOp::Load
    };
    let resolve_target = multisampled.as_ref().and(single_sampled.as_ref());
    // Samples that only the hardware resolves are not needed after the last pass.
    let store = if last && resolve_target.is_some() && !samples_are_read {
        StoreOp::Discard
    } else {
        StoreOp::Store
    };
    let texture = multisampled.as_ref().or(single_sampled.as_ref())?;
    Some(RenderPassColorAttachment {
        view: &texture.default_view,
        depth_slice: None,
        resolve_target: resolve_target.map(|texture| &*texture.default_view),
        ops: Operations { load, store },
    })
}

fn draw_clear<'w>(
    clear: &'w PackedClear,
    cache: &'w PipelineCache,
    pass: &mut TrackedRenderPass<'w>,
) {
    if let PackedClear::Colored {
        pipeline,
        bind_group,
    } = clear
        && let Some(pipeline) = cache.get_render_pipeline(*pipeline)
    {
        pass.set_render_pipeline(pipeline);
        pass.set_bind_group(0, bind_group, &[]);
        pass.draw(0..3, 0..1);
    }
}

fn draw_skybox<'v: 'w, 'w>(
    view: &MainPassViewItem<'v, '_>,
    pipeline: Option<CachedRenderPipelineId>,
    cache: &'w PipelineCache,
    pass: &mut TrackedRenderPass<'w>,
) {
    if let Some(SkyboxBindGroup((bind_group, skybox_offset))) = view.skybox
        && let Some(pipeline) = pipeline.and_then(|id| cache.get_render_pipeline(id))
    {
        pass.set_render_pipeline(pipeline);
        pass.set_bind_group(0, bind_group, &[view.uniform_offset.offset, *skybox_offset]);
        pass.draw(0..3, 0..1);
    }
}

fn resolve_to_transmission(
    view: &MainPassViewItem,
    cache: &PipelineCache,
    ctx: &mut RenderContext,
) {
    if let Some((_, transmission)) = view.transmission
        && let Some(pipeline) = view.resolve.to_transmission
    {
        let target = RenderPassColorAttachment {
            view: &transmission.view,
            depth_slice: None,
            resolve_target: None,
            ops: Operations {
                load: LoadOp::Load,
                store: StoreOp::Store,
            },
        };
        draw_resolve(view, pipeline, target, cache, ctx);
    }
}

fn draw_resolve(
    view: &MainPassViewItem,
    pipeline: CachedRenderPipelineId,
    target: RenderPassColorAttachment,
    cache: &PipelineCache,
    ctx: &mut RenderContext,
) {
    draw_fullscreen(
        ctx,
        "packed_ycocg_resolve",
        &[Some(target)],
        view.camera,
        cache.get_render_pipeline(pipeline),
        &view.resolve_bind_group.0,
        &[view.uniform_offset.offset],
    );
}

fn log_draw_error(drawn: Result<(), DrawError>, phase: &str) {
    if let Err(error) = drawn {
        error!("the {phase} phase was not drawn: {error:?}");
    }
}

/// Splits `len` transmissive objects, sorted from back to front, into `steps` ranges, each of which
/// samples the result of the ranges before it; 0 steps give one range.
fn transmission_ranges(len: usize, steps: usize) -> Vec<Range<usize>> {
    let count = steps.clamp(1, len.max(1));
    (0..count)
        .map(|i| len * i / count..len * (i + 1) / count)
        .collect()
}

/// The packed view that Bevy's main passes skip.
#[derive(Resource, Default)]
pub(super) struct SkippedView(Option<Entity>);

pub(super) fn skip_main_passes(
    current: Option<ResMut<CurrentView>>,
    mut skipped: ResMut<SkippedView>,
    packed: Query<(), With<PackedView>>,
) {
    if let Some(mut current) = current
        && packed.contains(current.0)
    {
        skipped.0 = Some(current.0);
        current.0 = Entity::PLACEHOLDER;
    }
}

pub(super) fn restore_current_view(
    current: Option<ResMut<CurrentView>>,
    mut skipped: ResMut<SkippedView>,
) {
    if let Some(mut current) = current
        && let Some(entity) = skipped.0.take()
    {
        current.0 = entity;
    }
}

/// Waits for all pipelines in a frame in which a view has switched formats, so that no mesh is missing in it: what is
/// on the screen stays there until then.
pub(super) fn wait_for_pipelines(switched: Res<SwitchedViews>, mut cache: ResMut<PipelineCache>) {
    if switched.views.is_empty() {
        return;
    }
    cache.process_queue();
    let pipelines = cache.pipelines().enumerate();
    let creating: Vec<_> = pipelines
        .filter(|(_, pipeline)| {
            matches!(pipeline.state, CachedPipelineState::Creating(_))
                && matches!(
                    pipeline.descriptor,
                    PipelineDescriptor::RenderPipelineDescriptor(_)
                )
        })
        .map(|(id, _)| CachedRenderPipelineId::new(id))
        .collect();
    for id in creating {
        cache.block_on_render_pipeline(id);
    }
}

#[cfg(test)]
mod tests {
    use super::transmission_ranges;

    #[test]
    fn ranges_cover_all_and_differ_by_one_at_most() {
        for len in 1..20 {
            for steps in 0..25 {
                let ranges = transmission_ranges(len, steps);
                assert_eq!(ranges.len(), steps.clamp(1, len));
                assert_eq!(ranges[0].start, 0);
                assert_eq!(ranges[ranges.len() - 1].end, len);
                assert!(ranges.windows(2).all(|w| w[0].end == w[1].start));
                assert!(
                    ranges
                        .iter()
                        .all(|r| r.len().abs_diff(len / ranges.len()) <= 1)
                );
            }
        }
    }
}
