//! The example scenes. A new one is a module and a line in [`ALL`].

use std::f32::consts::TAU;

use bevy::{
    camera::{CameraOutputMode, ScalingMode, Viewport, visibility::RenderLayers},
    camera_controller::free_camera::FreeCameraState,
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    ecs::query::QueryFilter,
    prelude::*,
    render::render_resource::BlendState,
};
use bevy_voxel_gi::Sky;

use crate::{
    headless::LabTarget,
    runner::{AFTER_LAYER, Scene, SceneSettings},
};

pub mod all_together;
pub mod deferred_accumulation;
mod error_view;
pub mod ewa;
mod maps;
pub mod voxel_gi;
pub mod wavelet_tex;
pub mod ycocg_fb;

/// Every scene, in the order of the gallery; the first is the one that opens by default.
pub static ALL: &[&dyn Scene] = &[
    &wavelet_tex::WaveletTex,
    &ycocg_fb::YCoCgFb,
    &ewa::Ewa,
    &voxel_gi::VoxelGi,
    &all_together::AllTogether,
    &deferred_accumulation::DeferredAccumulation,
];

/// Bevy's default for a `Camera3d`: it tone-maps and dithers.
pub const TONE_MAPPED: (Tonemapping, DebandDither) =
    (Tonemapping::TonyMcMapface, DebandDither::Enabled);

/// The camera writes its colours unchanged. Bevy does not dither without tone mapping, and warns of cameras
/// that ask for it.
pub const UNGRADED: (Tonemapping, DebandDither) = (Tonemapping::None, DebandDither::Disabled);

/// The layer of what a [`quad_camera`] shows.
const QUAD_LAYER: usize = AFTER_LAYER + 1;

/// Light from outside: a clear sky, and sunlit ground below it.
fn clear_sky() -> Sky {
    Sky {
        zenith: LinearRgba::rgb(2200.0, 3200.0, 5000.0),
        horizon: LinearRgba::rgb(4200.0, 4700.0, 5200.0),
        ground: LinearRgba::rgb(6500.0, 6000.0, 5000.0),
    }
}

/// A sun that wanders there and back.
#[derive(Component)]
struct Sun {
    /// The direction of its light at time 0.
    direction: Vec3,
    /// How far it wanders to each side, in radians.
    swing: f32,
}

/// Turns suns about the vertical.
fn move_sun(
    settings: Res<SceneSettings>,
    time: Res<Time>,
    mut suns: Query<(&Sun, &mut Transform)>,
) {
    /// Seconds there and back.
    const PERIOD: f32 = 40.0;
    let phase = match settings.toggle("sun_motion") {
        true => (time.elapsed_secs() * TAU / PERIOD).sin(),
        false => 0.0,
    };
    for (sun, mut pose) in &mut suns {
        let direction = Quat::from_rotation_y(phase * sun.swing) * sun.direction;
        pose.set_if_neq(Transform::default().looking_to(direction, Vec3::Y));
    }
}

/// Gives cameras new components, of which one is their pose.
fn place_cameras<F: QueryFilter>(world: &mut World, components: impl Bundle + Clone) {
    let mut cameras = world.query_filtered::<Entity, F>();
    for camera in cameras.iter(world).collect::<Vec<_>>() {
        let mut camera = world.entity_mut(camera);
        camera.insert(components.clone());
        // It would turn back to where it looked before.
        if camera.contains::<FreeCameraState>() {
            camera.insert(FreeCameraState::default());
        }
    }
}

fn despawn_all<C: Component>(world: &mut World) {
    let mut parts = world.query_filtered::<Entity, With<C>>();
    for part in parts.iter(world).collect::<Vec<_>>() {
        world.despawn(part);
    }
}

/// A camera that fills `area`, in pixels of the target, with a quad of 1 x 1 at the origin.
fn quad_camera(area: URect, target: &LabTarget) -> impl Bundle + use<> {
    (
        Camera2d,
        Camera {
            order: QUAD_LAYER as isize,
            viewport: Some(Viewport {
                physical_position: area.min,
                physical_size: area.size(),
                ..default()
            }),
            output_mode: CameraOutputMode::Write {
                blend_state: Some(BlendState::REPLACE),
                clear_color: ClearColorConfig::None,
            },
            ..default()
        },
        Projection::from(OrthographicProjection {
            scaling_mode: ScalingMode::Fixed {
                width: 1.0,
                height: 1.0,
            },
            ..OrthographicProjection::default_2d()
        }),
        target.0.clone(),
        RenderLayers::layer(QUAD_LAYER),
        Msaa::Off,
        Tonemapping::None,
        DebandDither::Disabled,
    )
}
