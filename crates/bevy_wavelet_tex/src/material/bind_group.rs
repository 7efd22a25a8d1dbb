//! From handles to what a shader binds.

use bevy::{
    asset::{AssetId, Handle},
    ecs::system::{SystemParamItem, lifetimeless::SRes},
    image::Image,
    render::{
        render_asset::{PrepareAssetError, RenderAsset, RenderAssets},
        render_resource::{
            AsBindGroup, AsBindGroupError, BindGroupLayout, BindGroupLayoutEntry, BindingResources,
            BufferInitDescriptor, BufferUsages, OwnedBindingResource, ShaderStages, ShaderType,
            TextureSampleType, TextureViewDimension, UnpreparedBindGroup,
            binding_types::{texture_2d_array, uniform_buffer},
            encase::UniformBuffer,
        },
        renderer::RenderDevice,
        texture::{FallbackImage, GpuImage},
    },
};

use super::{
    extension::{WaveletExtension, WaveletKey},
    uniform::{MaterialUniform, TextureUniform},
};
use crate::asset::WaveletTexture;

/// A [`WaveletTexture`] in the render world: its uniform and its images.
pub struct GpuWaveletTexture {
    uniform: TextureUniform,
    images: Vec<AssetId<Image>>,
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
            images: texture.images.iter().map(Handle::id).collect(),
        })
    }
}

/// Bindings of the textures, from 101, in the order of `bindings.wgsl`: the slot of the extension
/// and the image of its texture.
const TEXTURES: [(Slot, usize); 4] = [
    (Slot::BaseColor, 0),
    (Slot::BaseColor, 1),
    (Slot::Normal, 0),
    (Slot::Mask, 0),
];
const UNIFORM_BINDING: u32 = 100;

#[derive(Clone, Copy)]
enum Slot {
    BaseColor,
    Normal,
    Mask,
}

impl WaveletExtension {
    fn slot(&self, slot: Slot) -> Option<&Handle<WaveletTexture>> {
        match slot {
            Slot::BaseColor => self.base_color.as_ref(),
            Slot::Normal => self.normal.as_ref(),
            Slot::Mask => self.mask.as_ref(),
        }
    }
}

// By hand, since what is bound hangs on assets that the derive does not know of.
impl AsBindGroup for WaveletExtension {
    type Data = WaveletKey;
    type Param = (
        SRes<RenderAssets<GpuWaveletTexture>>,
        SRes<RenderAssets<GpuImage>>,
        SRes<FallbackImage>,
    );

    fn label() -> &'static str {
        "wavelet_extension"
    }

    fn bind_group_data(&self) -> WaveletKey {
        self.key()
    }

    fn unprepared_bind_group(
        &self,
        _: &BindGroupLayout,
        render_device: &RenderDevice,
        (textures, images, fallback): &mut SystemParamItem<'_, '_, Self::Param>,
        _: bool,
    ) -> Result<UnpreparedBindGroup, AsBindGroupError> {
        let texture = |slot| match self.slot(slot) {
            None => Ok(None),
            Some(handle) => textures
                .get(handle)
                .map(Some)
                .ok_or(AsBindGroupError::RetryNextUpdate),
        };
        let uniform = |slot| -> Result<TextureUniform, AsBindGroupError> {
            let uniform = texture(slot)?.map_or_else(TextureUniform::default, |t| t.uniform);
            Ok(uniform.addressed(self.address_mode))
        };
        let mut bytes = UniformBuffer::new(Vec::new());
        bytes
            .write(&MaterialUniform {
                base_color: uniform(Slot::BaseColor)?,
                normal: uniform(Slot::Normal)?,
                mask: uniform(Slot::Mask)?,
            })
            .expect("a vector grows");
        let buffer = render_device.create_buffer_with_data(&BufferInitDescriptor {
            label: Some("wavelet_material_uniform"),
            usage: BufferUsages::UNIFORM,
            contents: bytes.as_ref(),
        });

        let mut bindings = vec![(UNIFORM_BINDING, OwnedBindingResource::Buffer(buffer))];
        for (binding, (slot, image)) in (UNIFORM_BINDING + 1..).zip(TEXTURES) {
            // Gray has no chroma; nothing reads the stand-in.
            let view = match texture(slot)?.and_then(|texture| texture.images.get(image)) {
                Some(image) => {
                    &images
                        .get(*image)
                        .ok_or(AsBindGroupError::RetryNextUpdate)?
                        .texture_view
                }
                None => &fallback.d2_array.texture_view,
            };
            bindings.push((
                binding,
                OwnedBindingResource::TextureView(TextureViewDimension::D2Array, view.clone()),
            ));
        }
        Ok(UnpreparedBindGroup {
            bindings: BindingResources(bindings),
        })
    }

    fn bind_group_layout_entries(_: &RenderDevice, _: bool) -> Vec<BindGroupLayoutEntry> {
        let uniform =
            uniform_buffer::<MaterialUniform>(false).build(UNIFORM_BINDING, ShaderStages::FRAGMENT);
        debug_assert!(MaterialUniform::min_size().get() > 0);
        let texture = texture_2d_array(TextureSampleType::Float { filterable: true });
        let textures = (UNIFORM_BINDING + 1..)
            .take(TEXTURES.len())
            .map(|binding| texture.build(binding, ShaderStages::FRAGMENT));
        std::iter::once(uniform).chain(textures).collect()
    }
}
