//! Reports on the state of each camera and the memory of its colour textures.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bevy::{ecs::entity::EntityHashMap, platform::collections::HashSet, prelude::*};

use crate::{
    fallback::FallbackReason,
    settings::{DefaultFrameBufferQuality, FrameBufferFormat, FrameBufferQuality, PackedFormat},
};

/// What became of a camera's [`FrameBufferQuality`] in the last frame that was drawn. Component of every camera
/// with a quality, which the plugin adds and updates before `Update`.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub struct FrameBufferReport {
    /// How the camera is drawn.
    pub state: CameraState,
    /// The formats that were preferred to that of `state`, in the order of preference, and why they are not used.
    pub refused: Vec<RefusedFormat>,
    /// Memory of the camera's colour textures.
    pub memory: ColorMemory,
}

/// How a camera is drawn.
#[derive(Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[reflect(Default, Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum CameraState {
    /// No frame has been drawn yet, or Bevy's shaders are still loading.
    #[default]
    Pending,
    /// The camera has Bevy's format, as it should have, or draws no colours (`RenderTarget::None`).
    Exact,
    /// The camera draws packed colours in this format.
    Packed(PackedFormat),
    /// Bevy's passes draw the camera in [`FrameBufferFormat::Rg11b10Ufloat`].
    Rg11b10Ufloat,
    /// The camera has Bevy's format because it cannot use any of its quality, the last one for this reason.
    Fallback(FallbackReason),
}

/// A format that a camera cannot use.
#[derive(Reflect, Clone, Debug, PartialEq, Eq)]
#[reflect(Debug, Clone, PartialEq)]
pub struct RefusedFormat {
    /// The format.
    pub format: FrameBufferFormat,
    /// Why the camera cannot use it.
    pub reason: FallbackReason,
}

/// Memory of the colour textures that a camera draws to, in bytes as allocated. Cameras with the same
/// target share the textures.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub struct ColorMemory {
    /// Bytes of the packed texture with one sample per pixel.
    pub packed: u64,
    /// Bytes of the multisampled packed texture; 0 where it stays in the tile memory of the GPU.
    pub packed_multisampled: u64,
    /// Bytes of Bevy's two main textures.
    pub main: u64,
    /// Bytes of Bevy's multisampled main texture.
    pub main_multisampled: u64,
}

impl ColorMemory {
    /// Returns the sum of all textures in bytes.
    pub fn total(self) -> u64 {
        self.packed + self.packed_multisampled + self.main + self.main_multisampled
    }
}

/// Message that the state of a camera's [`FrameBufferReport`] has changed.
#[derive(Message, Clone, Debug, PartialEq, Eq)]
pub struct FrameBufferChanged {
    /// The camera.
    pub camera: Entity,
    /// Its new state.
    pub state: CameraState,
}

/// The reports of the last frame, by camera in the main world. The render world replaces them as a whole, so that
/// the main world never sees those of half a frame.
#[derive(Resource, Clone, Debug, Default)]
pub(crate) struct RenderedReports(Arc<Mutex<EntityHashMap<FrameBufferReport>>>);

impl RenderedReports {
    pub(crate) fn publish(&self, reports: EntityHashMap<FrameBufferReport>) {
        *self.lock() = reports;
    }

    fn lock(&self) -> MutexGuard<'_, EntityHashMap<FrameBufferReport>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Adds the components and the message.
pub(crate) struct ReportPlugin;

impl Plugin for ReportPlugin {
    fn build(&self, app: &mut App) {
        app.register_required_components::<FrameBufferQuality, FrameBufferReport>()
            .register_type::<FrameBufferReport>()
            .add_message::<FrameBufferChanged>()
            .init_resource::<RenderedReports>()
            .add_systems(First, (require_reports, update_reports).chain());
    }
}

/// Gives a report to cameras that have the quality of the app, and takes it from those without any.
fn require_reports(
    mut commands: Commands,
    default: Option<Res<DefaultFrameBufferQuality>>,
    missing: Query<Entity, (With<Camera3d>, Without<FrameBufferReport>)>,
    unused: Query<Entity, (With<FrameBufferReport>, Without<FrameBufferQuality>)>,
) {
    if default.is_some() {
        for camera in &missing {
            commands.entity(camera).insert(FrameBufferReport::default());
        }
    } else {
        for camera in &unused {
            commands.entity(camera).remove::<FrameBufferReport>();
        }
    }
}

fn update_reports(
    mut cameras: Query<(Entity, Option<&Name>, &mut FrameBufferReport)>,
    rendered: Res<RenderedReports>,
    mut changes: MessageWriter<FrameBufferChanged>,
    mut logged: Local<HashSet<(Entity, FallbackReason)>>,
) {
    if cameras.is_empty() {
        return;
    }
    let rendered = rendered.lock();
    for (camera, name, mut report) in &mut cameras {
        let Some(new) = rendered.get(&camera).filter(|&new| *new != *report) else {
            continue;
        };
        if new.state != report.state {
            changes.write(FrameBufferChanged {
                camera,
                state: new.state.clone(),
            });
            if let CameraState::Fallback(reason) = &new.state
                && logged.insert((camera, reason.clone()))
            {
                let name = name.map_or_else(|| camera.to_string(), |name| format!("`{name}`"));
                warn!("camera {name} does not use its FrameBufferQuality: {reason}");
            }
        }
        *report = new.clone();
    }
}
