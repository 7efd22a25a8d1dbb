//! Compute kernels: an entry point of a shader, in the variants that settings need.

use bevy::{
    ecs::system::SystemParam,
    prelude::*,
    render::{
        diagnostic::RecordDiagnostics,
        render_resource::{
            BindGroup, BindGroupLayoutDescriptor, CachedComputePipelineId, ComputePass,
            ComputePassDescriptor, ComputePipeline, ComputePipelineDescriptor, PipelineCache,
        },
        renderer::RenderContext,
    },
};

use super::bindings::Group;
use crate::prepare::buffers::{BufferShape, VolumeBuffers};

/// The pipelines that the passes of this frame need: light is computed only once all are ready.
#[derive(Resource, Default)]
pub(crate) struct RequiredPipelines(Vec<CachedComputePipelineId>);

impl RequiredPipelines {
    /// Empties the list; returns whether all pipelines in it are ready.
    pub(crate) fn take_ready(&mut self, cache: &PipelineCache) -> bool {
        self.0.drain(..).fold(true, |all, id| {
            all & cache.get_compute_pipeline(id).is_some()
        })
    }
}

/// By which passes choose their pipelines.
#[derive(SystemParam)]
pub(crate) struct Pipelines<'w> {
    cache: Res<'w, PipelineCache>,
    required: ResMut<'w, RequiredPipelines>,
}

/// An entry point of a compute shader.
pub(crate) struct Kernel {
    descriptor: ComputePipelineDescriptor,
    variants: Vec<(Vec<&'static str>, CachedComputePipelineId)>,
    current: Option<CachedComputePipelineId>,
}

impl Kernel {
    pub(super) fn new(
        label: &'static str,
        entry_point: &'static str,
        shader: &Handle<Shader>,
        layouts: &[&BindGroupLayoutDescriptor],
    ) -> Self {
        Self {
            descriptor: ComputePipelineDescriptor {
                label: Some(label.into()),
                layout: layouts.iter().map(|layout| (*layout).clone()).collect(),
                shader: shader.clone(),
                entry_point: Some(entry_point.into()),
                ..default()
            },
            variants: Vec::new(),
            current: None,
        }
    }

    /// A kernel of the passes that compute light: group 0 has the voxels, group 1 what the pass binds itself.
    pub(super) fn of_light(
        label: &'static str,
        entry_point: &'static str,
        shader: &Handle<Shader>,
        own: &Group,
    ) -> Self {
        let voxels = Group::of_light(0, false);
        Self::new(label, entry_point, shader, &[&voxels.layout, &own.layout])
            .with_zeroed_workgroup_memory()
    }

    pub(super) fn with_zeroed_workgroup_memory(mut self) -> Self {
        self.descriptor.zero_initialize_workgroup_memory = true;
        self
    }

    /// Chooses the variant with these shader defs for this frame, which waits until it is ready.
    pub(super) fn require(&mut self, defs: &[&'static str], pipelines: &mut Pipelines) {
        let id = self.choose(defs, pipelines);
        pipelines.required.0.push(id);
    }

    /// Chooses the variant with these shader defs for this frame.
    pub(super) fn choose(
        &mut self,
        defs: &[&'static str],
        pipelines: &Pipelines,
    ) -> CachedComputePipelineId {
        let known = self.variants.iter().find(|(known, _)| known == defs);
        let known = known.map(|(_, id)| *id);
        let id = known.unwrap_or_else(|| {
            let mut descriptor = self.descriptor.clone();
            descriptor.shader_defs = defs.iter().map(|&def| def.into()).collect();
            if defs.contains(&REPROJECTED_ALBEDO) {
                descriptor.layout[0] = Group::of_light(0, true).layout;
            }
            let id = pipelines.cache.queue_compute_pipeline(descriptor);
            self.variants.push((defs.to_vec(), id));
            id
        });
        self.current = Some(id);
        id
    }

    /// The variant of this frame, if it is ready.
    pub(super) fn pipeline<'a>(&self, cache: &'a PipelineCache) -> Option<&'a ComputePipeline> {
        cache.get_compute_pipeline(self.current?)
    }
}

/// The shader def of the kernels that compute light from reprojected albedo, which is in group 0 then.
const REPROJECTED_ALBEDO: &str = "REPROJECTED_ALBEDO";

pub(super) fn light_defs(shape: BufferShape) -> Vec<&'static str> {
    chosen([
        (shape.occlusion_only, "OCCLUSION_ONLY"),
        (shape.reprojects_albedo, REPROJECTED_ALBEDO),
        (shape.per_pixel, "PER_PIXEL"),
    ])
}

/// The shader defs that are on.
pub(crate) fn chosen<const N: usize>(defs: [(bool, &'static str); N]) -> Vec<&'static str> {
    let defs = defs.into_iter().filter(|(is_on, _)| *is_on);
    defs.map(|(_, def)| def).collect()
}

/// Records a compute pass with a timing span.
pub(super) fn record_pass(
    context: &mut RenderContext,
    label: &'static str,
    record: impl FnOnce(&mut ComputePass<'_>),
) {
    let diagnostics = context.diagnostic_recorder();
    let encoder = context.command_encoder();
    let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
        label: Some(label),
        ..default()
    });
    let span = diagnostics.as_ref().map(|d| d.pass_span(&mut pass, label));
    record(&mut pass);
    if let Some(span) = span {
        span.end(&mut pass);
    }
}

pub(super) fn set_bind_groups(pass: &mut ComputePass<'_>, groups: &[BindGroup]) {
    for (i, group) in (0..).zip(groups) {
        pass.set_bind_group(i, group, &[]);
    }
}

/// Workgroups in two dimensions, as one is limited to 65,535: rows of equal width with this number in total, and fewer
/// than there are rows in excess.
fn workgroup_grid(count: u32) -> [u32; 2] {
    const MAX_WIDTH: u32 = 32768;
    let rows = count.div_ceil(MAX_WIDTH).max(1);
    [count.div_ceil(rows), rows]
}

/// Dispatches this number of workgroups, and a few in excess, which shaders must leave out.
pub(super) fn dispatch_workgroups(pass: &mut ComputePass<'_>, count: u32) {
    let [width, rows] = workgroup_grid(count);
    pass.dispatch_workgroups(width, rows, 1);
}

pub(super) fn dispatch_voxels(
    pass: &mut ComputePass<'_>,
    pipeline: &ComputePipeline,
    buffers: &VolumeBuffers,
) {
    pass.set_pipeline(pipeline);
    let groups = buffers.shape.voxels.div_ceil(64);
    dispatch_workgroups(pass, u32::try_from(groups).unwrap_or(u32::MAX));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_has_hardly_more_workgroups_than_items() {
        assert_eq!(workgroup_grid(0)[0], 0);
        for count in [
            1,
            100,
            32_767,
            32_768,
            32_769,
            65_537,
            100_003,
            6 * 128 * 128 * 128,
        ] {
            let [width, rows] = workgroup_grid(count);
            assert!(width <= 32_768 && rows <= 65_535);
            let excess = width * rows - count;
            assert!(excess < rows, "{excess} of {count}");
        }
    }
}
