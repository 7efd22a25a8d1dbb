//! A tunnel on the GPU: each filter of the plugin against the hardware's own, of BC7, BC1 and RGBA8.
//!
//! Down a tunnel a texture is seen at every size and angle. All settings are in one app, each with
//! a tunnel of its own of which one is shown, so that their frame times are interleaved. The picture of a filter is compared with that of the hardware's filter of
//! the same name over RGBA8.
//!
//! `bytes` are those of the textures on the GPU, with mips. `fetched_bytes` are counted from the
//! filters, without a cache: what each fetch's texel takes in its blocks. `relative_time` has that of
//! a frame over that of one with BC7 or BC1 and the hardware's filter, and the same of sampling alone,
//! which is a frame's less that of one without a texture, where the hardware's sampling is a tenth of
//! its frame at least: less is noise. Times are the GPU's where it gives them.

mod filters;
mod stage;

use std::collections::BTreeMap;

use bevy::{
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    prelude::*,
    render::{RenderApp, render_asset::RenderAssets, renderer::RenderDevice, texture::GpuImage},
};
use bevy_wavelet_tex::{
    WaveletStorage, WaveletTexPlugin,
    codec::{rate::Rate, settings::Effort},
    material::storage_on,
};
use image::RgbImage;
use indicatif::ProgressBar;

pub use self::filters::{FILTERS, Filter};
use self::stage::{show, spawn_hardware, spawn_ours, tunnel};
use super::encoded::encoded;
use crate::{
    interleaved::{Candidate, benchmark},
    plan::Plan,
    record::{Measurement, ReportAdapter},
    study::{TradeoffError, note},
};
use bevy_frugal_lab::{
    headless::{HeadlessApp, HeadlessSettings, LabTarget},
    metrics::compare,
};

/// Frames before which every asset must have been loaded.
const MAX_FRAMES: u32 = 200;

/// Frames after which those of the setting before have given their times.
const SETTLING_FRAMES: u32 = 2;

/// The rows of `picture`, which tiles, in a frame of `size` pixels, and what rendered them.
pub fn rows(
    picture: &RgbImage,
    filters: &[Filter],
    size: [u32; 2],
    plan: &Plan,
    progress: &ProgressBar,
) -> Result<(ReportAdapter, Vec<Measurement>), TradeoffError> {
    let settings = HeadlessSettings::with_size(size[0], size[1]);
    let mut app = HeadlessApp::new(settings, |app| {
        app.add_plugins(WaveletTexPlugin);
        let target = app.world().resource::<LabTarget>().0.clone();
        app.world_mut().spawn((
            Camera3d::default(),
            target,
            Msaa::Off,
            Tonemapping::None,
            DebandDither::Disabled,
            // Toward one side, so that the texture is seen from near and far.
            Transform::from_xyz(0.3, -0.2, 0.0).looking_to(Vec3::new(0.15, -0.1, -1.0), Vec3::Y),
        ));
    })?;
    let adapter = ReportAdapter::from(app.adapter());
    if storage_on(app.world().resource::<RenderDevice>()) != WaveletStorage::Blocks {
        note(
            progress,
            "skipped: the tunnel, the adapter lacks BC or binds too few textures",
        );
        return Ok((adapter, Vec::new()));
    }
    let tunnel = app.world_mut().resource_mut::<Assets<Mesh>>().add(tunnel());
    let mut settings = spawn_hardware(app.world_mut(), &tunnel, picture, filters);
    let texture = encoded(picture, Rate::Color3, Effort::Default, true)?;
    settings.extend(
        filters
            .iter()
            .map(|f| spawn_ours(app.world_mut(), &tunnel, &texture, *f)),
    );

    let mut pictures = BTreeMap::<String, RgbImage>::new();
    for setting in &mut settings {
        progress.set_message(format!("tunnel, {}", setting.row.setting));
        show(app.world_mut(), setting.entity);
        app.run_until_ready(MAX_FRAMES)?;
        setting.row.bytes = Some(bytes_on_gpu(&mut app, &setting.images));
        let shown = app.capture_rgb8()?;
        if let Some(reference) = pictures.get(&setting.row.reference) {
            let error = Measurement::from(&compare(reference, &shown)?);
            setting.row = Measurement {
                mse: error.mse,
                psnr_db: error.psnr_db,
                flip: error.flip,
                max_error: error.max_error,
                ..std::mem::take(&mut setting.row)
            };
        }
        pictures.insert(setting.row.setting.clone(), shown);
    }
    let last = settings.last().map(|setting| setting.entity);
    let candidates = settings.into_iter();
    let candidates = candidates.map(|setting| Candidate::new(setting.entity, setting.row));
    let rows = benchmark(candidates.collect(), plan.rounds, |entity| {
        show(app.world_mut(), *entity);
        app.render_frames(SETTLING_FRAMES)?;
        let times = app.measure_spans(plan.tunnel_frames)?;
        if Some(*entity) == last {
            progress.inc(1);
        }
        Ok(times)
    })?;
    let rows = with_relative_times(rows, filters);
    if rows.iter().any(|row| row.gpu_ms.is_none()) {
        note(
            progress,
            "not measured: times of the GPU, it gave no timestamps",
        );
    }
    Ok((adapter, rows))
}

/// Bytes of all levels and layers of the textures that the GPU has for these images.
fn bytes_on_gpu(app: &mut HeadlessApp, images: &[Handle<Image>]) -> u64 {
    let render_world = app.app_mut().sub_app(RenderApp).world();
    let textures = render_world.resource::<RenderAssets<GpuImage>>();
    let bytes = |image: &Handle<Image>| {
        let texture = &textures.get(image)?.texture;
        let (width, height) = texture.format().block_dimensions();
        let block = u64::from(texture.format().block_copy_size(None)?);
        let level = |level: u32| {
            let blocks = |side: u32, block: u32| u64::from((side >> level).max(1).div_ceil(block));
            blocks(texture.width(), width) * blocks(texture.height(), height) * block
        };
        let layers = u64::from(texture.depth_or_array_layers());
        Some(layers * (0..texture.mip_level_count()).map(level).sum::<u64>())
    };
    images.iter().filter_map(bytes).sum()
}

/// Adds the times of the plugin's rows relative to those of BC7 and BC1 with the hardware's filter.
fn with_relative_times(mut rows: Vec<Measurement>, filters: &[Filter]) -> Vec<Measurement> {
    let frame = |row: &Measurement| row.gpu_ms.or(row.cpu_ms);
    let times: BTreeMap<String, f64> = rows
        .iter()
        .filter_map(|row| Some((row.setting.clone(), frame(row)?)))
        .collect();
    let Some(empty) = times.get("no texture") else {
        return rows;
    };
    for filter in filters {
        let name = format!("color3 {}", filter.name);
        let Some(row) = rows.iter_mut().find(|row| row.setting == name) else {
            continue;
        };
        for baseline in ["bc7", "bc1"] {
            let hardware = times.get(&format!("{baseline} {}", filter.hardware));
            let (Some(ours), Some(hardware)) = (times.get(&name), hardware) else {
                continue;
            };
            let times = &mut row.relative_time;
            times.insert(format!("{baseline} frame"), ours / hardware);
            let sampling = hardware - empty;
            if sampling > 0.1 * hardware {
                times.insert(format!("{baseline} sampling"), (ours - empty) / sampling);
            }
        }
    }
    rows
}
