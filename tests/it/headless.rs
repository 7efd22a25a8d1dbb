//! Frames without a window.

use bevy::{
    prelude::*,
    render::{
        RenderApp, RenderStartup,
        render_resource::{
            BufferDescriptor, BufferUsages, ComputePipelineDescriptor, PipelineCache,
        },
        renderer::RenderDevice,
    },
    shader::Shader,
};
use bevy_frugal_lab::headless::{
    AwaitedAssets, HeadlessApp, HeadlessError, HeadlessSettings, TargetFormat,
};

use crate::support::{gpu, gpu_alone, headless, lit_cube, renderer_errors};

const MAX_FRAMES: u32 = 200;

fn cube(settings: HeadlessSettings) -> HeadlessApp {
    let mut app = HeadlessApp::new(settings, lit_cube).expect("an adapter");
    app.run_until_ready(MAX_FRAMES).expect("ready");
    app
}

#[test]
fn two_apps_render_the_same_bytes() {
    let _gpu = gpu();
    let picture = || {
        let mut app = cube(HeadlessSettings::with_size(96, 64));
        assert!(!app.adapter().name.is_empty());
        let times = app.measure_frames(5).expect("frames");
        assert!(times.cpu_ms.is_some_and(|ms| ms > 0.0));
        app.capture_rgb8().expect("a picture")
    };
    let first = picture();
    assert_eq!(first.dimensions(), (96, 64));
    let lit = first.pixels().filter(|pixel| pixel[0] > 100).count();
    assert!(lit > 300, "only {lit} pixels show the cube");
    assert!(first == picture(), "the second run differs");
}

#[test]
fn pictures_of_any_size_and_format_can_be_captured() {
    let _gpu = gpu();
    for (width, height) in [(1, 1), (37, 53)] {
        let mut app = cube(HeadlessSettings::with_size(width, height));
        let picture = app.capture_rgb8().expect("a picture");
        assert_eq!(picture.dimensions(), (width, height));
    }
    for format in [TargetFormat::Float32, TargetFormat::Float16] {
        let mut app = cube(HeadlessSettings {
            format,
            ..HeadlessSettings::with_size(21, 9)
        });
        let picture = app.capture_f32().expect("a picture");
        assert_eq!((picture.width, picture.height), (21, 9));
        assert_eq!(picture.pixels.len(), 21 * 9);
        assert!(
            picture.pixels[21 * 4 + 10][0] > 0.05,
            "no cube in the middle"
        );
        let wrong = app.capture_rgb8().expect_err("floats are not bytes");
        assert!(matches!(wrong, HeadlessError::Format { .. }));
    }
}

#[test]
fn impossible_sizes_and_adapters_are_refused() {
    let _gpu = gpu();
    let refusal = |settings| match HeadlessApp::new(settings, |_| ()) {
        Ok(_) => panic!("accepted"),
        Err(error) => error.to_string(),
    };
    let text = refusal(HeadlessSettings::with_size(0, 5));
    assert!(text.contains("0x5"), "{text}");
    if std::env::var_os("WGPU_ADAPTER_NAME").is_none() {
        let text = refusal(HeadlessSettings {
            adapter_name: Some("no such adapter".into()),
            ..HeadlessSettings::default()
        });
        assert!(
            text.contains("no such adapter") && text.contains("driver"),
            "{text}"
        );
    }
}

#[test]
fn disabled_features_are_absent() {
    let _gpu = gpu();
    let bc = wgpu::Features::TEXTURE_COMPRESSION_BC;
    let with = headless(1, 1, |_| ());
    let settings = HeadlessSettings {
        disabled_features: bc,
        ..HeadlessSettings::with_size(1, 1)
    };
    let without = HeadlessApp::new(settings, |_| ()).expect("an adapter");
    assert!(!without.features().intersects(bc));
    assert_eq!(without.features() | bc, with.features() | bc);
}

#[test]
fn a_broken_pipeline_is_named() {
    let _gpu = gpu();
    let mut app = headless(4, 4, |app| {
        let source = "@compute @workgroup_size(1) fn main() { undefined_name(); }";
        let shader = Shader::from_wgsl(source, "broken.wgsl");
        let shader = app.world_mut().add_asset::<Shader>(shader);
        let queue = move |cache: Res<PipelineCache>| {
            cache.queue_compute_pipeline(ComputePipelineDescriptor {
                label: Some("broken_pipeline".into()),
                shader: shader.clone(),
                entry_point: Some("main".into()),
                ..default()
            });
        };
        app.sub_app_mut(RenderApp).add_systems(RenderStartup, queue);
    });
    let error = app.run_until_ready(MAX_FRAMES).expect_err("it is broken");
    let text = error.to_string();
    assert!(matches!(error, HeadlessError::Pipeline { .. }), "{text}");
    assert!(
        text.contains("broken_pipeline") && text.contains("undefined_name"),
        "{text}"
    );
}

#[test]
fn a_missing_asset_is_named() {
    let _gpu = gpu();
    let mut app = headless(4, 4, |app| {
        let image = app.world().load_asset::<Image>("missing.png");
        let mut awaited = app.world_mut().resource_mut::<AwaitedAssets>();
        awaited.0.push(image.untyped());
    });
    let error = app.run_until_ready(MAX_FRAMES).expect_err("missing");
    let text = error.to_string();
    assert!(text.contains("missing.png"), "{text}");
}

#[test]
fn an_error_of_the_renderer_is_reported() {
    // Its error is logged, too, and would fail a test beside it.
    let _gpu = gpu_alone();
    let mut app = cube(HeadlessSettings::with_size(4, 4));
    let device = app.world().resource::<RenderDevice>();
    device.create_buffer(&BufferDescriptor {
        label: Some("larger_than_any_memory"),
        size: u64::MAX / 2,
        usage: BufferUsages::STORAGE,
        mapped_at_creation: false,
    });
    let error = app
        .render_frames(2)
        .expect_err("it was refused")
        .to_string();
    assert!(error.contains("larger_than_any_memory"), "{error}");
    assert!(!renderer_errors().is_empty());
}
