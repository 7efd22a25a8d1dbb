//! The room: geometry, lights, and textures, as they are and encoded.

use std::{f32::consts::FRAC_PI_2, path::Path};

use bevy::{
    image::{ImageAddressMode, ImageSampler},
    light::CascadeShadowConfigBuilder,
    math::Affine2,
    prelude::*,
};
use bevy_wavelet_tex::codec::{
    color::ycocg_from_rgb,
    image::{ColorSpace, Content, WaveletImage},
    rate::Rate,
    settings::{Effort, EncodeSettings},
    source::{Pixels, Source},
};
use image::{DynamicImage, Rgba, RgbaImage};

use crate::{
    content,
    runner::{SceneSettings, Side},
    scenes::wavelet_tex::{self, Place},
    wavelets::{encoded, wavelets},
};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

#[derive(Resource)]
pub struct Sources {
    picture: SourceMap,
    bricks: [SourceMap; 2],
    floor: [SourceMap; 2],
    plant: [SourceMap; 3],
    plant_with_mask: SourceMap,
    encoded_with: Option<(Effort, Rate)>,
}

/// One map, and what the codec made of it.
pub struct SourceMap {
    pixels: RgbaImage,
    content: Content,
    color_space: ColorSpace,
    encoded: Option<WaveletImage>,
}

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
        let color = |image: DynamicImage| SourceMap::new(image, Content::Color, ColorSpace::Srgb);
        let normal =
            |image: DynamicImage| SourceMap::new(image, Content::Normal, ColorSpace::Linear);
        let [bricks, wood, leaves] = [content::bricks, content::wood, content::foliage]
            .map(|generate| generate(MATERIAL_SIZE, MATERIAL_SIZE, 1));
        let masked = leaves.masked_color();
        Self {
            picture: color(picture),
            bricks: [color(bricks.color.into()), normal(bricks.normal.into())],
            floor: [color(wood.color.into()), normal(wood.normal.into())],
            plant: [
                color(leaves.color.into()),
                normal(leaves.normal.into()),
                SourceMap::new(leaves.mask.into(), Content::Gray, ColorSpace::Linear),
            ],
            plant_with_mask: color(masked.into()),
            encoded_with: None,
        }
    }

    pub fn picture(&self) -> &RgbaImage {
        &self.picture.pixels
    }

    /// The same for the encoder.
    pub fn picture_source(&self) -> Source<'_> {
        let pixels: &[[u8; 4]] = bytemuck::cast_slice(self.picture.pixels.as_raw());
        Source::new(
            self.picture.pixels.dimensions().into(),
            Pixels::Rgba8(pixels),
        )
    }

    /// Encodes all maps, unless they are; `color` is the rate of colours.
    pub fn encode(&mut self, effort: Effort, color: Rate) {
        if self.encoded_with == Some((effort, color)) {
            return;
        }
        let maps = [&mut self.picture].into_iter();
        let maps = maps
            .chain(&mut self.bricks)
            .chain(&mut self.floor)
            .chain(&mut self.plant);
        maps.for_each(|map| map.encode(effort, color));
        self.encoded_with = Some((effort, color));
    }

    pub fn base_color(&self, surface: Surface) -> &SourceMap {
        match surface {
            Surface::Picture => &self.picture,
            Surface::Bricks => &self.bricks[0],
            Surface::Floor => &self.floor[0],
            Surface::Plant => &self.plant[0],
        }
    }

    /// The same with the mask as its alpha, as a `StandardMaterial` wants it.
    pub fn base_color_with_mask(&self, surface: Surface) -> &SourceMap {
        match surface {
            Surface::Plant => &self.plant_with_mask,
            _ => self.base_color(surface),
        }
    }

    pub fn normal(&self, surface: Surface) -> Option<&SourceMap> {
        match surface {
            Surface::Picture => None,
            Surface::Bricks => Some(&self.bricks[1]),
            Surface::Floor => Some(&self.floor[1]),
            Surface::Plant => Some(&self.plant[1]),
        }
    }

    pub fn mask(&self, surface: Surface) -> Option<&SourceMap> {
        (surface == Surface::Plant).then(|| &self.plant[2])
    }
}

impl SourceMap {
    fn new(image: DynamicImage, content: Content, color_space: ColorSpace) -> Self {
        Self {
            pixels: image.into_rgba8(),
            content,
            color_space,
            encoded: None,
        }
    }

    fn encode(&mut self, effort: Effort, color: Rate) {
        let rate = match self.content {
            Content::Color => color,
            other => Rate::usual(other),
        };
        let settings = EncodeSettings {
            effort,
            ..wavelets(rate, self.color_space)
        };
        match encoded(&self.pixels, &settings) {
            Ok(image) => self.encoded = Some(image),
            // A picture of the user's can be too large; what was shown stays.
            Err(error) => eprintln!("{error}"),
        }
    }

    /// What the codec made of it.
    ///
    /// # Panics
    /// Before [`Sources::encode`].
    pub fn encoded(&self) -> &WaveletImage {
        self.encoded.as_ref().expect("encoded at start")
    }

    /// The original as RGBA8 with a full chain of mips, filtered in linear light.
    pub fn uncompressed(&self, repeats: bool) -> Image {
        let mut image = content::mipped_texture(&self.pixels, self.color_space == ColorSpace::Srgb);
        if let ImageSampler::Descriptor(sampler) = &mut image.sampler
            && !repeats
        {
            sampler.set_address_mode(ImageAddressMode::ClampToEdge);
        }
        image
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
