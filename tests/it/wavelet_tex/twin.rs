//! A scene with a material of wavelet textures, and the same scene with the decoded images as ordinary textures.

use bevy::{
    asset::RenderAssetUsages,
    core_pipeline::{
        prepass::{DeferredPrepass, DepthPrepass, MotionVectorPrepass, NormalPrepass},
        tonemapping::{DebandDither, Tonemapping},
    },
    light::{DirectionalLightShadowMap, GlobalAmbientLight},
    pbr::DefaultOpaqueRendererMethod,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_frugal_lab::headless::{HeadlessSettings, LabTarget};
use bevy_wavelet_tex::{
    WaveletAddressMode, WaveletExtension, WaveletFilter, WaveletStandardMaterial, WaveletStorage,
    codec::{
        decoder::decode,
        image::{ColorSpace, Content, WaveletImage},
        rate::Rate,
        settings::EncodeSettings,
    },
};
use image::RgbImage;

use super::scene::{MAX_FRAMES, add_texture, app, encoded_with, wavelets};
use crate::support::pool::Pool;

/// How the camera draws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Path {
    Forward,
    Prepass,
    Deferred,
}

/// The textures of a material.
#[derive(Clone, Default)]
pub struct Maps {
    pub base_color: Option<WaveletImage>,
    pub mask: Option<WaveletImage>,
    pub emissive: Option<WaveletImage>,
    pub normal: Option<WaveletImage>,
    pub metallic_roughness: Option<WaveletImage>,
    pub occlusion: Option<WaveletImage>,
    /// Whether occlusion is the very texture of metallic and roughness.
    pub is_shared: bool,
}

/// Without mips, so that Bevy's textures, which have none here, are filtered alike.
pub fn without_mips(picture: &RgbImage, content: Content, color_space: ColorSpace) -> WaveletImage {
    let settings = EncodeSettings {
        mips: false,
        ..wavelets(Rate::usual(content), color_space)
    };
    encoded_with(picture, &settings)
}

/// What shows a material.
#[derive(Clone)]
pub struct Twin<'a> {
    pub path: Path,
    pub maps: Maps,
    pub base: &'a dyn Fn(&mut World) -> StandardMaterial,
    /// The brightness of the ambient light.
    pub ambient: f32,
    /// Spawns lights, cameras and meshes, and returns those that have the material.
    pub scene: &'a dyn Fn(&mut World, Entity) -> Vec<Entity>,
}

const SIZE: [u32; 2] = [96, 96];

static APPS: Pool = Pool::new(
    || app(HeadlessSettings::with_size(SIZE[0], SIZE[1])),
    // Texels on the other side of a mask's cutoff cast shadows no larger than a pixel.
    |world| world.insert_resource(DirectionalLightShadowMap::default()),
);

impl Twin<'_> {
    /// The picture of the wavelet material, and that of the decoded images.
    pub fn pictures(&self) -> [RgbImage; 2] {
        [self.wavelet(), self.decoded()]
    }

    pub fn wavelet(&self) -> RgbImage {
        self.render(|world| WaveletStandardMaterial {
            base: (self.base)(world),
            extension: self.extension(world),
        })
    }

    pub fn decoded(&self) -> RgbImage {
        self.render(|world| self.standard(world))
    }

    fn render<M: Material>(&self, material: impl FnOnce(&mut World) -> M) -> RgbImage {
        let mut app = APPS.app();
        let world = app.world_mut();
        world.insert_resource(match self.path {
            Path::Deferred => DefaultOpaqueRendererMethod::deferred(),
            Path::Forward | Path::Prepass => DefaultOpaqueRendererMethod::forward(),
        });
        world.insert_resource(GlobalAmbientLight {
            brightness: self.ambient,
            ..default()
        });
        let target = world.resource::<LabTarget>().0.clone();
        let mut camera = world.spawn((
            Camera3d::default(),
            target,
            Msaa::Off,
            Tonemapping::None,
            DebandDither::Disabled,
            Transform::from_xyz(0.0, 0.0, 2.6).looking_at(Vec3::ZERO, Vec3::Y),
        ));
        match self.path {
            Path::Forward => {}
            Path::Prepass => {
                camera.insert((DepthPrepass, NormalPrepass, MotionVectorPrepass));
            }
            Path::Deferred => {
                camera.insert((DepthPrepass, DeferredPrepass));
            }
        }
        let camera = camera.id();
        let entities = (self.scene)(world, camera);
        let material = material(world);
        let material = MeshMaterial3d(world.add_asset::<M>(material));
        for entity in entities {
            world.entity_mut(entity).insert(material.clone());
        }
        app.run_until_ready(MAX_FRAMES).expect("ready");
        app.render_frames(2).expect("frames");
        app.capture_rgb8().expect("a picture")
    }

    fn extension(&self, world: &mut World) -> WaveletExtension {
        let mut add = |image: &Option<WaveletImage>| {
            let image = image.as_ref()?;
            Some(add_texture(world, image, WaveletStorage::Blocks))
        };
        let metallic_roughness = add(&self.maps.metallic_roughness);
        let occlusion = if self.maps.is_shared {
            metallic_roughness.clone()
        } else {
            add(&self.maps.occlusion)
        };
        WaveletExtension {
            base_color: add(&self.maps.base_color),
            mask: add(&self.maps.mask),
            emissive: add(&self.maps.emissive),
            normal: add(&self.maps.normal),
            metallic_roughness,
            occlusion,
            filter: WaveletFilter::Bilinear,
            address_mode: WaveletAddressMode::ClampToEdge,
            ..default()
        }
    }

    fn standard(&self, world: &mut World) -> StandardMaterial {
        let maps = &self.maps;
        let data = |image: &Option<WaveletImage>| {
            let image = image.as_ref()?;
            Some((image.size, decode(image, 0).to_rgba8(image.content)))
        };
        let color = match (data(&maps.base_color), data(&maps.mask)) {
            (color, None) => color,
            (color, Some((size, mask))) => {
                let white = || (size, vec![[255; 4]; mask.len()]);
                let (size, mut texels) = color.unwrap_or_else(white);
                texels.iter_mut().zip(mask).for_each(|(t, m)| t[3] = m[0]);
                Some((size, texels))
            }
        };
        let shared = if maps.is_shared {
            &maps.metallic_roughness
        } else {
            &maps.occlusion
        };
        let base = (self.base)(world);
        let (orm, occlusion) = (data(&maps.metallic_roughness), data(shared));
        let (emissive, normal) = (data(&maps.emissive), data(&maps.normal));
        let mut add = |texels: Option<([u32; 2], Vec<[u8; 4]>)>, format| {
            let (size, texels) = texels?;
            Some(add_image(world, size, texels, format))
        };
        StandardMaterial {
            base_color_texture: add(color, TextureFormat::Rgba8UnormSrgb),
            emissive_texture: add(emissive, TextureFormat::Rgba8UnormSrgb),
            normal_map_texture: add(normal, TextureFormat::Rgba8Unorm),
            metallic_roughness_texture: add(orm, TextureFormat::Rgba8Unorm),
            occlusion_texture: add(occlusion, TextureFormat::Rgba8Unorm),
            ..base
        }
    }
}

pub fn add_image(
    world: &mut World,
    [width, height]: [u32; 2],
    texels: Vec<[u8; 4]>,
    format: TextureFormat,
) -> Handle<Image> {
    let size = Extent3d {
        width,
        height,
        depth_or_array_layers: 1,
    };
    let data = texels.into_flattened();
    let usage = RenderAssetUsages::all();
    world.add_asset(Image::new(size, TextureDimension::D2, data, format, usage))
}

/// A square around the origin that fills the picture, with tangents.
pub fn square(world: &mut World) -> Entity {
    rectangle(world, 2.2)
}

/// A square of this size around the origin, with tangents.
pub fn rectangle(world: &mut World, size: f32) -> Entity {
    let mesh = Mesh::from(Rectangle::new(size, size));
    let mesh = world.add_asset(mesh.with_generated_tangents().expect("tangents"));
    world.spawn(Mesh3d(mesh)).id()
}

/// The largest difference of a channel in levels of 255, and the mean.
pub fn differences(a: &RgbImage, b: &RgbImage) -> (u8, f64) {
    assert_eq!(a.dimensions(), b.dimensions());
    let all = a.as_raw().iter().zip(b.as_raw());
    let all = all.map(|(a, b)| a.abs_diff(*b));
    let sum: f64 = all.clone().map(f64::from).sum();
    (all.max().unwrap_or(0), sum / a.as_raw().len() as f64)
}
