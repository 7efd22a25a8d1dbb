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
};
use bevy_ycocg_fb::{FrameBufferReports, Reconstruction, YCoCgFrameBuffer, YCoCgFrameBufferPlugin};
use indicatif::ProgressBar;

use crate::{
    headless::{HeadlessApp, HeadlessError, HeadlessSettings, LabTarget, pixel_camera},
    record::Measurement,
    tradeoff::{
        interleaved::{Candidate, benchmark_apps},
        plan::Plan,
        study::TradeoffError,
    },
};

/// Frames before which every pipeline must have been compiled.
const MAX_FRAMES: u32 = 200;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Camera {
    /// Bevy's own with `Hdr`: the reference.
    Rgba16Float,
    /// What a user would pick today: a target of this format, without alpha and without `Hdr`.
    Rg11b10Ufloat,
    /// Packed, resolved to Bevy's `Rgba16Float` texture.
    PackedHdr,
    /// The same with another filter than the default.
    PackedHdrBy(Reconstruction),
    /// Packed, resolved and tone-mapped to the 8-bit target.
    PackedFused,
}

impl Camera {
    const ALL: [Self; 4] = [
        Self::Rgba16Float,
        Self::Rg11b10Ufloat,
        Self::PackedHdr,
        Self::PackedFused,
    ];

    /// The other filters: their time is in the resolve alone, so they are measured without layers.
    const FILTERS: [Self; 5] = [
        Self::PackedHdrBy(Reconstruction::Nearest),
        Self::PackedHdrBy(Reconstruction::Bilinear),
        Self::PackedHdrBy(Reconstruction::EdgeDirected),
        Self::PackedHdrBy(Reconstruction::Guided),
        Self::PackedHdrBy(Reconstruction::Quad),
    ];

    fn name(self) -> &'static str {
        match self {
            Self::Rgba16Float => super::settings::REFERENCE,
            Self::Rg11b10Ufloat => "rg11b10ufloat",
            Self::PackedHdr => "packed_hdr",
            Self::PackedHdrBy(Reconstruction::Nearest) => "packed_hdr nearest",
            Self::PackedHdrBy(Reconstruction::Bilinear) => "packed_hdr bilinear",
            Self::PackedHdrBy(Reconstruction::EdgeDirected) => "packed_hdr edge_directed",
            Self::PackedHdrBy(Reconstruction::Guided) => "packed_hdr guided",
            Self::PackedHdrBy(Reconstruction::Wide) => "packed_hdr wide",
            Self::PackedHdrBy(Reconstruction::Quad) => "packed_hdr quad",
            Self::PackedFused => "packed_fused",
        }
    }
}

#[derive(Clone, Copy, Debug)]
struct Load {
    layers: usize,
    blend: bool,
    msaa: Msaa,
}

const LOADS: [Load; 5] = [
    Load {
        layers: 0,
        blend: false,
        msaa: Msaa::Off,
    },
    Load {
        layers: 8,
        blend: false,
        msaa: Msaa::Off,
    },
    Load {
        layers: 8,
        blend: true,
        msaa: Msaa::Off,
    },
    Load {
        layers: 0,
        blend: false,
        msaa: Msaa::Sample4,
    },
    Load {
        layers: 8,
        blend: false,
        msaa: Msaa::Sample4,
    },
];

/// The rows of all cameras under all loads.
pub fn rows(plan: &Plan, progress: &ProgressBar) -> Result<Vec<Measurement>, TradeoffError> {
    let Some(size) = plan.picture else {
        return Ok(Vec::new());
    };
    let mut rows = Vec::new();
    for load in LOADS {
        let blending = if load.blend { "blend" } else { "opaque" };
        let scene = format!(
            "overdraw_{}_{blending}_{}x",
            load.layers,
            load.msaa.samples()
        );
        progress.set_message(scene.clone());
        let mut candidates = Vec::new();
        let filters = Camera::FILTERS.into_iter().filter(|_| load.layers == 0);
        for camera in Camera::ALL.into_iter().chain(filters) {
            let (app, bytes) = app(camera, load, size)?;
            let row = Measurement {
                scene: scene.clone(),
                setting: camera.name().into(),
                reference: super::settings::REFERENCE.into(),
                bytes: Some(bytes),
                ..Measurement::default()
            };
            candidates.push(Candidate::new(app, row));
        }
        rows.extend(benchmark_apps(candidates, plan.rounds, plan.frames)?);
        progress.inc(1);
    }
    Ok(rows)
}

/// The scene of the first load: nothing saved, and the resolve paid.
pub const NO_OVERDRAW: &str = "overdraw_0_opaque_1x";

/// How many steps of the progress bar [`rows`] takes.
pub const STEPS: usize = LOADS.len();

/// An app that is ready to be measured, and the bytes of its colour textures.
fn app(camera: Camera, load: Load, size: [u32; 2]) -> Result<(HeadlessApp, u64), HeadlessError> {
    let settings = HeadlessSettings::with_size(size[0], size[1]);
    let mut app = HeadlessApp::new(settings, |app| {
        app.add_plugins(YCoCgFrameBufferPlugin);
    })?;
    let world = app.world_mut();
    spawn_layers(world, load, size);
    let camera = spawn_camera(world, camera, load.msaa, size);
    app.run_until_ready(MAX_FRAMES)?;
    let reports = app.world().resource::<FrameBufferReports>();
    let bytes = reports
        .get(camera)
        .map_or(0, |report| report.memory.total());
    Ok((app, bytes))
}

fn spawn_layers(world: &mut World, load: Load, size: [u32; 2]) {
    let mesh: Mesh = Rectangle::new(size[0] as f32, size[1] as f32).into();
    let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
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
    let material = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(material);
    for _ in 0..load.layers {
        world.spawn((Mesh3d(mesh.clone()), MeshMaterial3d(material.clone())));
    }
}

fn spawn_camera(world: &mut World, camera: Camera, msaa: Msaa, size: [u32; 2]) -> Entity {
    let view = pixel_camera(world.resource::<LabTarget>(), size);
    let entity = world.spawn(view).insert(msaa).id();
    match camera {
        Camera::Rgba16Float => {
            world
                .entity_mut(entity)
                .insert((Hdr, Tonemapping::default()));
        }
        Camera::Rg11b10Ufloat => {
            let format = TextureFormat::Rg11b10Ufloat;
            let image = Image::new_target_texture(size[0], size[1], format, None);
            let image = world.resource_mut::<Assets<Image>>().add(image);
            let target = RenderTarget::Image(ImageRenderTarget::from(image));
            world.entity_mut(entity).insert(target);
        }
        Camera::PackedHdr => {
            let packed = YCoCgFrameBuffer::default();
            world
                .entity_mut(entity)
                .insert((Hdr, Tonemapping::default(), packed));
        }
        Camera::PackedHdrBy(reconstruction) => {
            let packed = YCoCgFrameBuffer {
                reconstruction,
                ..default()
            };
            world
                .entity_mut(entity)
                .insert((Hdr, Tonemapping::default(), packed));
        }
        Camera::PackedFused => {
            let packed = YCoCgFrameBuffer::default();
            world
                .entity_mut(entity)
                .insert((Tonemapping::default(), packed));
        }
    }
    entity
}
