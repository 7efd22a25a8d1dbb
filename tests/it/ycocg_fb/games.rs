//! What games and their plugins add to a camera: the app goes on, with a picture and a reason.

use std::sync::atomic::{AtomicBool, Ordering};

use bevy::{
    camera::{CameraMainTextureUsages, Hdr, RenderTarget},
    core_pipeline::{
        Core3d, Core3dSystems, FullscreenShader,
        core_3d::CORE_3D_DEPTH_FORMAT,
        core_3d::{Opaque3d, Opaque3dBatchSetKey, Opaque3dBinKey},
        prepass::DepthPrepass,
        tonemapping::tonemapping,
    },
    prelude::*,
    render::{
        Render, RenderApp, RenderStartup, RenderSystems,
        render_phase::{
            AddRenderCommand, BinnedRenderPhaseType, DrawFunctions, InputUniformIndex, PhaseItem,
            RenderCommand, RenderCommandResult, SetItemPipeline, TrackedRenderPass,
            ViewBinnedRenderPhases,
        },
        render_resource::{
            CachedRenderPipelineId, ColorTargetState, ColorWrites, CompareFunction,
            DepthStencilState, Extent3d, FragmentState, PipelineCache, RenderPassDescriptor,
            RenderPipelineDescriptor, TextureDescriptor, TextureDimension, TextureFormat,
            TextureUsages,
        },
        renderer::{RenderContext, RenderDevice, ViewQuery},
        sync_world::MainEntity,
        view::{ExtractedView, Msaa, ViewTarget},
    },
};
use bevy_frugal_lab::headless::HeadlessError;
use bevy_ycocg_fb::{
    CameraState, FallbackReason as Reason, FrameBufferQuality as Quality, FrameBufferReport,
};

use super::{Studio, TestCamera, lit_scene, packing};
use crate::support::{gpu, gpu_alone, renderer_errors};

#[test]
fn storage_in_the_main_texture_keeps_bevys_format() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    studio.mode(true, Msaa::Off).camera(|camera| {
        let usages = CameraMainTextureUsages::default();
        camera.insert(usages.with(TextureUsages::STORAGE_BINDING));
    });
    studio.check_fallback(Quality::Compact, Reason::StorageUsage);
    studio.packed(packing());
}

#[test]
fn a_camera_of_depth_alone_has_what_it_should_have() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    studio.app.world_mut().spawn((
        Name::new("depth"),
        Camera3d::default(),
        DepthPrepass,
        Msaa::Off,
        RenderTarget::None {
            size: UVec2::splat(32),
        },
        Quality::Compact,
    ));
    studio.rg11b10ufloat();
    let world = studio.app.world_mut();
    let report = world
        .query_filtered::<&FrameBufferReport, With<DepthPrepass>>()
        .single(world)
        .unwrap();
    assert_eq!(report.state, CameraState::Exact);
    assert_eq!(report.memory.total(), 0);
}

#[derive(Resource)]
struct FixedPipeline(CachedRenderPipelineId);

fn queue_fixed(
    mut commands: Commands,
    cache: Res<PipelineCache>,
    fullscreen: Res<FullscreenShader>,
    assets: Res<AssetServer>,
) {
    let id = cache.queue_render_pipeline(fixed(&fullscreen, &assets, "fixed_post"));
    commands.insert_resource(FixedPipeline(id));
}

fn fixed(
    fullscreen: &FullscreenShader,
    assets: &AssetServer,
    label: &'static str,
) -> RenderPipelineDescriptor {
    RenderPipelineDescriptor {
        label: Some(label.into()),
        vertex: fullscreen.to_vertex_state(),
        fragment: Some(FragmentState {
            shader: assets.load("shaders/fixed.wesl"),
            targets: vec![Some(ColorTargetState {
                write_mask: ColorWrites::RED,
                ..TextureFormat::Rgba16Float.into()
            })],
            ..default()
        }),
        ..default()
    }
}

/// As Bevy's example `custom_post_processing` has it.
fn draw_fixed(
    view: ViewQuery<&ViewTarget>,
    pipeline: Res<FixedPipeline>,
    cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let Some(pipeline) = cache.get_render_pipeline(pipeline.0) else {
        return;
    };
    let target = view.into_inner();
    let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
        label: Some("fixed_post"),
        color_attachments: &[Some(target.get_unsampled_color_attachment())],
        ..default()
    });
    pass.set_render_pipeline(pipeline);
    pass.draw(0..3, 0..1);
}

/// A lit scene whose camera has `Hdr` from the first frame on.
fn hdr_scene(app: &mut App) {
    lit_scene(app);
    app.add_systems(
        PostStartup,
        |mut commands: Commands, camera: Single<Entity, With<TestCamera>>| {
            commands.entity(*camera).insert(Hdr);
        },
    );
}

fn with_post_processing(app: &mut App) {
    hdr_scene(app);
    app.sub_app_mut(RenderApp)
        .add_systems(RenderStartup, queue_fixed)
        .add_systems(
            Core3d,
            draw_fixed
                .in_set(Core3dSystems::PostProcess)
                .before(tonemapping),
        );
}

#[test]
fn post_processing_of_a_fixed_format_keeps_bevys_format_and_is_named() {
    // What it logs would fail a test beside it.
    let _gpu = gpu_alone();
    let mut studio = Studio::new(with_post_processing);
    studio.mode(true, Msaa::Off);
    let Reason::RefusedByRenderer(error) = studio.fallback(Quality::Compact) else {
        panic!("{:?}", studio.state());
    };
    assert!(error.contains("fixed_post"), "{error}");
    // One frame: wgpu reports it at the end of the encoder and of the submission.
    let errors = renderer_errors();
    assert!(
        errors.len() == 2 && errors.iter().all(|error| error.contains("fixed_post")),
        "{errors:#?}"
    );
    // Its target is Bevy's.
    studio.packed(packing());
}

/// Makes a texture that no device allows.
static BREAKS: AtomicBool = AtomicBool::new(false);

#[test]
fn an_error_that_is_not_of_the_format_reaches_the_app() {
    let _gpu = gpu_alone();
    let mut studio = Studio::new(|app| {
        lit_scene(app);
        app.sub_app_mut(RenderApp).add_systems(
            Render,
            (|device: Res<RenderDevice>| {
                if BREAKS.load(Ordering::Relaxed) {
                    device.create_texture(&TextureDescriptor {
                        label: Some("of the game"),
                        size: Extent3d::default(),
                        mip_level_count: 20,
                        sample_count: 1,
                        dimension: TextureDimension::D2,
                        format: TextureFormat::Rgba8Unorm,
                        usage: TextureUsages::TEXTURE_BINDING,
                        view_formats: &[],
                    });
                }
            })
            .in_set(RenderSystems::Queue),
        );
    });
    studio.mode(true, Msaa::Off).rg11b10ufloat();
    BREAKS.store(true, Ordering::Relaxed);
    let result = studio.app.render_frames(3);
    BREAKS.store(false, Ordering::Relaxed);
    let Err(HeadlessError::Renderer { error }) = result else {
        panic!("{result:?}");
    };
    assert!(error.contains("of the game"), "{error}");
    assert!(!renderer_errors().is_empty());
}

/// A pass of its own, as Bevy's example `custom_render_phase` has one.
fn own_pass(_: ViewQuery<&ViewTarget>) {}

#[test]
fn a_system_in_the_main_pass_is_named_and_keeps_the_camera_from_packing() {
    let _gpu = gpu();
    let mut studio = Studio::new(|app| {
        lit_scene(app);
        app.sub_app_mut(RenderApp)
            .add_systems(Core3d, own_pass.in_set(Core3dSystems::MainPass));
    });
    studio.mode(true, Msaa::Off);
    let Reason::MainPassSystem(name) = studio.fallback(packing()) else {
        panic!("{:?}", studio.state());
    };
    assert!(name.ends_with("own_pass`"), "{name}");
    studio.rg11b10ufloat();
}

struct DrawItem;

impl<P: PhaseItem> RenderCommand<P> for DrawItem {
    type Param = ();
    type ViewQuery = ();
    type ItemQuery = ();

    fn render<'w>(
        _: &P,
        (): (),
        _: Option<()>,
        (): (),
        pass: &mut TrackedRenderPass<'w>,
    ) -> RenderCommandResult {
        pass.draw(0..3, 0..1);
        RenderCommandResult::Success
    }
}

type DrawCustom = (SetItemPipeline, DrawItem);

fn queue_item_pipeline(
    mut commands: Commands,
    cache: Res<PipelineCache>,
    fullscreen: Res<FullscreenShader>,
    assets: Res<AssetServer>,
) {
    let id = cache.queue_render_pipeline(RenderPipelineDescriptor {
        depth_stencil: Some(DepthStencilState {
            format: CORE_3D_DEPTH_FORMAT,
            depth_write_enabled: Some(false),
            depth_compare: Some(CompareFunction::Always),
            stencil: default(),
            bias: default(),
        }),
        ..fixed(&fullscreen, &assets, "fixed_item")
    });
    commands.insert_resource(FixedPipeline(id));
}

/// As Bevy's example `custom_phase_item` does.
fn queue_item(
    pipeline: Res<FixedPipeline>,
    mut phases: ResMut<ViewBinnedRenderPhases<Opaque3d>>,
    functions: Res<DrawFunctions<Opaque3d>>,
    views: Query<(Entity, &MainEntity, &ExtractedView)>,
) {
    let draw_function = functions.read().id::<DrawCustom>();
    for (entity, main_entity, view) in &views {
        let Some(phase) = phases.get_mut(&view.retained_view_entity) else {
            continue;
        };
        phase.add(
            Opaque3dBatchSetKey {
                draw_function,
                pipeline: pipeline.0,
                material_bind_group_index: None,
                lightmap_slab: None,
                slabs: default(),
            },
            Opaque3dBinKey {
                asset_id: AssetId::<Mesh>::default().untyped(),
            },
            (entity, *main_entity),
            InputUniformIndex::default(),
            BinnedRenderPhaseType::NonMesh,
        );
    }
}

#[test]
fn an_item_of_a_fixed_format_keeps_bevys_format_and_is_named() {
    let _gpu = gpu();
    let mut studio = Studio::new(|app| {
        hdr_scene(app);
        app.sub_app_mut(RenderApp)
            .add_render_command::<Opaque3d, DrawCustom>()
            .add_systems(RenderStartup, queue_item_pipeline)
            .add_systems(Render, queue_item.in_set(RenderSystems::Queue));
    });
    studio.mode(true, Msaa::Off);
    for quality in [Quality::Compact, packing()] {
        let (Reason::FixedFormat(name) | Reason::UnpackedPipeline(name)) = studio.fallback(quality)
        else {
            panic!("{:?}", studio.state());
        };
        assert!(name.contains("fixed_item"), "{name}");
    }
}
