//! The settings and the layout of a material's maps, as a tag in the key of its pipelines and as their shader defs.
//!
//! A pipeline is compiled for the maps that its material has: Bevy asks whether there is a map at run time, which costs
//! the filter's code for all maps.

use std::sync::{PoisonError, RwLock};

use bevy::{
    pbr::MeshPipelineKey,
    render::render_resource::{FragmentState, RenderPipelineDescriptor},
    shader::ShaderDefVal,
};
use bevy_frugal_hooks::SpecializedMaterial;

use super::{
    adapter::is_old_llvmpipe,
    layout::{MAPS, MapLayout},
};
use crate::{
    settings::{EwaMethod, EwaSettings},
    shaders::EwaUniform,
};

/// Name of the tag of filtered materials.
pub(super) const TAG: &str = "bevy_ewa";
/// Feature of the statements in Bevy's shaders that maps of any layout need.
const EWA: &str = "BEVY_EWA";

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

const PERIODIC: usize = 12;

/// The settings as a part of the pipeline key: the values of the shader defs, whose names are constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct EwaKey([u32; 14]);

const NAMES: [&str; 14] = [
    "EWA_METHOD",
    "EWA_PROBES",
    "EWA_KERNEL",
    "EWA_LEVEL_OF_DETAIL",
    "EWA_KERNEL_RADIUS_PIXELS",
    "EWA_PROBE_RADIUS_PIXELS",
    "EWA_MAX_ANISOTROPY",
    "EWA_MINOR_RADIUS_TEXELS",
    "EWA_LEVEL_BLEND",
    "EWA_MAX_FETCHES",
    "EWA_SPATIAL_THRESHOLD",
    "EWA_SAMPLER_ANISOTROPY",
    "EWA_PERIODIC",
    "EWA_UNIFORM_LEVELS",
];

impl EwaKey {
    /// Creates the key of these settings, `None` for the methods that leave the pipelines to Bevy; `llvmpipe` is true
    /// on that driver.
    pub fn new(settings: &EwaSettings, llvmpipe: bool) -> Option<Self> {
        if matches!(
            settings.method,
            EwaMethod::Anisotropic | EwaMethod::Hardware
        ) {
            return None;
        }
        let uniform = EwaUniform::new(settings);
        Some(Self([
            uniform.method,
            uniform.probes,
            uniform.kernel,
            uniform.level_of_detail,
            uniform.kernel_radius_pixels.to_bits(),
            uniform.probe_radius_pixels.to_bits(),
            uniform.max_anisotropy.to_bits(),
            uniform.minor_radius_texels.to_bits(),
            uniform.level_blend.to_bits(),
            uniform.max_fetches.to_bits(),
            uniform.spatial_threshold.to_bits(),
            uniform.sampler_anisotropy,
            uniform.periodic,
            llvmpipe.into(),
        ]))
    }

    /// Returns the shader defs of a pipeline that filters maps in this layout.
    pub fn shader_defs(&self, layout: MapLayout) -> Vec<ShaderDefVal> {
        let mut values = self.0;
        if layout.is_clamped {
            values[PERIODIC] = 0;
        }
        let values = NAMES.into_iter().zip(values);
        let values = values.map(|(name, value)| ShaderDefVal::UInt(name.into(), value));
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
