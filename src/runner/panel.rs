//! The side panel and the split line.

use std::sync::{Arc, Mutex};

use bevy::{ecs::system::SystemParam, prelude::*, window::PrimaryWindow};
use bevy_egui::{
    EguiContexts,
    egui::{self, Align2, Color32, CursorIcon, FontId, LayerId, Sense, Stroke, UiBuilder},
};

use crate::{
    headless::frames::FrameClock,
    runner::{
        MemoryFigures, Notes, PictureArea, SceneSettings, SettingKind, SettingValue, Split,
        SplitLine, memory_table,
    },
};

/// Lets the panel offer other scenes; the chosen one is there when the window has closed.
#[derive(Resource, Clone, Debug)]
pub struct ScenePicker {
    pub names: Vec<&'static str>,
    /// The scene that the user asked for, if any.
    pub chosen: Arc<Mutex<Option<&'static str>>>,
}

/// Name, description and plugin of the scene, for the panel.
#[derive(Resource, Clone, Copy)]
pub(super) struct SceneTitle {
    pub name: &'static str,
    pub plugin: &'static str,
    pub description: &'static str,
}

/// The frame times of the last frames.
#[derive(Resource, Default)]
pub(super) struct LiveTimes(pub FrameClock);

/// Distance from the split line at which it can be grabbed, in logical pixels.
const GRAB: f32 = 8.0;

#[derive(SystemParam)]
pub(super) struct PanelData<'w> {
    title: Res<'w, SceneTitle>,
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
pub(super) fn draw(
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
    ui.heading(data.title.name);
    ui.label(data.title.description);
    ui.weak(format!("plugin: {}", data.title.plugin));
    if let Some(picker) = &data.picker {
        ui.separator();
        scenes(ui, picker, data.title.name, &mut data.exit);
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
    memory_table::draw(ui, &data.memory);
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
