//! The room: geometry, lights, and textures, as they are and encoded.

use std::{f32::consts::FRAC_PI_2, path::Path};

use bevy::{light::CascadeShadowConfigBuilder, math::Affine2, prelude::*};
use bevy_wavelet_tex::codec::{
    color::ycocg_from_rgb,
    source::{Pixels, Source},
};
use image::{Rgba, RgbaImage};

use crate::{
    content,
    runner::{SceneSettings, Side},
    scenes::{
        maps::{Maps, Role},
        wavelet_tex::{self, Place},
    },
};

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Surface {
    Picture,
    Bricks,
    Floor,
    Plant,
}

impl Surface {
    pub fn repeats(self) -> bool {
        matches!(self, Self::Bricks | Self::Floor)
    }
}

#[derive(Component, Clone, Copy, Debug)]
pub struct Part {
    surface: Surface,
    /// Repetitions of the texture in x and y.
    repeat: Vec2,
}

impl Part {
    pub fn surface(self) -> Surface {
        self.surface
    }
}

#[derive(Component)]
pub struct RoomLight;

/// What both sides' materials have in common.
pub fn base_material(part: Part) -> StandardMaterial {
    let (roughness, alpha_mode) = match part.surface {
        Surface::Picture => (0.8, AlphaMode::Opaque),
        Surface::Bricks => (0.9, AlphaMode::Opaque),
        Surface::Floor => (0.45, AlphaMode::Opaque),
        Surface::Plant => (0.6, AlphaMode::Mask(0.5)),
    };
    let leaf = part.surface == Surface::Plant;
    StandardMaterial {
        perceptual_roughness: roughness,
        // A print has no sheen that would veil its colours.
        reflectance: if part.surface == Surface::Picture {
            0.0
        } else {
            StandardMaterial::default().reflectance
        },
        alpha_mode,
        double_sided: leaf,
        cull_mode: if leaf {
            None
        } else {
            StandardMaterial::default().cull_mode
        },
        uv_transform: Affine2::from_scale(part.repeat),
        ..default()
    }
}

/// Spawns every part twice, one for each side, and a light for each.
pub fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>) -> Result {
    let on_the_floor = Quat::from_rotation_x(-FRAC_PI_2);
    let parts = [
        (
            Surface::Bricks,
            Vec2::new(4.0, 2.0),
            Vec2::new(8.0, 4.0),
            Transform::from_xyz(0.0, 2.0, -1.0),
        ),
        (
            Surface::Floor,
            Vec2::new(4.0, 3.0),
            Vec2::new(8.0, 6.0),
            Transform::from_xyz(0.0, 0.0, 2.0).with_rotation(on_the_floor),
        ),
        (
            Surface::Picture,
            Vec2::ONE,
            Vec2::new(2.4, 1.6),
            Transform::from_xyz(-0.55, 1.5, -0.96),
        ),
        (
            Surface::Plant,
            Vec2::ONE,
            Vec2::new(1.0, 1.0),
            Transform::from_xyz(1.3, 0.75, -0.3).with_rotation(Quat::from_rotation_y(-0.5)),
        ),
    ];
    for (surface, repeat, size, transform) in parts {
        let mesh = Mesh::from(Rectangle::from_size(size)).with_generated_tangents()?;
        let mesh = Mesh3d(meshes.add(mesh));
        for side in Side::BOTH {
            let part = Part { surface, repeat };
            commands.spawn((part, side, side.layers(), mesh.clone(), transform));
        }
    }
    for side in Side::BOTH {
        // Directional lights keep to the views of their layers; Bevy's GPU clusters let spot lights
        // shine on all.
        let shadows = CascadeShadowConfigBuilder {
            num_cascades: 1,
            maximum_distance: 9.0,
            ..default()
        };
        commands.spawn((
            RoomLight,
            side.layers(),
            DirectionalLight {
                illuminance: 7000.0,
                shadow_maps_enabled: true,
                ..default()
            },
            shadows.build(),
            Transform::default(),
        ));
        commands.spawn((
            side.layers(),
            DirectionalLight {
                illuminance: 2000.0,
                ..default()
            },
            Transform::from_xyz(-0.5, 0.6, 1.0).looking_at(Vec3::ZERO, Vec3::Y),
        ));
    }
    Ok(())
}

pub fn aim_lights(
    settings: Res<SceneSettings>,
    mut lights: Query<&mut Transform, With<RoomLight>>,
) {
    let (sin, cos) = settings.float("light_angle").to_radians().sin_cos();
    for mut transform in &mut lights {
        *transform = Transform::from_xyz(sin, 0.7, cos).looking_at(Vec3::ZERO, Vec3::Y);
    }
}

/// Shows the room, or hides it.
pub fn show(settings: Res<SceneSettings>, mut parts: Query<&mut Visibility, With<Part>>) {
    for mut visibility in &mut parts {
        visibility.set_if_neq(match wavelet_tex::PLACE.of(&settings) {
            Place::Room => Visibility::Inherited,
            Place::Rates => Visibility::Hidden,
        });
    }
}

/// Side of the generated materials in pixels.
const MATERIAL_SIZE: u32 = 512;

/// The maps of the room.
pub type Sources = Maps<Surface>;

impl Sources {
    /// The room with the user's picture in it, or a generated one.
    pub fn new(picture: Option<&Path>) -> Self {
        let opened = picture.and_then(|path| match image::open(path) {
            Ok(image) => Some(image),
            Err(error) => {
                eprintln!(
                    "cannot show '{}': {error}; a generated picture stands in",
                    path.display()
                );
                None
            }
        });
        let picture = opened.unwrap_or_else(|| content::photo_like(768, 512, 1).into());
        let mut maps = Maps::empty();
        maps.add(Surface::Picture, Role::Color, picture.into_rgba8());
        let [bricks, wood, leaves] = [content::bricks, content::wood, content::foliage]
            .map(|generate| generate(MATERIAL_SIZE, MATERIAL_SIZE, 1));
        maps.add_material(Surface::Bricks, bricks, false);
        maps.add_material(Surface::Floor, wood, false);
        maps.add_material(Surface::Plant, leaves, true);
        maps
    }

    pub fn picture(&self) -> &RgbaImage {
        let picture = self.get(Surface::Picture, Role::Color);
        picture.expect("added when the maps were made")
    }

    /// The same for the encoder.
    pub fn picture_source(&self) -> Source<'_> {
        let pixels: &[[u8; 4]] = bytemuck::cast_slice(self.picture().as_raw());
        Source::new(self.picture().dimensions().into(), Pixels::Rgba8(pixels))
    }
}

/// The luma of a picture, in all three channels.
pub fn gray(picture: &RgbaImage) -> RgbaImage {
    let mut gray = picture.clone();
    for Rgba([r, g, b, _]) in gray.pixels_mut() {
        let luma = ycocg_from_rgb([*r, *g, *b].map(f32::from)).y.round() as u8;
        [*r, *g, *b] = [luma; 3];
    }
    gray
}
