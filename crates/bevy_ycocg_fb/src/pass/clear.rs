//! The clear colour. A gray one is set by the load operation; any other one has a chrominance that
//! depends on the pixel, so a full-screen triangle draws it.

use bevy::{
    asset::load_embedded_asset,
    camera::ClearColorConfig,
    core_pipeline::{FullscreenShader, core_3d::CORE_3D_DEPTH_FORMAT},
    ecs::entity::EntityHashMap,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries,
            CachedRenderPipelineId, ColorTargetState, ColorWrites, CompareFunction,
            DepthStencilState, FragmentState, MultisampleState, PipelineCache,
            RenderPipelineDescriptor, ShaderStages, SpecializedRenderPipeline,
            SpecializedRenderPipelines, UniformBuffer, binding_types::uniform_buffer,
        },
        renderer::{RenderDevice, RenderQueue},
        sync_world::MainEntity,
    },
};

use crate::{settings::PackedFormat, view::formatted::PackedView};

#[derive(Resource)]
pub(crate) struct ClearPipeline {
    layout: BindGroupLayoutDescriptor,
    fullscreen: FullscreenShader,
    shader: Handle<Shader>,
}

pub(super) fn init_pipeline(
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
                targets: vec![Some(ColorTargetState {
                    format: format.texture_format(),
                    blend: None,
                    write_mask: ColorWrites::ALL,
                })],
                ..default()
            }),
            ..default()
        }
    }
}

/// Uniform buffers of the clear colours by camera, which are kept from frame to frame.
#[derive(Resource, Default)]
pub(crate) struct ClearUniforms(EntityHashMap<(LinearRgba, UniformBuffer<Vec4>)>);

/// The operation that clears a view.
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

pub(super) fn prepare(
    mut commands: Commands,
    views: Query<(Entity, &MainEntity, &PackedView, &ExtractedCamera)>,
    stale: Query<Entity, (With<PackedClear>, Without<PackedView>)>,
    global: Res<ClearColor>,
    mut uniforms: ResMut<ClearUniforms>,
    pipeline: Res<ClearPipeline>,
    mut pipelines: ResMut<SpecializedRenderPipelines<ClearPipeline>>,
    cache: Res<PipelineCache>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
) {
    for entity in &stale {
        commands.entity(entity).remove::<PackedClear>();
    }
    uniforms
        .0
        .retain(|&camera, _| views.iter().any(|(_, main, ..)| main.id() == camera));
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
            .0
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
