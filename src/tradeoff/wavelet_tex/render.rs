//! A textured quad on the GPU: the filters of the plugin against the hardware's bilinear one.
//!
//! A pixel of the texture is as large as one of the picture but lies a quarter of it aside, so that
//! the filters have something to blend. The apps of all settings are built first and then measured
//! in turns: what slows the machine down for a while slows down all of them.

use bevy::{
    asset::RenderAssetUsages,
    image::{ImageAddressMode, ImageSampler, ImageSamplerDescriptor},
    math::Affine2,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_wavelet_tex::{
    WaveletExtension, WaveletFilter, WaveletStandardMaterial, WaveletStorage, WaveletTexPlugin,
    WaveletTexture,
    codec::{
        image::{Content, WaveletImage},
        rate::Rate,
        search::Effort,
    },
};
use image::RgbImage;
use indicatif::ProgressBar;

use super::{PLUGIN, encoded, fetches, note, original};
use crate::{
    headless::{HeadlessApp, HeadlessError, HeadlessSettings, LabTarget, pixel_camera},
    metrics::compare,
    record::{Measurement, ReportAdapter},
    tradeoff::{
        TradeoffError,
        contest::{Contestant, contest},
        options::Plan,
    },
};

/// How far the texture lies aside, in its pixels.
const OFFSET: f32 = 0.25;

/// Frames before which every asset must have been loaded.
const MAX_FRAMES: u32 = 200;

/// The filters with their names and the decoded pixels that they blend.
pub const FILTERS: [(WaveletFilter, &str, f64); 4] = [
    (WaveletFilter::Nearest, "nearest", 1.0),
    (WaveletFilter::NearestMipLinear, "nearest mip linear", 2.0),
    (WaveletFilter::Bilinear, "bilinear", 4.0),
    (WaveletFilter::Trilinear, "trilinear", 8.0),
];

/// The rows of `photo` with `filters` in a picture of `size` pixels, the original first, and what rendered them.
///
/// `gpu_ms` and `cpu_ms` are those of a frame.
///
/// # Errors
/// [`TradeoffError`] when the photograph cannot be encoded, rendered or compared.
pub fn rows(
    photo: &RgbImage,
    filters: &[(WaveletFilter, &str, f64)],
    size: [u32; 2],
    plan: &Plan,
    progress: &ProgressBar,
) -> Result<(ReportAdapter, Vec<Measurement>), TradeoffError> {
    let row = Measurement {
        scene: "photo rendered".into(),
        setting: "rgba8 bilinear".into(),
        ..original(photo, Content::Color)
    };
    let mut app = quad_app(photo, size, |world, base| add_rgba8(world, base, photo))?;
    let adapter = ReportAdapter::from(app.adapter());
    let blocks = app
        .features()
        .contains(wgpu::Features::TEXTURE_COMPRESSION_BC);
    let reference = app.capture_rgb8()?;
    let mut contestants = vec![Contestant::new(app, row)];

    let texture = encoded(photo, Rate::Color3, Effort::Default, true)?;
    let level_0 = encoded(photo, Rate::Color3, Effort::Fast, false)?.gpu_bytes();
    if !blocks {
        note(
            progress,
            "skipped: rendering, the adapter samples no BC textures",
        );
    }
    for (filter, name, pixels) in filters.iter().copied().filter(|_| blocks) {
        let mut app = quad_app(photo, size, |world, base| {
            add_wavelet(world, base, &texture, filter)
        })?;
        let row = Measurement {
            plugin: PLUGIN.into(),
            scene: "photo rendered".into(),
            setting: format!("color3 {name}"),
            reference: "rgba8 bilinear".into(),
            bytes: Some(level_0 as u64),
            fetches: Some(pixels * fetches(&texture)),
            ..Measurement::from(&compare(&reference, &app.capture_rgb8()?)?)
        };
        contestants.push(Contestant::new(app, row));
    }
    let rows = contest(contestants, plan.rounds, plan.frames)?;
    progress.inc(u64::from(plan.rounds));
    if rows.iter().any(|row| row.gpu_ms.is_none()) {
        note(
            progress,
            "not measured: times of the GPU, it gave no timestamps",
        );
    }
    Ok((adapter, rows))
}

/// An app that shows the middle of `photo`, ready to be captured; `spawn` gives the quad its material.
fn quad_app(
    photo: &RgbImage,
    size: [u32; 2],
    spawn: impl FnOnce(&mut World, StandardMaterial) -> Entity,
) -> Result<HeadlessApp, HeadlessError> {
    let settings = HeadlessSettings::with_size(size[0], size[1]);
    let mut app = HeadlessApp::new(settings, |app| {
        app.add_plugins(WaveletTexPlugin);
        let camera = pixel_camera(app.world().resource::<LabTarget>(), size);
        app.world_mut().spawn(camera);
    })?;
    let (shown, whole) = (UVec2::from(size), UVec2::from(photo.dimensions()));
    let pixel = 1.0 / whole.as_vec2();
    let border = (whole.saturating_sub(shown) / 2).as_vec2();
    let base = StandardMaterial {
        unlit: true,
        uv_transform: Affine2::from_scale_angle_translation(
            pixel * shown.as_vec2(),
            0.0,
            pixel * (border + OFFSET),
        ),
        ..default()
    };
    let world = app.world_mut();
    let quad = spawn(world, base);
    let mesh: Mesh = Rectangle::new(size[0] as f32, size[1] as f32).into();
    let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
    world.entity_mut(quad).insert(Mesh3d(mesh));
    app.run_until_ready(MAX_FRAMES)?;
    Ok(app)
}

fn add_rgba8(world: &mut World, base: StandardMaterial, photo: &RgbImage) -> Entity {
    let texels = photo.pixels().flat_map(|p| [p[0], p[1], p[2], 255]);
    let mut image = Image::new(
        Extent3d {
            width: photo.width(),
            height: photo.height(),
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        texels.collect(),
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        address_mode_v: ImageAddressMode::Repeat,
        ..ImageSamplerDescriptor::linear()
    });
    let image = world.resource_mut::<Assets<Image>>().add(image);
    let material = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(StandardMaterial {
            base_color_texture: Some(image),
            ..base
        });
    world.spawn(MeshMaterial3d(material)).id()
}

fn add_wavelet(
    world: &mut World,
    base: StandardMaterial,
    texture: &WaveletImage,
    filter: WaveletFilter,
) -> Entity {
    let texture = world.resource_scope(|world, mut textures: Mut<Assets<WaveletTexture>>| {
        let mut images = world.resource_mut::<Assets<Image>>();
        WaveletTexture::add(texture, WaveletStorage::Blocks, &mut textures, &mut images)
    });
    let extension = WaveletExtension {
        base_color: Some(texture),
        filter,
        ..default()
    };
    let material = world
        .resource_mut::<Assets<WaveletStandardMaterial>>()
        .add(WaveletStandardMaterial { base, extension });
    world.spawn(MeshMaterial3d(material)).id()
}
