//! A game pays for what it uses: with all plugins added and none used, a frame is Bevy's own.

use std::collections::BTreeSet;

use bevy::{
    prelude::*,
    render::{
        RenderApp,
        render_resource::{CachedPipeline, PipelineCache, PipelineDescriptor},
        renderer::RenderDevice,
    },
};
use image::RgbImage;

use crate::support::{add_plugins, gpu, headless, lit_cube};

/// What there is of a frame.
struct Frame {
    picture: RgbImage,
    /// Passes with a time stamp.
    passes: BTreeSet<String>,
    /// Labels of render and compute pipelines, whichever state they are in.
    pipelines: Vec<String>,
    /// Name and bytes of each allocation of the device, sorted.
    allocations: Vec<(String, u64)>,
}

/// Sorted, as pipelines are made in any order.
fn pipelines(cache: &PipelineCache) -> Vec<String> {
    let label = |pipeline: &CachedPipeline| match &pipeline.descriptor {
        PipelineDescriptor::RenderPipelineDescriptor(render) => render.label.clone(),
        PipelineDescriptor::ComputePipelineDescriptor(compute) => compute.label.clone(),
        PipelineDescriptor::MeshPipelineDescriptor(mesh) => mesh.label.clone(),
    };
    let labels = cache.pipelines().map(label);
    let mut labels: Vec<_> = labels
        .map(|label| label.unwrap_or_default().into())
        .collect();
    labels.sort();
    labels
}

fn frame(build: impl FnOnce(&mut App)) -> Frame {
    let mut app = headless(48, 32, |app| {
        build(app);
        lit_cube(app);
    });
    app.run_until_ready(100).expect("ready");
    let picture = app.capture_rgb8().expect("a picture");
    let (_, spans) = app.measure_spans(2).expect("frames");
    let world = app.app_mut().sub_app(RenderApp).world();
    let device = world.resource::<RenderDevice>().wgpu_device();
    let report = device.generate_allocator_report();
    let allocations = report.into_iter().flat_map(|report| report.allocations);
    let mut allocations: Vec<_> = allocations.map(|a| (a.name, a.size)).collect();
    allocations.sort();
    Frame {
        picture,
        passes: spans.into_keys().collect(),
        pipelines: pipelines(world.resource()),
        allocations,
    }
}

#[test]
fn plugins_that_are_added_but_not_used_cost_nothing() {
    let _gpu = gpu();
    let bevy = frame(|_| {});
    let ours = frame(add_plugins);
    assert!(bevy.picture == ours.picture, "another picture");
    assert_eq!(bevy.passes, ours.passes);
    assert_eq!(bevy.pipelines, ours.pipelines);
    let names = |frame: &Frame| {
        let names = frame.allocations.iter().map(|(name, _)| name.clone());
        names.collect::<Vec<_>>()
    };
    assert_eq!(names(&bevy), names(&ours));
    // An allocation may be up to its alignment larger, depending on what was before it.
    let bytes = |frame: &Frame| {
        frame
            .allocations
            .iter()
            .map(|(_, bytes)| bytes)
            .sum::<u64>()
    };
    let difference = bytes(&bevy).abs_diff(bytes(&ours));
    println!(
        "{} allocations, {difference} bytes of alignment",
        ours.allocations.len()
    );
    assert!(difference < 1024, "{difference} bytes");
}
