//! Deferred lighting with diffuse and specular light in one target (thesis 4.8, figure 4.12).
//!
//! A red and a green light shine onto a ball and a floor. Each light is drawn over the whole screen
//! and adds its light, as in a deferred renderer; then the surface is lit with the sums. Before:
//! diffuse and specular light in a target each. After: both in one, packed in two channels each; or
//! the usual shortcut, which keeps the luminance of specular light only: diffuse light is yellow
//! where both lights shine, so both highlights turn yellow.

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    camera::Hdr,
    core_pipeline::{
        FullscreenShader,
        schedule::{Core3d, Core3dSystems},
    },
    mesh::VertexBufferLayout,
    platform::collections::HashMap,
    prelude::*,
    render::{
        Render, RenderApp, RenderStartup, RenderSystems,
        camera::ExtractedCamera,
        diagnostic::RecordDiagnostics,
        extract_component::{ExtractComponent, ExtractComponentPlugin},
        extract_resource::{ExtractResource, ExtractResourcePlugin},
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries,
            BlendComponent, BlendFactor, BlendOperation, BlendState, CachedRenderPipelineId,
            ColorTargetState, ColorWrites, FragmentState, LoadOp, Operations, PipelineCache,
            RenderPassColorAttachment, RenderPassDescriptor, RenderPipelineDescriptor,
            ShaderStages, ShaderType, StoreOp, TextureDescriptor, TextureDimension, TextureFormat,
            TextureSampleType, TextureUsages, UniformBuffer, VertexState,
            binding_types::{texture_2d, uniform_buffer},
        },
        renderer::{RenderContext, RenderDevice, RenderQueue, ViewQuery},
        texture::{CachedTexture, TextureCache},
        view::{ViewTarget, ViewUniform, ViewUniformOffset, ViewUniforms},
    },
    shader::{ShaderDefVal, load_shader_library},
};
use bevy_ycocg_fb::YCoCgFrameBufferPlugin;

use crate::runner::{Choice, MemoryFigures, PictureArea, Scene, SceneSetting, SceneSettings, Side};

pub mod reference;

pub struct DeferredAccumulation;

impl Scene for DeferredAccumulation {
    fn name(&self) -> &'static str {
        "deferred_accumulation"
    }

    fn plugin(&self) -> &'static str {
        "bevy_ycocg_fb"
    }

    fn description(&self) -> &'static str {
        "A red and a green light: diffuse and specular light in two targets before, in one after"
    }

    fn settings(&self) -> Vec<SceneSetting> {
        vec![
            METHOD.setting(),
            SceneSetting::float(
                "light_distance",
                "half the distance between the lights",
                LIGHT_DISTANCE,
                0.1..=4.0,
                "m",
            ),
        ]
    }

    fn view(&self) -> Transform {
        Transform::from_xyz(0.0, 1.25, 2.3).looking_at(Vec3::new(0.0, 0.5, 0.0), Vec3::Y)
    }

    fn build(&self, app: &mut App) {
        app.add_plugins(LightAccumulationPlugin)
            .insert_resource(ClearColor(Color::BLACK))
            .add_systems(
                Update,
                apply_settings.run_if(resource_changed::<SceneSettings>),
            )
            .add_systems(Update, count_memory);
    }

    fn configure_camera(&self, camera: &mut EntityCommands, side: Side) {
        let way = match side {
            Side::Before => LightAccumulation::Exact,
            Side::After => LightAccumulation::Packed,
        };
        camera.insert((way, Msaa::Off));
    }
}

static METHOD: Choice<LightAccumulation, 2> = Choice::new(
    "method",
    "how one target holds both kinds of light",
    0,
    [
        ("packed", LightAccumulation::Packed),
        ("specular_luminance", LightAccumulation::SpecularLuminance),
    ],
);

/// Half the distance between the lights at the start, in metres.
pub const LIGHT_DISTANCE: f32 = 1.5;

/// A red and a green light above and before the ball.
pub fn sources(distance: f32) -> LightSources {
    let source = |x: f32, intensity: Vec3| LightSource {
        position: Vec3::new(x, 2.2, 1.6),
        intensity,
    };
    LightSources(vec![
        source(-distance, Vec3::new(6.0, 0.15, 0.1)),
        source(distance, Vec3::new(0.15, 4.5, 0.2)),
    ])
}

fn apply_settings(
    settings: Res<SceneSettings>,
    mut shown: ResMut<LightSources>,
    mut cameras: Query<(&Side, &mut LightAccumulation)>,
) {
    *shown = sources(settings.float("light_distance"));
    let after = METHOD.of(&settings);
    for (side, mut way) in &mut cameras {
        if *side == Side::After {
            way.set_if_neq(after);
        }
    }
}

fn count_memory(
    area: Res<PictureArea>,
    mut memory: ResMut<MemoryFigures>,
    cameras: Query<(&Side, &LightAccumulation)>,
) {
    let pixels = u64::from(area.0.width()) * u64::from(area.0.height());
    for (side, way) in &cameras {
        let name = format!("accumulated light {}", side.name());
        let bytes = pixels * way.bytes_per_pixel();
        if memory.0.get(&name) != Some(&bytes) {
            memory.0.insert(name, bytes);
        }
    }
}

/// Largest number of lights; those beyond it are ignored.
pub const MAX_SOURCES: usize = 8;

/// How a camera accumulates the light of the lights before it lights the surface with it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Hash, ExtractComponent)]
#[extract_app(RenderApp)]
#[require(Hdr)]
pub enum LightAccumulation {
    /// Diffuse and specular light in a target each: 16 bytes a pixel.
    Exact,
    /// Both in one target, each as luminance and one chrominance in a checkerboard: 8 bytes a pixel.
    #[default]
    Packed,
    /// Diffuse light and the luminance of specular light in one target: 8 bytes a pixel, and
    /// highlights in the colour of the diffuse light (the shortcut of thesis figure 4.12).
    SpecularLuminance,
}

impl LightAccumulation {
    pub const ALL: [Self; 3] = [Self::Exact, Self::Packed, Self::SpecularLuminance];

    /// Number of four-channel targets.
    pub fn targets(self) -> usize {
        match self {
            Self::Exact => 2,
            Self::Packed | Self::SpecularLuminance => 1,
        }
    }

    /// Bytes of all its targets, a pixel.
    pub fn bytes_per_pixel(self) -> u64 {
        8 * self.targets() as u64
    }
}

/// A light without extent.
#[derive(Clone, Copy, Debug, Default, PartialEq, ShaderType)]
pub struct LightSource {
    /// Position in metres.
    pub position: Vec3,
    /// Scene-linear light at a distance of one metre.
    pub intensity: Vec3,
}

/// The lights, [`MAX_SOURCES`] at most. Default: none.
#[derive(Resource, Clone, Debug, Default, PartialEq, ExtractResource)]
#[extract_app(RenderApp)]
pub struct LightSources(pub Vec<LightSource>);

/// Lights the ball for cameras with a [`LightAccumulation`], with the [`LightSources`].
pub struct LightAccumulationPlugin;

impl Plugin for LightAccumulationPlugin {
    fn build(&self, app: &mut App) {
        // For its shader library.
        if !app.is_plugin_added::<YCoCgFrameBufferPlugin>() {
            app.add_plugins(YCoCgFrameBufferPlugin);
        }
        load_shader_library!(app, "surface.wesl");
        embedded_asset!(app, "light.wesl");
        embedded_asset!(app, "combine.wesl");
        app.init_resource::<LightSources>().add_plugins((
            ExtractComponentPlugin::<LightAccumulation>::default(),
            ExtractResourcePlugin::<LightSources>::default(),
        ));
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .init_resource::<SourcesBuffer>()
            .add_systems(RenderStartup, init)
            .add_systems(
                Render,
                (prepare, prepare_targets).in_set(RenderSystems::PrepareResources),
            )
            .add_systems(
                Core3d,
                accumulate
                    .after(Core3dSystems::MainPass)
                    .before(Core3dSystems::EarlyPostProcess),
            );
    }
}

/// The uniform buffer of lights in `light.wesl`.
#[derive(Clone, Default, ShaderType)]
struct SourcesUniform {
    sources: [LightSource; MAX_SOURCES],
}

/// The lights' buffer and their number.
#[derive(Resource, Default)]
struct SourcesBuffer {
    /// All of them; unused ones are dark.
    buffer: UniformBuffer<SourcesUniform>,
    /// How many to draw.
    count: u32,
}

fn prepare(
    sources: Res<LightSources>,
    mut buffer: ResMut<SourcesBuffer>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
) {
    let shown = &sources.0[..sources.0.len().min(MAX_SOURCES)];
    let mut uniform = SourcesUniform::default();
    uniform.sources[..shown.len()].copy_from_slice(shown);
    buffer.count = shown.len() as u32;
    buffer.buffer.set(uniform);
    buffer.buffer.write_buffer(&device, &queue);
}

/// The accumulated light of a camera, one or two textures.
#[derive(Component)]
struct AccumulatedLight(Vec<CachedTexture>);

/// Gives every camera its targets, as large as its main texture.
fn prepare_targets(
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
fn accumulate(
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
const FORMAT: TextureFormat = TextureFormat::Rgba16Float;

/// The pipelines of one [`LightAccumulation`].
struct Pipelines {
    /// Adds a light, the instance.
    light: CachedRenderPipelineId,
    combine: CachedRenderPipelineId,
    combine_layout: BindGroupLayoutDescriptor,
}

#[derive(Resource)]
struct AccumulationPipelines {
    light_layout: BindGroupLayoutDescriptor,
    by_way: HashMap<LightAccumulation, Pipelines>,
}

fn init(
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
