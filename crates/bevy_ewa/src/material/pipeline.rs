//! The settings and the layout of a material's maps, as a tag in the key of its pipelines and as their shader defs.
//!
//! A pipeline is compiled for the maps that its material has: Bevy asks whether there is a map at run time, which costs
//! the filter's code for all maps.
//!
//! The adapter decides, too: Mesa's llvmpipe needs workarounds, and OpenGL ES and WebGL2 cannot do all.

use std::sync::{
    PoisonError, RwLock,
    atomic::{AtomicBool, Ordering},
};

use bevy::{
    log::warn_once,
    pbr::MeshPipelineKey,
    render::{
        render_resource::{FragmentState, RenderPipelineDescriptor},
        renderer::RenderAdapterInfo,
        settings::Backends,
    },
    shader::ShaderDefVal,
};
use bevy_frugal_hooks::SpecializedMaterial;

use super::layout::{MAPS, MapLayout};
use crate::{
    settings::{EwaMethod, EwaSettings},
    shaders::EwaUniform,
};

/// Name of the tag of filtered materials.
pub(super) const TAG: &str = "bevy_ewa";
/// Feature of the statements in Bevy's shaders that maps of any layout need.
const EWA: &str = "BEVY_EWA";
/// Whether the textures repeat or mirror.
const PERIODIC: &str = "EWA_PERIODIC";

/// What pipelines are compiled with; a tag is an index. It grows with the distinct settings and layouts, not with the
/// materials. Hooks have no access to a world.
static KEYS: RwLock<Vec<(EwaKey, MapLayout)>> = RwLock::new(Vec::new());

/// The tag of materials that are filtered so.
pub(super) fn tag_of(key: (EwaKey, MapLayout)) -> u64 {
    let mut keys = KEYS.write().unwrap_or_else(PoisonError::into_inner);
    let index = keys.iter().position(|known| *known == key);
    index.unwrap_or_else(|| {
        keys.push(key);
        keys.len() - 1
    }) as u64
}

/// What a tag stands for.
fn key_of(tag: u64) -> Option<(EwaKey, MapLayout)> {
    let keys = KEYS.read().unwrap_or_else(PoisonError::into_inner);
    keys.get(tag as usize).copied()
}

/// The settings as a part of the pipeline key: the shader defs and their values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct EwaKey([(&'static str, u32); 14]);

impl EwaKey {
    /// Creates the key of these settings, `None` for the methods that leave the pipelines to Bevy; `llvmpipe` is true
    /// on that driver.
    pub fn new(settings: &EwaSettings, llvmpipe: bool) -> Option<Self> {
        if is_texture_units(settings.method) {
            return None;
        }
        let uniform = EwaUniform::new(settings);
        let radii = [
            uniform.kernel_radius_pixels,
            uniform.probe_radius_pixels,
            uniform.minor_radius_texels,
        ];
        let [kernel_radius, probe_radius, minor_radius] = radii.map(f32::to_bits);
        Some(Self([
            ("EWA_METHOD", uniform.method),
            ("EWA_PROBES", uniform.probes),
            ("EWA_KERNEL", uniform.kernel),
            ("EWA_LEVEL_OF_DETAIL", uniform.level_of_detail),
            ("EWA_KERNEL_RADIUS_PIXELS", kernel_radius),
            ("EWA_PROBE_RADIUS_PIXELS", probe_radius),
            ("EWA_MAX_ANISOTROPY", uniform.max_anisotropy.to_bits()),
            ("EWA_MINOR_RADIUS_TEXELS", minor_radius),
            ("EWA_LEVEL_BLEND", uniform.level_blend.to_bits()),
            ("EWA_MAX_FETCHES", uniform.max_fetches.to_bits()),
            ("EWA_SPATIAL_THRESHOLD", uniform.spatial_threshold.to_bits()),
            ("EWA_SAMPLER_ANISOTROPY", uniform.sampler_anisotropy),
            (PERIODIC, uniform.periodic),
            ("EWA_UNIFORM_LEVELS", llvmpipe.into()),
        ]))
    }

    /// Returns the shader defs of a pipeline that filters maps in this layout.
    pub fn shader_defs(&self, layout: MapLayout) -> Vec<ShaderDefVal> {
        let values = self.0.into_iter().map(|(name, value)| {
            let is_switched_off = name == PERIODIC && layout.is_clamped;
            ShaderDefVal::UInt(name.into(), if is_switched_off { 0 } else { value })
        });
        let mut defs: Vec<_> = values.chain([EWA.into()]).collect();
        for (index, map) in MAPS.iter().enumerate() {
            let map = map.to_uppercase();
            if layout.shared & (1 << index) != 0 {
                defs.push(format!("EWA_SHARED_{map}").into());
            } else if layout.own & (1 << index) != 0 {
                defs.push(format!("EWA_OWN_{map}").into());
            }
        }
        if layout.shared != 0 {
            defs.push(ShaderDefVal::UInt("EWA_SHARED".into(), layout.shared));
            if !layout.has_parallax {
                defs.push("EWA_SHARED_EARLY".into());
            }
            if layout.is_shared_uv_b {
                defs.push("EWA_SHARED_UV_B".into());
            }
        }
        defs
    }

    /// Adds the shader defs of the filter to a pipeline, unless its pass samples none of the maps.
    fn apply(
        &self,
        layout: MapLayout,
        key: MeshPipelineKey,
        descriptor: &mut RenderPipelineDescriptor,
    ) {
        let Some(fragment) = &mut descriptor.fragment else {
            return;
        };
        let is_prepass = has(fragment, "PREPASS_PIPELINE");
        // This pass keeps Bevy's filter there. The mesh key of the main pass has the same flag, so the shader def has
        // to be checked, too.
        if is_old_llvmpipe() && is_prepass && key.contains(MeshPipelineKey::MOTION_VECTOR_PREPASS) {
            return;
        }
        let layout = if is_prepass && !has(fragment, "DEFERRED_PREPASS") {
            layout.in_prepass(
                has(fragment, "MAY_DISCARD"),
                has(fragment, "NORMAL_PREPASS"),
            )
        } else {
            layout
        };
        if !layout.is_empty() {
            fragment.shader_defs.extend(self.shader_defs(layout));
        }
    }
}

fn has(fragment: &FragmentState, def: &'static str) -> bool {
    fragment.shader_defs.contains(&def.into())
}

/// The material hook, by which pipelines of tagged materials filter.
pub(super) fn apply_filter(
    material: SpecializedMaterial,
    descriptor: &mut RenderPipelineDescriptor,
) {
    if let Some((key, layout)) = material.tag(TAG).and_then(key_of) {
        key.apply(layout, material.mesh_key, descriptor);
    }
}

/// It is global to the process, because pipeline keys and hooks have no access to a world.
static IS_LLVMPIPE: AtomicBool = AtomicBool::new(false);
static IS_LLVMPIPE_OLD: AtomicBool = AtomicBool::new(false);
static LACKS_LEVEL_QUERIES: AtomicBool = AtomicBool::new(false);

/// The first version of Mesa whose llvmpipe is known to compile the filter in a motion-vector prepass.
const GOOD_MESA: u32 = 25;

pub(super) fn is_llvmpipe() -> bool {
    IS_LLVMPIPE.load(Ordering::Relaxed)
}

/// Whether the pipelines are Bevy's own.
fn is_texture_units(method: EwaMethod) -> bool {
    matches!(method, EwaMethod::Anisotropic | EwaMethod::Hardware)
}

/// Whether the adapter is an older llvmpipe: that of Mesa 22 ends the process while it compiles a motion-vector prepass
/// with the filter.
fn is_old_llvmpipe() -> bool {
    IS_LLVMPIPE_OLD.load(Ordering::Relaxed)
}

/// The settings that the adapter can filter by. Shaders of OpenGL ES and WebGL2 cannot ask how many levels a texture
/// has, which all methods but the texture unit's need.
pub(super) fn supported(settings: EwaSettings) -> EwaSettings {
    if is_texture_units(settings.method) || !LACKS_LEVEL_QUERIES.load(Ordering::Relaxed) {
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
pub(super) fn detect_adapter(adapter: &RenderAdapterInfo) {
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
