//! Lookups by the shaders of `bevy_ewa`, one a pixel, at given coordinates: what they compute without what a
//! rasteriser makes of derivatives.

use bevy::{
    asset::{embedded_asset, embedded_path},
    image::{ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor},
    mesh::MeshVertexBufferLayoutRef,
    pbr::{Material, MaterialPipeline, MaterialPipelineKey, MaterialPlugin},
    prelude::*,
    reflect::TypePath,
    render::render_resource::{
        AsBindGroup, RenderPipelineDescriptor, SpecializedMeshPipelineError, TextureFormat,
    },
    shader::{ShaderDefVal, ShaderRef},
};
use bevy_ewa::{
    EwaPlugin, EwaSettings, EwaUniform,
    reference::{AddressMode, Derivatives, Texture},
};

use crate::{
    content,
    headless::{
        HeadlessApp, HeadlessError, HeadlessSettings, LabTarget, TargetFormat, pixel_camera,
    },
    lookups::scenes::{EwaScene, computed_picture, linear_mse},
};

pub mod scenes;

/// A quad that filters one texture at given coordinates.
pub struct Lookups {
    app: HeadlessApp,
    material: Handle<LookupMaterial>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TexelFormat {
    /// 32-bit floats.
    Float32,
    /// Eight bits a channel, of values from 0 to 1.
    Unorm8,
}

impl Lookups {
    /// Square pictures of `size` pixels, with coordinates and derivatives for each of them.
    pub fn new(
        size: u32,
        texture: &Texture,
        format: TexelFormat,
        sampler_anisotropy: u16,
        coordinates: &[([f64; 2], Derivatives)],
    ) -> Result<Self, HeadlessError> {
        let settings = HeadlessSettings::with_size(size, size).in_format(TargetFormat::Float32);
        let mut app = HeadlessApp::new(settings, |app| {
            embedded_asset!(app, "lookup.wesl");
            app.add_plugins((
                EwaPlugin::OPT_IN,
                MaterialPlugin::<LookupMaterial>::default(),
            ));
        })?;
        let software = app.adapter().name.contains("llvmpipe");
        let gradients = coordinates
            .iter()
            .map(|(_, d)| [d.dx[0], d.dx[1], d.dy[0], d.dy[1]]);
        let uvs = coordinates.iter().map(|(uv, _)| [uv[0], uv[1], 0.0, 1.0]);
        let world = app.world_mut();
        let mut images = world.resource_mut::<Assets<Image>>();
        let material = LookupMaterial {
            settings: EwaUniform::new(&EwaSettings::default()),
            filtered: images.add(mipped(texture, format, sampler_anisotropy)),
            gradients: images.add(float_image(size, gradients.collect())),
            coordinates: images.add(float_image(size, uvs.collect())),
            software,
        };
        let material = world.add_asset::<LookupMaterial>(material);
        let mesh = world.add_asset(Rectangle::new(size as f32, size as f32));
        world.spawn((Mesh3d(mesh), MeshMaterial3d(material.clone())));
        let camera = pixel_camera(world.resource::<LabTarget>(), [size, size]);
        world.spawn(camera);
        Ok(Self { app, material })
    }

    /// Chooses what is filtered next.
    pub fn set(&mut self, settings: &EwaSettings, frame: u32) -> Result<(), HeadlessError> {
        let mut materials = self
            .app
            .world_mut()
            .resource_mut::<Assets<LookupMaterial>>();
        if let Some(mut material) = materials.get_mut(&self.material) {
            material.settings = EwaUniform {
                frame,
                ..EwaUniform::new(settings)
            };
        }
        self.app.run_until_ready(200)?;
        self.app.render_frames(1)
    }

    /// The linear picture of a setting.
    pub fn picture(
        &mut self,
        settings: &EwaSettings,
        frame: u32,
    ) -> Result<Vec<[f32; 4]>, HeadlessError> {
        self.set(settings, frame)?;
        Ok(self.app.capture_f32()?.pixels)
    }

    /// Whether the adapter is Mesa's llvmpipe, whose anisotropic filter heeds no derivatives.
    pub fn is_software(&self) -> bool {
        self.app.adapter().name.contains("llvmpipe")
    }

    /// The app, to measure its frames.
    pub fn into_app(self) -> HeadlessApp {
        self.app
    }

    pub fn app(&self) -> &HeadlessApp {
        &self.app
    }
}

/// Mean squared error of linear values against exact EWA, in squares of 8-bit units: of what
/// rounding to bytes would hide.
pub fn linear_error(
    scene: &EwaScene,
    size: u32,
    settings: [&EwaSettings; 2],
    format: TexelFormat,
) -> Result<f64, HeadlessError> {
    let texture = (scene.texture)();
    let coordinates = scene.coordinates(size);
    let mut lookups = Lookups::new(size, &texture, format, 1, &coordinates)?;
    let [actual, expected] = settings;
    let picture = lookups.picture(actual, 0)?;
    let picture = picture
        .iter()
        .map(|p| [p[0], p[1], p[2]].map(f64::from))
        .collect();
    let reference = computed_picture(&texture, &coordinates, size, expected, 0).0;
    Ok(linear_mse(&reference, &picture))
}

#[derive(Asset, AsBindGroup, TypePath, Clone)]
#[bind_group_data(LookupKey)]
struct LookupMaterial {
    #[uniform(0)]
    settings: EwaUniform,
    #[texture(1)]
    #[sampler(2)]
    filtered: Handle<Image>,
    #[texture(3, filterable = false)]
    gradients: Handle<Image>,
    #[texture(4, filterable = false)]
    coordinates: Handle<Image>,
    software: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct LookupKey {
    method: u32,
    probes: u32,
    kernel: u32,
    sampler_anisotropy: u32,
    software: bool,
}

impl From<&LookupMaterial> for LookupKey {
    fn from(material: &LookupMaterial) -> Self {
        Self {
            method: material.settings.method,
            probes: material.settings.probes,
            kernel: material.settings.kernel,
            sampler_anisotropy: material.settings.sampler_anisotropy,
            software: material.software,
        }
    }
}

impl Material for LookupMaterial {
    fn fragment_shader() -> ShaderRef {
        let path = bevy::asset::AssetPath::from_path_buf(embedded_path!("lookup.wesl"));
        ShaderRef::Path(path.with_source("embedded"))
    }

    fn specialize(
        _: &MaterialPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        _: &MeshVertexBufferLayoutRef,
        key: MaterialPipelineKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        let key = key.bind_group_data;
        if let Some(fragment) = &mut descriptor.fragment {
            fragment.shader_defs.extend(
                [
                    ("EWA_METHOD", key.method),
                    ("EWA_PROBES", key.probes),
                    ("EWA_KERNEL", key.kernel),
                    ("EWA_SAMPLER_ANISOTROPY", key.sampler_anisotropy),
                    ("EWA_UNIFORM_LEVELS", key.software.into()),
                ]
                .map(|(name, value)| ShaderDefVal::UInt(name.into(), value)),
            );
        }
        Ok(())
    }
}

fn float_image(size: u32, texels: Vec<[f64; 4]>) -> Image {
    let bytes = texels.into_iter().flatten();
    let bytes = bytes
        .flat_map(|value| (value as f32).to_le_bytes())
        .collect();
    content::texture([size; 2], TextureFormat::Rgba32Float, 1, bytes)
}

/// The texture with all its mip levels.
fn mipped(texture: &Texture, format: TexelFormat, sampler_anisotropy: u16) -> Image {
    let values = texture
        .levels
        .iter()
        .flat_map(|level| level.texels.iter().flatten().copied());
    let (bytes, format) = match format {
        TexelFormat::Float32 => (
            values
                .flat_map(|value| (value as f32).to_le_bytes())
                .collect(),
            TextureFormat::Rgba32Float,
        ),
        TexelFormat::Unorm8 => (
            values.map(|value| (value * 255.0).round() as u8).collect(),
            TextureFormat::Rgba8Unorm,
        ),
    };
    let levels = texture.levels.len() as u32;
    let mut image = content::texture(texture.size(), format, levels, bytes);
    let address = texture.address.map(|address| match address {
        AddressMode::Repeat => ImageAddressMode::Repeat,
        AddressMode::MirrorRepeat => ImageAddressMode::MirrorRepeat,
        AddressMode::ClampToEdge => ImageAddressMode::ClampToEdge,
        AddressMode::ClampToBorder => ImageAddressMode::ClampToBorder,
    });
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: address[0],
        address_mode_v: address[1],
        mipmap_filter: ImageFilterMode::Linear,
        anisotropy_clamp: sampler_anisotropy,
        ..ImageSamplerDescriptor::linear()
    });
    image
}
