//! The bind group of the material extension.

use bevy::{
    asset::{AssetId, Handle},
    ecs::system::{SystemParamItem, lifetimeless::SRes},
    image::Image,
    render::{
        render_asset::{PrepareAssetError, RenderAsset, RenderAssets},
        render_resource::{
            AsBindGroup, AsBindGroupError, BindGroupBuilder, BindGroupLayout, BindGroupLayoutEntry,
            BufferInitDescriptor, BufferUsages, Sampler, SamplerBindingType, ShaderStages,
            ShaderType, TextureSampleType, TextureViewDimension, UnpreparedBindingResource,
            binding_types::{self, texture_2d_array, uniform_buffer},
            encase::UniformBuffer,
        },
        renderer::RenderDevice,
        texture::{FallbackImage, GpuImage},
    },
};

use super::{
    extension::{Map, WaveletExtension, WaveletKey},
    form::TextureForm,
    samplers::WaveletSamplers,
    uniform::{MaterialUniform, TextureUniform},
};
use crate::asset::{Part, Parts, WaveletTexture};

/// A [`WaveletTexture`] in the render world: its uniform and its images.
pub struct GpuWaveletTexture {
    form: TextureForm,
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
            form: TextureForm::new(&texture),
            uniform: TextureUniform::new(&texture),
            images: texture.images.as_ref().map(Handle::id),
        })
    }
}

const UNIFORM_BINDING: u32 = 100;
const LINEAR_CLAMP_BINDING: u32 = 101;
const DECODED_SAMPLER_BINDING: u32 = 102;
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
        // The key has the forms that the material knew last, and the bind group has to have the same.
        let texture = |map| match self.map(map) {
            None => Ok(None),
            Some(handle) => textures
                .get(handle)
                .filter(|texture| self.forms.of(map) == texture.form)
                .map(Some)
                .ok_or(AsBindGroupError::RetryNextUpdate),
        };
        let uniform = |map| -> Result<TextureUniform, AsBindGroupError> {
            let Some(texture) = texture(map)? else {
                return Ok(TextureUniform::default());
            };
            Ok(texture
                .uniform
                .of_form(texture.form.bits(self.address_mode)))
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

        let sampler = |sampler: &Sampler| {
            UnpreparedBindingResource::Sampler(SamplerBindingType::Filtering, sampler.clone())
        };
        let decoded = samplers.decoded(self.filter, self.address_mode);
        let mut bindings = vec![
            (UNIFORM_BINDING, UnpreparedBindingResource::Buffer(buffer)),
            (LINEAR_CLAMP_BINDING, sampler(samplers.linear_clamp())),
            (DECODED_SAMPLER_BINDING, sampler(decoded)),
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
        let samplers = [LINEAR_CLAMP_BINDING, DECODED_SAMPLER_BINDING].map(|binding| {
            binding_types::sampler(SamplerBindingType::Filtering)
                .build(binding, ShaderStages::FRAGMENT)
        });
        std::iter::once(uniform)
            .chain(samplers)
            .chain(textures)
            .collect()
    }
}
