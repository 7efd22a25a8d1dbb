//! Composes shaders as Bevy does and validates the result, without a driver.

use std::{
    fs,
    hash::{DefaultHasher, Hash, Hasher},
    path::Path,
    sync::Arc,
};

use bevy::{
    asset::uuid::Uuid,
    prelude::*,
    render::renderer::RenderDevice,
    shader::{Shader, ShaderCache, ShaderCacheSource, ShaderDefVal},
};

/// Shaders and their libraries; makes WGSL of them.
pub struct Composer(ShaderCache<String, ()>);

impl Composer {
    /// No shaders.
    pub fn empty() -> Self {
        Self(ShaderCache::new((), |(), source, _| match source {
            ShaderCacheSource::Wgsl(source) => Ok(source),
            ShaderCacheSource::SpirV(_) => unreachable!("no shader is SPIR-V"),
        }))
    }

    /// All shaders of an app.
    pub fn new(app: &World) -> Self {
        let mut composer = Self::empty();
        for (id, shader) in app.resource::<Assets<Shader>>().iter() {
            composer.0.set_shader(id, shader.clone());
        }
        composer
    }

    /// The shaders of one of our crates, without an app.
    pub fn of_crate(name: &str) -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("crates")
            .join(name);
        let mut composer = Self::empty();
        composer.add_folder(name, &root.join("src"), "");
        composer
    }

    fn add_folder(&mut self, name: &str, folder: &Path, below: &str) {
        for entry in fs::read_dir(folder).expect("a folder").flatten() {
            let file = entry.file_name().into_string().expect("UTF-8");
            let below = format!("{below}/{file}");
            if entry.path().is_dir() {
                self.add_folder(name, &entry.path(), &below);
            } else if file.ends_with(".wesl") {
                let source = fs::read_to_string(entry.path()).expect("a shader");
                let shader = Shader::from_wesl(source, format!("embedded://{name}{below}"));
                let mut hasher = DefaultHasher::new();
                below.hash(&mut hasher);
                let uuid = Uuid::from_u128(hasher.finish().into());
                self.0.set_shader(AssetId::Uuid { uuid }, shader);
            }
        }
    }

    /// The WGSL of a shader, validated.
    pub fn compose(
        &mut self,
        id: AssetId<Shader>,
        defs: &[ShaderDefVal],
    ) -> Result<Arc<String>, String> {
        let source = self.0.get(0, id, defs).map_err(|error| error.to_string())?;
        let module =
            naga::front::wgsl::parse_str(&source).map_err(|error| error.emit_to_string(&source))?;
        let mut validator = naga::valid::Validator::new(
            naga::valid::ValidationFlags::all(),
            naga::valid::Capabilities::all(),
        );
        validator
            .validate(&module)
            .map_err(|error| error.emit_to_string(&source))?;
        match function_with_element_as_argument(&module) {
            Some(function) => Err(format!(
                "`{function}` is called with an element of a binding array, of which naga makes invalid SPIR-V"
            )),
            None => Ok(source),
        }
    }

    /// The WGSL of a shader that is given as WESL, validated.
    pub fn compose_source(
        &mut self,
        source: &str,
        defs: &[ShaderDefVal],
    ) -> Result<Arc<String>, String> {
        let id = AssetId::Uuid {
            uuid: Uuid::from_u128(1),
        };
        let shader = Shader::from_wesl(source.to_owned(), "tests/source.wesl");
        self.0.set_shader(id, shader);
        self.compose(id, defs)
    }
}

/// A function that is called with an element of a binding array: naga's SPIR-V passes the element where the function
/// takes a pointer, and NVIDIA's driver crashes at that.
fn function_with_element_as_argument(module: &naga::Module) -> Option<String> {
    let functions = module.functions.iter().map(|(_, function)| function);
    let entry_points = module.entry_points.iter().map(|entry| &entry.function);
    functions.chain(entry_points).find_map(|function| {
        let is_element = |argument: &naga::Handle<naga::Expression>| {
            let (naga::Expression::Access { base, .. }
            | naga::Expression::AccessIndex { base, .. }) = function.expressions[*argument]
            else {
                return false;
            };
            let naga::Expression::GlobalVariable(variable) = function.expressions[base] else {
                return false;
            };
            let of_variable = &module.types[module.global_variables[variable].ty].inner;
            matches!(of_variable, naga::TypeInner::BindingArray { .. })
        };
        let called = call(&function.body, &|arguments| {
            arguments.iter().any(is_element)
        })?;
        Some(module.functions[called].name.clone().unwrap_or_default())
    })
}

/// The first call in a block whose arguments are so.
fn call(
    block: &naga::Block,
    is_so: &impl Fn(&[naga::Handle<naga::Expression>]) -> bool,
) -> Option<naga::Handle<naga::Function>> {
    block.iter().find_map(|statement| match statement {
        naga::Statement::Call {
            function,
            arguments,
            ..
        } => is_so(arguments).then_some(*function),
        naga::Statement::Block(block) => call(block, is_so),
        naga::Statement::If { accept, reject, .. } => {
            call(accept, is_so).or_else(|| call(reject, is_so))
        }
        naga::Statement::Switch { cases, .. } => {
            cases.iter().find_map(|case| call(&case.body, is_so))
        }
        naga::Statement::Loop {
            body, continuing, ..
        } => call(body, is_so).or_else(|| call(continuing, is_so)),
        _ => None,
    })
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

/// Returns the definitions that Bevy adds to all shaders of a device.
pub fn device_defs(device: &RenderDevice) -> [ShaderDefVal; 3] {
    let bindings = device.limits().max_storage_buffers_per_shader_stage;
    [
        ShaderDefVal::UInt("AVAILABLE_STORAGE_BUFFER_BINDINGS".into(), bindings),
        ShaderDefVal::Bool(
            "AVAILABLE_STORAGE_BUFFER_BINDINGS__GE_3".into(),
            bindings >= 3,
        ),
        ShaderDefVal::Bool(
            "AVAILABLE_STORAGE_BUFFER_BINDINGS__GE_6".into(),
            bindings >= 6,
        ),
    ]
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
