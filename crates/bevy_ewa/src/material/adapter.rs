//! What the filter has to know of the adapter: Mesa's llvmpipe needs workarounds, and OpenGL ES and WebGL2 cannot do all.

use std::sync::atomic::{AtomicBool, Ordering};

use bevy::{
    log::warn_once,
    render::{renderer::RenderAdapterInfo, settings::Backends},
};

use crate::settings::{EwaMethod, EwaSettings};

/// It is global to the process, because pipeline keys and hooks have no access to a world.
static IS_LLVMPIPE: AtomicBool = AtomicBool::new(false);
static IS_LLVMPIPE_OLD: AtomicBool = AtomicBool::new(false);
static LACKS_LEVEL_QUERIES: AtomicBool = AtomicBool::new(false);

/// The first version of Mesa whose llvmpipe is known to compile the filter in a motion-vector prepass.
const GOOD_MESA: u32 = 25;

pub(super) fn is_llvmpipe() -> bool {
    IS_LLVMPIPE.load(Ordering::Relaxed)
}

/// Whether the adapter is an older llvmpipe: that of Mesa 22 ends the process while it compiles a motion-vector prepass
/// with the filter.
pub(super) fn is_old_llvmpipe() -> bool {
    IS_LLVMPIPE_OLD.load(Ordering::Relaxed)
}

/// The settings that the adapter can filter by. Shaders of OpenGL ES and WebGL2 cannot ask how many levels a texture
/// has, which all methods but the texture unit's need.
pub(super) fn supported(settings: EwaSettings) -> EwaSettings {
    let is_in_shader = !matches!(
        settings.method,
        EwaMethod::Anisotropic | EwaMethod::Hardware
    );
    if !is_in_shader || !LACKS_LEVEL_QUERIES.load(Ordering::Relaxed) {
        return settings;
    }
    warn_once!(
        "bevy_ewa: shaders of OpenGL and WebGL2 cannot filter by ellipses: textures get `EwaMethod::Anisotropic` \
         instead. Vulkan, Metal, Direct3D 12 and WebGPU can."
    );
    EwaSettings {
        method: EwaMethod::Anisotropic,
        sampler_anisotropy: 16,
        ..settings
    }
}

/// Says what becomes of textures whose samplers get anisotropy, where the driver is at fault.
pub(super) fn warn_of_anisotropy() {
    if is_llvmpipe() {
        warn_once!(
            "bevy_ewa: Mesa's software driver returns black where an anisotropic sampler meets texture coordinates that \
             do not change, as on models with a colour for each face. GPUs do not. For such pictures use \
             `EwaMethod::Hardware`"
        );
    }
}

/// Sets the adapter, when the renderer has chosen it.
pub(super) fn detect(adapter: &RenderAdapterInfo) {
    let is_gl = Backends::from(adapter.backend) == Backends::GL;
    LACKS_LEVEL_QUERIES.store(is_gl, Ordering::Relaxed);
    let is_llvmpipe = adapter.name.contains("llvmpipe");
    IS_LLVMPIPE.store(is_llvmpipe, Ordering::Relaxed);
    let mesa = mesa_version(&adapter.driver_info);
    let is_good = mesa.is_some_and(|mesa| mesa >= GOOD_MESA);
    IS_LLVMPIPE_OLD.store(is_llvmpipe && !is_good, Ordering::Relaxed);
}

/// The major version in a text such as `Mesa 25.0.7 (LLVM 15.0.6)`.
fn mesa_version(driver: &str) -> Option<u32> {
    let (_, version) = driver.split_once("Mesa ")?;
    version.split('.').next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_version_of_mesa_is_in_the_text_of_the_driver() {
        assert_eq!(
            mesa_version("Mesa 25.0.7-2~bpo12+1 (LLVM 15.0.6)"),
            Some(25)
        );
        assert_eq!(mesa_version("Mesa 22.3.6 (LLVM 15.0.6)"), Some(22));
        assert_eq!(mesa_version("570.86"), None);
    }
}
