//! The material properties that voxels use.

use bevy::{
    math::Affine2,
    mesh::UvChannel,
    pbr::{ExtendedMaterial, MaterialExtension},
    prelude::*,
    render::render_resource::Face,
};
use bevy_frugal_hooks::{MapImage, MapImages};

use crate::settings::MeshVoxelMaterial;

/// A texture of a [`VoxelMaterial`]: any two-dimensional image that the GPU samples, of any format, whether its data is
/// on the CPU or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct VoxelTexture {
    /// The image.
    pub image: AssetId<Image>,
    /// Whether it uses the second texture coordinates, `Mesh::ATTRIBUTE_UV_1`.
    pub uses_uv_1: bool,
}

impl VoxelTexture {
    /// Returns the texture of an image that uses these coordinates.
    pub fn new(image: &Handle<Image>, channel: &UvChannel) -> Self {
        Self {
            image: image.id(),
            uses_uv_1: *channel == UvChannel::Uv1,
        }
    }
}

/// How a [`VoxelMaterial`] is cut out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum VoxelAlpha {
    /// It is not.
    #[default]
    Opaque,
    /// Where alpha is below this cutoff, 0 to 1, there are holes. Alpha is the product of that of the material, its base
    /// colour texture and the vertices.
    Mask(f32),
    /// Alpha is the opaque fraction.
    Coverage,
    /// This fraction is opaque, 0 to 1, whatever alpha is.
    Constant(f32),
}

/// The properties of a mesh's material that voxels use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoxelMaterial {
    /// Base colour and alpha, linear. The diffuse reflectance is this, times the base colour texture and the colour of the
    /// vertices, times one minus `metallic`.
    pub base_color: LinearRgba,
    /// Multiplied with the base colour.
    pub base_color_texture: Option<VoxelTexture>,
    /// Whether only the alpha of the base colour texture counts, and the vertices' colours do not.
    pub ignores_colors: bool,
    /// Fraction that does not reflect diffusely, 0 to 1.
    pub metallic: f32,
    /// Its blue channel is multiplied with `metallic`.
    pub metallic_texture: Option<VoxelTexture>,
    /// Emission per channel, in the units of `StandardMaterial::emissive`.
    pub emissive: Vec3,
    /// Multiplied with the emission.
    pub emissive_texture: Option<VoxelTexture>,
    /// Factor of all that it emits into the volume, at least 0.
    pub emission_factor: f32,
    /// Weight of the camera's exposure in the emission, 0 to 1; see
    /// `StandardMaterial::emissive_exposure_weight`.
    pub emissive_exposure_weight: f32,
    /// Whether it shows its base colour whatever the light: it emits the base colour, and reflects nothing.
    pub unlit: bool,
    /// Transform of the texture coordinates.
    pub uv_transform: Affine2,
    /// How it is cut out.
    pub alpha: VoxelAlpha,
    /// Whether both sides are drawn.
    pub double_sided: bool,
    /// Whether it is transparent and therefore not voxelised.
    pub transparent: bool,
}

impl Default for VoxelMaterial {
    fn default() -> Self {
        Self::NEUTRAL
    }
}

impl VoxelMaterial {
    /// An unknown material: neutral gray (thesis section 6.5.2).
    pub const NEUTRAL: Self = Self {
        base_color: LinearRgba::rgb(0.5, 0.5, 0.5),
        base_color_texture: None,
        ignores_colors: false,
        metallic: 0.0,
        metallic_texture: None,
        emissive: Vec3::ZERO,
        emissive_texture: None,
        emission_factor: 1.0,
        emissive_exposure_weight: 0.0,
        unlit: false,
        uv_transform: Affine2::IDENTITY,
        alpha: VoxelAlpha::Opaque,
        double_sided: false,
        transparent: false,
    };

    /// Returns the material with the images of maps that it does not know.
    pub(super) fn with_images(mut self, images: &MapImages) -> Self {
        let texture = |map: &Option<MapImage>| {
            map.as_ref().map(|map| VoxelTexture {
                image: map.image,
                uses_uv_1: map.channel == UvChannel::Uv1,
            })
        };
        self.base_color_texture = self.base_color_texture.or(texture(&images.base_color));
        self.emissive_texture = self.emissive_texture.or(texture(&images.emissive));
        self.metallic_texture = self
            .metallic_texture
            .or(texture(&images.metallic_roughness));
        self
    }

    /// Returns the material of a mesh that overrides some of it.
    pub(super) fn overridden_by(mut self, mesh: &MeshVoxelMaterial) -> Self {
        if let Some(albedo) = mesh.albedo {
            let alpha = self.base_color.alpha;
            self.base_color = LinearRgba::from_vec3(albedo).with_alpha(alpha);
            self.metallic = 0.0;
            self.metallic_texture = None;
            self.ignores_colors = true;
        }
        if let Some(emissive) = mesh.emissive {
            self.emissive = emissive.to_vec3();
            self.emissive_texture = None;
            self.unlit = false;
        }
        if let Some(factor) = mesh.emission_factor {
            self.emission_factor *= factor;
        }
        if let Some(coverage) = mesh.coverage {
            self.alpha = VoxelAlpha::Constant(coverage);
        }
        self
    }
}

/// A material that defines the [`VoxelMaterial`] of its meshes.
///
/// It is implemented for `StandardMaterial`, and for extensions of materials that implement it. For other materials,
/// implement this trait and add [`VoxelMaterialPlugin`](crate::VoxelMaterialPlugin); without it, their meshes are
/// neutral gray.
pub trait AsVoxelMaterial: Material {
    /// Returns the material for voxels. It is asked for again when the material changes, and textures are read again
    /// when their images change.
    fn as_voxel_material(&self) -> VoxelMaterial;
}

impl AsVoxelMaterial for StandardMaterial {
    fn as_voxel_material(&self) -> VoxelMaterial {
        let texture = |image: &Option<Handle<Image>>, channel: &UvChannel| {
            image
                .as_ref()
                .map(|image| VoxelTexture::new(image, channel))
        };
        let alpha = match self.alpha_mode {
            AlphaMode::Mask(cutoff) => VoxelAlpha::Mask(cutoff),
            AlphaMode::AlphaToCoverage => VoxelAlpha::Coverage,
            _ => VoxelAlpha::Opaque,
        };
        let transparent = matches!(
            self.alpha_mode,
            AlphaMode::Blend | AlphaMode::Premultiplied | AlphaMode::Add | AlphaMode::Multiply
        ) || self.specular_transmission > 0.5;
        VoxelMaterial {
            base_color: self.base_color.to_linear(),
            base_color_texture: texture(&self.base_color_texture, &self.base_color_channel),
            ignores_colors: false,
            metallic: self.metallic,
            metallic_texture: texture(
                &self.metallic_roughness_texture,
                &self.metallic_roughness_channel,
            ),
            emissive: self.emissive.to_vec3(),
            emissive_texture: texture(&self.emissive_texture, &self.emissive_channel),
            emission_factor: 1.0,
            emissive_exposure_weight: self.emissive_exposure_weight,
            unlit: self.unlit,
            uv_transform: self.uv_transform,
            alpha,
            double_sided: self.cull_mode != Some(Face::Back),
            transparent,
        }
    }
}

impl<B: AsVoxelMaterial, E: MaterialExtension> AsVoxelMaterial for ExtendedMaterial<B, E> {
    fn as_voxel_material(&self) -> VoxelMaterial {
        self.base.as_voxel_material()
    }
}
