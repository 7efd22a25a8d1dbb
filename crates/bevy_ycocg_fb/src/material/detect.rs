//! Detection of the shaders that pack: they call the patched function of Bevy or the pack function
//! itself, or import a module that does.

use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard};

use bevy::{
    platform::collections::{HashMap, HashSet},
    prelude::*,
    shader::{Shader, ShaderImport, Source},
};

/// The shaders that pack the colours that they write. The main world and the render world share it.
#[derive(Resource, Clone, Debug, Default)]
pub(crate) struct PackingShaders(Arc<RwLock<Detected>>);

#[derive(Debug, Default)]
struct Detected {
    shaders: HashSet<AssetId<Shader>>,
    /// Incremented with every change of `shaders`.
    generation: u64,
}

impl PackingShaders {
    pub(crate) fn contains(&self, shader: AssetId<Shader>) -> bool {
        self.read().shaders.contains(&shader)
    }

    /// Returns a number that changes whenever the result of `contains` may change.
    pub(crate) fn generation(&self) -> u64 {
        self.read().generation
    }

    fn read(&self) -> RwLockReadGuard<'_, Detected> {
        self.0.read().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Checks all shaders whenever one was loaded or changed.
pub(crate) fn find_packing_shaders(shaders: Res<Assets<Shader>>, packing: Res<PackingShaders>) {
    if !shaders.is_changed() {
        return;
    }
    let modules: HashMap<&ShaderImport, &Shader> = shaders
        .iter()
        .map(|(_, shader)| (&shader.import_path, shader))
        .collect();
    let found: HashSet<_> = shaders
        .iter()
        .filter(|(_, shader)| packs(shader, &modules, &mut HashSet::new()))
        .map(|(id, _)| id)
        .collect();
    if packing.read().shaders != found {
        let mut packing = packing.0.write().unwrap_or_else(PoisonError::into_inner);
        packing.shaders = found;
        packing.generation += 1;
    }
}

fn packs<'a>(
    shader: &'a Shader,
    modules: &HashMap<&ShaderImport, &'a Shader>,
    visited: &mut HashSet<&'a ShaderImport>,
) -> bool {
    calls_pack(shader)
        || shader.imports.iter().any(|import| {
            visited.insert(import)
                && modules
                    .get(import)
                    .is_some_and(|module| packs(module, modules, visited))
        })
}

/// Whether a shader calls one of the functions that pack and does not define it.
fn calls_pack(shader: &Shader) -> bool {
    let (Source::Wesl(source) | Source::Wgsl(source)) = &shader.source else {
        return false;
    };
    let calls = |function: &str| {
        source.contains(&format!("{function}(")) && !source.contains(&format!("fn {function}("))
    };
    // Bevy's module that defines the first function is patched to call the second, but a shader that
    // imports this module for another item does not pack.
    let defines_first = source.contains("fn main_pass_post_lighting_processing(");
    calls("main_pass_post_lighting_processing") || (!defines_first && calls("pack_fragment"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(sources: &[(&str, &str)]) -> Vec<bool> {
        let shaders: Vec<_> = sources
            .iter()
            .map(|(path, source)| Shader::from_wesl((*source).to_owned(), *path))
            .collect();
        let modules = shaders.iter().map(|s| (&s.import_path, s)).collect();
        shaders
            .iter()
            .map(|s| packs(s, &modules, &mut HashSet::new()))
            .collect()
    }

    #[test]
    fn shaders_pack_that_call_pack_or_import_a_module_that_does() {
        let library = "import bevy_ycocg_fb::shaders::pack::pack_fragment;\n\
            fn main_pass_post_lighting_processing(c: vec4<f32>) -> vec4<f32> {\n\
            return pack_fragment(c, c); }";
        let lit = "import bevy_pbr::render::pbr_functions::main_pass_post_lighting_processing;\n\
            fn f() { x = main_pass_post_lighting_processing(c); }";
        let own = "import bevy_ycocg_fb::shaders::pack::pack_fragment;\n\
            fn f() { x = pack_fragment(c, p); }";
        let module = "import bevy_pbr::render::pbr_functions as fns;\n\
            fn shade() { x = fns::main_pass_post_lighting_processing(c); }";
        let through = "import package::shade::shade;\nfn f() { x = shade(); }";
        let raw = "import bevy_pbr::render::pbr_functions::alpha_discard;\nfn f() { return c; }";
        let plain = "@fragment fn f() -> @location(0) vec4<f32> { return vec4(1.0); }";
        assert_eq!(
            found(&[
                ("embedded://bevy_pbr/render/pbr_functions.wesl", library),
                ("lit.wesl", lit),
                ("own.wesl", own),
                ("shade.wesl", module),
                ("through.wesl", through),
                ("raw.wesl", raw),
                ("plain.wesl", plain),
            ]),
            [false, true, true, true, true, false, false]
        );
    }
}
