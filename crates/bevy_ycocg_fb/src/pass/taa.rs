//! Temporal anti-aliasing of cameras in `Rg11b10Ufloat`.
//!
//! Bevy's pass keeps its confidence in the alpha channel of its history, which has the format of the view. So it is
//! replaced by the same pass, with Bevy's own shader, whose history has Bevy's own HDR format. It is taken over
//! after Bevy has jittered the camera and before it would allocate its history.

use bevy::{
    anti_alias::taa::{
        TemporalAntiAliasHistoryTextures, TemporalAntiAliasPipelineId, TemporalAntiAliasing,
    },
    core_pipeline::{Core3d, Core3dSystems, FullscreenShader, prepass::ViewPrepassTextures},
    diagnostic::FrameCount,
    prelude::*,
    render::{
        Render, RenderApp, RenderStartup, RenderSystems,
        camera::ExtractedCamera,
        render_resource::{
            BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries,
            CachedRenderPipelineId, FilterMode, FragmentState, Operations, PipelineCache,
            RenderPassColorAttachment, RenderPipelineDescriptor, Sampler, SamplerBindingType,
            SamplerDescriptor, ShaderStages, SpecializedRenderPipeline, SpecializedRenderPipelines,
            TextureFormat, TextureSampleType,
            binding_types::{sampler, texture_2d, texture_depth_2d},
        },
        renderer::{RenderContext, RenderDevice, ViewQuery},
        texture::{CachedTexture, TextureCache},
        view::{Msaa, ViewTarget},
    },
};

use super::draw_fullscreen;
use crate::{
    material::RG11B10UFLOAT,
    view::formatted::{Rg11b10UfloatView, target_descriptor},
};

/// Bevy's shader.
const SHADER: &str = "embedded://bevy_anti_alias/taa/taa.wesl";
/// Bevy's HDR format.
const HISTORY_FORMAT: TextureFormat = TextureFormat::Rgba16Float;

pub(super) struct TaaPlugin;

impl Plugin for TaaPlugin {
    fn build(&self, app: &mut App) {
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .init_resource::<SpecializedRenderPipelines<TaaPipeline>>()
            .add_systems(RenderStartup, init_pipeline)
            .add_systems(
                Render,
                (
                    take_over
                        .after(RenderSystems::PrepareViews)
                        .before(RenderSystems::Queue),
                    prepare.in_set(RenderSystems::PrepareResources),
                ),
            )
            .add_systems(Core3d, anti_alias.in_set(Core3dSystems::EarlyPostProcess));
    }
}

/// A view whose anti-aliasing this module has taken over.
#[derive(Component)]
struct TakenOver {
    reset: bool,
}

/// The history of a view, and the pipeline of this frame.
#[derive(Component)]
struct TaaHistory {
    read: CachedTexture,
    write: CachedTexture,
    pipeline: CachedRenderPipelineId,
}

#[derive(Resource)]
struct TaaPipeline {
    layout: BindGroupLayoutDescriptor,
    nearest: Sampler,
    linear: Sampler,
    fullscreen: FullscreenShader,
    shader: Handle<Shader>,
}

fn init_pipeline(
    mut commands: Commands,
    device: Res<RenderDevice>,
    fullscreen: Res<FullscreenShader>,
    asset_server: Res<AssetServer>,
) {
    let filtered = TextureSampleType::Float { filterable: true };
    let entries = BindGroupLayoutEntries::sequential(
        ShaderStages::FRAGMENT,
        (
            texture_2d(filtered),
            texture_2d(filtered),
            texture_2d(filtered),
            texture_depth_2d(),
            sampler(SamplerBindingType::NonFiltering),
            sampler(SamplerBindingType::Filtering),
        ),
    );
    let sampler = |filter| {
        device.create_sampler(&SamplerDescriptor {
            mag_filter: filter,
            min_filter: filter,
            ..default()
        })
    };
    commands.insert_resource(TaaPipeline {
        layout: BindGroupLayoutDescriptor::new("rg11b10ufloat_taa", &entries),
        nearest: sampler(FilterMode::Nearest),
        linear: sampler(FilterMode::Linear),
        fullscreen: fullscreen.clone(),
        shader: asset_server.load(SHADER),
    });
}

impl SpecializedRenderPipeline for TaaPipeline {
    /// Whether there is a history, and whether the camera has `Hdr`.
    type Key = (bool, bool);

    fn specialize(&self, (has_history, hdr): Self::Key) -> RenderPipelineDescriptor {
        let defs = [
            (RG11B10UFLOAT, true),
            ("TONEMAP", hdr),
            ("RESET", !has_history),
        ];
        RenderPipelineDescriptor {
            label: Some("rg11b10ufloat_taa".into()),
            layout: vec![self.layout.clone()],
            vertex: self.fullscreen.to_vertex_state(),
            fragment: Some(FragmentState {
                shader: self.shader.clone(),
                shader_defs: defs
                    .into_iter()
                    .filter(|(_, is_set)| *is_set)
                    .map(|(def, _)| def.into())
                    .collect(),
                targets: [TextureFormat::Rg11b10Ufloat, HISTORY_FORMAT]
                    .map(|format| Some(format.into()))
                    .into(),
                ..default()
            }),
            ..default()
        }
    }
}

/// Bevy extracts its component anew in every frame.
fn take_over(
    mut commands: Commands,
    views: Query<(Entity, &TemporalAntiAliasing, &Msaa), With<Rg11b10UfloatView>>,
    stale: Query<
        Entity,
        (
            With<TakenOver>,
            Or<(Without<Rg11b10UfloatView>, Without<TemporalAntiAliasing>)>,
        ),
    >,
) {
    for entity in &stale {
        commands.entity(entity).remove::<(TakenOver, TaaHistory)>();
    }
    for (entity, settings, msaa) in &views {
        if *msaa == Msaa::Off {
            let reset = settings.reset;
            commands
                .entity(entity)
                .remove::<(
                    TemporalAntiAliasing,
                    TemporalAntiAliasHistoryTextures,
                    TemporalAntiAliasPipelineId,
                )>()
                .insert(TakenOver { reset });
        }
    }
}

fn prepare(
    mut commands: Commands,
    views: Query<(Entity, &ExtractedCamera, &TakenOver, Has<TaaHistory>)>,
    pipeline: Res<TaaPipeline>,
    mut pipelines: ResMut<SpecializedRenderPipelines<TaaPipeline>>,
    pipeline_cache: Res<PipelineCache>,
    mut textures: ResMut<TextureCache>,
    device: Res<RenderDevice>,
    frames: Res<FrameCount>,
) {
    for (entity, camera, taken_over, has_history) in &views {
        let Some(size) = camera.physical_target_size else {
            continue;
        };
        let labels = ["rg11b10ufloat_taa_history_1", "rg11b10ufloat_taa_history_2"];
        let mut pair = labels.map(|label| {
            let descriptor = target_descriptor(label, size, HISTORY_FORMAT, 1);
            textures.get(&device, descriptor)
        });
        if !frames.0.is_multiple_of(2) {
            pair.reverse();
        }
        let [write, read] = pair;
        let has_history = has_history && !taken_over.reset;
        let [current, _next] = [has_history, true]
            .map(|history| pipelines.specialize(&pipeline_cache, &pipeline, (history, camera.hdr)));
        commands.entity(entity).insert(TaaHistory {
            read,
            write,
            pipeline: current,
        });
    }
}

fn anti_alias(
    view: ViewQuery<(
        &ExtractedCamera,
        &ViewTarget,
        &TaaHistory,
        &ViewPrepassTextures,
    )>,
    pipeline: Res<TaaPipeline>,
    cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (camera, target, history, prepass) = view.into_inner();
    let (Some(render_pipeline), Some(motion_vectors), Some(depth)) = (
        cache.get_render_pipeline(history.pipeline),
        &prepass.motion_vectors,
        &prepass.depth,
    ) else {
        return;
    };
    let target = target.post_process_write();
    let bind_group = ctx.render_device().create_bind_group(
        "rg11b10ufloat_taa",
        &cache.get_bind_group_layout(&pipeline.layout),
        &BindGroupEntries::sequential((
            target.source,
            &history.read.default_view,
            &motion_vectors.texture.default_view,
            &depth.texture.default_view,
            &pipeline.nearest,
            &pipeline.linear,
        )),
    );
    let targets = [target.destination, &history.write.default_view].map(|view| {
        Some(RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: Operations::default(),
        })
    });
    draw_fullscreen(
        &mut ctx,
        "rg11b10ufloat_taa",
        &targets,
        camera,
        Some(render_pipeline),
        &bind_group,
        &[],
    );
}
