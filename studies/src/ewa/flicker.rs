//! What moves that should not: the change of the error from a frame to the next, of computed pictures, and under Bevy's own
//! temporal anti-aliasing on a checkered floor, rasterised, with a camera that stands still and one that moves.

use bevy::{
    anti_alias::taa::TemporalAntiAliasing,
    camera::Hdr,
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    diagnostic::FrameCount,
    prelude::*,
};
use bevy_ewa::{
    EwaMethod, EwaPlugin, EwaSettings, EwaStandardMaterial,
    reference::{Texture, scenes::Surface},
};
use bevy_frugal_lab::{
    content,
    headless::{HeadlessApp, HeadlessError, HeadlessSettings, LabTarget, TargetFormat},
    lookups::scenes::{
        EwaScene, Pixels, computed_picture, coordinates, linear_mse, mean, true_picture,
    },
};
use image::{Rgba, RgbaImage};

use crate::ewa::FIVE;

const FRAMES: u32 = 8;

/// Part of a frame in the history of temporal anti-aliasing, as in Bevy's.
const NEW_PART: f64 = 0.1;

/// Textures by which the camera moves in a frame.
const STEP: f64 = 0.013;

/// Flicker in squares of 8-bit units, of linear values, by how the camera moves: mean squared change of the error against
/// the truth, and of the picture of a camera that stands still, without and with temporal anti-aliasing without jitter.
///
/// `frames` is the number of frames after which the method repeats, 1 where they are all the same.
pub fn flicker(
    scene: &EwaScene,
    truths: &[Pixels],
    size: u32,
    settings: &EwaSettings,
    frames: u32,
) -> [(&'static str, f64); 3] {
    let (surface, texture) = ((scene.surface)(), (scene.texture)());
    let moved = |i: u32| computed(&texture, &at(&surface, i), size, settings, i);
    let errors: Vec<_> = (0..FRAMES)
        .zip(truths)
        .map(|(i, truth)| difference(&moved(i), truth))
        .collect();
    let changes = errors.windows(2).map(|pair| linear_mse(&pair[0], &pair[1]));
    let moving = changes.sum::<f64>() / f64::from(FRAMES - 1);

    let frames =
        (0..frames.max(2)).map(|frame| computed(&texture, &surface, size, settings, frame));
    let frames: Vec<_> = frames.collect();
    let changes = frames.windows(2).map(|pair| linear_mse(&pair[0], &pair[1]));
    let still = changes.sum::<f64>() / (frames.len() - 1) as f64;
    let mut history = mean(&frames);
    let mut still_with_taa = 0.0;
    // Long enough for the history to forget how it began.
    for frame in frames.iter().cycle().take(64) {
        let next = blended(&history, frame);
        still_with_taa = linear_mse(&history, &next);
        history = next;
    }
    [
        ("moving", moving),
        ("still", still),
        ("still, TAA", still_with_taa),
    ]
}

pub fn truths(scene: &EwaScene, size: u32, rate: u32) -> Vec<Pixels> {
    let texture = (scene.texture)();
    let frame = |i| true_picture(&texture, &at(&(scene.surface)(), i), size, rate);
    (0..FRAMES).map(frame).collect()
}

fn at(surface: &Surface, step: u32) -> Surface {
    surface.with_camera_moved_by(STEP * f64::from(step))
}

fn computed(
    texture: &Texture,
    surface: &Surface,
    size: u32,
    settings: &EwaSettings,
    frame: u32,
) -> Pixels {
    let coordinates = coordinates(surface, size);
    computed_picture(texture, &coordinates, size, settings, frame).0
}

fn difference(a: &Pixels, b: &Pixels) -> Pixels {
    let pairs = a.iter().zip(b);
    pairs.map(|(a, b)| [0, 1, 2].map(|c| a[c] - b[c])).collect()
}

fn blended(history: &Pixels, frame: &Pixels) -> Pixels {
    let pairs = history.iter().zip(frame);
    pairs
        .map(|(h, f)| [0, 1, 2].map(|c| h[c] + (f[c] - h[c]) * NEW_PART))
        .collect()
}

/// Frames until the history has forgotten how it began; a multiple of the period of Bevy's jitter.
const WARM_UP: u32 = 48;

/// Frames that are compared with the next.
const TAA_FRAMES: usize = 16;

/// Units by which the camera moves in a frame.
const TAA_STEP: f32 = 0.02;

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

/// Mean squared changes from a frame to the next of all methods, with temporal anti-aliasing or without, in squares of
/// 8-bit units of linear values: of the picture while the camera stands still, and of the difference from the first
/// method's picture while the camera moves.
pub fn taa_flicker(
    size: u32,
    taa: bool,
) -> Result<Vec<(&'static str, [(&'static str, f64); 2])>, HeadlessError> {
    let mut stage = Stage::new(size, taa)?;
    let mut reference = Vec::new();
    let mut found = Vec::new();
    for (setting, method) in METHODS {
        stage.set_method(method)?;
        let still = stage.frames(0.0)?;
        let moving = stage.frames(TAA_STEP)?;
        if reference.is_empty() {
            reference.clone_from(&moving);
        }
        let errors: Vec<Frame> = moving
            .iter()
            .zip(&reference)
            .map(|(a, b)| a.iter().zip(b).map(|(a, b)| a - b).collect())
            .collect();
        let changes = [("still", change(&still)), ("moving", change(&errors))];
        found.push((setting, changes));
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
        let settings = HeadlessSettings::with_size(size, size).in_format(TargetFormat::Float16);
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
            view(0.0),
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
        for i in 0..WARM_UP + TAA_FRAMES as u32 {
            let moved = view(step * i as f32);
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
fn view(moved: f32) -> Transform {
    Transform::from_xyz(0.0, 0.5, -moved).looking_to(Vec3::new(0.1, -0.28, -1.0), Vec3::Y)
}
