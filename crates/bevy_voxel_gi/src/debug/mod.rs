//! A debug view that shows the voxels in place of a camera's picture.

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    core_pipeline::{Core3d, Core3dSystems, FullscreenShader, tonemapping::tonemapping},
    prelude::*,
    render::{
        GpuResourceAppExt, Render, RenderApp, RenderStartup, RenderSystems,
        extract_component::{ExtractComponent, ExtractComponentPlugin},
        render_resource::{
            BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries,
            CachedRenderPipelineId, ColorTargetState, ColorWrites, FragmentState, Operations,
            PipelineCache, RenderPassColorAttachment, RenderPassDescriptor,
            RenderPipelineDescriptor, ShaderStages, SpecializedRenderPipeline,
            SpecializedRenderPipelines, TextureFormat, TextureSampleType,
            binding_types::{texture_3d, uniform_buffer},
        },
        renderer::{RenderContext, ViewQuery},
        view::{ExtractedView, ViewTarget, ViewUniform, ViewUniformOffset, ViewUniforms},
    },
};

use crate::{
    passes::bindings::{BindGroups, Binding, Group},
    prepare::buffers::VolumeBuffers,
};

/// Add to a camera to show the voxels instead of the scene.
#[derive(Component, ExtractComponent, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[extract_app(RenderApp)]
#[reflect(Component, Default, Clone)]
pub struct VoxelGiDebug {
    /// The property of the voxels that is shown.
    pub field: DebugField,
}

/// A property of the voxels that [`VoxelGiDebug`] can show.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DebugField {
    /// The sub-voxels that triangles overlap, with brightness alternating by voxel.
    #[default]
    Occupancy,
    /// Diffuse reflectance.
    Albedo,
    /// Normals, with components mapped from -1..1 to 0..1.
    Normal,
    /// The radiance that leaves each face.
    Radiance,
    /// The indirect irradiance of each face, without the direct light of light sources: what pixels read.
    Irradiance,
}

impl DebugField {
    fn shader_def(self) -> &'static str {
        match self {
            Self::Occupancy => "FIELD_OCCUPANCY",
            Self::Albedo => "FIELD_ALBEDO",
            Self::Normal => "FIELD_NORMAL",
            Self::Radiance => "FIELD_RADIANCE",
            Self::Irradiance => "FIELD_IRRADIANCE",
        }
    }
}

pub(crate) struct DebugViewPlugin;

impl Plugin for DebugViewPlugin {
    fn build(&self, app: &mut App) {
        embedded_asset!(app, "view.wesl");
        app.register_type::<VoxelGiDebug>()
            .add_plugins(ExtractComponentPlugin::<VoxelGiDebug>::default());
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .init_gpu_resource::<SpecializedRenderPipelines<DebugPipeline>>()
            .add_systems(RenderStartup, init_pipeline)
            .add_systems(Render, prepare_pipelines.in_set(RenderSystems::Prepare))
            .add_systems(
                Core3d,
                show.in_set(Core3dSystems::PostProcess).after(tonemapping),
            );
    }
}

#[derive(Resource)]
struct DebugPipeline {
    /// Without reprojected albedo, and with it.
    voxels: [Group; 2],
    light: Group,
    view_layout: BindGroupLayoutDescriptor,
    fullscreen: FullscreenShader,
    shader: Handle<Shader>,
}

fn init_pipeline(
    mut commands: Commands,
    fullscreen: Res<FullscreenShader>,
    assets: Res<AssetServer>,
) {
    let fragment = ShaderStages::FRAGMENT;
    commands.insert_resource(DebugPipeline {
        voxels: [false, true]
            .map(|albedo| Group::of_voxels(fragment, "voxel_gi_debug_volume", 0, albedo)),
        light: Group::of_stages(
            fragment,
            "voxel_gi_debug_light",
            &[Binding::Radiance, Binding::Colors],
            &[],
        ),
        view_layout: BindGroupLayoutDescriptor::new(
            "voxel_gi_debug_view",
            &BindGroupLayoutEntries::sequential(
                fragment,
                (
                    uniform_buffer::<ViewUniform>(true),
                    texture_3d(TextureSampleType::Float { filterable: false }),
                ),
            ),
        ),
        fullscreen: fullscreen.clone(),
        shader: load_embedded_asset!(assets.as_ref(), "view.wesl"),
    });
}

/// Selects the shader variant of the debug pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct DebugKey {
    field: DebugField,
    format: TextureFormat,
    reprojects_albedo: bool,
}

impl SpecializedRenderPipeline for DebugPipeline {
    type Key = DebugKey;

    fn specialize(&self, key: Self::Key) -> RenderPipelineDescriptor {
        let mut shader_defs = vec![key.field.shader_def().into()];
        if key.reprojects_albedo {
            shader_defs.push("REPROJECTED_ALBEDO".into());
        }
        RenderPipelineDescriptor {
            label: Some("voxel_gi_debug".into()),
            layout: vec![
                self.voxels[usize::from(key.reprojects_albedo)]
                    .layout
                    .clone(),
                self.light.layout.clone(),
                self.view_layout.clone(),
            ],
            vertex: self.fullscreen.to_vertex_state(),
            fragment: Some(FragmentState {
                shader: self.shader.clone(),
                shader_defs,
                targets: vec![Some(ColorTargetState {
                    format: key.format,
                    blend: None,
                    write_mask: ColorWrites::ALL,
                })],
                ..default()
            }),
            ..default()
        }
    }
}

#[derive(Component)]
struct DebugPipelineId(CachedRenderPipelineId);

fn prepare_pipelines(
    mut commands: Commands,
    views: Query<(Entity, &ExtractedView, &VoxelGiDebug)>,
    buffers: Option<Res<VolumeBuffers>>,
    pipeline: Res<DebugPipeline>,
    mut pipelines: ResMut<SpecializedRenderPipelines<DebugPipeline>>,
    cache: Res<PipelineCache>,
) {
    let Some(buffers) = buffers else {
        return;
    };
    let occlusion_only = buffers.shape.occlusion_only;
    for (entity, view, debug) in &views {
        let field = if occlusion_only && debug.field == DebugField::Radiance {
            warn_once!(
                "voxel GI: ambient occlusion stores no radiance, so the debug view shows occupancy; \
                 choose another field, or global illumination"
            );
            DebugField::Occupancy
        } else {
            debug.field
        };
        let key = DebugKey {
            field,
            format: view.target_format,
            reprojects_albedo: buffers.shape.reprojects_albedo,
        };
        let id = pipelines.specialize(&cache, &pipeline, key);
        commands.entity(entity).insert(DebugPipelineId(id));
    }
}

fn show(
    view: ViewQuery<(&ViewTarget, &ViewUniformOffset, &DebugPipelineId), With<VoxelGiDebug>>,
    mut context: RenderContext,
    pipeline: Res<DebugPipeline>,
    groups: BindGroups,
    views: Res<ViewUniforms>,
) {
    let (target, offset, id) = view.into_inner();
    let (Some(buffers), Some(volume)) = (&groups.buffers, &groups.volume.0) else {
        return;
    };
    let voxels = &pipeline.voxels[usize::from(buffers.shape.reprojects_albedo)];
    let (Some(render_pipeline), Some(texture), Some(view_uniforms), Some(voxels), Some(light)) = (
        groups.cache.get_render_pipeline(id.0),
        groups.images.get(&volume.texture),
        views.uniforms.binding(),
        groups.bind(voxels),
        groups.bind(&pipeline.light),
    ) else {
        return;
    };
    let view = BindGroupEntries::sequential((view_uniforms, &texture.texture_view));
    let view = groups.create(&pipeline.view_layout, &view);
    let post_process = target.post_process_write();
    let mut pass = context.begin_tracked_render_pass(RenderPassDescriptor {
        label: Some("voxel_gi_debug"),
        color_attachments: &[Some(RenderPassColorAttachment {
            view: post_process.destination,
            depth_slice: None,
            resolve_target: None,
            ops: Operations::default(),
        })],
        depth_stencil_attachment: None,
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    });
    pass.set_render_pipeline(render_pipeline);
    pass.set_bind_group(0, &voxels, &[]);
    pass.set_bind_group(1, &light, &[]);
    pass.set_bind_group(2, &view, &[offset.offset]);
    pass.draw(0..3, 0..1);
}
