//! The material extension, which is the API for games.

use bevy::{
    asset::{Asset, Assets, Handle, embedded_path},
    mesh::MeshVertexBufferLayoutRef,
    pbr::{
        ExtendedMaterial, MaterialExtension, MaterialExtensionKey, MaterialExtensionPipeline,
        StandardMaterial,
    },
    reflect::TypePath,
    render::render_resource::{RenderPipelineDescriptor, SpecializedMeshPipelineError},
    shader::{ShaderDefVal, ShaderRef},
};

use super::form::{self, TextureForm};
use crate::{
    asset::WaveletTexture,
    settings::{WaveletAddressMode, WaveletFilter},
};

/// A `StandardMaterial` whose maps are wavelet textures.
pub type WaveletStandardMaterial = ExtendedMaterial<StandardMaterial, WaveletExtension>;

/// The wavelet textures of a material. A map that is `None` costs nothing in the shader.
///
/// The textures use the material's first UV set and its `uv_transform`. The `StandardMaterial`
/// keeps all of its own fields, so leave its textures of the same maps empty.
#[derive(Asset, Clone, Debug, Default, TypePath)]
pub struct WaveletExtension {
    /// Multiplies the base colour, and its alpha where the texture has one. Gray or colour.
    pub base_color: Option<Handle<WaveletTexture>>,
    /// Multiplies the emissive colour, which is black by default. Gray or colour.
    pub emissive: Option<Handle<WaveletTexture>>,
    /// Normal map in tangent space, with +Y up. The mesh needs tangents.
    pub normal: Option<Handle<WaveletTexture>>,
    /// Multiplies roughness by G and metallic by B, as in glTF. Colour, linear.
    pub metallic_roughness: Option<Handle<WaveletTexture>>,
    /// Fraction of the indirect light that is not occluded, in R. Gray, linear.
    pub occlusion: Option<Handle<WaveletTexture>>,
    /// Multiplies the base colour's alpha; for `AlphaMode::Mask` and blending. Gray, linear.
    pub mask: Option<Handle<WaveletTexture>>,
    /// Filter of all textures of the material. Default: [`WaveletFilter::Trilinear`].
    pub filter: WaveletFilter,
    /// How coordinates outside of `[0, 1]` are addressed. Default: [`WaveletAddressMode::Repeat`].
    pub address_mode: WaveletAddressMode,
    /// What the plugin knows of the textures once they are loaded.
    #[doc(hidden)]
    pub forms: WaveletForms,
}

/// The form of each map's texture, in the order of `Map::ALL`: what the shader is specialised by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WaveletForms([TextureForm; 6]);

impl WaveletForms {
    pub(super) fn of(&self, map: Map) -> TextureForm {
        self.0[map as usize]
    }
}

/// The key that a pipeline of the extension is specialised by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct WaveletKey {
    /// The bits of each map's form, in the order of [`Map::ALL`]; `None` where there is no map.
    maps: [Option<u32>; 6],
    filter: WaveletFilter,
}

/// A map of the material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Map {
    BaseColor,
    Emissive,
    Normal,
    MetallicRoughness,
    Occlusion,
    Mask,
}

impl Map {
    pub(super) const ALL: [Self; 6] = [
        Self::BaseColor,
        Self::Emissive,
        Self::Normal,
        Self::MetallicRoughness,
        Self::Occlusion,
        Self::Mask,
    ];

    fn shader_def(self) -> &'static str {
        match self {
            Self::BaseColor => "WAVELET_BASE_COLOR",
            Self::Emissive => "WAVELET_EMISSIVE",
            Self::Normal => "WAVELET_NORMAL",
            Self::MetallicRoughness => "WAVELET_METALLIC_ROUGHNESS",
            Self::Occlusion => "WAVELET_OCCLUSION",
            Self::Mask => "WAVELET_MASK",
        }
    }
}

impl WaveletExtension {
    pub(super) fn map(&self, map: Map) -> Option<&Handle<WaveletTexture>> {
        match map {
            Map::BaseColor => self.base_color.as_ref(),
            Map::Emissive => self.emissive.as_ref(),
            Map::Normal => self.normal.as_ref(),
            Map::MetallicRoughness => self.metallic_roughness.as_ref(),
            Map::Occlusion => self.occlusion.as_ref(),
            Map::Mask => self.mask.as_ref(),
        }
    }

    /// Iterates over the textures that are in use.
    pub fn textures(&self) -> impl Iterator<Item = &Handle<WaveletTexture>> {
        Map::ALL.into_iter().filter_map(|map| self.map(map))
    }

    /// The forms of the textures. A texture that has not been loaded has none.
    pub(super) fn current_forms(&self, textures: &Assets<WaveletTexture>) -> WaveletForms {
        WaveletForms(Map::ALL.map(|map| {
            let texture = self.map(map).and_then(|handle| textures.get(handle));
            texture.map_or_else(TextureForm::default, TextureForm::new)
        }))
    }

    pub(super) fn key(&self) -> WaveletKey {
        let form = |map| self.forms.of(map).bits(self.address_mode);
        WaveletKey {
            maps: Map::ALL.map(|map| self.map(map).map(|_| form(map))),
            filter: self.filter,
        }
    }
}

impl WaveletKey {
    fn shader_defs(self) -> impl Iterator<Item = ShaderDefVal> {
        let maps = Map::ALL.into_iter().zip(self.maps);
        let maps = maps.flat_map(|(map, form)| {
            let defs = form.map(|form| {
                let name = map.shader_def();
                let planes = form::has_planes(form).then(|| format!("{name}_PLANES").into());
                let form = ShaderDefVal::UInt(format!("{name}_FORM").into(), form);
                [Some(name.into()), Some(form), planes]
                    .into_iter()
                    .flatten()
            });
            defs.into_iter().flatten()
        });
        let filter = match self.filter {
            WaveletFilter::Nearest => Some("WAVELET_FILTER_NEAREST"),
            WaveletFilter::NearestMipLinear => Some("WAVELET_FILTER_NEAREST_MIP_LINEAR"),
            WaveletFilter::Bilinear => Some("WAVELET_FILTER_BILINEAR"),
            WaveletFilter::Stochastic => Some("WAVELET_FILTER_STOCHASTIC"),
            WaveletFilter::StochasticQuad => Some("WAVELET_FILTER_STOCHASTIC_QUAD"),
            WaveletFilter::Trilinear => None,
            WaveletFilter::Anisotropic => Some("WAVELET_FILTER_ANISOTROPIC"),
        };
        maps.chain(filter.map(Into::into))
    }
}

const FORWARD_SHADER: &str = "forward.wesl";

impl MaterialExtension for WaveletExtension {
    fn fragment_shader() -> ShaderRef {
        embedded_shader(FORWARD_SHADER)
    }

    fn deferred_fragment_shader() -> ShaderRef {
        embedded_shader(FORWARD_SHADER)
    }

    fn prepass_fragment_shader() -> ShaderRef {
        embedded_shader("prepass.wesl")
    }

    fn specialize(
        _pipeline: &MaterialExtensionPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        _layout: &MeshVertexBufferLayoutRef,
        key: MaterialExtensionKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        if let Some(fragment) = &mut descriptor.fragment {
            fragment
                .shader_defs
                .extend(key.bind_group_data.shader_defs());
        }
        Ok(())
    }
}

fn embedded_shader(name: &str) -> ShaderRef {
    let path = embedded_path!("").join(name);
    ShaderRef::Path(bevy::asset::AssetPath::from(path).with_source("embedded"))
}
