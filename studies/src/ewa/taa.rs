//! Flicker under Bevy's own temporal anti-aliasing: a checkered floor, rasterised, with a camera that
//! stands still and one that moves.

use bevy::{
    anti_alias::taa::TemporalAntiAliasing, camera::Hdr, core_pipeline::tonemapping::DebandDither,
    core_pipeline::tonemapping::Tonemapping, diagnostic::FrameCount, prelude::*,
};
use bevy_ewa::{EwaMethod, EwaPlugin, EwaProbes, EwaSettings, EwaStandardMaterial};
use image::{Rgba, RgbaImage};

use bevy_frugal_lab::{
    content,
    headless::{HeadlessApp, HeadlessError, HeadlessSettings, LabTarget, TargetFormat},
};

/// Frames until the history has forgotten how it began; a multiple of the period of Bevy's jitter.
const WARM_UP: u32 = 48;

/// Frames that are compared with the next.
const FRAMES: usize = 16;

/// Units by which the camera moves in a frame.
const STEP: f32 = 0.02;

const FIVE: EwaProbes = EwaProbes::Five;

/// What is measured, the first being what the others are compared with.
pub const METHODS: [(&str, EwaMethod); 6] = [
    ("reference", EwaMethod::Reference),
    ("approximate", EwaMethod::Approximate { probes: FIVE }),
    ("temporal", EwaMethod::Temporal { probes: FIVE }),
    (
        "spatial_temporal",
        EwaMethod::SpatialTemporal { probes: FIVE },
    ),
    ("stochastic", EwaMethod::Stochastic),
    ("trilinear", EwaMethod::Hardware),
];

/// Mean squared changes from a frame to the next, in squares of 8-bit units of linear values.
#[derive(Clone, Debug, PartialEq)]
pub struct TaaFlicker {
    pub setting: &'static str,
    /// Change of the picture while the camera stands still.
    pub still: f64,
    /// Change of the difference from the first method's picture while the camera moves.
    pub moving: f64,
}

/// Measures all methods, with temporal anti-aliasing or without.
pub fn taa_flicker(size: u32, taa: bool) -> Result<Vec<TaaFlicker>, HeadlessError> {
    let mut stage = Stage::new(size, taa)?;
    let mut reference = Vec::new();
    let mut found = Vec::new();
    for (setting, method) in METHODS {
        stage.set_method(method)?;
        let still = stage.frames(0.0)?;
        let moving = stage.frames(STEP)?;
        if reference.is_empty() {
            reference.clone_from(&moving);
        }
        let errors: Vec<Frame> = moving
            .iter()
            .zip(&reference)
            .map(|(a, b)| a.iter().zip(b).map(|(a, b)| a - b).collect())
            .collect();
        found.push(TaaFlicker {
            setting,
            still: change(&still),
            moving: change(&errors),
        });
    }
    Ok(found)
}

/// Linear channels, in 8-bit units.
type Frame = Vec<f64>;

fn change(frames: &[Frame]) -> f64 {
    let changes = frames.windows(2).map(|pair| {
        let squares = pair[0].iter().zip(&pair[1]).map(|(a, b)| (a - b).powi(2));
        squares.sum::<f64>() / pair[0].len() as f64
    });
    changes.sum::<f64>() / (frames.len() - 1) as f64
}

struct Stage {
    app: HeadlessApp,
    camera: Entity,
    material: Handle<EwaStandardMaterial>,
}

impl Stage {
    fn new(size: u32, taa: bool) -> Result<Self, HeadlessError> {
        let settings = HeadlessSettings {
            format: TargetFormat::Float16,
            ..HeadlessSettings::with_size(size, size)
        };
        let mut app = HeadlessApp::new(settings, |app| {
            app.add_plugins(EwaPlugin::OPT_IN);
        })?;
        let world = app.world_mut();
        let checks = RgbaImage::from_fn(256, 256, |x, y| {
            let bright = (x / 32 + y / 32) % 2 == 0;
            Rgba(if bright {
                [240, 240, 240, 255]
            } else {
                [20, 20, 20, 255]
            })
        });
        let checks = content::mipped_texture(&checks, true);
        let checks = world.add_asset(checks);
        let material = EwaStandardMaterial {
            base: StandardMaterial {
                base_color_texture: Some(checks),
                unlit: true,
                ..default()
            },
            extension: EwaSettings::default().into(),
        };
        let material = world.add_asset::<EwaStandardMaterial>(material);
        let floor = Plane3d::new(Vec3::Y, Vec2::splat(200.0)).mesh().build();
        let uvs: Vec<_> = [[0.0, 200.0], [200.0, 200.0], [0.0, 0.0], [200.0, 0.0]].into();
        let floor = floor.with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs);
        let floor = world.add_asset(floor);
        world.spawn((Mesh3d(floor), MeshMaterial3d(material.clone())));
        let target = world.resource::<LabTarget>().0.clone();
        let mut camera = world.spawn((
            Camera3d::default(),
            target,
            Hdr,
            Tonemapping::None,
            DebandDither::Disabled,
            Msaa::Off,
            at(0.0),
        ));
        if taa {
            camera.insert(TemporalAntiAliasing::default());
        }
        let camera = camera.id();
        Ok(Self {
            app,
            camera,
            material,
        })
    }

    fn set_method(&mut self, method: EwaMethod) -> Result<(), HeadlessError> {
        let world = self.app.world_mut();
        let mut materials = world.resource_mut::<Assets<EwaStandardMaterial>>();
        if let Some(mut material) = materials.get_mut(&self.material) {
            material.extension = EwaSettings::with_method(method).into();
        }
        self.app.run_until_ready(300).map(drop)
    }

    /// Frames of a camera that has moved by `step` in each for a while.
    fn frames(&mut self, step: f32) -> Result<Vec<Frame>, HeadlessError> {
        // Jitter and rotation of the probes are the same for all methods.
        while !self
            .app
            .world()
            .resource::<FrameCount>()
            .0
            .is_multiple_of(16)
        {
            self.app.render_frames(1)?;
        }
        let mut frames = Vec::new();
        for i in 0..WARM_UP + FRAMES as u32 {
            let moved = at(step * i as f32);
            self.app.world_mut().entity_mut(self.camera).insert(moved);
            self.app.render_frames(1)?;
            if i >= WARM_UP {
                let pixels = self.app.capture_f32()?.pixels;
                let channels = pixels.iter().flat_map(|p| &p[..3]);
                frames.push(channels.map(|c| f64::from(*c) * 255.0).collect());
            }
        }
        Ok(frames)
    }
}

/// A grazing view of the floor, from further on.
fn at(moved: f32) -> Transform {
    Transform::from_xyz(0.0, 0.5, -moved).looking_to(Vec3::new(0.1, -0.28, -1.0), Vec3::Y)
}
