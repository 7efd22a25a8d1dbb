//! Composes shaders as Bevy does and validates the result, without a driver.

use bevy::{
    prelude::*,
    shader::{Shader, ShaderCache, ShaderCacheError, ShaderCacheSource, ShaderDefVal},
};

/// All shaders of an app.
pub struct Composer(ShaderCache<naga::Module, ()>);

impl Composer {
    pub fn new(app: &World) -> Self {
        let mut cache = ShaderCache::new((), |(), source, _| parsed(source));
        for (id, shader) in app.resource::<Assets<Shader>>().iter() {
            cache.set_shader(id, shader.clone());
        }
        Self(cache)
    }

    /// Composes and validates the shader.
    pub fn validate(&mut self, id: AssetId<Shader>, defs: &[ShaderDefVal]) -> Result<(), String> {
        let module = self.0.get(0, id, defs).map_err(|error| error.to_string())?;
        let mut validator = naga::valid::Validator::new(
            naga::valid::ValidationFlags::all(),
            naga::valid::Capabilities::all(),
        );
        match validator.validate(&module) {
            Ok(_) => Ok(()),
            Err(error) => Err(format!("{error:?}")),
        }
    }

    /// Composes and validates a shader that is not in the app.
    pub fn validate_source(&mut self, source: &str, defs: &[ShaderDefVal]) -> Result<(), String> {
        let id = AssetId::Uuid {
            uuid: bevy::asset::uuid::Uuid::from_u128(1),
        };
        let shader = Shader::from_wesl(source.to_owned(), "tests/source.wesl");
        self.0.set_shader(id, shader);
        self.validate(id, defs)
    }
}

fn parsed(source: ShaderCacheSource) -> Result<naga::Module, ShaderCacheError> {
    let ShaderCacheSource::Wgsl(source) = source else {
        unreachable!("no shader is SPIR-V");
    };
    naga::front::wgsl::parse_str(&source)
        .map_err(|error| ShaderCacheError::CreateShaderModule(error.emit_to_string(&source)))
}

/// The shader of the app whose path ends so.
pub fn shader_at(app: &World, end: &str) -> AssetId<Shader> {
    let shaders = app.resource::<Assets<Shader>>();
    let mut found = shaders
        .iter()
        .filter(|(_, shader)| shader.path.ends_with(end));
    let (id, _) = found.next().unwrap_or_else(|| panic!("no shader {end}"));
    assert!(found.next().is_none(), "{end} is ambiguous");
    id
}

/// The numbers that Bevy defines for the shaders of every mesh pipeline.
pub fn mesh_numbers() -> Vec<ShaderDefVal> {
    [
        ("MATERIAL_BIND_GROUP", 3),
        ("MAX_CASCADES_PER_LIGHT", 4),
        ("MAX_DIRECTIONAL_LIGHTS", 10),
        ("AVAILABLE_STORAGE_BUFFER_BINDINGS", 8),
        ("PER_OBJECT_BUFFER_BATCH_SIZE", 64),
        ("TONEMAPPING_LUT_TEXTURE_BINDING_INDEX", 27),
        ("TONEMAPPING_LUT_SAMPLER_BINDING_INDEX", 28),
    ]
    .map(|(name, value)| ShaderDefVal::UInt(name.into(), value))
    .into()
}
