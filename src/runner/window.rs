//! A scene in a window: its panel with settings and figures, and the split line.

use std::{
    collections::BTreeMap,
    sync::{Arc, Mutex},
    time::Duration,
};

use bevy::{
    camera::{CameraOutputMode, visibility::RenderLayers},
    camera_controller::free_camera::{FreeCamera, FreeCameraPlugin},
    ecs::system::SystemParam,
    prelude::*,
    render::{RenderPlugin, diagnostic::RenderDiagnosticsPlugin, render_resource::BlendState},
    window::PrimaryWindow,
};
use bevy_egui::{
    EguiContexts, EguiGlobalSettings, EguiPlugin, EguiPrimaryContextPass, PrimaryEguiContext,
    egui::{self, Align2, Color32, CursorIcon, FontId, LayerId, Sense, Stroke, UiBuilder},
};

use crate::{
    headless::{
        AwaitedAssets, AwaitedWork, HeadlessSettings, LabTarget, frames::FrameClock, wgpu_settings,
    },
    runner::{
        MemoryFigures, Notes, Options, PictureArea, RunError, Scene, SceneImage, SceneSettings,
        SettingKind, SettingValue, Side, Split, SplitLine, split,
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
    let wgpu_settings = wgpu_settings(&HeadlessSettings {
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
    .insert_resource(ShownScene(scene))
    .init_resource::<AwaitedAssets>()
    .init_resource::<AwaitedWork>()
    .init_resource::<MemoryFigures>()
    .init_resource::<Notes>()
    .init_resource::<LiveTimes>()
    .add_systems(Startup, spawn_panel_camera)
    .add_systems(Update, (steer_before_camera, record_times))
    .add_systems(EguiPrimaryContextPass, draw_panel);
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

/// Lets the panel offer other scenes; the chosen one is there when the window has closed.
#[derive(Resource, Clone, Debug)]
pub struct ScenePicker {
    pub names: Vec<&'static str>,
    /// The scene that the user asked for, if any.
    pub chosen: Arc<Mutex<Option<&'static str>>>,
}

#[derive(Resource, Clone, Copy)]
struct ShownScene(&'static dyn Scene);

/// The frame times of the last frames.
#[derive(Resource, Default)]
struct LiveTimes(pub FrameClock);

/// Distance from the split line at which it can be grabbed, in logical pixels.
const GRAB: f32 = 8.0;

#[derive(SystemParam)]
struct PanelData<'w> {
    scene: Res<'w, ShownScene>,
    settings: ResMut<'w, SceneSettings>,
    split: ResMut<'w, Split>,
    area: ResMut<'w, PictureArea>,
    times: Res<'w, LiveTimes>,
    memory: Res<'w, MemoryFigures>,
    notes: Res<'w, Notes>,
    line: Res<'w, SplitLine>,
    picker: Option<Res<'w, ScenePicker>>,
    exit: MessageWriter<'w, AppExit>,
}

/// Draws the panel at the right and the line in the picture area, which is what is left.
fn draw_panel(
    mut contexts: EguiContexts,
    window: Single<&Window, With<PrimaryWindow>>,
    mut data: PanelData,
) -> Result {
    let context = contexts.ctx_mut()?.clone();
    let mut root = egui::Ui::new(
        context.clone(),
        "lab_root".into(),
        UiBuilder::new()
            .layer_id(LayerId::background())
            .max_rect(context.viewport_rect()),
    );
    egui::Panel::right("lab_panel")
        .default_size(300.0)
        .show(&mut root, |ui| {
            egui::ScrollArea::vertical().show(ui, |ui| panel(ui, &mut data));
        });

    let free = root.available_rect_before_wrap();
    let scale = window.scale_factor();
    let physical = |position: egui::Pos2| {
        UVec2::new((position.x * scale) as u32, (position.y * scale) as u32)
            .min(window.physical_size())
    };
    let area = URect::from_corners(physical(free.min), physical(free.max));
    data.area.set_if_neq(PictureArea(area));
    if data.line.0 {
        split_line(&mut root, free, &mut data.split);
    }
    Ok(())
}

fn panel(ui: &mut egui::Ui, data: &mut PanelData) {
    let scene = data.scene.0;
    ui.heading(scene.name());
    ui.label(scene.description());
    ui.weak(format!("plugin: {}", scene.plugin()));
    if let Some(picker) = &data.picker {
        ui.separator();
        scenes(ui, picker, scene.name(), &mut data.exit);
    }
    ui.separator();
    // On a copy, so that only a real change counts as one.
    let mut settings = data.settings.clone();
    setting_grid(ui, &mut settings);
    data.settings.set_if_neq(settings);
    ui.separator();
    figures(ui, data);
    ui.separator();
    ui.weak("Drag the line with the left mouse button. Hold the right one to look around, fly with W A S D E Q.");
}

fn scenes(
    ui: &mut egui::Ui,
    picker: &ScenePicker,
    current: &str,
    exit: &mut MessageWriter<AppExit>,
) {
    ui.horizontal_wrapped(|ui| {
        for name in &picker.names {
            let button = ui.selectable_label(*name == current, *name);
            if button.clicked()
                && *name != current
                && let Ok(mut chosen) = picker.chosen.lock()
            {
                *chosen = Some(name);
                exit.write(AppExit::Success);
            }
        }
    });
}

fn setting_grid(ui: &mut egui::Ui, settings: &mut SceneSettings) {
    egui::Grid::new("lab_settings")
        .num_columns(2)
        .show(ui, |ui| {
            for (setting, value) in settings.iter_mut() {
                ui.label(setting.name).on_hover_text(setting.help);
                match (&setting.kind, value) {
                    (SettingKind::Float { range, unit, .. }, SettingValue::Float(value)) => {
                        ui.add(egui::Slider::new(value, range.clone()).suffix(spaced(unit)));
                    }
                    (SettingKind::Integer { range, unit, .. }, SettingValue::Integer(value)) => {
                        ui.add(egui::Slider::new(value, range.clone()).suffix(spaced(unit)));
                    }
                    (SettingKind::Choice { names, .. }, SettingValue::Choice(value)) => {
                        egui::ComboBox::from_id_salt(setting.name)
                            .selected_text(*value)
                            .show_ui(ui, |ui| {
                                for name in *names {
                                    ui.selectable_value(value, *name, *name);
                                }
                            });
                    }
                    (_, SettingValue::Toggle(value)) => {
                        ui.checkbox(value, "");
                    }
                    (kind, value) => {
                        ui.label(format!("{value:?} does not fit {kind:?}"));
                    }
                }
                ui.end_row();
            }
        });
}

fn figures(ui: &mut egui::Ui, data: &PanelData) {
    let times = data.times.0.medians();
    let ms = |time: Option<f64>| match time {
        Some(ms) => format!("{ms:.2} ms"),
        None => "unknown".into(),
    };
    egui::Grid::new("lab_figures")
        .num_columns(2)
        .show(ui, |ui| {
            let mut row = |name: &str, value: String| {
                ui.label(name);
                ui.monospace(value);
                ui.end_row();
            };
            row("frame", ms(times.cpu_ms));
            row("GPU", ms(times.gpu_ms));
        });
    memory_table(ui, &data.memory);
    for (name, text) in &data.notes.0 {
        ui.horizontal_wrapped(|ui| {
            ui.strong(name);
            ui.label(text);
        });
    }
}

fn split_line(ui: &mut egui::Ui, area: egui::Rect, split: &mut ResMut<Split>) {
    let x = area.left() + area.width() * split.position;
    let grab = egui::Rect::from_x_y_ranges(x - GRAB..=x + GRAB, area.y_range()).intersect(area);
    let line = ui
        .interact(grab, "lab_split".into(), Sense::drag())
        .on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
    if line.dragged()
        && let Some(pointer) = line.interact_pointer_pos()
    {
        let position = (pointer.x - area.left()) / area.width().max(1.0);
        split.set_if_neq(Split {
            position: position.clamp(0.0, 1.0),
        });
    }
    let painter = ui.painter();
    let stroke = |width, color| Stroke::new(width, color);
    painter.vline(
        x,
        area.y_range(),
        stroke(3.0, Color32::from_black_alpha(160)),
    );
    painter.vline(x, area.y_range(), stroke(1.0, Color32::WHITE));
    for (name, align, offset) in [
        ("before", Align2::RIGHT_TOP, -GRAB),
        ("after", Align2::LEFT_TOP, GRAB),
    ] {
        let at = egui::pos2(x + offset, area.top() + GRAB);
        let font = FontId::proportional(16.0);
        for (shift, color) in [(1.0, Color32::BLACK), (0.0, Color32::WHITE)] {
            let at = at + egui::Vec2::splat(shift);
            painter.text(at, align, name, font.clone(), color);
        }
    }
}

/// A unit to put after a number.
fn spaced(unit: &str) -> String {
    if unit.is_empty() {
        String::new()
    } else {
        format!(" {unit}")
    }
}

/// Draws a row a name, with the figures of before and after beside each other.
fn memory_table(ui: &mut egui::Ui, figures: &MemoryFigures) {
    if figures.0.is_empty() {
        return;
    }
    egui::Grid::new("lab_memory")
        .num_columns(3)
        .striped(true)
        .show(ui, |ui| {
            for heading in ["memory", "before", "after"] {
                ui.strong(heading);
            }
            ui.end_row();
            for (name, sides) in rows(figures) {
                ui.label(name);
                for bytes in sides {
                    ui.monospace(bytes.map(text).unwrap_or_default());
                }
                ui.end_row();
            }
        });
}

/// Names with the bytes before and after; a name without a side stands in the first column.
pub fn rows(figures: &MemoryFigures) -> BTreeMap<&str, [Option<u64>; 2]> {
    let mut rows = BTreeMap::<&str, [Option<u64>; 2]>::new();
    for (name, &bytes) in &figures.0 {
        let (name, column) = match name.strip_suffix(" after") {
            Some(name) => (name, 1),
            None => (name.strip_suffix(" before").unwrap_or(name), 0),
        };
        rows.entry(name).or_default()[column] = Some(bytes);
    }
    rows
}

/// In KiB below one MiB, else in MiB.
pub fn text(bytes: u64) -> String {
    let kib = bytes as f64 / 1024.0;
    if kib < 1024.0 {
        format!("{kib:.1} KiB")
    } else {
        format!("{:.2} MiB", kib / 1024.0)
    }
}
