//! Text inserted into Bevy's shaders when they are loaded.
//!
//! A [`ShaderPatch`] only inserts, at positions that must exist exactly once; it takes nothing
//! away, so the anchors of other patches survive and the order does not matter. It leaves its name
//! in the source and is therefore never applied twice, and it is applied again when the shader is
//! reloaded. Where it does not fit, as may happen with another version of Bevy, the shader stays
//! as it is, the patch is [`PatchState::Refused`] and one error names the shader and the reason.

mod text;

use bevy::{
    asset::AssetEventSystems,
    platform::collections::HashMap,
    prelude::*,
    shader::{Shader, ShaderImport, Source},
};

pub use text::{Insertion, PatchError, patched};

/// A change of one shader.
#[derive(Clone, Debug)]
pub struct ShaderPatch {
    /// Unique; appears in the patched source as a comment.
    pub name: &'static str,
    /// The path of the shader as a WESL module, such as `bevy_pbr::render::pbr_functions`.
    pub shader: &'static str,
    /// The items that the inserted text imports, by their full paths.
    pub imports: Vec<&'static str>,
    /// Texts that must occur so many times before anything is inserted: a shader that Bevy extended
    /// by one more place to patch is refused.
    pub counted: Vec<(&'static str, usize)>,
    /// What is inserted; all of it or nothing.
    pub insertions: Vec<Insertion>,
}

impl ShaderPatch {
    /// A patch that inserts nothing yet.
    pub fn new(name: &'static str, shader: &'static str) -> Self {
        Self {
            name,
            shader,
            imports: Vec::new(),
            counted: Vec::new(),
            insertions: Vec::new(),
        }
    }

    fn is_for(&self, shader: &Shader) -> bool {
        matches!(&shader.import_path, ShaderImport::Custom(path) if path == self.shader)
    }
}

/// What became of a patch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PatchState {
    /// Its shader is not loaded yet.
    Pending,
    /// It is in.
    Applied,
    /// It does not fit; the shader is untouched.
    Refused(PatchError),
}

/// The patches of this app, and what became of them.
#[derive(Resource, Debug, Default)]
pub struct ShaderPatches {
    patches: Vec<ShaderPatch>,
    states: HashMap<&'static str, PatchState>,
}

impl ShaderPatches {
    /// What became of the patch of this name; `None` if it was never added.
    pub fn state(&self, name: &str) -> Option<&PatchState> {
        self.states.get(name)
    }

    /// Whether all of these are in.
    pub fn all_applied(&self, names: &[&str]) -> bool {
        names
            .iter()
            .all(|name| self.state(name) == Some(&PatchState::Applied))
    }

    /// The first of these that was refused, and why.
    pub fn refused<'a>(&'a self, names: &[&'a str]) -> Option<(&'a str, &'a PatchError)> {
        names.iter().find_map(|&name| match self.state(name) {
            Some(PatchState::Refused(error)) => Some((name, error)),
            _ => None,
        })
    }

    fn add(&mut self, patch: ShaderPatch) {
        if self
            .states
            .insert(patch.name, PatchState::Pending)
            .is_none()
        {
            self.patches.push(patch);
        }
    }
}

/// Adds patches to an app.
pub trait PatchShadersExt {
    /// Applies this patch as soon as its shader is loaded, before any pipeline is built from it.
    ///
    /// Adding a patch of the same name again does nothing.
    fn patch_shader(&mut self, patch: ShaderPatch) -> &mut Self;
}

impl PatchShadersExt for App {
    fn patch_shader(&mut self, patch: ShaderPatch) -> &mut Self {
        if !self.world().contains_resource::<ShaderPatches>() {
            self.init_resource::<ShaderPatches>().add_systems(
                PostUpdate,
                // Before the shaders of this frame are announced to the renderer.
                apply_patches
                    .run_if(resource_exists_and_changed::<Assets<Shader>>)
                    .before(AssetEventSystems),
            );
        }
        self.world_mut().resource_mut::<ShaderPatches>().add(patch);
        self
    }
}

fn apply_patches(mut shaders: ResMut<Assets<Shader>>, mut patches: ResMut<ShaderPatches>) {
    let ShaderPatches { patches, states } = &mut *patches;
    for patch in patches.iter() {
        let ids: Vec<_> = shaders
            .iter()
            .filter(|(_, shader)| patch.is_for(shader))
            .map(|(id, _)| id)
            .collect();
        for id in ids {
            let state = apply(&mut shaders, id, patch);
            if let PatchState::Refused(error) = &state
                && states.get(patch.name) != Some(&state)
            {
                error!(
                    "`{}` leaves Bevy's shader `{}` as it is: {error}",
                    patch.name, patch.shader
                );
            }
            states.insert(patch.name, state);
        }
    }
}

/// Writes to the assets only where something is inserted: to be told of a change is to run again.
fn apply(
    shaders: &mut ResMut<Assets<Shader>>,
    id: AssetId<Shader>,
    patch: &ShaderPatch,
) -> PatchState {
    let Some(shader) = shaders.get(id) else {
        return PatchState::Pending;
    };
    let Source::Wesl(source) = &shader.source else {
        return PatchState::Refused(PatchError::NotWesl);
    };
    let source = match patched(source, patch) {
        Ok(Some(source)) => source,
        Ok(None) => return PatchState::Applied,
        Err(error) => return PatchState::Refused(error),
    };
    // Parsed again, because a patch may import another module.
    let parsed = Shader::from_wesl(source, shader.path.clone());
    let patched = Shader {
        source: parsed.source,
        imports: parsed.imports,
        ..shader.clone()
    };
    match shaders.insert(id, patched) {
        Ok(()) => PatchState::Applied,
        Err(error) => PatchState::Refused(PatchError::Asset(error.to_string())),
    }
}
