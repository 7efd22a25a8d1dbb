//! The material extension that a game uses.

use bevy::{
    asset::{Asset, Handle, embedded_path},
    mesh::MeshVertexBufferLayoutRef,
    pbr::{
        ExtendedMaterial, MaterialExtension, MaterialExtensionKey, MaterialExtensionPipeline,
        StandardMaterial,
    },
    reflect::{Reflect, TypePath},
    render::render_resource::{RenderPipelineDescriptor, SpecializedMeshPipelineError},
    shader::{ShaderDefVal, ShaderRef},
};

use crate::asset::WaveletTexture;

/// A `StandardMaterial` whose maps are wavelet textures.
pub type WaveletStandardMaterial = ExtendedMaterial<StandardMaterial, WaveletExtension>;

/// The wavelet textures of a material; what is `None` costs nothing in the shader.
///
/// They use the material's first UV set and its `uv_transform`. The `StandardMaterial` beside it
/// keeps all its own fields: leave its textures for the same maps empty.
#[derive(Asset, Clone, Debug, Default, TypePath)]
pub struct WaveletExtension {
    /// Multiplies the base colour. Gray or colour.
    pub base_color: Option<Handle<WaveletTexture>>,
    /// Normal map in tangent space, +Y up. The mesh needs tangents.
    pub normal: Option<Handle<WaveletTexture>>,
    /// Multiplies the base colour's alpha; for `AlphaMode::Mask` and blending. Gray, linear.
    pub mask: Option<Handle<WaveletTexture>>,
    /// How the textures are filtered. Default: trilinear.
    pub filter: WaveletFilter,
    /// What is seen outside of `[0, 1]`. Default: repeat.
    pub address_mode: WaveletAddressMode,
}

/// How decoded pixels are filtered, from cheapest to smoothest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
pub enum WaveletFilter {
    /// Nearest pixel of the nearest mip: one fetch for each plane.
    Nearest,
    /// Four pixels of the nearest mip.
    Bilinear,
    /// Four pixels of two mips.
    #[default]
    Trilinear,
}

/// What is seen outside of `[0, 1]`, as in wgpu's `AddressMode`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
pub enum WaveletAddressMode {
    /// The texture again.
    #[default]
    Repeat,
    /// The pixels of the edge.
    ClampToEdge,
    /// The texture again, every other time mirrored.
    MirrorRepeat,
}

/// What a pipeline of the extension is specialised for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct WaveletKey {
    base_color: bool,
    normal: bool,
    mask: bool,
    filter: WaveletFilter,
}

impl WaveletExtension {
    pub(super) fn key(&self) -> WaveletKey {
        WaveletKey {
            base_color: self.base_color.is_some(),
            normal: self.normal.is_some(),
            mask: self.mask.is_some(),
            filter: self.filter,
        }
    }
}

impl WaveletKey {
    fn shader_defs(self) -> impl Iterator<Item = ShaderDefVal> {
        [
            (self.base_color, "WAVELET_BASE_COLOR"),
            (self.normal, "WAVELET_NORMAL"),
            (self.mask, "WAVELET_MASK"),
            (
                self.filter == WaveletFilter::Nearest,
                "WAVELET_FILTER_NEAREST",
            ),
            (
                self.filter == WaveletFilter::Bilinear,
                "WAVELET_FILTER_BILINEAR",
            ),
        ]
        .into_iter()
        .filter(|(wanted, _)| *wanted)
        .map(|(_, def)| def.into())
    }
}

const FORWARD_SHADER: &str = "forward.wgsl";

impl MaterialExtension for WaveletExtension {
    fn fragment_shader() -> ShaderRef {
        embedded_shader(FORWARD_SHADER)
    }

    fn deferred_fragment_shader() -> ShaderRef {
        embedded_shader(FORWARD_SHADER)
    }

    fn prepass_fragment_shader() -> ShaderRef {
        embedded_shader("prepass.wgsl")
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
