//! Insertion of text into Bevy's shaders when they are loaded.
//!
//! A [`ShaderPatch`] only inserts, at positions that must exist exactly once. It removes nothing, so
//! the anchors of other patches stay intact and the order of patches does not matter. It writes its name
//! into the source and is therefore never applied twice; it is applied again when the shader is
//! reloaded. If it does not fit, as may happen with another version of Bevy, the shader stays
//! unchanged, the patch is [`PatchState::Refused`] and one error names the shader and the reason.

mod patch;

use bevy::{
    asset::AssetEventSystems,
    platform::collections::HashMap,
    prelude::*,
    shader::{Shader, Source},
};

pub use patch::{Insertion, PatchError, ShaderPatch, patched};

/// The state of a patch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PatchState {
    /// The shader is not loaded yet.
    Pending,
    /// The shader contains the patch.
    Applied,
    /// The patch does not fit, and the shader is unchanged.
    Refused(PatchError),
}

/// The patches of an app and their states.
#[derive(Resource, Debug, Default)]
pub struct ShaderPatches {
    patches: Vec<ShaderPatch>,
    states: HashMap<&'static str, PatchState>,
}

impl ShaderPatches {
    /// Returns the state of the patch of this name; `None` if it was never added.
    pub fn state(&self, name: &str) -> Option<&PatchState> {
        self.states.get(name)
    }

    /// Returns true if all of these patches are applied.
    pub fn all_applied(&self, names: &[&str]) -> bool {
        names
            .iter()
            .all(|name| self.state(name) == Some(&PatchState::Applied))
    }

    /// Returns the first of these patches that was refused, and the reason.
    pub fn refused<'a>(&'a self, names: &[&'a str]) -> Option<(&'a str, &'a PatchError)> {
        names.iter().find_map(|&name| match self.state(name) {
            Some(PatchState::Refused(error)) => Some((name, error)),
            _ => None,
        })
    }

    fn add(&mut self, patch: ShaderPatch) {
        if !self.states.contains_key(patch.name) {
            self.states.insert(patch.name, PatchState::Pending);
            self.patches.push(patch);
        }
    }
}

/// Extension trait that adds patches to an app.
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
                // Before asset events announce the shaders of this frame to the renderer.
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
        // Another shader may override Bevy's by its import path, and it is not known which of them is compiled. So a
        // patch is applied where it is in all of them.
        let states_of_shaders = ids.into_iter().map(|id| apply(&mut shaders, id, patch));
        let Some(state) = states_of_shaders.reduce(|state, other| match state {
            PatchState::Refused(_) => state,
            _ => other,
        }) else {
            continue;
        };
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

/// Writes to the assets only where something is inserted, because every change of them runs the system
/// again.
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
    // It is parsed again, because a patch may import another module.
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

#[cfg(test)]
mod tests {
    use super::*;

    const PATH: &str = "embedded://bevy_pbr/render/test.wesl";

    fn patch() -> ShaderPatch {
        ShaderPatch {
            insertions: vec![Insertion::before("return color;", "color = 2.0 * color;\n")],
            ..ShaderPatch::new("test", "bevy_pbr::render::test")
        }
    }

    fn app(sources: &[&str]) -> App {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, AssetPlugin::default()))
            .init_asset::<Shader>()
            .patch_shader(patch());
        let mut shaders = app.world_mut().resource_mut::<Assets<Shader>>();
        for source in sources {
            let shader = shaders.add(Shader::from_wesl((*source).to_owned(), PATH));
            // The asset stays as long as its handle.
            std::mem::forget(shader);
        }
        app.update();
        app
    }

    const BEVYS: &str = "fn f(c: f32) -> f32 { var color = c;\nreturn color;\n}";
    const OVERRIDE: &str = "fn f(c: f32) -> f32 { return c; }";

    #[test]
    fn a_shader_that_overrides_bevys_is_not_taken_for_the_patched_one() {
        for sources in [[BEVYS, OVERRIDE], [OVERRIDE, BEVYS]] {
            let app = app(&sources);
            let patches = app.world().resource::<ShaderPatches>();
            assert!(patches.refused(&["test"]).is_some(), "{patches:?}");
        }
    }

    #[test]
    fn a_patch_that_is_added_again_stays_applied() {
        let mut app = app(&[BEVYS]);
        let is_applied = |app: &App| {
            app.world()
                .resource::<ShaderPatches>()
                .all_applied(&["test"])
        };
        assert!(is_applied(&app));
        app.patch_shader(patch());
        assert!(is_applied(&app));
        app.update();
        assert!(is_applied(&app));
    }
}
