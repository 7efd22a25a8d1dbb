//! The targets of a camera, their pipelines, and what is drawn to them.

use bevy::{
    asset::load_embedded_asset,
    core_pipeline::FullscreenShader,
    mesh::VertexBufferLayout,
    platform::collections::HashMap,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        diagnostic::RecordDiagnostics,
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries,
            BlendComponent, BlendFactor, BlendOperation, BlendState, CachedRenderPipelineId,
            ColorTargetState, ColorWrites, FragmentState, LoadOp, Operations, PipelineCache,
            RenderPassColorAttachment, RenderPassDescriptor, RenderPipelineDescriptor,
            ShaderStages, StoreOp, TextureDescriptor, TextureDimension, TextureFormat,
            TextureSampleType, TextureUsages, VertexState,
            binding_types::{texture_2d, uniform_buffer},
        },
        renderer::{RenderContext, RenderDevice, ViewQuery},
        texture::{CachedTexture, TextureCache},
        view::{ViewTarget, ViewUniform, ViewUniformOffset, ViewUniforms},
    },
    shader::ShaderDefVal,
};

use crate::scenes::deferred_accumulation::{
    LightAccumulation, MAX_SOURCES, SourcesBuffer, SourcesUniform,
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

/// Format of the accumulated light, and of the camera's main texture.
pub const FORMAT: TextureFormat = TextureFormat::Rgba16Float;

/// The pipelines of one [`LightAccumulation`].
pub struct Pipelines {
    /// Adds a light, the instance.
    pub light: CachedRenderPipelineId,
    pub combine: CachedRenderPipelineId,
    pub combine_layout: BindGroupLayoutDescriptor,
}

#[derive(Resource)]
pub struct AccumulationPipelines {
    pub light_layout: BindGroupLayoutDescriptor,
    pub by_way: HashMap<LightAccumulation, Pipelines>,
}

pub fn init(
    mut commands: Commands,
    assets: Res<AssetServer>,
    cache: Res<PipelineCache>,
    fullscreen: Res<FullscreenShader>,
) {
    let light_shader = load_embedded_asset!(assets.as_ref(), "light.wesl");
    let combine_shader = load_embedded_asset!(assets.as_ref(), "combine.wesl");
    let light_layout = BindGroupLayoutDescriptor::new(
        "light_accumulation_light_layout",
        &BindGroupLayoutEntries::sequential(
            ShaderStages::FRAGMENT,
            (
                uniform_buffer::<ViewUniform>(true),
                uniform_buffer::<SourcesUniform>(false),
            ),
        ),
    );
    let pipelines = LightAccumulation::ALL.map(|way| {
        let light = cache.queue_render_pipeline(RenderPipelineDescriptor {
            label: Some("light_accumulation_light_pipeline".into()),
            layout: vec![light_layout.clone()],
            vertex: VertexState {
                shader: light_shader.clone(),
                shader_defs: defs(way),
                entry_point: Some("vertex".into()),
                buffers: Vec::<VertexBufferLayout>::new(),
                ..default()
            },
            fragment: Some(FragmentState {
                shader: light_shader.clone(),
                shader_defs: defs(way),
                entry_point: Some("fragment".into()),
                targets: vec![Some(target(Some(ADDITIVE))); way.targets()],
                ..default()
            }),
            ..default()
        });
        let combine_layout = combine_layout(way);
        let combine = cache.queue_render_pipeline(RenderPipelineDescriptor {
            label: Some("light_accumulation_combine_pipeline".into()),
            layout: vec![combine_layout.clone()],
            vertex: fullscreen.to_vertex_state(),
            fragment: Some(FragmentState {
                shader: combine_shader.clone(),
                shader_defs: defs(way),
                entry_point: Some("fragment".into()),
                targets: vec![Some(target(None))],
                ..default()
            }),
            ..default()
        });
        let pipelines = Pipelines {
            light,
            combine,
            combine_layout,
        };
        (way, pipelines)
    });
    commands.insert_resource(AccumulationPipelines {
        light_layout,
        by_way: pipelines.into_iter().collect(),
    });
}

/// Light adds up, packed or not: packing is linear.
const ADDITIVE: BlendState = {
    let sum = BlendComponent {
        src_factor: BlendFactor::One,
        dst_factor: BlendFactor::One,
        operation: BlendOperation::Add,
    };
    BlendState {
        color: sum,
        alpha: sum,
    }
};

fn target(blend: Option<BlendState>) -> ColorTargetState {
    ColorTargetState {
        format: FORMAT,
        blend,
        write_mask: ColorWrites::ALL,
    }
}

fn combine_layout(way: LightAccumulation) -> BindGroupLayoutDescriptor {
    let texture = || texture_2d(TextureSampleType::Float { filterable: false });
    let view = uniform_buffer::<ViewUniform>(true);
    let stages = ShaderStages::FRAGMENT;
    let entries = match way.targets() {
        1 => BindGroupLayoutEntries::sequential(stages, (view, texture())).to_vec(),
        _ => BindGroupLayoutEntries::sequential(stages, (view, texture(), texture())).to_vec(),
    };
    BindGroupLayoutDescriptor::new("light_accumulation_combine_layout", &entries)
}

fn defs(way: LightAccumulation) -> Vec<ShaderDefVal> {
    let mut defs = vec![ShaderDefVal::UInt("MAX_SOURCES".into(), MAX_SOURCES as u32)];
    match way {
        LightAccumulation::Exact => defs.push("EXACT".into()),
        LightAccumulation::Packed => defs.push("PACKED".into()),
        LightAccumulation::SpecularLuminance => {}
    }
    defs
}
