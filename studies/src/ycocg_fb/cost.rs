//! What a camera costs: memory as allocated, and frame times with and without overdraw.
//!
//! Scenes are named `LAYERS` `_opaque` or `_blend` `_SAMPLESx`: `overdraw_0_opaque_1x` is a frame
//! with nothing in it, that is the clear, the resolve and the tone mapping; the difference to
//! `overdraw_8_opaque_1x` is the fill of 8 layers. The layers coincide, so that all of them pass
//! the depth test.

use bevy::{
    camera::{Hdr, ImageRenderTarget, RenderTarget},
    core_pipeline::tonemapping::Tonemapping,
    prelude::*,
    render::render_resource::TextureFormat,
    utils::default,
};
use bevy_frugal_lab::headless::{
    HeadlessApp, HeadlessError, HeadlessSettings, LabTarget, pixel_camera,
};
use bevy_ycocg_fb::{
    CameraState, FrameBufferQuality, FrameBufferReport, PackedFormat, Reconstruction,
    YCoCgFrameBuffer, YCoCgFrameBufferPlugin,
};
use indicatif::ProgressBar;

use crate::{
    benchmark::time_rows,
    plan::Plan,
    record::{ReportAdapter, TimeRow},
    run::TradeoffError,
    ycocg_fb::REFERENCE,
};

/// What a frame has in it.
#[derive(Clone, Copy, Debug)]
pub struct Load {
    pub layers: usize,
    pub blend: bool,
    pub msaa: Msaa,
}

impl Load {
    /// Its name as that of a scene.
    pub fn name(self) -> String {
        let blending = if self.blend { "blend" } else { "opaque" };
        format!(
            "overdraw_{}_{blending}_{}x",
            self.layers,
            self.msaa.samples()
        )
    }
}

/// Layers of the study.
const LAYERS: usize = 8;

/// All loads, with nothing in it and with so many layers.
pub fn loads(layers: usize) -> [Load; STEPS] {
    [
        (0, false, Msaa::Off),
        (layers, false, Msaa::Off),
        (layers, true, Msaa::Off),
        (0, false, Msaa::Sample4),
        (layers, false, Msaa::Sample4),
    ]
    .map(|(layers, blend, msaa)| Load {
        layers,
        blend,
        msaa,
    })
}

/// The rows of the study's cameras under all loads.
pub fn rows(plan: &Plan, progress: &ProgressBar) -> Result<Vec<TimeRow>, TradeoffError> {
    let Some(size) = plan.picture else {
        return Ok(Vec::new());
    };
    let mut rows = Vec::new();
    for load in loads(LAYERS) {
        progress.set_message(load.name());
        rows.extend(load_rows(load, &cameras(), size, plan)?.1);
        progress.inc(1);
    }
    Ok(rows)
}

/// The rows of cameras under a load, interleaved, and what rendered them. Cameras that the adapter lacks are left out.
pub fn load_rows(
    load: Load,
    cameras: &[Camera],
    size: [u32; 2],
    plan: &Plan,
) -> Result<(ReportAdapter, Vec<TimeRow>), TradeoffError> {
    let mut candidates = Vec::new();
    let filters = filters().filter(|_| load.layers == 0 && load.msaa == Msaa::Off);
    for camera in cameras.iter().copied().chain(filters) {
        let Some((app, bytes)) = app(camera, load, size)? else {
            continue;
        };
        let row = TimeRow {
            bytes: Some(bytes),
            ..TimeRow::new(load.name(), camera.name)
        };
        candidates.push((app, row));
    }
    Ok(time_rows(candidates, plan.rounds, plan.frames, None)?)
}

/// The scene of the first load: nothing saved, and the resolve paid.
pub const NO_OVERDRAW: &str = "overdraw_0_opaque_1x";

/// How many steps of the progress bar [`rows`] takes.
pub const STEPS: usize = 5;

/// An app that is ready to be measured, and the bytes of its colour textures; none where the adapter has not what
/// the camera needs.
fn app(
    camera: Camera,
    load: Load,
    size: [u32; 2],
) -> Result<Option<(HeadlessApp, u64)>, HeadlessError> {
    let settings = HeadlessSettings::with_size(size[0], size[1]);
    let mut app = HeadlessApp::new(settings, |app| {
        app.add_plugins(YCoCgFrameBufferPlugin);
    })?;
    let blends = wgpu::Features::FLOAT32_BLENDABLE;
    if camera.bytes > 8 && load.blend && !app.features().contains(blends) {
        return Ok(None);
    }
    let world = app.world_mut();
    spawn_layers(world, load, size);
    let entity = spawn_camera(world, camera, load.msaa, size);
    app.run_until_ready(crate::MAX_FRAMES)?;
    let report = app.world().get::<FrameBufferReport>(entity);
    let report = report.cloned().unwrap_or_default();
    let uses_format = matches!(
        report.state,
        CameraState::Packed(_) | CameraState::Rg11b10Ufloat
    );
    if camera.quality != FrameBufferQuality::Exact && !uses_format {
        return Ok(None);
    }
    Ok(Some((app, report.memory.total())))
}

fn spawn_layers(world: &mut World, load: Load, size: [u32; 2]) {
    let mesh: Mesh = Rectangle::new(size[0] as f32, size[1] as f32).into();
    let mesh = world.add_asset(mesh);
    let material = StandardMaterial {
        base_color: Color::srgba(0.9, 0.4, 0.2, 0.5),
        alpha_mode: if load.blend {
            AlphaMode::Blend
        } else {
            AlphaMode::Opaque
        },
        unlit: true,
        ..default()
    };
    let material = world.add_asset::<StandardMaterial>(material);
    for _ in 0..load.layers {
        world.spawn((Mesh3d(mesh.clone()), MeshMaterial3d(material.clone())));
    }
}

fn spawn_camera(world: &mut World, camera: Camera, msaa: Msaa, size: [u32; 2]) -> Entity {
    let view = pixel_camera(world.resource::<LabTarget>(), size);
    let entity = world.spawn(view).insert(msaa).id();
    let target = camera.target.map(|format| {
        let image = Image::new_target_texture(size[0], size[1], format, None);
        let image = world.add_asset(image);
        RenderTarget::Image(ImageRenderTarget::from(image))
    });
    let mut spawned = world.entity_mut(entity);
    if camera.hdr {
        spawned.insert(Hdr);
    }
    match target {
        Some(target) => spawned.insert(target),
        // `pixel_camera` has no tone mapping.
        None => spawned.insert(Tonemapping::default()),
    };
    spawned.insert(camera.quality);
    entity
}

/// A camera by what its colours are drawn to.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// Its name in the records.
    pub name: &'static str,
    /// Bytes of a sample of colour.
    pub bytes: u32,
    pub hdr: bool,
    /// A target of this format in place of the picture.
    pub target: Option<TextureFormat>,
    pub quality: FrameBufferQuality,
}

impl Camera {
    fn new(
        name: &'static str,
        bytes: u32,
        hdr: bool,
        quality: impl Into<FrameBufferQuality>,
    ) -> Self {
        Self {
            name,
            bytes,
            hdr,
            target: None,
            quality: quality.into(),
        }
    }

    fn target(name: &'static str, bytes: u32, target: TextureFormat) -> Self {
        Self {
            target: Some(target),
            ..Self::new(name, bytes, false, FrameBufferQuality::Exact)
        }
    }
}

/// Bevy's own, what a user would pick today, and the plugin's: resolved to Bevy's HDR texture, or tone-mapped.
pub fn cameras() -> Vec<Camera> {
    vec![
        Camera::new(REFERENCE, 8, true, FrameBufferQuality::Exact),
        Camera::new("rg11b10ufloat", 4, true, FrameBufferQuality::Compact),
        Camera::new("packed_hdr", 4, true, YCoCgFrameBuffer::default()),
        Camera::new("packed_fused", 4, false, YCoCgFrameBuffer::default()),
    ]
}

/// The other filters: their time is in the resolve alone, so they are measured without layers.
pub fn filters() -> impl Iterator<Item = Camera> {
    let filters = [
        ("packed_hdr nearest", Reconstruction::Nearest),
        ("packed_hdr bilinear", Reconstruction::Bilinear),
        ("packed_hdr edge_directed", Reconstruction::EdgeDirected),
        ("packed_hdr guided", Reconstruction::Guided),
        ("packed_hdr quad", Reconstruction::Quad),
    ];
    filters.into_iter().map(|(name, reconstruction)| {
        let packed = YCoCgFrameBuffer {
            reconstruction,
            ..default()
        };
        Camera::new(name, 4, true, packed)
    })
}

/// Those, and the cameras with 8 and 32 bits a channel.
pub fn all_cameras() -> Vec<Camera> {
    let mut all = cameras();
    all.extend([
        Camera::target("rgba8", 4, TextureFormat::Rgba8UnormSrgb),
        Camera::new(
            "packed_unorm8",
            2,
            false,
            YCoCgFrameBuffer::with_format(PackedFormat::Unorm8),
        ),
        Camera::target("rgba32float", 16, TextureFormat::Rgba32Float),
        Camera::new(
            "packed_float32",
            8,
            true,
            YCoCgFrameBuffer::with_format(PackedFormat::Float32),
        ),
    ]);
    all
}
