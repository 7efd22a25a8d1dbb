//! Deferred lighting with diffuse and specular light in one target (thesis 4.8, figure 4.12).
//!
//! A red and a green light shine onto a ball and a floor. Each light is drawn over the whole screen
//! and adds its light, as in a deferred renderer; then the surface is lit with the sums. Before:
//! diffuse and specular light in a target each. After: both in one, packed in two channels each; or
//! the usual shortcut, which keeps the luminance of specular light only: diffuse light is yellow
//! where both lights shine, so both highlights turn yellow.

use bevy::{
    asset::embedded_asset,
    camera::Hdr,
    core_pipeline::schedule::{Core3d, Core3dSystems},
    prelude::*,
    render::{
        Render, RenderApp, RenderStartup, RenderSystems,
        extract_component::{ExtractComponent, ExtractComponentPlugin},
        extract_resource::{ExtractResource, ExtractResourcePlugin},
        render_resource::{ShaderType, UniformBuffer},
        renderer::{RenderDevice, RenderQueue},
    },
    shader::load_shader_library,
};
use bevy_ycocg_fb::YCoCgFrameBufferPlugin;

use crate::runner::{MemoryFigures, PictureArea, Scene, SceneSetting, SceneSettings, Side};

mod pass;
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
            SceneSetting::choice(
                "method",
                "how one target holds both kinds of light",
                0,
                &["packed", "specular_luminance"],
            ),
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
    let after = match settings.choice("method") {
        "specular_luminance" => LightAccumulation::SpecularLuminance,
        _ => LightAccumulation::Packed,
    };
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
        let name = match side {
            Side::Before => "accumulated light before",
            Side::After => "accumulated light after",
        };
        let bytes = pixels * way.bytes_per_pixel();
        if memory.0.get(name) != Some(&bytes) {
            memory.0.insert(name.into(), bytes);
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
        load_shader_library!(app, "packing.wesl");
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
            .add_systems(RenderStartup, pass::init)
            .add_systems(
                Render,
                (prepare, pass::prepare_targets).in_set(RenderSystems::PrepareResources),
            )
            .add_systems(
                Core3d,
                pass::accumulate
                    .after(Core3dSystems::MainPass)
                    .before(Core3dSystems::EarlyPostProcess),
            );
    }
}

/// The uniform buffer of lights in `light.wesl`.
#[derive(Clone, Default, ShaderType)]
pub struct SourcesUniform {
    sources: [LightSource; MAX_SOURCES],
}

/// The lights' buffer and their number.
#[derive(Resource, Default)]
pub struct SourcesBuffer {
    /// All of them; unused ones are dark.
    pub buffer: UniformBuffer<SourcesUniform>,
    /// How many to draw.
    pub count: u32,
}

pub fn prepare(
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
