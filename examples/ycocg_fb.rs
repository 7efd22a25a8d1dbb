//! A camera with `Hdr` and bloom, whose frame buffer takes 8 bytes a sample, 4 or fewer.
//!
//! 1: `Exact`. 2: `Compact`. 3: the packed format. 4: `Smallest`, for which `Hdr` and bloom are off. M: multisampling.

mod common;

use bevy::{
    camera::Hdr, camera_controller::free_camera::FreeCamera, post_process::bloom::Bloom, prelude::*,
};
use bevy_ycocg_fb::{
    FrameBufferQuality, FrameBufferReport, YCoCgFrameBuffer, YCoCgFrameBufferPlugin,
};

fn main() -> AppExit {
    App::new()
        .add_plugins((common::plugins(), YCoCgFrameBufferPlugin))
        .add_systems(Startup, spawn)
        .add_systems(Update, (switch, turn, describe))
        .run()
}

#[derive(Component)]
struct Turning;

fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    commands.spawn((
        Camera3d::default(),
        FreeCamera::default(),
        Hdr,
        Bloom::NATURAL,
        FrameBufferQuality::Compact,
        Transform::from_xyz(0.0, 2.2, 7.0).looking_at(Vec3::new(0.0, 0.6, 0.0), Vec3::Y),
    ));
    commands.spawn((
        DirectionalLight {
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(-3.0, 6.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(14.0, 14.0))),
        MeshMaterial3d(materials.add(Color::srgb(0.3, 0.34, 0.3))),
    ));
    // Saturated colours, bright lights and glass: what packed colours are worst at.
    let sphere = meshes.add(Sphere::new(0.7));
    let cube = meshes.add(Cuboid::from_length(0.5));
    for i in 0..7 {
        let x = 1.5 * (i as f32 - 3.0);
        let hue = 51.0 * i as f32;
        commands.spawn((
            Mesh3d(sphere.clone()),
            MeshMaterial3d(materials.add(StandardMaterial {
                base_color: Color::hsl(hue, 1.0, 0.5),
                perceptual_roughness: 0.3,
                ..default()
            })),
            Transform::from_xyz(x, 0.7, 0.0),
        ));
        commands.spawn((
            Turning,
            Mesh3d(cube.clone()),
            MeshMaterial3d(materials.add(StandardMaterial {
                emissive: LinearRgba::from(Color::hsl(hue, 1.0, 0.5)) * 30.0,
                ..default()
            })),
            Transform::from_xyz(x, 2.4, -1.5),
        ));
        commands.spawn((
            Turning,
            Mesh3d(cube.clone()),
            MeshMaterial3d(materials.add(Color::hsla(hue + 180.0, 1.0, 0.6, 0.5))),
            Transform::from_xyz(x + 0.5, 0.5, 1.6),
        ));
    }
}

fn turn(mut turning: Query<&mut Transform, With<Turning>>, time: Res<Time>) {
    for mut transform in &mut turning {
        transform.rotate_y(0.7 * time.delta_secs());
    }
}

fn switch(
    mut commands: Commands,
    keys: Res<ButtonInput<KeyCode>>,
    camera: Single<(Entity, &mut Msaa), With<Camera3d>>,
) {
    let (entity, mut msaa) = camera.into_inner();
    for (key, quality) in [
        (KeyCode::Digit1, FrameBufferQuality::Exact),
        (KeyCode::Digit2, FrameBufferQuality::Compact),
        (KeyCode::Digit3, YCoCgFrameBuffer::default().into()),
        (KeyCode::Digit4, FrameBufferQuality::Smallest),
    ] {
        if keys.just_pressed(key) {
            let mut camera = commands.entity(entity);
            camera.insert(quality);
            if quality == FrameBufferQuality::Smallest {
                camera.remove::<(Hdr, Bloom)>();
            } else {
                camera.insert((Hdr, Bloom::NATURAL));
            }
        }
    }
    if keys.just_pressed(KeyCode::KeyM) {
        *msaa = match *msaa {
            Msaa::Off => Msaa::Sample4,
            _ => Msaa::Off,
        };
    }
}

/// What became of the camera's quality is in a component: the format, or why it is not used.
fn describe(
    mut caption: Single<&mut Text, With<common::Caption>>,
    camera: Single<(&FrameBufferQuality, &FrameBufferReport, &Msaa)>,
) {
    let (quality, report, msaa) = *camera;
    caption.0 = format!(
        "{quality:?} (1, 2, 3, 4), {:?}\n{}x (M): {:.1} MB of colours",
        report.state,
        msaa.samples(),
        report.memory.total() as f64 / 1e6,
    );
}
