//! The bind group of the material extension, and its samplers, which all materials share.

use bevy::{
    asset::{AssetId, Handle},
    ecs::{
        resource::Resource,
        system::{SystemParamItem, lifetimeless::SRes},
        world::{FromWorld, World},
    },
    image::Image,
    log::error_once,
    pbr::StandardMaterial,
    platform::collections::HashMap,
    render::{
        render_asset::{PrepareAssetError, RenderAsset, RenderAssets},
        render_resource::{
            AddressMode, AsBindGroup, AsBindGroupError, BindGroupBuilder, BindGroupLayout,
            BindGroupLayoutEntry, BindingType, BufferInitDescriptor, BufferUsages, FilterMode,
            MipmapFilterMode, Sampler, SamplerBindingType, SamplerDescriptor, ShaderStages,
            ShaderType, TextureSampleType, TextureViewDimension, UnpreparedBindingResource,
            binding_types::{self, texture_2d_array, uniform_buffer},
            encase::UniformBuffer,
        },
        renderer::RenderDevice,
        settings::WgpuFeatures,
        texture::{FallbackImage, GpuImage},
    },
};

use super::{
    extension::{Map, WaveletExtension, WaveletKey},
    uniform::{MaterialUniform, TextureForm, TextureUniform},
};
use crate::{
    asset::WaveletTexture,
    settings::{WaveletAddressMode, WaveletFilter, WaveletStorage},
};

/// A [`WaveletTexture`] in the render world: its uniform and its images.
pub struct GpuWaveletTexture {
    form: TextureForm,
    uniform: TextureUniform,
    /// Those of all [`Part`]s.
    images: [Option<AssetId<Image>>; 3],
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
            images: texture.images.all().map(|image| image.map(Handle::id)),
        })
    }
}

const UNIFORM_BINDING: u32 = 100;
const LINEAR_CLAMP_BINDING: u32 = 101;
const DECODED_SAMPLER_BINDING: u32 = 102;
const FIRST_TEXTURE_BINDING: u32 = 103;

/// An image of a texture.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    Luma,
    Detail,
    Chroma,
}

/// The textures, from [`FIRST_TEXTURE_BINDING`] in the order of `bindings.wesl`: the map, and the
/// image of its texture.
const TEXTURES: [(Map, Part); 16] = [
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
    (Map::Occlusion, Part::Chroma),
    (Map::Mask, Part::Luma),
    (Map::Mask, Part::Detail),
    (Map::Mask, Part::Chroma),
];

/// Textures that a view of Bevy 0.20 has at most in a fragment shader (`mesh_view_bindings.rs`), and a lightmap.
const BEVYS_TEXTURES: u32 = 17 + 1;

/// The limit of a device that is too low for [`TEXTURES`], and the number of textures that it would have to allow.
///
/// The layout of a bind group is the same for all materials of a type, so it has the textures of all planes that a map
/// may have. Where a device has a lower limit, it has one texture for each map, and the loader decodes those textures
/// that have more.
pub(crate) fn missing_textures(device: &RenderDevice) -> Option<[u32; 2]> {
    let limit = device.limits().max_sampled_textures_per_shader_stage;
    let is_texture = |entry: &&BindGroupLayoutEntry| {
        matches!(entry.ty, BindingType::Texture { .. })
            && entry.visibility.contains(ShaderStages::FRAGMENT)
    };
    let base = StandardMaterial::bind_group_layout_entries(device, true);
    let base = base.iter().filter(is_texture).count();
    let needed = BEVYS_TEXTURES + (base + TEXTURES.len()) as u32;
    (needed > limit).then_some([limit, needed])
}

/// How a device can store wavelet textures that an app makes at run time with
/// [`WaveletTexture::add`](crate::WaveletTexture::add): as blocks, or decoded where it lacks
/// `TEXTURE_COMPRESSION_BC` or binds too few textures for a material with all planes. The loader chooses by itself.
pub fn storage_on(device: &RenderDevice) -> WaveletStorage {
    let samples_bc = device
        .features()
        .contains(WgpuFeatures::TEXTURE_COMPRESSION_BC);
    if samples_bc && missing_textures(device).is_none() {
        WaveletStorage::Blocks
    } else {
        WaveletStorage::Decoded
    }
}

/// The bindings of the textures: where the device's limit is too low for all planes, those of the first texture of
/// each map.
fn bound_textures(device: &RenderDevice) -> impl Iterator<Item = (u32, (Map, Part))> + use<> {
    let is_limited = missing_textures(device).is_some();
    (FIRST_TEXTURE_BINDING..)
        .zip(TEXTURES)
        .filter(move |(_, (_, part))| !is_limited || *part == Part::Luma)
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
        let is_limited = missing_textures(render_device).is_some();
        // The key has the forms that the material knew last, and the bind group has to have the same.
        let texture = |map| -> Result<Option<&GpuWaveletTexture>, AsBindGroupError> {
            let Some(handle) = self.bound(map) else {
                return Ok(None);
            };
            let texture = textures.get(handle);
            let texture = texture.filter(|texture| self.forms.of(map) == texture.form);
            let texture = texture.ok_or(AsBindGroupError::RetryNextUpdate)?;
            if is_limited && texture.images.iter().flatten().count() > 1 {
                // The loader decodes such textures; those that are made at run time are the app's own.
                error_once!(
                    "a wavelet texture of several planes cannot be shown, since the device binds \
                     too few textures: add it with the storage of material::storage_on"
                );
                return Err(AsBindGroupError::RetryNextUpdate);
            }
            Ok(Some(texture))
        };
        let uniform = |map| -> Result<TextureUniform, AsBindGroupError> {
            let of_form = |texture: &GpuWaveletTexture| {
                let form = texture.form.bits(self.address_mode);
                texture.uniform.of_form(form)
            };
            Ok(texture(map)?.map_or_else(TextureUniform::default, of_form))
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
        let decoded = &samplers.decoded[&(self.filter, self.address_mode)];
        let mut bindings = vec![
            (UNIFORM_BINDING, UnpreparedBindingResource::Buffer(buffer)),
            (LINEAR_CLAMP_BINDING, sampler(&samplers.linear_clamp)),
            (DECODED_SAMPLER_BINDING, sampler(decoded)),
        ];
        for (binding, (map, part)) in bound_textures(render_device) {
            // Missing images are bound to a fallback of one pixel, which the shader never reads.
            let view = match texture(map)?.and_then(|texture| texture.images[part as usize]) {
                Some(image) => {
                    let image = images.get(image);
                    &image.ok_or(AsBindGroupError::RetryNextUpdate)?.texture_view
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

    fn bind_group_layout_entries(
        render_device: &RenderDevice,
        _: bool,
    ) -> Vec<BindGroupLayoutEntry> {
        let uniform =
            uniform_buffer::<MaterialUniform>(false).build(UNIFORM_BINDING, ShaderStages::FRAGMENT);
        debug_assert!(MaterialUniform::min_size().get() > 0);
        let texture = texture_2d_array(TextureSampleType::Float { filterable: true });
        let textures = bound_textures(render_device)
            .map(|(binding, _)| texture.build(binding, ShaderStages::FRAGMENT));
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

/// The samplers, which are made once.
#[derive(Resource)]
pub struct WaveletSamplers {
    /// The sampler of coefficients and of chroma.
    linear_clamp: Sampler,
    /// Those of textures that were decoded on load, which filter as the shader filters others.
    decoded: HashMap<(WaveletFilter, WaveletAddressMode), Sampler>,
}

impl FromWorld for WaveletSamplers {
    fn from_world(world: &mut World) -> Self {
        let device = world.resource::<RenderDevice>();
        let linear_clamp = SamplerDescriptor {
            label: Some("wavelet_linear_clamp"),
            mag_filter: FilterMode::Linear,
            min_filter: FilterMode::Linear,
            ..Default::default()
        };
        let decoded = WaveletFilter::ALL.into_iter().flat_map(|filter| {
            WaveletAddressMode::ALL.map(|address| {
                let sampler = device.create_sampler(&decoded(filter, address));
                ((filter, address), sampler)
            })
        });
        Self {
            linear_clamp: device.create_sampler(&linear_clamp),
            decoded: decoded.collect(),
        }
    }
}

fn decoded(filter: WaveletFilter, address: WaveletAddressMode) -> SamplerDescriptor<'static> {
    use WaveletFilter::{
        Anisotropic, Bilinear, Nearest, NearestMipLinear, Stochastic, StochasticQuad,
    };
    let texels = match filter {
        Nearest | NearestMipLinear => FilterMode::Nearest,
        _ => FilterMode::Linear,
    };
    let levels = match filter {
        Nearest | Bilinear => MipmapFilterMode::Nearest,
        _ => MipmapFilterMode::Linear,
    };
    let address = match address {
        WaveletAddressMode::Repeat => AddressMode::Repeat,
        WaveletAddressMode::ClampToEdge => AddressMode::ClampToEdge,
        WaveletAddressMode::MirrorRepeat => AddressMode::MirrorRepeat,
    };
    SamplerDescriptor {
        label: Some("wavelet_decoded"),
        address_mode_u: address,
        address_mode_v: address,
        mag_filter: texels,
        min_filter: texels,
        mipmap_filter: levels,
        anisotropy_clamp: match filter {
            Anisotropic | Stochastic | StochasticQuad => 16,
            _ => 1,
        },
        ..Default::default()
    }
}
