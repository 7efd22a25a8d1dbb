//! The material properties that voxels use.

use bevy::{
    pbr::{ExtendedMaterial, MaterialExtension},
    prelude::*,
    render::render_resource::{Face, ShaderType},
};

use super::mean_color::MeanColors;
use crate::settings::MeshVoxelMaterial;

/// The properties of a mesh's material that voxels use. Keep in sync with `shaders/gpu_types.wesl`.
#[derive(ShaderType, Clone, Copy, Debug, PartialEq)]
pub struct VoxelMaterial {
    /// Diffuse reflectance per channel, 0 to 1.
    pub albedo: Vec3,
    /// Weight of the camera's exposure in the emission, 0 to 1; see
    /// `StandardMaterial::emissive_exposure_weight`.
    pub emissive_exposure_weight: f32,
    /// Emission per channel, in the units of `StandardMaterial::emissive`.
    pub emissive: Vec3,
    /// 1 if both sides are drawn, else 0.
    pub double_sided: u32,
    /// 1 if it is transparent and therefore not voxelised, else 0.
    pub transparent: u32,
    /// Opaque fraction of its area, 0 to 1: below 1 where an alpha mask cuts holes.
    pub coverage: f32,
}

impl VoxelMaterial {
    /// An unknown material: neutral gray (thesis section 6.5.2).
    pub const NEUTRAL: Self = Self {
        albedo: Vec3::splat(0.5),
        emissive_exposure_weight: 0.0,
        emissive: Vec3::ZERO,
        double_sided: 0,
        transparent: 0,
        coverage: 1.0,
    };

    /// Returns the material of a mesh that overrides some of it.
    pub(super) fn overridden_by(self, mesh: &MeshVoxelMaterial) -> Self {
        let coverage = mesh.coverage.filter(|coverage| coverage.is_finite());
        let emissive = mesh
            .emissive
            .map(|color| finite(color.to_vec3()).max(Vec3::ZERO));
        Self {
            emissive: emissive.unwrap_or(self.emissive),
            albedo: mesh.albedo.map_or(self.albedo, |albedo| {
                finite(albedo).clamp(Vec3::ZERO, Vec3::ONE)
            }),
            coverage: coverage.map_or(self.coverage, |coverage| coverage.clamp(0.0, 1.0)),
            ..self
        }
    }
}

/// A material that defines the [`VoxelMaterial`] of its meshes.
///
/// It is implemented for `StandardMaterial` and its extensions. For other materials, implement this
/// trait and add [`VoxelMaterialPlugin`](crate::VoxelMaterialPlugin); without it, their meshes are
/// neutral gray.
pub trait AsVoxelMaterial: Material {
    /// Returns the material for voxels. `mean` gives the mean colour of an image, mid gray while it is not
    /// loaded.
    fn as_voxel_material(&self, mean: &mut MeanColors) -> VoxelMaterial;
}

impl AsVoxelMaterial for StandardMaterial {
    fn as_voxel_material(&self, mean: &mut MeanColors) -> VoxelMaterial {
        let base = self.base_color.to_linear();
        let (texel, coverage) = match (&self.base_color_texture, self.alpha_mode) {
            (Some(image), AlphaMode::Mask(cutoff)) => mean.masked(image, cutoff / base.alpha),
            (Some(image), AlphaMode::AlphaToCoverage) => {
                let texel = mean.of(image);
                (texel, texel.alpha * base.alpha)
            }
            (Some(image), _) => (mean.of(image), 1.0),
            (None, AlphaMode::Mask(cutoff)) => (LinearRgba::WHITE, f32::from(base.alpha >= cutoff)),
            (None, AlphaMode::AlphaToCoverage) => (LinearRgba::WHITE, base.alpha),
            (None, _) => (LinearRgba::WHITE, 1.0),
        };
        let mut texture = |image: &Option<Handle<Image>>| match image {
            Some(image) => mean.of(image),
            None => LinearRgba::WHITE,
        };
        let metallic = self.metallic * texture(&self.metallic_roughness_texture).blue;
        let transparent = matches!(
            self.alpha_mode,
            AlphaMode::Blend | AlphaMode::Premultiplied | AlphaMode::Add | AlphaMode::Multiply
        ) || self.specular_transmission > 0.5;
        let color = base.to_vec3() * texel.to_vec3();
        // An unlit material shows its colour whatever the exposure, as an emission of weight 0 does.
        let (albedo, emissive, exposure_weight) = if self.unlit {
            (Vec3::ZERO, color, 0.0)
        } else {
            let emissive = self.emissive.to_vec3() * texture(&self.emissive_texture).to_vec3();
            let albedo = color * (1.0 - metallic);
            (albedo, emissive, self.emissive_exposure_weight)
        };
        VoxelMaterial {
            albedo: finite(albedo).clamp(Vec3::ZERO, Vec3::ONE),
            emissive_exposure_weight: exposure_weight.clamp(0.0, 1.0),
            emissive: finite(emissive).max(Vec3::ZERO),
            double_sided: u32::from(self.cull_mode != Some(Face::Back)),
            transparent: u32::from(transparent),
            coverage: if coverage.is_finite() {
                coverage.clamp(0.0, 1.0)
            } else {
                1.0
            },
        }
    }
}

impl<E: MaterialExtension> AsVoxelMaterial for ExtendedMaterial<StandardMaterial, E> {
    fn as_voxel_material(&self, mean: &mut MeanColors) -> VoxelMaterial {
        self.base.as_voxel_material(mean)
    }
}

fn finite(v: Vec3) -> Vec3 {
    if v.is_finite() { v } else { Vec3::ZERO }
}
