//! The settings as shader defs of a pipeline.

use bevy::{
    pbr::MeshPipelineKey, render::render_resource::RenderPipelineDescriptor, shader::ShaderDefVal,
};

use super::uniform::EwaUniform;
use crate::settings::EwaSettings;

/// Switches Bevy's shaders to ours.
pub(crate) const EWA: &str = "BEVY_EWA";

/// What Bevy's prepass has in its shader defs.
const PREPASS: &str = "PREPASS_PIPELINE";

const PERIODIC: &str = "EWA_PERIODIC";

/// Takes back that the textures repeat.
pub(super) fn clamp(shader_defs: &mut [ShaderDefVal]) {
    for def in shader_defs {
        if let ShaderDefVal::UInt(name, value) = def
            && name == PERIODIC
        {
            *value = 0;
        }
    }
}

/// Leaves the maps of a pipeline to Bevy.
pub(super) fn disable(descriptor: &mut RenderPipelineDescriptor) {
    if let Some(fragment) = &mut descriptor.fragment {
        fragment.shader_defs.retain(|def| *def != EWA.into());
    }
}

/// The settings in the key of a pipeline: the names of its shader defs are constant, so their
/// values are all there is. None samples as Bevy does.
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
    /// The key of these settings, on llvmpipe or not.
    pub fn new(settings: &EwaSettings, software: bool) -> Self {
        let settings = settings.sanitized();
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
            software.into(),
        ]))
    }

    /// The shader defs.
    pub fn shader_defs(&self) -> Vec<ShaderDefVal> {
        let Some(values) = self.0 else {
            return Vec::new();
        };
        let values = NAMES.into_iter().zip(values);
        let values = values.map(|(name, value)| ShaderDefVal::UInt(name.into(), value));
        values.chain([EWA.into()]).collect()
    }

    fn is_software(&self) -> bool {
        self.0.is_some_and(|values| values[VALUES - 1] != 0)
    }

    /// Makes a pipeline filter its maps.
    pub(crate) fn apply(&self, key: MeshPipelineKey, descriptor: &mut RenderPipelineDescriptor) {
        if let Some(fragment) = &mut descriptor.fragment {
            // Mesa's llvmpipe ends the process while it compiles this; unfiltered normals are better.
            // The key of the main pass names the prepass, too.
            if self.is_software()
                && key.contains(MeshPipelineKey::MOTION_VECTOR_PREPASS)
                && fragment.shader_defs.contains(&PREPASS.into())
            {
                return;
            }
            fragment.shader_defs.extend(self.shader_defs());
        }
    }
}
