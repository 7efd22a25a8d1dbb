//! Runs the frames of a method in a scene and compares them with path tracing.

use std::{error::Error, ops::RangeInclusive, path::Path, time::Instant};

use bevy::{color::Srgba, math::Vec3, prelude::*, render::renderer::RenderDevice};
use bevy_frugal_lab::{
    boxes::{TracedScene, agreement, block_means, spawn_box_scene},
    headless::{HeadlessApp, HeadlessError, HeadlessSettings, TargetFormat, median},
};
use bevy_frugal_studies::{
    record::{ReportAdapter, Times},
    voxel_gi::LightRow,
};
use bevy_solari::SolariPlugins;
use image::{ImageResult, Rgb, RgbImage};

use crate::{bake::Baked, method::Method};

/// Frames before which every pipeline must have been compiled.
const MAX_FRAMES: u32 = 200;
/// Frames of a still camera after which its picture is compared.
const FRAMES: [u32; 3] = [1, 8, 64];
/// Frames whose mean is compared too, where pictures have noise: by then the light has settled.
const SETTLED: RangeInclusive<u32> = 193..=256;

/// The rows of a method in a scene, and the adapter; its pictures are written to the folder.
///
/// # Errors
/// What cannot be rendered or written, or which features the adapter lacks.
pub fn rows(
    truth: &TracedScene,
    method: Method,
    pictures: Option<&Path>,
) -> Result<(Vec<LightRow>, ReportAdapter), Box<dyn Error>> {
    let scene = &truth.scene;
    let (mut app, baked) = app(truth, method)?;
    let direct = picture(&mut app)?;
    if matches!(method, Method::Ambient | Method::AmbientAndSsao) {
        fit_ambient(&mut app, truth, &direct)?;
        app.render_frames(2)?;
    }
    let total = total(truth);
    let row = |setting: String, picture: &[Vec3], truth: &[Vec3]| {
        let found = agreement(picture, scene.camera.width, truth);
        LightRow {
            scene: scene.name.clone(),
            setting,
            relative_error: Some(found.relative_error),
            bias: Some(found.bias),
            ..LightRow::default()
        }
    };
    let frames = if method.converges() {
        &FRAMES[..]
    } else {
        &[8]
    };
    let last = if method.is_noisy() {
        *SETTLED.end()
    } else {
        frames.last().copied().unwrap_or_default()
    };
    method.switch_on(app.world_mut(), scene);
    let mut rows = Vec::new();
    let mut times = Vec::new();
    let mut before = Vec::new();
    let mut sum = vec![Vec3::ZERO; (scene.camera.width * scene.camera.height) as usize];
    for frame in 1..=last {
        let start = Instant::now();
        app.render_frames(1)?;
        times.push(1e3 * start.elapsed().as_secs_f64());
        let now = picture(&mut app)?;
        if SETTLED.contains(&frame) {
            sum.iter_mut().zip(&now).for_each(|(sum, now)| *sum += now);
        }
        if frames.contains(&frame) {
            let setting = if method.converges() {
                format!("{}, frame {frame}", method.name())
            } else {
                method.name().into()
            };
            rows.push(LightRow {
                flicker: (frame > 1).then(|| flicker(&before, &now)),
                times: Times {
                    cpu_ms: median(&times),
                    ..Times::default()
                },
                ..row(setting, &now, &total)
            });
            times.clear();
        }
        before = now;
    }
    if method.is_noisy() {
        let (first, last) = (SETTLED.start(), SETTLED.end());
        let count = last - first + 1;
        before = sum.iter().map(|sum| sum / count as f32).collect();
        let setting = format!("{}, mean of frames {first} to {last}", method.name());
        rows.push(row(setting, &before, &total));
    }
    let adds = !method.traces_rays() && method != Method::NoGi;
    if adds {
        let added = difference(&before, &direct);
        let setting = format!("{}, what it adds", method.name());
        rows.push(row(setting, &added, &truth.indirect));
    }
    rows.extend(baked.map(|baked| baked.row(&scene.name, method.name())));
    if let Some(folder) = pictures {
        let gray = mean(&truth.indirect);
        let write = |part: &str, picture: &[Vec3]| {
            let file = format!("{} {}{part}.png", scene.name, method.name());
            write_png(&folder.join(file), scene.camera.width, picture, gray)
        };
        write("", &before)?;
        if adds {
            write(" adds", &difference(&before, &direct))?;
        }
    }
    Ok((rows, app.adapter().into()))
}

/// The app of a method, with all its pipelines and without light of earlier frames, and what was baked for it.
fn app(
    truth: &TracedScene,
    method: Method,
) -> Result<(HeadlessApp, Option<Baked>), Box<dyn Error>> {
    let camera = &truth.scene.camera;
    let settings = HeadlessSettings {
        format: TargetFormat::Float32,
        ..HeadlessSettings::with_size(camera.width, camera.height)
    };
    let mut app = HeadlessApp::new(settings, |app| method.build(app))?;
    let missing = SolariPlugins::required_wgpu_features()
        .difference(app.world().resource::<RenderDevice>().features());
    if method.traces_rays() && !missing.is_empty() {
        let name = &app.adapter().name;
        return Err(format!(
            "bevy_solari cannot draw on `{name}`, which lacks {missing:?}: choose another adapter with \
             WGPU_ADAPTER_NAME, or run this with `scripts/gpu-static software`"
        )
        .into());
    }
    let world = app.world_mut();
    let boxes = spawn_box_scene(world, &truth.scene);
    let baked = method.prepare(world, &truth.scene, &boxes[..truth.scene.boxes.len()]);
    method.switch_on(world, &truth.scene);
    app.run_until_ready(MAX_FRAMES)?;
    method.switch_off(app.world_mut());
    // What is removed may still be seen in the first.
    app.render_frames(3)?;
    Ok((app, baked))
}

/// All light of surfaces, and zero where a block shows none.
fn total(truth: &TracedScene) -> Vec<Vec3> {
    let blocks = truth.direct.iter().zip(&truth.indirect);
    blocks
        .map(|(direct, indirect)| match *indirect {
            Vec3::ZERO => Vec3::ZERO,
            indirect => direct + indirect,
        })
        .collect()
}

/// Sets the ambient light of an app that has none; `direct` is its picture.
///
/// # Errors
/// [`HeadlessError`] when a frame cannot be rendered.
fn fit_ambient(
    app: &mut HeadlessApp,
    truth: &TracedScene,
    direct: &[Vec3],
) -> Result<(), HeadlessError> {
    app.world_mut().insert_resource(ambient(Vec3::ONE));
    app.render_frames(2)?;
    let white = difference(&picture(app)?, direct);
    let white = block_means(&white, truth.scene.camera.width);
    let (mut added, mut wanted) = (Vec3::ZERO, Vec3::ZERO);
    for (white, indirect) in white.iter().zip(&truth.indirect) {
        if *indirect != Vec3::ZERO {
            added += white;
            wanted += indirect;
        }
    }
    let fitted = wanted / added.max(Vec3::splat(f32::MIN_POSITIVE));
    app.world_mut().insert_resource(ambient(fitted));
    Ok(())
}

fn ambient(luminance: Vec3) -> GlobalAmbientLight {
    let brightness = luminance.max_element();
    GlobalAmbientLight {
        color: LinearRgba::from_vec3(luminance / brightness).into(),
        brightness,
        ..default()
    }
}

/// The picture of the last frame.
fn picture(app: &mut HeadlessApp) -> Result<Vec<Vec3>, HeadlessError> {
    let image = app.capture_f32()?;
    let rgb = |p: &[f32; 4]| Vec3::new(p[0], p[1], p[2]);
    Ok(image.pixels.iter().map(rgb).collect())
}

/// One picture less another.
fn difference(with: &[Vec3], without: &[Vec3]) -> Vec<Vec3> {
    with.iter().zip(without).map(|(a, b)| a - b).collect()
}

/// Mean absolute difference of two pictures over the mean of the second.
fn flicker(before: &[Vec3], now: &[Vec3]) -> f64 {
    let sum = |values: &mut dyn Iterator<Item = Vec3>| -> f64 {
        values.map(|v| f64::from(v.element_sum())).sum()
    };
    sum(&mut before.iter().zip(now).map(|(a, b)| (b - a).abs())) / sum(&mut now.iter().copied())
}

/// Writes a picture in which this radiance is a middle gray.
///
/// # Errors
/// If the file cannot be written.
fn write_png(path: &Path, width: u32, picture: &[Vec3], gray: f32) -> ImageResult<()> {
    let height = picture.len() as u32 / width;
    let image = RgbImage::from_fn(width, height, |x, y| {
        let light = picture[(x + y * width) as usize] * 0.2 / gray;
        Rgb(
            Srgba::from(LinearRgba::from_vec3(light.clamp(Vec3::ZERO, Vec3::ONE)))
                .to_u8_array_no_alpha(),
        )
    });
    image.save(path)
}

/// The mean of all channels of a picture.
fn mean(picture: &[Vec3]) -> f32 {
    picture.iter().sum::<Vec3>().element_sum() / (3 * picture.len()).max(1) as f32
}
