//! Where the cameras of a scene draw to.

use bevy::{camera::RenderTarget, ecs::resource::Resource, window::WindowRef};

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
