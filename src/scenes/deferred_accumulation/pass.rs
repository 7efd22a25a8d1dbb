//! The targets of a camera, and what is drawn to them.

use bevy::{
    prelude::*,
    render::{
        camera::ExtractedCamera,
        diagnostic::RecordDiagnostics,
        render_resource::{
            BindGroup, BindGroupEntries, LoadOp, Operations, PipelineCache,
            RenderPassColorAttachment, RenderPassDescriptor, StoreOp, TextureDescriptor,
            TextureDimension, TextureUsages,
        },
        renderer::{RenderContext, RenderDevice, ViewQuery},
        texture::{CachedTexture, TextureCache},
        view::{ViewTarget, ViewUniformOffset, ViewUniforms},
    },
};

use super::{
    pipeline::{AccumulationPipelines, FORMAT},
    settings::LightAccumulation,
    sources::SourcesBuffer,
};

/// The accumulated light of a camera, one or two textures.
#[derive(Component)]
pub struct AccumulatedLight(Vec<CachedTexture>);

/// Gives every camera its targets, as large as its main texture.
pub fn prepare_targets(
    mut commands: Commands,
    mut textures: ResMut<TextureCache>,
    device: Res<RenderDevice>,
    views: Query<(Entity, &ViewTarget, &LightAccumulation)>,
) {
    for (entity, target, way) in &views {
        let descriptor = TextureDescriptor {
            label: Some("accumulated_light"),
            size: target.main_texture().size(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: FORMAT,
            usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        };
        let targets = (0..way.targets()).map(|_| textures.get(&device, descriptor.clone()));
        commands
            .entity(entity)
            .insert(AccumulatedLight(targets.collect()));
    }
}

/// Draws every light, then lights the surface.
pub fn accumulate(
    view: ViewQuery<(
        &ExtractedCamera,
        &ViewTarget,
        &ViewUniformOffset,
        &LightAccumulation,
        &AccumulatedLight,
    )>,
    pipelines: Option<Res<AccumulationPipelines>>,
    cache: Res<PipelineCache>,
    uniforms: Res<ViewUniforms>,
    sources: Res<SourcesBuffer>,
    mut context: RenderContext,
) {
    let (camera, target, offset, way, light) = view.into_inner();
    let Some(pipelines) = pipelines else {
        return;
    };
    let Some(own) = pipelines.by_way.get(way) else {
        return;
    };
    let (Some(light_pipeline), Some(combine_pipeline), Some(view_binding), Some(lamps_binding)) = (
        cache.get_render_pipeline(own.light),
        cache.get_render_pipeline(own.combine),
        uniforms.uniforms.binding(),
        sources.buffer.binding(),
    ) else {
        return;
    };
    let device = context.render_device();
    let light_bindings = device.create_bind_group(
        "light_accumulation_light",
        &cache.get_bind_group_layout(&pipelines.light_layout),
        &BindGroupEntries::sequential((view_binding.clone(), lamps_binding)),
    );
    let combine_layout = cache.get_bind_group_layout(&own.combine_layout);
    let combine_bindings: BindGroup = match &light.0[..] {
        [only] => device.create_bind_group(
            "light_accumulation_combine",
            &combine_layout,
            &BindGroupEntries::sequential((view_binding, &only.default_view)),
        ),
        [diffuse, specular, ..] => device.create_bind_group(
            "light_accumulation_combine",
            &combine_layout,
            &BindGroupEntries::sequential((
                view_binding,
                &diffuse.default_view,
                &specular.default_view,
            )),
        ),
        [] => return,
    };
    let attachment = |texture| {
        Some(RenderPassColorAttachment {
            view: texture,
            depth_slice: None,
            resolve_target: None,
            ops: Operations {
                load: LoadOp::Clear(default()),
                store: StoreOp::Store,
            },
        })
    };
    let light_attachments: Vec<_> = light
        .0
        .iter()
        .map(|texture| attachment(&texture.default_view))
        .collect();
    let combine_attachments = [Some(target.get_unsampled_color_attachment())];

    let diagnostics = context.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let time_span = diagnostics.time_span(context.command_encoder(), "light_accumulation");
    let steps = [
        (
            "light_accumulation_lights",
            &light_attachments[..],
            light_pipeline,
            &light_bindings,
            sources.count,
        ),
        (
            "light_accumulation_combine",
            &combine_attachments[..],
            combine_pipeline,
            &combine_bindings,
            1,
        ),
    ];
    for (label, color_attachments, pipeline, bindings, draws) in steps {
        let mut pass = context.begin_tracked_render_pass(RenderPassDescriptor {
            label: Some(label),
            color_attachments,
            depth_stencil_attachment: None,
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        if let Some(viewport) = &camera.viewport {
            pass.set_camera_viewport(viewport);
        }
        pass.set_render_pipeline(pipeline);
        pass.set_bind_group(0, bindings, &[offset.offset]);
        for instance in 0..draws {
            pass.draw(0..3, instance..instance + 1);
        }
    }
    time_span.end(context.command_encoder());
}
