//! Building a headless app by its settings, and running its frames.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::atomic::{AtomicBool, Ordering},
    time::{Duration, Instant},
};

use bevy::{
    app::{App, PluginGroup, TerminalCtrlCHandlerPlugin},
    asset::UntypedHandle,
    camera::{ImageRenderTarget, RenderTarget, ScalingMode},
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    ecs::{
        resource::Resource,
        schedule::{Schedules, SingleThreadedExecutor},
    },
    light::{DirectionalLightShadowMap, PointLightShadowMap},
    log::LogPlugin,
    prelude::*,
    render::{
        RenderPlugin,
        diagnostic::RenderDiagnosticsPlugin,
        error_handler::{RenderErrorHandler, RenderErrorPolicy},
        pipelined_rendering::PipelinedRenderingPlugin,
        render_resource::{TextureFormat, TextureUsages},
        renderer::{RenderAdapterInfo, RenderDevice},
    },
    time::TimeUpdateStrategy,
    window::{ExitCondition, WindowRef},
    winit::WinitPlugin,
};

use crate::headless::{AdapterInfo, FrameTimes, HeadlessError, frames::FrameClock, wgpu_settings};

/// The error with which the renderer stopped.
#[derive(Resource)]
struct RendererStopped(String);

/// A Bevy app that renders into an image.
pub struct HeadlessApp {
    pub(super) app: App,
    pub(super) target: Handle<Image>,
    pub(super) settings: HeadlessSettings,
    adapter: AdapterInfo,
}

impl HeadlessApp {
    /// Builds the app; `build` adds the plugins and the scene.
    ///
    /// `build` finds [`LabTarget`] in the world, the target of its cameras, and may register
    /// assets to wait for in [`AwaitedAssets`].
    pub fn new(
        settings: HeadlessSettings,
        build: impl FnOnce(&mut App),
    ) -> Result<Self, HeadlessError> {
        let wgpu_settings = wgpu_settings(&settings)?;
        let mut app = App::new();
        app.add_plugins(
            DefaultPlugins
                .set(WindowPlugin {
                    primary_window: None,
                    exit_condition: ExitCondition::DontExit,
                    ..default()
                })
                .set(RenderPlugin {
                    render_creation: wgpu_settings.into(),
                    synchronous_pipeline_compilation: !settings.compiles_in_background,
                    ..default()
                })
                .set(AssetPlugin {
                    file_path: settings.asset_folder.clone(),
                    watch_for_changes_override: Some(false),
                    ..default()
                })
                .disable::<WinitPlugin>()
                .disable::<PipelinedRenderingPlugin>()
                .disable::<TerminalCtrlCHandlerPlugin>()
                // Errors come back as values; a process can install one logger only.
                .disable::<LogPlugin>(),
        )
        .add_plugins(RenderDiagnosticsPlugin)
        .insert_resource(RenderErrorHandler(|error, world, _| {
            world.insert_resource(RendererStopped(error.description.clone()));
            RenderErrorPolicy::StopRendering
        }))
        .insert_resource(TimeUpdateStrategy::ManualDuration(settings.time_step))
        .insert_resource(DirectionalLightShadowMap {
            size: shadow_map_size(&settings),
        })
        .insert_resource(PointLightShadowMap {
            size: shadow_map_size(&settings) / 2,
        })
        .init_resource::<AwaitedAssets>()
        .init_resource::<AwaitedWork>();

        let target = add_target(&mut app, &settings);
        app.insert_resource(LabTarget(RenderTarget::Image(ImageRenderTarget::from(
            target.clone(),
        ))));
        build(&mut app);
        app.finish();
        app.cleanup();
        apply_threads(&mut app);
        let adapter = AdapterInfo::from(&**app.world().resource::<RenderAdapterInfo>());
        Ok(Self {
            app,
            target,
            settings,
            adapter,
        })
    }

    /// The adapter that renders.
    pub fn adapter(&self) -> &AdapterInfo {
        &self.adapter
    }

    pub fn settings(&self) -> &HeadlessSettings {
        &self.settings
    }

    /// The features of the device: those of the adapter without the disabled ones.
    pub fn features(&self) -> wgpu::Features {
        self.app.world().resource::<RenderDevice>().features()
    }

    pub fn world(&self) -> &World {
        self.app.world()
    }

    /// The world of the scene, to change it between frames.
    pub fn world_mut(&mut self) -> &mut World {
        self.app.world_mut()
    }

    /// Loads an asset, for which [`run_until_ready`](Self::run_until_ready) waits.
    pub fn load<A: Asset>(&mut self, path: &str) -> Handle<A> {
        let handle = self.app.world().load_asset(path.to_owned());
        self.await_asset(&handle);
        handle
    }

    /// Has [`run_until_ready`](Self::run_until_ready) wait for an asset that is loading.
    pub fn await_asset<A: Asset>(&mut self, handle: &Handle<A>) {
        let mut awaited = self.app.world_mut().resource_mut::<AwaitedAssets>();
        awaited.0.push(handle.clone().untyped());
    }

    /// The app itself, for its sub-apps.
    pub fn app_mut(&mut self) -> &mut App {
        &mut self.app
    }

    /// Renders `count` frames and waits for the GPU after each.
    pub fn render_frames(&mut self, count: u32) -> Result<(), HeadlessError> {
        for _ in 0..count {
            self.render_frame()?;
        }
        self.check_pipelines()
    }

    /// Renders `count` frames and gives the median of their times.
    pub fn measure_frames(&mut self, count: u32) -> Result<FrameTimes, HeadlessError> {
        Ok(self.measure_spans(count)?.0)
    }

    /// The same, and the median time on the GPU in milliseconds of each top-level span by name.
    pub fn measure_spans(
        &mut self,
        count: u32,
    ) -> Result<(FrameTimes, BTreeMap<String, f64>), HeadlessError> {
        let mut clock = FrameClock::starting_now(self.app.world());
        for _ in 0..count {
            let cpu = self.render_frame()?;
            clock.record(cpu, self.app.world());
        }
        self.check_pipelines()?;
        Ok((clock.medians(), clock.span_medians()))
    }

    /// One frame; the time that the CPU took for it, without the wait for the GPU.
    pub(super) fn render_frame(&mut self) -> Result<Duration, HeadlessError> {
        let start = Instant::now();
        self.app.update();
        let cpu = start.elapsed();
        self.wait_for_gpu()?;
        match self.app.world().get_resource::<RendererStopped>() {
            Some(RendererStopped(error)) => Err(HeadlessError::Renderer {
                error: error.clone(),
            }),
            None => Ok(cpu),
        }
    }

    pub(super) fn wait_for_gpu(&self) -> Result<(), HeadlessError> {
        let device = self.app.world().resource::<RenderDevice>();
        let wait = wgpu::PollType::Wait {
            submission_index: None,
            timeout: Some(self.settings.gpu_timeout),
        };
        match device.poll(wait) {
            Ok(_) => Ok(()),
            Err(error) => Err(self.readback_error(error)),
        }
    }

    pub(super) fn readback_error(&self, error: impl ToString) -> HeadlessError {
        HeadlessError::Readback {
            seconds: self.settings.gpu_timeout.as_secs_f32(),
            error: error.to_string(),
        }
    }
}

/// Two texels of a shadow map for each pixel along the picture's longer edge, and no more than Bevy's own: on
/// a software driver shadow maps take most of the time of a small picture.
fn shadow_map_size(settings: &HeadlessSettings) -> usize {
    let longest = settings.width.max(settings.height) as usize;
    let default = DirectionalLightShadowMap::default().size;
    (2 * longest).next_power_of_two().clamp(256, default)
}

fn add_target(app: &mut App, settings: &HeadlessSettings) -> Handle<Image> {
    let mut image = Image::new_target_texture(
        settings.width,
        settings.height,
        settings.format.texture_format(),
        None,
    );
    image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
    app.world_mut().add_asset(image)
}

/// Pixel format of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TargetFormat {
    /// Eight bits a channel, sRGB encoded: what a display would show.
    #[default]
    Srgb8,
    /// 32-bit floats, linear. The scene decides on tone mapping.
    Float32,
    /// 16-bit floats, linear. The scene decides on tone mapping.
    Float16,
}

impl TargetFormat {
    pub fn texture_format(self) -> TextureFormat {
        match self {
            Self::Srgb8 => TextureFormat::Rgba8UnormSrgb,
            Self::Float32 => TextureFormat::Rgba32Float,
            Self::Float16 => TextureFormat::Rgba16Float,
        }
    }
}

/// Settings of a [`HeadlessApp`].
#[derive(Clone, Debug)]
pub struct HeadlessSettings {
    /// Width of the picture in pixels, 1 to the adapter's limit. Default 640.
    pub width: u32,
    /// Height of the picture in pixels, 1 to the adapter's limit. Default 360.
    pub height: u32,
    /// Pixel format of the picture. Default [`TargetFormat::Srgb8`].
    pub format: TargetFormat,
    /// Part of the adapter's name, in any case. Default none: the fastest adapter. The
    /// environment variable `WGPU_ADAPTER_NAME` has precedence, as in Bevy.
    pub adapter_name: Option<String>,
    /// Features that the device must not have even if the adapter does, to test fall-backs.
    /// Default none.
    pub disabled_features: wgpu::Features,
    /// Limits that the device must not exceed even if the adapter does. Default none.
    pub constrained_limits: Option<wgpu::Limits>,
    /// Time between two frames as the scene sees it. Default 1/60 s.
    pub time_step: Duration,
    /// Longest wait for the GPU to finish a frame. Default 60 s.
    pub gpu_timeout: Duration,
    /// Whether pipelines compile in the background while frames go on, as in a game. Default `false`: a frame waits
    /// for what it needs.
    pub compiles_in_background: bool,
    /// Folder of the assets, absolute or relative to the package. Default `assets`.
    pub asset_folder: String,
}

impl Default for HeadlessSettings {
    fn default() -> Self {
        Self {
            width: 640,
            height: 360,
            format: TargetFormat::default(),
            adapter_name: None,
            disabled_features: wgpu::Features::empty(),
            constrained_limits: None,
            time_step: Duration::from_nanos(1_000_000_000 / 60),
            gpu_timeout: Duration::from_secs(60),
            compiles_in_background: false,
            asset_folder: "assets".into(),
        }
    }
}

impl HeadlessSettings {
    /// Default settings with a picture of `width` by `height` pixels.
    pub fn with_size(width: u32, height: u32) -> Self {
        Self {
            width,
            height,
            ..Self::default()
        }
    }

    /// The same with a picture in this format.
    pub fn in_format(self, format: TargetFormat) -> Self {
        Self { format, ..self }
    }
}

/// The render target for the cameras of a scene, so that one scene serves a window and headless.
///
/// A camera is spawned with `target.0.clone()` as one of its components.
#[derive(Resource, Clone, Debug)]
pub struct LabTarget(pub RenderTarget);

impl LabTarget {
    pub fn window() -> Self {
        Self(RenderTarget::Window(WindowRef::Primary))
    }
}

/// A camera that sees a rectangle of `size` units around the origin, from +Z, pixel by pixel:
/// orthographic, without multisampling, tone mapping and dithering.
pub fn pixel_camera(target: &LabTarget, [width, height]: [u32; 2]) -> impl Bundle {
    let scaling_mode = ScalingMode::Fixed {
        width: width as f32,
        height: height as f32,
    };
    (
        Camera3d::default(),
        target.0.clone(),
        Msaa::Off,
        Tonemapping::None,
        DebandDither::Disabled,
        Projection::from(OrthographicProjection {
            scaling_mode,
            ..OrthographicProjection::default_3d()
        }),
        Transform::from_xyz(0.0, 0.0, 10.0),
    )
}

/// The assets that a scene needs before its picture is meaningful.
#[derive(Resource, Clone, Debug, Default)]
pub struct AwaitedAssets(pub Vec<UntypedHandle>);

/// What a scene is still computing before its picture is meaningful, by name; the scene adds and
/// removes it. None of it may depend on what the cameras draw; see [`Unwatched`].
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct AwaitedWork(pub BTreeSet<&'static str>);

/// Present while a headless app waits until its scene is ready. Cameras may draw one pixel then as long as there
/// is [`AwaitedWork`]: on a software driver a frame's time is that of its pixels.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct Unwatched;

static ONE_THREAD: AtomicBool = AtomicBool::new(false);

/// Whether apps that are built from now on run their systems one after the other, each app on the thread that updates
/// it. Bevy's own way, and the default, is one pool of threads for the whole process: where several apps share it, a
/// frame of one waits for systems of the others.
pub fn use_one_thread(one: bool) {
    ONE_THREAD.store(one, Ordering::Relaxed);
}

/// Prepares the schedules of a built app.
fn apply_threads(app: &mut App) {
    if !ONE_THREAD.load(Ordering::Relaxed) {
        return;
    }
    for sub_app in app.sub_apps_mut().iter_mut() {
        let Some(mut schedules) = sub_app.world_mut().get_resource_mut::<Schedules>() else {
            continue;
        };
        for (_, schedule) in schedules.iter_mut() {
            schedule.set_executor(SingleThreadedExecutor::new());
        }
    }
}
