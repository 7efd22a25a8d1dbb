//! Waiting until every asset is loaded and every pipeline compiled.

use bevy::{
    asset::{AssetServer, LoadState, RecursiveDependencyLoadState},
    render::{
        RenderApp,
        render_resource::{CachedPipelineState, PipelineCache, PipelineDescriptor},
    },
    shader::ShaderCacheError,
    time::{Time, Virtual},
};

use super::{AwaitedAssets, AwaitedWork, HeadlessApp, HeadlessError, Unwatched};

/// Frames in a row without anything new to load or compile after which a scene counts as ready.
///
/// An asset takes one frame to reach the render world, its pipelines are requested in the next
/// and drawn with in the third.
const QUIET_FRAMES: u32 = 3;

impl HeadlessApp {
    /// Renders until all [`AwaitedAssets`] are loaded, all [`AwaitedWork`] is done and all pipelines compiled; the number of
    /// frames that it took.
    ///
    /// The scene's time stands still meanwhile, so that it does not depend on how long a disk
    /// takes to load an asset.
    pub fn run_until_ready(&mut self, max_frames: u32) -> Result<u32, HeadlessError> {
        let was_paused = self.set_paused(true);
        self.app.insert_resource(Unwatched);
        let result = self.wait_until_ready(max_frames);
        self.app.world_mut().remove_resource::<Unwatched>();
        self.set_paused(was_paused);
        result
    }

    /// Renders until no pipeline waits, as one does for a shader that a busy machine loads late: nothing that it draws
    /// would be in the picture. Not in apps whose pipelines compile in the background.
    pub(super) fn wait_for_pipelines(&mut self) {
        const MAX_FRAMES: u32 = 500;
        if !self.settings.compiles_in_background && self.waiting_pipelines().next().is_some() {
            // What is never ready is not in the picture of a game, either.
            let _ = self.run_until_ready(MAX_FRAMES);
        }
    }

    /// Stops or restarts the scene's time; whether it stood still before.
    fn set_paused(&mut self, pause: bool) -> bool {
        let mut time = self.app.world_mut().resource_mut::<Time<Virtual>>();
        let was_paused = time.is_paused();
        if pause {
            time.pause();
        } else {
            time.unpause();
        }
        was_paused
    }

    fn wait_until_ready(&mut self, max_frames: u32) -> Result<u32, HeadlessError> {
        let mut quiet = 0;
        let mut pipelines = 0;
        let mut waiting = vec!["the first frame".into()];
        for frame in 1..=max_frames {
            self.render_frame()?;
            self.check_pipelines()?;
            waiting = self.loading_assets()?;
            waiting.extend(self.waiting_pipelines());
            let work = &self.app.world().resource::<AwaitedWork>().0;
            waiting.extend(work.iter().map(ToString::to_string));
            let count = self.pipeline_cache().pipelines().count();
            quiet = if waiting.is_empty() && count == pipelines {
                quiet + 1
            } else {
                0
            };
            pipelines = count;
            if quiet == QUIET_FRAMES {
                return Ok(frame);
            }
            if !waiting.is_empty() {
                // Assets load on other threads: let them, instead of burning frames.
                std::thread::sleep(std::time::Duration::from_millis(2));
            }
        }
        if waiting.is_empty() {
            waiting.push(format!("{QUIET_FRAMES} frames without a new pipeline"));
        }
        Err(HeadlessError::NotReady {
            frames: max_frames,
            waiting,
        })
    }

    /// Fails if a pipeline failed.
    pub fn check_pipelines(&self) -> Result<(), HeadlessError> {
        for pipeline in self.pipeline_cache().pipelines() {
            if let CachedPipelineState::Err(error) = &pipeline.state
                && !is_waiting(&pipeline.state)
            {
                return Err(HeadlessError::Pipeline {
                    label: label(&pipeline.descriptor),
                    error: error.to_string(),
                });
            }
        }
        Ok(())
    }

    fn pipeline_cache(&self) -> &PipelineCache {
        self.app.sub_app(RenderApp).world().resource()
    }

    fn waiting_pipelines(&self) -> impl Iterator<Item = String> {
        self.pipeline_cache()
            .pipelines()
            .filter(|pipeline| is_waiting(&pipeline.state))
            .map(|pipeline| format!("pipeline `{}`", label(&pipeline.descriptor)))
    }

    /// Awaited assets that are still loading.
    fn loading_assets(&self) -> Result<Vec<String>, HeadlessError> {
        let world = self.app.world();
        let server = world.resource::<AssetServer>();
        let mut loading = Vec::new();
        for handle in &world.resource::<AwaitedAssets>().0 {
            // An asset that was added rather than loaded has no state, and is there.
            let Some((load, _, recursive)) = server.get_load_states(handle.id()) else {
                continue;
            };
            let path = match handle.path() {
                Some(path) => path.to_string(),
                None => format!("{:?}", handle.id()),
            };
            let failure = match (&load, &recursive) {
                (LoadState::Failed(error), _) => Some(error),
                (_, RecursiveDependencyLoadState::Failed(error)) => Some(error),
                _ => None,
            };
            if let Some(error) = failure {
                let error = error.to_string();
                return Err(HeadlessError::Asset { path, error });
            }
            if !load.is_loaded() || !recursive.is_loaded() {
                loading.push(format!("asset `{path}`"));
            }
        }
        Ok(loading)
    }
}

/// Whether the cache will try this pipeline again: a shader that is still loading is an error to
/// it as well.
fn is_waiting(state: &CachedPipelineState) -> bool {
    matches!(
        state,
        CachedPipelineState::Queued
            | CachedPipelineState::Creating(_)
            | CachedPipelineState::Err(
                ShaderCacheError::ShaderNotLoaded(_)
                    | ShaderCacheError::ShaderImportNotYetAvailable
            )
    )
}

fn label(descriptor: &PipelineDescriptor) -> String {
    let label = match descriptor {
        PipelineDescriptor::RenderPipelineDescriptor(descriptor) => &descriptor.label,
        PipelineDescriptor::ComputePipelineDescriptor(descriptor) => &descriptor.label,
        PipelineDescriptor::MeshPipelineDescriptor(descriptor) => &descriptor.label,
    };
    label.as_deref().unwrap_or("unlabelled").into()
}
