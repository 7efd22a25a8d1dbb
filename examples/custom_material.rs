//! A material of the game's own beside the plugins: light of its glow bounces, its textures get mip levels, and it is
//! drawn into a compact frame buffer.
//!
//! Space: the glow, on and off.

mod common;

use bevy::{
    camera::Exposure,
    camera_controller::free_camera::FreeCamera,
    mesh::UvChannel,
    pbr::{ExtendedMaterial, MaterialExtension},
    prelude::*,
    render::render_resource::AsBindGroup,
    shader::ShaderRef,
};
use bevy_ewa::{EwaMaterialPlugin, EwaPlugin};
use bevy_voxel_gi::{
    AsVoxelMaterial, VoxelGiPlugin, VoxelGiVolume, VoxelMaterial, VoxelMaterialPlugin, VoxelTexture,
};
use bevy_ycocg_fb::{DefaultFrameBufferQuality, FrameBufferQuality, YCoCgFrameBufferPlugin};

/// Rings of light. Its shader ends in Bevy's `main_pass_post_lighting_processing`, so it needs nothing for the frame
/// buffer.
#[derive(Asset, AsBindGroup, Reflect, Clone)]
struct Rings {
    /// Luminance of the rings, in cd/m².
    #[uniform(0)]
    glow: LinearRgba,
    #[texture(1)]
    #[sampler(2)]
    pattern: Option<Handle<Image>>,
}

impl Material for Rings {
    fn fragment_shader() -> ShaderRef {
        "shaders/rings.wesl".into()
    }
}

/// What voxels know of the material. Without this, it would be a gray obstacle.
impl AsVoxelMaterial for Rings {
    fn as_voxel_material(&self) -> VoxelMaterial {
        let pattern = self.pattern.as_ref();
        VoxelMaterial {
            base_color: LinearRgba::rgb(0.1, 0.1, 0.1),
            // Half of a period of the rings glows.
            emissive: 0.5 * self.glow.to_vec3(),
            emissive_texture: pattern.map(|image| VoxelTexture::new(image, &UvChannel::Uv0)),
            ..default()
        }
    }
}

/// An extension of Bevy's material has the voxels of its base.
#[derive(Asset, AsBindGroup, Reflect, Clone, Default)]
struct Dusty {}

impl MaterialExtension for Dusty {}

type DustyMaterial = ExtendedMaterial<StandardMaterial, Dusty>;

fn main() -> AppExit {
    App::new()
        .add_plugins((
            common::plugins(),
            EwaPlugin::default(),
            VoxelGiPlugin,
            YCoCgFrameBufferPlugin,
        ))
        // The game's own materials, and one line for each plugin that wants to know of them.
        .add_plugins((
            MaterialPlugin::<Rings>::default(),
            VoxelMaterialPlugin::<Rings>::default(),
            EwaMaterialPlugin::<Rings>::default(),
            MaterialPlugin::<DustyMaterial>::default(),
            VoxelMaterialPlugin::<DustyMaterial>::default(),
            EwaMaterialPlugin::<DustyMaterial>::default(),
        ))
        .insert_resource(DefaultFrameBufferQuality(FrameBufferQuality::Compact))
        .insert_resource(GlobalAmbientLight::NONE)
        .add_systems(Startup, spawn)
        .add_systems(Update, (switch, describe))
        .run()
}

const GLOW: LinearRgba = LinearRgba::rgb(4000.0, 1200.0, 200.0);

fn spawn(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut rings: ResMut<Assets<Rings>>,
    mut dusty: ResMut<Assets<DustyMaterial>>,
) {
    commands.spawn((
        VoxelGiVolume::fixed(16.0),
        Transform::from_xyz(0.0, 2.0, 0.0),
    ));
    commands.spawn((
        Camera3d::default(),
        FreeCamera::default(),
        Exposure { ev100: 11.0 },
        Transform::from_xyz(0.0, 2.5, 7.0).looking_at(Vec3::new(0.0, 1.2, 0.0), Vec3::Y),
    ));
    let plaster = dusty.add(DustyMaterial {
        base: StandardMaterial {
            base_color: Color::srgb(0.8, 0.8, 0.8),
            perceptual_roughness: 1.0,
            ..default()
        },
        extension: Dusty {},
    });
    for (at, size) in [
        ([0.0, -0.25, 0.0], [10.0, 0.5, 10.0]),
        ([0.0, 2.0, -3.0], [10.0, 4.0, 0.5]),
        ([-2.5, 0.6, 0.0], [1.2, 1.2, 1.2]),
    ] {
        commands.spawn((
            Mesh3d(meshes.add(Cuboid::from_size(size.into()))),
            MeshMaterial3d(plaster.clone()),
            Transform::from_translation(at.into()),
        ));
    }
    commands.spawn((
        Mesh3d(meshes.add(Sphere::new(0.8).mesh().uv(64, 32))),
        MeshMaterial3d(rings.add(Rings {
            glow: GLOW,
            pattern: Some(assets.load("bricks.jpg")),
        })),
        Transform::from_xyz(0.6, 0.8, 0.0),
    ));
}

fn switch(keys: Res<ButtonInput<KeyCode>>, mut rings: ResMut<Assets<Rings>>) {
    if keys.just_pressed(KeyCode::Space) {
        for (_, material) in rings.iter_mut() {
            let is_on = material.glow != LinearRgba::BLACK;
            material.glow = if is_on { LinearRgba::BLACK } else { GLOW };
        }
    }
}

fn describe(mut caption: Single<&mut Text, With<common::Caption>>, rings: Res<Assets<Rings>>) {
    let is_on = rings
        .iter()
        .any(|(_, rings)| rings.glow != LinearRgba::BLACK);
    caption.0 = format!("the glow: {} (Space)", if is_on { "on" } else { "off" });
}
