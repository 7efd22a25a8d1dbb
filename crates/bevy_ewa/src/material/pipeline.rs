//! The settings as shader defs of a pipeline.

use bevy::{
    pbr::MeshPipelineKey, render::render_resource::RenderPipelineDescriptor, shader::ShaderDefVal,
};

use crate::{settings::EwaSettings, shaders::EwaUniform};

/// Feature of the inserted branches in Bevy's shaders.
pub(crate) const EWA: &str = "BEVY_EWA";

/// Shader def by which Bevy marks prepass pipelines.
const PREPASS: &str = "PREPASS_PIPELINE";

const PERIODIC: &str = "EWA_PERIODIC";

/// Sets `periodic` to 0 in the shader defs of a pipeline.
pub(super) fn disable_periodic(shader_defs: &mut [ShaderDefVal]) {
    for def in shader_defs {
        if let ShaderDefVal::UInt(name, value) = def
            && name == PERIODIC
        {
            *value = 0;
        }
    }
}

/// Removes the feature of the filter from a pipeline, so that Bevy samples its maps.
pub(super) fn disable(descriptor: &mut RenderPipelineDescriptor) {
    if let Some(fragment) = &mut descriptor.fragment {
        fragment.shader_defs.retain(|def| *def != EWA.into());
    }
}

/// The settings as a part of the pipeline key: the values of the shader defs, whose names are constant.
/// Without values (`EwaMethod::Hardware`), the pipeline samples as Bevy does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct EwaKey(Option<[u32; VALUES]>);

const VALUES: usize = 14;

const NAMES: [&str; VALUES] = [
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
    PERIODIC,
    "EWA_UNIFORM_LEVELS",
];

impl EwaKey {
    /// Creates the key of these settings; `llvmpipe` is true on that driver.
    pub fn new(settings: &EwaSettings, llvmpipe: bool) -> Self {
        let settings = settings.clamped();
        if settings.method == crate::EwaMethod::Hardware {
            return Self(None);
        }
        let uniform = EwaUniform::new(&settings);
        Self(Some([
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

    /// Returns the shader defs, none for `EwaMethod::Hardware`.
    pub fn shader_defs(&self) -> Vec<ShaderDefVal> {
        let Some(values) = self.0 else {
            return Vec::new();
        };
        let values = NAMES.into_iter().zip(values);
        let values = values.map(|(name, value)| ShaderDefVal::UInt(name.into(), value));
        values.chain([EWA.into()]).collect()
    }

    fn is_llvmpipe(&self) -> bool {
        self.0.is_some_and(|values| values[VALUES - 1] != 0)
    }

    /// Adds the shader defs of the filter to a pipeline.
    pub(crate) fn apply(&self, key: MeshPipelineKey, descriptor: &mut RenderPipelineDescriptor) {
        if let Some(fragment) = &mut descriptor.fragment {
            // Mesa's llvmpipe ends the process while it compiles a motion-vector prepass with the
            // filter, so this pass keeps Bevy's. The mesh key of the main pass has the same flag, so the
            // shader def has to be checked, too.
            if self.is_llvmpipe()
                && key.contains(MeshPipelineKey::MOTION_VECTOR_PREPASS)
                && fragment.shader_defs.contains(&PREPASS.into())
            {
                return;
            }
            fragment.shader_defs.extend(self.shader_defs());
        }
    }
}
