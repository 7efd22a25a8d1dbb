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

use std::collections::BTreeMap;

use bevy::{
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    image::{ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor},
    math::Affine2,
    prelude::*,
    render::{
        RenderApp, render_asset::RenderAssets, render_resource::TextureFormat,
        renderer::RenderDevice, texture::GpuImage,
    },
};
use bevy_frugal_lab::{
    content::{self, add_texture, encoded, wavelets},
    headless::{AwaitedAssets, HeadlessApp, HeadlessSettings, LabTarget},
    metrics::compare,
};
use bevy_wavelet_tex::{
    WaveletExtension, WaveletFilter, WaveletStandardMaterial, WaveletStorage, WaveletTexPlugin,
    WaveletTexture,
    codec::{
        blocks::{BlockQuality, Texel, encode_bc1, encode_bc7},
        image::{ColorSpace, WaveletImage},
        rate::Rate,
    },
    material::storage_on,
};
use image::{RgbImage, RgbaImage, buffer::ConvertBuffer};
use indicatif::ProgressBar;
use serde::{Deserialize, Serialize};

use crate::{
    benchmark::benchmark,
    plan::Plan,
    record::{PictureError, ReportAdapter, Times},
    run::{TradeoffError, note},
    wavelet_tex::fetches_and_bytes,
};

/// A filter in the tunnel.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TunnelRow {
    pub setting: String,
    /// The hardware's filter over RGBA8.
    pub reference: String,
    #[serde(flatten)]
    pub error: Option<PictureError>,
    /// Memory on the GPU in bytes.
    pub bytes: u64,
    /// Texture fetches a pixel.
    pub fetches: f64,
    /// Bytes of textures that a pixel fetches.
    pub fetched_bytes: f64,
    #[serde(flatten)]
    pub times: Times,
    /// Time over that of another setting, by the name of that.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub relative_time: BTreeMap<String, f64>,
}

/// Frames after which those of the setting before have given their times.
const SETTLING_FRAMES: u32 = 2;

/// The rows of `picture`, which tiles, in a frame of `size` pixels, and what rendered them.
pub fn rows(
    picture: &RgbImage,
    filters: &[Filter],
    size: [u32; 2],
    plan: &Plan,
    progress: &ProgressBar,
) -> Result<(ReportAdapter, Vec<TunnelRow>), TradeoffError> {
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
    let tunnel = app.world_mut().add_asset(tunnel());
    let mut settings = spawn_hardware(app.world_mut(), &tunnel, picture, filters);
    let texture = encoded(picture, &wavelets(Rate::Color3, ColorSpace::Srgb))?;
    settings.extend(
        filters
            .iter()
            .map(|f| spawn_ours(app.world_mut(), &tunnel, &texture, *f)),
    );

    let mut pictures = BTreeMap::<String, RgbImage>::new();
    for setting in &mut settings {
        progress.set_message(format!("tunnel, {}", setting.row.setting));
        show(app.world_mut(), setting.entity);
        app.run_until_ready(crate::MAX_FRAMES)?;
        setting.row.bytes = bytes_on_gpu(&mut app, &setting.images);
        let shown = app.capture_rgb8()?;
        if let Some(reference) = pictures.get(&setting.row.reference) {
            setting.row.error = Some(compare(reference, &shown)?.into());
        }
        pictures.insert(setting.row.setting.clone(), shown);
    }
    let mut entities: Vec<_> = settings.iter().map(|setting| setting.entity).collect();
    let last = entities.last().copied();
    let times = benchmark(&mut entities, plan.rounds, None, |entity| {
        show(app.world_mut(), *entity);
        app.render_frames(SETTLING_FRAMES)?;
        let times = app.measure_spans(plan.tunnel_frames)?;
        if Some(*entity) == last {
            progress.inc(1);
        }
        Ok(times)
    })?;
    let rows = settings.into_iter().zip(times);
    let rows = rows.map(|(setting, times)| TunnelRow {
        times,
        ..setting.row
    });
    let rows = rows.collect();
    let rows = with_relative_times(rows, filters);
    if rows.iter().any(|row| row.times.gpu_ms.is_none()) {
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
fn with_relative_times(mut rows: Vec<TunnelRow>, filters: &[Filter]) -> Vec<TunnelRow> {
    let times: BTreeMap<String, f64> = rows
        .iter()
        .filter_map(|row| Some((row.setting.clone(), row.times.frame_ms()?)))
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

/// A filter of the plugin, and the hardware's that is most similar.
#[derive(Clone, Copy, Debug)]
pub struct Filter {
    pub filter: WaveletFilter,
    pub name: &'static str,
    /// Neighbouring pixels that it decodes together.
    pub pixels: f64,
    /// How often it does that.
    pub lookups: f64,
    pub hardware: &'static str,
}

/// All filters. An anisotropic sample of the plugin is counted as one trilinear one; it is up to 16 of them
/// where a footprint is long and narrow.
pub const FILTERS: [Filter; 7] = [
    Filter::new(WaveletFilter::Nearest, "nearest", [1.0, 1.0], "nearest"),
    Filter::new(
        WaveletFilter::NearestMipLinear,
        "nearest mip linear",
        [1.0, 2.0],
        "nearest mip linear",
    ),
    Filter::new(
        WaveletFilter::Stochastic,
        "stochastic",
        [1.0, 1.0],
        "anisotropic",
    ),
    Filter::new(
        WaveletFilter::StochasticQuad,
        "stochastic quad",
        [1.0, 1.0],
        "anisotropic",
    ),
    Filter::new(WaveletFilter::Bilinear, "bilinear", [4.0, 1.0], "bilinear"),
    Filter::new(
        WaveletFilter::Trilinear,
        "trilinear",
        [4.0, 2.0],
        "trilinear",
    ),
    Filter::new(
        WaveletFilter::Anisotropic,
        "anisotropic",
        [4.0, 2.0],
        "anisotropic",
    ),
];

impl Filter {
    const fn new(
        filter: WaveletFilter,
        name: &'static str,
        [pixels, lookups]: [f64; 2],
        hardware: &'static str,
    ) -> Self {
        Self {
            filter,
            name,
            pixels,
            lookups,
            hardware,
        }
    }
}

/// The hardware's filters with the texels that they blend.
const HARDWARE: [(&str, f64); 5] = [
    ("nearest", 1.0),
    ("nearest mip linear", 2.0),
    ("bilinear", 4.0),
    ("trilinear", 8.0),
    ("anisotropic", 128.0),
];

/// Formats of the hardware's rows: name, bytes of a texel, format.
const FORMATS: [(&str, f64, TextureFormat); 3] = [
    ("rgba8", 4.0, TextureFormat::Rgba8UnormSrgb),
    ("bc7", 1.0, TextureFormat::Bc7RgbaUnormSrgb),
    ("bc1", 0.5, TextureFormat::Bc1RgbaUnormSrgb),
];

/// Of the tunnel, in metres; its radius is 1.
const LENGTH: f32 = 60.0;

/// A material in a tunnel of its own, and its row so far.
struct Setting {
    entity: Entity,
    images: Vec<Handle<Image>>,
    row: TunnelRow,
}

/// A tunnel without a texture, and the hardware's own filters.
fn spawn_hardware(
    world: &mut World,
    tunnel: &Handle<Mesh>,
    picture: &RgbImage,
    filters: &[Filter],
) -> Vec<Setting> {
    let row = TunnelRow {
        setting: "no texture".into(),
        reference: "nothing".into(),
        ..TunnelRow::default()
    };
    let mut settings = vec![Setting {
        entity: spawn_standard(world, tunnel, None),
        images: Vec::new(),
        row,
    }];
    let rgba: RgbaImage = picture.convert();
    for (format_name, texel_bytes, format) in FORMATS {
        let image = hardware_texture(&rgba, format);
        for (filter, texels) in HARDWARE {
            if !filters.iter().any(|f| f.hardware == filter) {
                continue;
            }
            let mut image = image.clone();
            image.sampler = sampler(filter);
            let image = world.add_asset(image);
            let row = TunnelRow {
                setting: format!("{format_name} {filter}"),
                reference: format!("rgba8 {filter}"),
                fetches: 1.0,
                fetched_bytes: texels * texel_bytes,
                ..TunnelRow::default()
            };
            settings.push(Setting {
                entity: spawn_standard(world, tunnel, Some(image.clone())),
                images: vec![image],
                row,
            });
        }
    }
    settings
}

fn spawn_ours(
    world: &mut World,
    tunnel: &Handle<Mesh>,
    texture: &WaveletImage,
    filter: Filter,
) -> Setting {
    let handle = add_texture(world, texture, WaveletStorage::Blocks);
    let textures = world.resource::<Assets<WaveletTexture>>();
    let images = textures
        .get(&handle)
        .map(|t| t.images.iter().cloned().collect());
    let extension = WaveletExtension {
        base_color: Some(handle),
        filter: filter.filter,
        ..default()
    };
    let material = world.add_asset::<WaveletStandardMaterial>(WaveletStandardMaterial {
        base: base(),
        extension,
    });
    let [fetches, bytes] = fetches_and_bytes(texture, filter.pixels);
    let row = TunnelRow {
        setting: format!("color3 {}", filter.name),
        reference: format!("rgba8 {}", filter.hardware),
        fetches: filter.lookups * fetches,
        fetched_bytes: filter.lookups * bytes,
        ..TunnelRow::default()
    };
    Setting {
        entity: spawn(world, tunnel, MeshMaterial3d(material)),
        images: images.unwrap_or_default(),
        row,
    }
}

fn spawn_standard(
    world: &mut World,
    tunnel: &Handle<Mesh>,
    image: Option<Handle<Image>>,
) -> Entity {
    let material = world.add_asset::<StandardMaterial>(StandardMaterial {
        base_color_texture: image.clone(),
        ..base()
    });
    if let Some(image) = image {
        world
            .resource_mut::<AwaitedAssets>()
            .0
            .push(image.untyped());
    }
    spawn(world, tunnel, MeshMaterial3d(material))
}

fn spawn(world: &mut World, tunnel: &Handle<Mesh>, material: impl Bundle) -> Entity {
    let tunnel = Mesh3d(tunnel.clone());
    world.spawn((tunnel, material, Visibility::Hidden)).id()
}

/// What all materials share: four textures around, a texture for every 1.5 metres.
fn base() -> StandardMaterial {
    StandardMaterial {
        unlit: true,
        cull_mode: None,
        uv_transform: Affine2::from_scale(Vec2::new(4.0, LENGTH / 1.5)),
        ..default()
    }
}

fn tunnel() -> Mesh {
    let cylinder = Cylinder::new(1.0, LENGTH)
        .mesh()
        .resolution(64)
        .without_caps();
    Mesh::from(cylinder).rotated_by(Quat::from_rotation_x(std::f32::consts::FRAC_PI_2))
}

/// Shows one tunnel and hides the others.
fn show(world: &mut World, shown: Entity) {
    let mut tunnels = world.query_filtered::<(Entity, &mut Visibility), With<Mesh3d>>();
    for (entity, mut visibility) in tunnels.iter_mut(world) {
        visibility.set_if_neq(if entity == shown {
            Visibility::Visible
        } else {
            Visibility::Hidden
        });
    }
}

/// The picture with mips in one of the hardware's formats.
fn hardware_texture(picture: &RgbaImage, format: TextureFormat) -> Image {
    let mut image = content::mipped_texture(picture, true);
    let data = image.data.take().unwrap_or_default();
    let mut blocks = Vec::new();
    let mut start = 0;
    for level in 0..image.texture_descriptor.mip_level_count {
        let size = [picture.width(), picture.height()].map(|s| (s >> level).max(1));
        let end = start + 4 * (size[0] * size[1]) as usize;
        let texels: &[Texel] = bytemuck::cast_slice(&data[start..end]);
        start = end;
        match format {
            TextureFormat::Bc7RgbaUnormSrgb => blocks.extend(encode_bc7(size, [1; 3], |x, y| {
                let [r, g, b, _] = texels[(y * size[0] + x) as usize];
                [r, g, b].map(|v| f32::from(v) / 255.0)
            })),
            TextureFormat::Bc1RgbaUnormSrgb => {
                blocks.extend(encode_bc1(texels, size, BlockQuality::High));
            }
            _ => blocks.extend_from_slice(texels.as_flattened()),
        }
    }
    image.data = Some(blocks);
    image.texture_descriptor.format = format;
    image
}

fn sampler(filter: &str) -> ImageSampler {
    let [nearest, linear] = [ImageFilterMode::Nearest, ImageFilterMode::Linear];
    let (within, between) = match filter {
        "nearest" => (nearest, nearest),
        "nearest mip linear" => (nearest, linear),
        "bilinear" => (linear, nearest),
        _ => (linear, linear),
    };
    ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        address_mode_v: ImageAddressMode::Repeat,
        mag_filter: within,
        min_filter: within,
        mipmap_filter: between,
        anisotropy_clamp: if filter == "anisotropic" { 16 } else { 1 },
        ..default()
    })
}
