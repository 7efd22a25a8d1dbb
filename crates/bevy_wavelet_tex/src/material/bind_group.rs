//! The bind group of the material extension.

use bevy::{
    asset::{AssetId, Handle},
    ecs::{
        resource::Resource,
        system::{SystemParamItem, lifetimeless::SRes},
        world::{FromWorld, World},
    },
    image::Image,
    platform::collections::HashMap,
    render::{
        render_asset::{PrepareAssetError, RenderAsset, RenderAssets},
        render_resource::{
            AddressMode, AsBindGroup, AsBindGroupError, BindGroupBuilder, BindGroupLayout,
            BindGroupLayoutEntry, BufferInitDescriptor, BufferUsages, FilterMode, MipmapFilterMode,
            Sampler, SamplerBindingType, SamplerDescriptor, ShaderStages, ShaderType,
            TextureSampleType, TextureViewDimension, UnpreparedBindingResource,
            binding_types::{self, texture_2d_array, uniform_buffer},
            encase::UniformBuffer,
        },
        renderer::RenderDevice,
        texture::{FallbackImage, GpuImage},
    },
};

use super::{
    extension::{Map, WaveletExtension, WaveletKey},
    uniform::{MaterialUniform, TextureUniform},
};
use crate::{
    asset::{Part, Parts, WaveletTexture},
    settings::WaveletAddressMode,
};

/// A [`WaveletTexture`] in the render world: its uniform and its images.
pub struct GpuWaveletTexture {
    uniform: TextureUniform,
    images: Parts<AssetId<Image>>,
}

impl RenderAsset for GpuWaveletTexture {
    type SourceAsset = WaveletTexture;
    type Param = ();

    fn prepare_asset(
        texture: WaveletTexture,
        _: AssetId<WaveletTexture>,
        (): &mut SystemParamItem<Self::Param>,
        _: Option<&Self>,
    ) -> Result<Self, PrepareAssetError<WaveletTexture>> {
        Ok(Self {
            uniform: TextureUniform::new(&texture),
            images: texture.images.as_ref().map(Handle::id),
        })
    }
}

const UNIFORM_BINDING: u32 = 100;
const CHROMA_SAMPLER_BINDING: u32 = 101;
const COEFFICIENT_SAMPLER_BINDING: u32 = 102;
const FIRST_TEXTURE_BINDING: u32 = 103;

/// The textures, from [`FIRST_TEXTURE_BINDING`] in the order of `bindings.wesl`: the map, and the
/// image of its texture.
const TEXTURES: [(Map, Part); 14] = [
    (Map::BaseColor, Part::Luma),
    (Map::BaseColor, Part::Detail),
    (Map::BaseColor, Part::Chroma),
    (Map::Emissive, Part::Luma),
    (Map::Emissive, Part::Detail),
    (Map::Emissive, Part::Chroma),
    (Map::Normal, Part::Luma),
    (Map::MetallicRoughness, Part::Luma),
    (Map::MetallicRoughness, Part::Detail),
    (Map::MetallicRoughness, Part::Chroma),
    (Map::Occlusion, Part::Luma),
    (Map::Occlusion, Part::Detail),
    (Map::Mask, Part::Luma),
    (Map::Mask, Part::Detail),
];

/// The samplers of each address mode, which are made once and shared by all materials.
#[derive(Resource)]
pub struct WaveletSamplers(HashMap<WaveletAddressMode, [Sampler; 2]>);

impl WaveletSamplers {
    /// The sampler of chroma and the sampler of coefficients.
    fn of(&self, mode: WaveletAddressMode) -> Option<&[Sampler; 2]> {
        self.0.get(&mode)
    }
}

impl FromWorld for WaveletSamplers {
    fn from_world(world: &mut World) -> Self {
        let device = world.resource::<RenderDevice>();
        let linear = SamplerDescriptor {
            label: Some("wavelet_chroma"),
            mag_filter: FilterMode::Linear,
            min_filter: FilterMode::Linear,
            ..Default::default()
        };
        let samplers = |mode: WaveletAddressMode| {
            let address = match mode {
                WaveletAddressMode::Repeat => AddressMode::Repeat,
                WaveletAddressMode::ClampToEdge => AddressMode::ClampToEdge,
                WaveletAddressMode::MirrorRepeat => AddressMode::MirrorRepeat,
            };
            let coefficients = SamplerDescriptor {
                label: Some("wavelet_coefficients"),
                address_mode_u: address,
                address_mode_v: address,
                mipmap_filter: MipmapFilterMode::Linear,
                anisotropy_clamp: 16,
                ..linear.clone()
            };
            let all = [&linear, &coefficients].map(|d| device.create_sampler(d));
            (mode, all)
        };
        Self(WaveletAddressMode::ALL.map(samplers).into_iter().collect())
    }
}

// This is not derived because the bindings depend on assets that the derive macro cannot reach.
impl AsBindGroup for WaveletExtension {
    type Data = WaveletKey;
    type Param = (
        SRes<RenderAssets<GpuWaveletTexture>>,
        SRes<RenderAssets<GpuImage>>,
        SRes<FallbackImage>,
        SRes<WaveletSamplers>,
    );

    fn label() -> &'static str {
        "wavelet_extension"
    }

    fn bind_group_data(&self) -> WaveletKey {
        self.key()
    }

    fn build_bind_group(
        &self,
        _: &BindGroupLayout,
        render_device: &RenderDevice,
        (textures, images, fallback, samplers): &mut SystemParamItem<'_, '_, Self::Param>,
        _: bool,
        output: &mut BindGroupBuilder,
    ) -> Result<(), AsBindGroupError> {
        let texture = |map| match self.map(map) {
            None => Ok(None),
            Some(handle) => textures
                .get(handle)
                .map(Some)
                .ok_or(AsBindGroupError::RetryNextUpdate),
        };
        let uniform = |map| -> Result<TextureUniform, AsBindGroupError> {
            let uniform = texture(map)?.map_or_else(TextureUniform::default, |t| t.uniform);
            Ok(uniform.addressed(self.address_mode))
        };
        let mut bytes = UniformBuffer::new(Vec::new());
        bytes
            .write(&MaterialUniform {
                base_color: uniform(Map::BaseColor)?,
                emissive: uniform(Map::Emissive)?,
                normal: uniform(Map::Normal)?,
                metallic_roughness: uniform(Map::MetallicRoughness)?,
                occlusion: uniform(Map::Occlusion)?,
                mask: uniform(Map::Mask)?,
            })
            .expect("a vector grows");
        let buffer = render_device.create_buffer_with_data(&BufferInitDescriptor {
            label: Some("wavelet_material_uniform"),
            usage: BufferUsages::UNIFORM,
            contents: bytes.as_ref(),
        });

        let [chroma, coefficients] = samplers
            .of(self.address_mode)
            .ok_or(AsBindGroupError::RetryNextUpdate)?
            .clone();
        let sampler =
            |sampler| UnpreparedBindingResource::Sampler(SamplerBindingType::Filtering, sampler);
        let mut bindings = vec![
            (UNIFORM_BINDING, UnpreparedBindingResource::Buffer(buffer)),
            (CHROMA_SAMPLER_BINDING, sampler(chroma)),
            (COEFFICIENT_SAMPLER_BINDING, sampler(coefficients)),
        ];
        for (binding, (map, part)) in (FIRST_TEXTURE_BINDING..).zip(TEXTURES) {
            // Missing images are bound to a fallback of one pixel, which the shader never reads.
            let view = match texture(map)?.and_then(|texture| texture.images.part(part)) {
                Some(image) => {
                    &images
                        .get(image)
                        .ok_or(AsBindGroupError::RetryNextUpdate)?
                        .texture_view
                }
                None => &fallback.d2_array.texture_view,
            };
            bindings.push((
                binding,
                UnpreparedBindingResource::TextureView(TextureViewDimension::D2Array, view.clone()),
            ));
        }
        output.extend(bindings);
        Ok(())
    }

    fn bind_group_layout_entries(_: &RenderDevice, _: bool) -> Vec<BindGroupLayoutEntry> {
        let uniform =
            uniform_buffer::<MaterialUniform>(false).build(UNIFORM_BINDING, ShaderStages::FRAGMENT);
        debug_assert!(MaterialUniform::min_size().get() > 0);
        let texture = texture_2d_array(TextureSampleType::Float { filterable: true });
        let textures = (FIRST_TEXTURE_BINDING..)
            .take(TEXTURES.len())
            .map(|binding| texture.build(binding, ShaderStages::FRAGMENT));
        let samplers = [CHROMA_SAMPLER_BINDING, COEFFICIENT_SAMPLER_BINDING].map(|binding| {
            binding_types::sampler(SamplerBindingType::Filtering)
                .build(binding, ShaderStages::FRAGMENT)
        });
        std::iter::once(uniform)
            .chain(samplers)
            .chain(textures)
            .collect()
    }
}
