//! The tunnels, each with a material of its own.

use bevy::{
    image::{ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor},
    math::Affine2,
    prelude::*,
    render::render_resource::TextureFormat,
};
use bevy_wavelet_tex::{
    WaveletExtension, WaveletStandardMaterial, WaveletStorage, WaveletTexture,
    codec::{
        blocks::{BlockQuality, Texel, encode_bc1, encode_bc7},
        image::WaveletImage,
    },
};
use image::{RgbImage, RgbaImage, buffer::ConvertBuffer};

use super::filters::{FORMATS, Filter, HARDWARE};
use crate::{
    record::Measurement,
    wavelet_tex::encoded::{fetched_bytes, fetches},
};
use bevy_frugal_lab::{content, headless::AwaitedAssets};

/// Of the tunnel, in metres; its radius is 1.
const LENGTH: f32 = 60.0;

/// A material in a tunnel of its own, and its row so far.
pub(super) struct Setting {
    pub(super) entity: Entity,
    pub(super) images: Vec<Handle<Image>>,
    pub(super) row: Measurement,
}

impl Setting {
    fn new(entity: Entity, images: Vec<Handle<Image>>, row: Measurement) -> Self {
        let row = Measurement {
            scene: "tunnel".into(),
            ..row
        };
        Self {
            entity,
            images,
            row,
        }
    }
}

/// A tunnel without a texture, and the hardware's own filters.
pub(super) fn spawn_hardware(
    world: &mut World,
    tunnel: &Handle<Mesh>,
    picture: &RgbImage,
    filters: &[Filter],
) -> Vec<Setting> {
    let row = Measurement {
        setting: "no texture".into(),
        reference: "nothing".into(),
        fetches: Some(0.0),
        fetched_bytes: Some(0.0),
        ..Measurement::default()
    };
    let entity = spawn_standard(world, tunnel, None);
    let mut settings = vec![Setting::new(entity, Vec::new(), row)];
    let rgba: RgbaImage = picture.convert();
    for (format_name, texel_bytes, format) in FORMATS {
        let image = hardware_texture(&rgba, format);
        for (filter, texels) in HARDWARE {
            if !filters.iter().any(|f| f.hardware == filter) {
                continue;
            }
            let mut image = image.clone();
            image.sampler = sampler(filter);
            let image = world.resource_mut::<Assets<Image>>().add(image);
            let row = Measurement {
                setting: format!("{format_name} {filter}"),
                reference: format!("rgba8 {filter}"),
                fetches: Some(1.0),
                fetched_bytes: Some(texels * texel_bytes),
                ..Measurement::default()
            };
            let entity = spawn_standard(world, tunnel, Some(image.clone()));
            settings.push(Setting::new(entity, vec![image], row));
        }
    }
    settings
}

pub(super) fn spawn_ours(
    world: &mut World,
    tunnel: &Handle<Mesh>,
    texture: &WaveletImage,
    filter: Filter,
) -> Setting {
    let handle = world.resource_scope(|world, mut textures: Mut<Assets<WaveletTexture>>| {
        let mut images = world.resource_mut::<Assets<Image>>();
        WaveletTexture::add(texture, WaveletStorage::Blocks, &mut textures, &mut images)
    });
    let textures = world.resource::<Assets<WaveletTexture>>();
    let images = textures
        .get(&handle)
        .map(|t| t.images.iter().cloned().collect());
    let extension = WaveletExtension {
        base_color: Some(handle),
        filter: filter.filter,
        ..default()
    };
    let material =
        world
            .resource_mut::<Assets<WaveletStandardMaterial>>()
            .add(WaveletStandardMaterial {
                base: base(),
                extension,
            });
    let row = Measurement {
        setting: format!("color3 {}", filter.name),
        reference: format!("rgba8 {}", filter.hardware),
        fetches: Some(filter.lookups * fetches(texture, filter.pixels)),
        fetched_bytes: Some(filter.lookups * fetched_bytes(texture, filter.pixels)),
        ..Measurement::default()
    };
    let entity = world.spawn((
        Mesh3d(tunnel.clone()),
        MeshMaterial3d(material),
        Visibility::Hidden,
    ));
    Setting::new(entity.id(), images.unwrap_or_default(), row)
}

fn spawn_standard(
    world: &mut World,
    tunnel: &Handle<Mesh>,
    image: Option<Handle<Image>>,
) -> Entity {
    let material = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(StandardMaterial {
            base_color_texture: image.clone(),
            ..base()
        });
    if let Some(image) = image {
        world
            .resource_mut::<AwaitedAssets>()
            .0
            .push(image.untyped());
    }
    let tunnel = Mesh3d(tunnel.clone());
    world
        .spawn((tunnel, MeshMaterial3d(material), Visibility::Hidden))
        .id()
}

/// What all materials share: four textures around, a texture for every 1.5 metres.
fn base() -> StandardMaterial {
    StandardMaterial {
        unlit: true,
        cull_mode: None,
        uv_transform: Affine2::from_scale(Vec2::new(4.0, LENGTH / 1.5)),
        ..default()
    }
}

pub(super) fn tunnel() -> Mesh {
    let cylinder = Cylinder::new(1.0, LENGTH)
        .mesh()
        .resolution(64)
        .without_caps();
    Mesh::from(cylinder).rotated_by(Quat::from_rotation_x(std::f32::consts::FRAC_PI_2))
}

/// Shows one tunnel and hides the others.
pub(super) fn show(world: &mut World, shown: Entity) {
    let mut tunnels = world.query_filtered::<(Entity, &mut Visibility), With<Mesh3d>>();
    for (entity, mut visibility) in tunnels.iter_mut(world) {
        visibility.set_if_neq(if entity == shown {
            Visibility::Visible
        } else {
            Visibility::Hidden
        });
    }
}

/// The picture with mips in one of the hardware's formats.
fn hardware_texture(picture: &RgbaImage, format: TextureFormat) -> Image {
    let mut image = content::mipped_texture(picture, true);
    let data = image.data.take().unwrap_or_default();
    let mut blocks = Vec::new();
    let mut start = 0;
    for level in 0..image.texture_descriptor.mip_level_count {
        let size = [picture.width(), picture.height()].map(|s| (s >> level).max(1));
        let end = start + 4 * (size[0] * size[1]) as usize;
        let texels: &[Texel] = bytemuck::cast_slice(&data[start..end]);
        start = end;
        match format {
            TextureFormat::Bc7RgbaUnormSrgb => blocks.extend(encode_bc7(size, [1; 3], |x, y| {
                let [r, g, b, _] = texels[(y * size[0] + x) as usize];
                [r, g, b].map(|v| f32::from(v) / 255.0)
            })),
            TextureFormat::Bc1RgbaUnormSrgb => {
                blocks.extend(encode_bc1(texels, size, BlockQuality::High));
            }
            _ => blocks.extend_from_slice(texels.as_flattened()),
        }
    }
    image.data = Some(blocks);
    image.texture_descriptor.format = format;
    image
}

fn sampler(filter: &str) -> ImageSampler {
    let [nearest, linear] = [ImageFilterMode::Nearest, ImageFilterMode::Linear];
    let (within, between) = match filter {
        "nearest" => (nearest, nearest),
        "nearest mip linear" => (nearest, linear),
        "bilinear" => (linear, nearest),
        _ => (linear, linear),
    };
    ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        address_mode_v: ImageAddressMode::Repeat,
        mag_filter: within,
        min_filter: within,
        mipmap_filter: between,
        anisotropy_clamp: if filter == "anisotropic" { 16 } else { 1 },
        ..default()
    })
}
