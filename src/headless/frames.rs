//! Frames once all is ready: their times, and their pictures as bytes or floats.
//!
//! The CPU time is that of one update: scene systems, extraction and recording of the commands.
//! The GPU time is the sum of the top-level spans that Bevy's passes record; work outside a span
//! is not in it. Medians, as one hiccup of the system should not move the figure.

use std::{
    collections::{BTreeMap, HashMap},
    sync::mpsc,
    time::Duration,
};

use bevy::{
    asset::{AssetServer, LoadState, RecursiveDependencyLoadState},
    diagnostic::DiagnosticsStore,
    ecs::world::World,
    platform::time::Instant,
    prelude::*,
    render::{
        RenderApp,
        render_asset::RenderAssets,
        render_resource::{CachedPipelineState, PipelineCache, PipelineDescriptor},
        renderer::{RenderDevice, RenderQueue},
        texture::GpuImage,
    },
    shader::ShaderCacheError,
    time::{Time, Virtual},
};
use image::RgbImage;
use serde::Serialize;

use crate::headless::{
    AwaitedAssets, AwaitedWork, HeadlessApp, HeadlessError, TargetFormat, Unwatched,
};

/// Median times of a number of frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FrameTimes {
    /// Time of the CPU in milliseconds; none when no frame was measured.
    pub cpu_ms: Option<f64>,
    /// Time of the GPU in milliseconds; none when the adapter has no timestamps or none of the
    /// frames has come back yet (they are a few frames late).
    pub gpu_ms: Option<f64>,
}

#[derive(Default)]
pub(crate) struct FrameClock {
    cpu_ms: Vec<f64>,
    gpu_ms: Vec<f64>,
    spans: BTreeMap<String, Vec<f64>>,
    seen: HashMap<String, Instant>,
}

impl FrameClock {
    /// A clock that does not count what was measured before.
    pub(crate) fn starting_now(world: &World) -> Self {
        let mut clock = Self::default();
        if let Some(store) = world.get_resource::<DiagnosticsStore>() {
            clock.new_spans(store);
        }
        clock
    }

    pub(crate) fn record(&mut self, cpu: Duration, world: &World) {
        self.cpu_ms.push(cpu.as_secs_f64() * 1e3);
        if let Some(store) = world.get_resource::<DiagnosticsStore>() {
            let spans = self.new_spans(store);
            if !spans.is_empty() {
                self.gpu_ms.push(spans.values().sum());
            }
            for (name, ms) in spans {
                self.spans.entry(name).or_default().push(ms);
            }
        }
    }

    /// Keeps only the last `count` frames, for a running median.
    pub(crate) fn keep_last(&mut self, count: usize) {
        let spans = self.spans.values_mut();
        for times in [&mut self.cpu_ms, &mut self.gpu_ms]
            .into_iter()
            .chain(spans)
        {
            times.drain(..times.len().saturating_sub(count));
        }
    }

    /// The medians so far.
    pub(crate) fn medians(&self) -> FrameTimes {
        FrameTimes {
            cpu_ms: median(&self.cpu_ms),
            gpu_ms: median(&self.gpu_ms),
        }
    }

    /// The median of each top-level span so far.
    pub(crate) fn span_medians(&self) -> BTreeMap<String, f64> {
        let spans = self.spans.iter();
        spans
            .filter_map(|(name, times)| Some((name.clone(), median(times)?)))
            .collect()
    }

    /// Times of the top-level spans that came in since the last call; of a span that came in
    /// several times, the sum.
    fn new_spans(&mut self, store: &DiagnosticsStore) -> BTreeMap<String, f64> {
        let mut spans = BTreeMap::new();
        for diagnostic in store.iter() {
            let path = diagnostic.path();
            let components: Vec<_> = path.components().collect();
            let ["render", name, "elapsed_gpu"] = components[..] else {
                continue;
            };
            for measurement in diagnostic.measurements() {
                let seen = self.seen.get(path.as_str());
                if seen.is_none_or(|seen| measurement.time > *seen) {
                    *spans.entry(name.to_string()).or_insert(0.0) += measurement.value;
                }
            }
            if let Some(last) = diagnostic.measurement() {
                self.seen.insert(path.as_str().into(), last.time);
            }
        }
        spans
    }
}

/// The median: the middle value, or the mean of the two middle ones.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    match sorted.len() {
        0 => None,
        len if len % 2 == 1 => Some(sorted[middle]),
        _ => Some((sorted[middle - 1] + sorted[middle]) / 2.0),
    }
}

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
    fn wait_for_pipelines(&mut self) {
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

/// A picture of linear floats.
#[derive(Clone, Debug, PartialEq)]
pub struct Rgba32FImage {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Red, green, blue and alpha of the pixels, row after row from the top left.
    pub pixels: Vec<[f32; 4]>,
}

impl HeadlessApp {
    /// The last rendered frame as a display would show it, without alpha.
    pub fn capture_rgb8(&mut self) -> Result<RgbImage, HeadlessError> {
        let actual = self.settings.format;
        if actual != TargetFormat::Srgb8 {
            let requested = TargetFormat::Srgb8;
            return Err(HeadlessError::Format { actual, requested });
        }
        self.wait_for_pipelines();
        let bytes = self.read_target(4)?;
        let mut rgb = bytes.chunks_exact(4).flat_map(|texel| &texel[..3]);
        Ok(RgbImage::from_fn(
            self.settings.width,
            self.settings.height,
            |_, _| image::Rgb(std::array::from_fn(|_| *rgb.next().unwrap_or(&0))),
        ))
    }

    /// The last rendered frame as linear floats.
    pub fn capture_f32(&mut self) -> Result<Rgba32FImage, HeadlessError> {
        self.wait_for_pipelines();
        let actual = self.settings.format;
        let pixels = match actual {
            TargetFormat::Float32 => texels(&self.read_target(16)?, f32::from_le_bytes),
            TargetFormat::Float16 => texels(&self.read_target(8)?, |bytes| {
                half::f16::from_le_bytes(bytes).to_f32()
            }),
            TargetFormat::Srgb8 => {
                let requested = TargetFormat::Float32;
                return Err(HeadlessError::Format { actual, requested });
            }
        };
        Ok(Rgba32FImage {
            width: self.settings.width,
            height: self.settings.height,
            pixels,
        })
    }

    fn read_target(&self, texel_bytes: u32) -> Result<Vec<u8>, HeadlessError> {
        Ok(self.read_texture(&self.target, texel_bytes)?.1)
    }

    /// The size and the texels of an image on the GPU, slice by slice and row by row without padding. A
    /// texel has `texel_bytes` bytes.
    pub fn read_texture(
        &self,
        image: &Handle<Image>,
        texel_bytes: u32,
    ) -> Result<(wgpu::Extent3d, Vec<u8>), HeadlessError> {
        self.read_level(image, 0, texel_bytes)
    }

    /// The size and the texels of a mip level of an image, as of [`Self::read_texture`].
    pub fn read_level(
        &self,
        image: &Handle<Image>,
        level: u32,
        texel_bytes: u32,
    ) -> Result<(wgpu::Extent3d, Vec<u8>), HeadlessError> {
        let world = self.app.sub_app(RenderApp).world();
        let device = world.resource::<RenderDevice>().wgpu_device();
        let image = world
            .resource::<RenderAssets<GpuImage>>()
            .get(image)
            .ok_or(HeadlessError::NoTarget)?;

        let size = image.texture.size();
        let size = size.mip_level_size(level, image.texture.dimension());
        let row = size.width * texel_bytes;
        let padded_row = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let rows = u64::from(size.height) * u64::from(size.depth_or_array_layers);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("lab_readback_buffer"),
            size: u64::from(padded_row) * rows,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor {
            label: Some("lab_readback"),
        });
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo {
                mip_level: level,
                ..image.texture.as_image_copy()
            },
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(padded_row),
                    rows_per_image: Some(size.height),
                },
            },
            size,
        );
        world.resource::<RenderQueue>().submit([encoder.finish()]);

        let (sender, receiver) = mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver is gone only when the wait has failed already.
            let _ = sender.send(result);
        });
        self.wait_for_gpu()?;
        match receiver.recv_timeout(self.settings.gpu_timeout) {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(self.readback_error(error)),
            Err(error) => return Err(self.readback_error(error)),
        }
        let mapped = buffer.slice(..).get_mapped_range();
        let mapped = mapped.map_err(|error| self.readback_error(error))?;
        let rows = mapped.chunks_exact(padded_row as usize);
        let texels = rows.flat_map(|padded| &padded[..row as usize]).copied();
        Ok((size, texels.collect()))
    }
}

/// Texels of four channels of `N` little-endian bytes.
fn texels<const N: usize>(bytes: &[u8], decode: impl Fn([u8; N]) -> f32) -> Vec<[f32; 4]> {
    bytes
        .chunks_exact(4 * N)
        .map(|texel| {
            std::array::from_fn(|channel| {
                decode(std::array::from_fn(|byte| texel[channel * N + byte]))
            })
        })
        .collect()
}
