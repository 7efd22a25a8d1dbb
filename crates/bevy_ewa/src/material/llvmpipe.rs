//! Detection of Mesa's llvmpipe, which needs workarounds.

use std::sync::atomic::{AtomicBool, Ordering};

use bevy::render::renderer::RenderAdapterInfo;

/// It is global to the process, because pipeline keys and hooks have no access to a world.
static IS_LLVMPIPE: AtomicBool = AtomicBool::new(false);

/// Whether the adapter is llvmpipe.
pub(super) fn is_llvmpipe() -> bool {
    IS_LLVMPIPE.load(Ordering::Relaxed)
}

/// Sets the adapter, when the renderer has chosen it.
pub(super) fn detect(adapter: &RenderAdapterInfo) {
    IS_LLVMPIPE.store(adapter.name.contains("llvmpipe"), Ordering::Relaxed);
}
