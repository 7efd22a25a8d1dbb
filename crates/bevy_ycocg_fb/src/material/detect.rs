//! Detection of the shaders that pack: they end in a call of the patched function of Bevy, of the pack function
//! itself, or of a function that does.

use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard};

use bevy::{
    platform::collections::{HashMap, HashSet},
    prelude::*,
    shader::{Shader, ShaderImport, Source},
};

use super::final_call::{Packing, packing};

/// The pack function, and that of Bevy which is patched to end in it.
const PACKING: [&str; 2] = ["main_pass_post_lighting_processing", "pack_fragment"];

/// The shaders that pack the colours that they write. The main world and the render world share it.
#[derive(Resource, Clone, Debug, Default)]
pub(crate) struct PackingShaders(Arc<RwLock<Detected>>);

#[derive(Debug, Default)]
struct Detected {
    shaders: HashSet<AssetId<Shader>>,
    /// All shaders that are loaded.
    inspected: HashSet<AssetId<Shader>>,
    /// Incremented with every change of `shaders`.
    generation: u64,
}

impl PackingShaders {
    pub(crate) fn contains(&self, shader: AssetId<Shader>) -> bool {
        self.read().shaders.contains(&shader)
    }

    /// Whether the shader is loaded; pipelines of others are not ready.
    pub(crate) fn is_inspected(&self, shader: AssetId<Shader>) -> bool {
        self.read().inspected.contains(&shader)
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
    let all: Vec<_> = shaders.iter().collect();
    let packs = shaders_that_pack(&all.iter().map(|(_, shader)| *shader).collect::<Vec<_>>());
    let inspected = all.iter().map(|(id, _)| *id).collect();
    let shaders: HashSet<_> = all
        .iter()
        .zip(packs)
        .filter_map(|((id, _), packs)| packs.then_some(*id))
        .collect();
    let mut detected = packing.0.write().unwrap_or_else(PoisonError::into_inner);
    detected.inspected = inspected;
    if detected.shaders != shaders {
        detected.shaders = shaders;
        detected.generation += 1;
    }
}

/// Returns whether the fragment shaders of each shader pack. Functions pack that end in a call of another one that
/// does, in the same shader or in one that it imports.
fn shaders_that_pack(shaders: &[&Shader]) -> Vec<bool> {
    let mut functions: HashMap<&ShaderImport, HashSet<String>> = HashMap::default();
    loop {
        let packings: Vec<_> = shaders
            .iter()
            .map(|shader| {
                let imported = shader.imports.iter().filter_map(|path| functions.get(path));
                let names: std::collections::HashSet<_> = imported
                    .flatten()
                    .map(String::as_str)
                    .chain(PACKING)
                    .collect();
                match &shader.source {
                    // Most shaders mention none of them, and are not parsed.
                    Source::Wesl(source) | Source::Wgsl(source)
                        if names.iter().any(|&name| source.contains(name)) =>
                    {
                        packing(source, &names)
                    }
                    _ => Packing::default(),
                }
            })
            .collect();
        let mut grown = false;
        let fragments = packings.iter().map(|packing| packing.fragment).collect();
        for (shader, packing) in shaders.iter().zip(packings) {
            let known = functions.entry(&shader.import_path).or_default();
            for function in packing.functions {
                grown |= known.insert(function);
            }
        }
        if !grown {
            return fragments;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn packs(sources: &[(&str, &str)]) -> Vec<bool> {
        let shaders: Vec<_> = sources
            .iter()
            .map(|(path, source)| Shader::from_wesl((*source).to_owned(), *path))
            .collect();
        shaders_that_pack(&shaders.iter().collect::<Vec<_>>())
    }

    #[test]
    fn shaders_pack_that_end_in_a_call_of_pack_or_of_a_function_that_does() {
        let library = "import bevy_ycocg_fb::shaders::pack::pack_fragment;\n\
            fn main_pass_post_lighting_processing(c: vec4<f32>) -> vec4<f32> {\n\
            return pack_fragment(c, c); }";
        let lit = "import bevy_pbr::render::pbr_functions::main_pass_post_lighting_processing;\n\
            @fragment fn f() -> O { return main_pass_post_lighting_processing(c); }";
        let own = "import bevy_ycocg_fb::shaders::pack::pack_fragment as pack;\n\
            @fragment fn f() -> O { let x = pack(c, p); return x; }";
        let module = "import bevy_pbr::render::pbr_functions as fns;\n\
            fn shade() -> vec4<f32> { return fns::main_pass_post_lighting_processing(c); }\n\
            fn other() -> vec4<f32> { return vec4(1.0); }";
        let through = "import package::shade::shade;\n@fragment fn f() -> O { return shade(); }";
        let beside =
            "import package::shade::{other, shade};\n@fragment fn f() -> O { return other(); }";
        let brighter =
            "import package::shade::shade;\n@fragment fn f() -> O { return 2.0 * shade(); }";
        let raw = "import bevy_pbr::render::pbr_functions::alpha_discard;\n\
            @fragment fn f() -> O { return c; }";
        assert_eq!(
            packs(&[
                ("embedded://bevy_pbr/render/pbr_functions.wesl", library),
                ("lit.wesl", lit),
                ("own.wesl", own),
                ("shade.wesl", module),
                ("through.wesl", through),
                ("beside.wesl", beside),
                ("brighter.wesl", brighter),
                ("raw.wesl", raw),
            ]),
            [false, true, true, false, true, false, false, false]
        );
    }
}
