//! A scene in a window, with its panel.

use std::time::Duration;

use bevy::{
    camera::{CameraOutputMode, visibility::RenderLayers},
    camera_controller::free_camera::{FreeCamera, FreeCameraPlugin},
    prelude::*,
    render::{RenderPlugin, diagnostic::RenderDiagnosticsPlugin, render_resource::BlendState},
};
use bevy_egui::{EguiGlobalSettings, EguiPlugin, EguiPrimaryContextPass, PrimaryEguiContext};

use crate::{
    headless::{AwaitedAssets, AwaitedWork, HeadlessSettings, LabTarget, adapter},
    runner::{
        MemoryFigures, Notes, Options, RunError, Scene, SceneImage, Side,
        panel::{self, LiveTimes, ScenePicker, SceneTitle},
        split,
    },
};

/// Frames over which the figures of the panel are the median.
const FRAMES: usize = 60;

/// Opens a window with `scene` and returns when the user closes it.
pub fn open(
    scene: &'static dyn Scene,
    options: &Options,
    picker: Option<ScenePicker>,
) -> Result<(), RunError> {
    let settings = options.settings(scene)?;
    let has = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    if cfg!(target_os = "linux") && !has("DISPLAY") && !has("WAYLAND_DISPLAY") {
        return Err(RunError::NoDisplay);
    }
    let wgpu_settings = adapter::wgpu_settings(&HeadlessSettings {
        adapter_name: options.adapter.clone(),
        ..HeadlessSettings::default()
    })?;
    let window = Window {
        title: format!("bevy_frugal: {}", scene.name()),
        resolution: (options.size.width, options.size.height).into(),
        ..default()
    };
    let mut app = App::new();
    app.add_plugins(
        DefaultPlugins
            .set(WindowPlugin {
                primary_window: Some(window),
                ..default()
            })
            .set(RenderPlugin {
                render_creation: wgpu_settings.into(),
                ..default()
            }),
    )
    .add_plugins((
        EguiPlugin::default(),
        FreeCameraPlugin,
        RenderDiagnosticsPlugin,
    ))
    .insert_resource(LabTarget::window())
    .insert_resource(settings)
    .insert_resource(SceneImage(options.image.clone()))
    .insert_resource(SceneTitle {
        name: scene.name(),
        plugin: scene.plugin(),
        description: scene.description(),
    })
    .init_resource::<AwaitedAssets>()
    .init_resource::<AwaitedWork>()
    .init_resource::<MemoryFigures>()
    .init_resource::<Notes>()
    .init_resource::<LiveTimes>()
    .add_systems(Startup, spawn_panel_camera)
    .add_systems(Update, (steer_before_camera, record_times))
    .add_systems(EguiPrimaryContextPass, panel::draw);
    if let Some(picker) = picker {
        app.insert_resource(picker);
    }
    split::add_cameras(&mut app, scene);
    scene.build(&mut app);
    match app.run() {
        AppExit::Success => Ok(()),
        AppExit::Error(_) => Err(RunError::Window),
    }
}

/// A camera for the panel alone, over the whole window.
fn spawn_panel_camera(mut commands: Commands, mut egui: ResMut<EguiGlobalSettings>) {
    egui.auto_create_primary_context = false;
    commands.spawn((
        PrimaryEguiContext,
        Camera2d,
        // As of the 2D cameras of scenes: Bevy gives those of one target one depth texture.
        Msaa::Off,
        RenderLayers::none(),
        Camera {
            order: 10,
            output_mode: CameraOutputMode::Write {
                blend_state: Some(BlendState::ALPHA_BLENDING),
                clear_color: ClearColorConfig::None,
            },
            clear_color: ClearColorConfig::Custom(Color::NONE),
            ..default()
        },
    ));
}

/// The right mouse button steers, as the left one drags the split line.
fn steer_before_camera(mut commands: Commands, cameras: Query<(Entity, &Side), Added<Camera>>) {
    for (entity, side) in &cameras {
        if *side == Side::Before {
            commands.entity(entity).insert(FreeCamera {
                mouse_key_cursor_grab: MouseButton::Right,
                ..default()
            });
        }
    }
}

fn record_times(world: &mut World) {
    let frame: Duration = world.resource::<Time<Real>>().delta();
    world.resource_scope(|world, mut times: Mut<LiveTimes>| {
        times.0.record(frame, world);
        times.0.keep_last(FRAMES);
    });
}
