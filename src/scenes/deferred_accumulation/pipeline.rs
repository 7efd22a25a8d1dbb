//! The pipelines of each [`LightAccumulation`]: one that adds a light, one that combines.

use bevy::{
    asset::load_embedded_asset,
    core_pipeline::FullscreenShader,
    mesh::VertexBufferLayout,
    platform::collections::HashMap,
    prelude::*,
    render::{
        render_resource::{
            BindGroupLayoutDescriptor, BindGroupLayoutEntries, BlendComponent, BlendFactor,
            BlendOperation, BlendState, CachedRenderPipelineId, ColorTargetState, ColorWrites,
            FragmentState, PipelineCache, RenderPipelineDescriptor, ShaderStages, TextureFormat,
            TextureSampleType, VertexState,
            binding_types::{texture_2d, uniform_buffer},
        },
        view::ViewUniform,
    },
    shader::ShaderDefVal,
};

use super::{
    settings::{LightAccumulation, MAX_SOURCES},
    sources::SourcesUniform,
};

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
