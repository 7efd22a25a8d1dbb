//! Reports on the state of each camera and the memory of its colour textures.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bevy::{ecs::entity::EntityHashMap, prelude::*};

use crate::fallback::FallbackReason;

/// Reports on the state of each camera with a [`YCoCgFrameBuffer`](crate::YCoCgFrameBuffer) and on the
/// memory of all cameras, in the last rendered frame.
#[derive(Resource, Clone, Debug, Default)]
pub struct FrameBufferReports(Arc<Mutex<EntityHashMap<CameraReport>>>);

/// The report on one camera.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CameraReport {
    /// Whether the camera uses its format; `None` without the component, and until Bevy's shaders are loaded.
    pub state: Option<CameraState>,
    /// Memory of the camera's colour textures.
    pub memory: ColorMemory,
}

/// The state of a camera with a [`YCoCgFrameBuffer`](crate::YCoCgFrameBuffer).
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CameraState {
    /// The camera draws packed colours.
    Packed,
    /// Bevy's passes draw the camera in [`FrameBufferFormat::Rg11b10Ufloat`](crate::FrameBufferFormat).
    Rg11b10Ufloat,
    /// The camera draws as without the component, for this reason.
    Fallback(FallbackReason),
}

/// Memory of the colour textures that a camera draws to, in bytes as allocated. Cameras with the same
/// target share the textures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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

impl FrameBufferReports {
    /// Returns the report on a camera, by its entity in the main world.
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
