//! What became of each camera, and what its colour textures take.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bevy::{ecs::entity::EntityHashMap, prelude::*};

use crate::view::fallback::FallbackReason;

/// What became of each camera with a [`YCoCgFrameBuffer`](crate::YCoCgFrameBuffer), and the
/// memory of all cameras, in the last frame that was rendered.
#[derive(Resource, Clone, Debug, Default)]
pub struct FrameBufferReports(Arc<Mutex<EntityHashMap<CameraReport>>>);

/// What became of one camera.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CameraReport {
    /// `None` for a camera without the component, and until Bevy's shaders are loaded.
    pub state: Option<CameraState>,
    /// Its colour textures.
    pub memory: ColorMemory,
}

/// Whether a camera packs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CameraState {
    /// It does.
    Packed,
    /// It draws as Bevy does, for this reason.
    Fallback(FallbackReason),
}

/// Bytes of the colour textures that a camera draws to, as allocated. Cameras with one target
/// share them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ColorMemory {
    /// The packed texture of one sample a pixel.
    pub packed: u64,
    /// The packed texture of several.
    pub packed_multisampled: u64,
    /// Bevy's two main textures.
    pub main: u64,
    /// Bevy's multisampled main texture.
    pub main_multisampled: u64,
}

impl ColorMemory {
    /// All of them, in bytes.
    pub fn total(self) -> u64 {
        self.packed + self.packed_multisampled + self.main + self.main_multisampled
    }
}

impl FrameBufferReports {
    /// The report on a camera, by its entity in the main world.
    pub fn get(&self, camera: Entity) -> Option<CameraReport> {
        self.lock().get(&camera).cloned()
    }

    pub(crate) fn clear(&self) {
        self.lock().clear();
    }

    pub(crate) fn set_state(&self, camera: Entity, state: CameraState) {
        self.lock().entry(camera).or_default().state = Some(state);
    }

    pub(crate) fn set_memory(&self, camera: Entity, memory: ColorMemory) {
        self.lock().entry(camera).or_default().memory = memory;
    }

    fn lock(&self) -> MutexGuard<'_, EntityHashMap<CameraReport>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
