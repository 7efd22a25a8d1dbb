//! The samplers of the material extension, which all materials share.

use bevy::{
    ecs::{
        resource::Resource,
        world::{FromWorld, World},
    },
    platform::collections::HashMap,
    render::{
        render_resource::{AddressMode, FilterMode, MipmapFilterMode, Sampler, SamplerDescriptor},
        renderer::RenderDevice,
    },
};

use crate::settings::{WaveletAddressMode, WaveletFilter};

/// The samplers, which are made once.
#[derive(Resource)]
pub struct WaveletSamplers {
    linear_clamp: Sampler,
    decoded: HashMap<(WaveletFilter, WaveletAddressMode), Sampler>,
}

impl WaveletSamplers {
    /// The sampler of coefficients and of chroma.
    pub(super) fn linear_clamp(&self) -> &Sampler {
        &self.linear_clamp
    }

    /// The sampler of textures that were decoded on load, which filters as the shader filters others.
    pub(super) fn decoded(&self, filter: WaveletFilter, address: WaveletAddressMode) -> &Sampler {
        &self.decoded[&(filter, address)]
    }
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
