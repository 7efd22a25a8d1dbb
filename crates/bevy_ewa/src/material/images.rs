//! What the filter has to know of the images of an app.

use std::collections::HashMap;

use bevy::{
    image::{ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor},
    prelude::*,
    render::render_resource::{TextureDescriptor, TextureFormat},
};

use super::settings::{EwaImage, EwaOverrides};
use crate::{
    mips::generator::{MipSupport, NoMips, is_written_on_gpu},
    report::MipReport,
};

/// An image without its texels.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ImageShape {
    pub size: [u32; 2],
    pub mips: MipReport,
    pub sampler: ImageSamplerDescriptor,
    /// Format of the views that generate levels: an sRGB format where the texels or their view are sRGB.
    pub mip_format: TextureFormat,
    pub is_excluded: bool,
    /// Whether its sampler is nearest, and the app wants it so.
    pub is_pixel_art: bool,
    /// Whether its generated levels follow each draw to it.
    pub after_draws: bool,
    descriptor: TextureDescriptor<'static>,
}

impl ImageShape {
    fn new(
        image: &Image,
        choice: EwaImage,
        default_sampler: &ImageSamplerDescriptor,
        support: Option<&MipSupport>,
    ) -> Self {
        let descriptor = &image.texture_descriptor;
        let sampler = match &image.sampler {
            ImageSampler::Default => default_sampler,
            ImageSampler::Descriptor(sampler) => sampler,
        };
        let is_nearest = [sampler.mag_filter, sampler.min_filter]
            .iter()
            .any(|filter| matches!(filter, ImageFilterMode::Nearest));
        let is_pixel_art = is_nearest && !choice.use_nearest;
        let is_written = is_written_on_gpu(descriptor);
        let mips = if descriptor.mip_level_count > 1 {
            MipReport::Own(descriptor.mip_level_count)
        } else if choice.is_excluded || choice.max_levels <= 1 {
            MipReport::Without(NoMips::Excluded)
        } else if is_pixel_art {
            MipReport::Without(NoMips::NearestSampler)
        } else if is_written && !choice.after_draws {
            MipReport::Without(NoMips::WrittenOnGpu)
        } else {
            let levels = support.map_or(Err(NoMips::NoRenderer), |support| {
                support.levels(descriptor)
            });
            match levels {
                Ok(levels) => MipReport::Generated(levels.min(choice.max_levels)),
                Err(reason) => MipReport::Without(reason),
            }
        };
        let view = image.texture_view_descriptor.as_ref();
        let view_format = view.and_then(|view| view.format);
        let format = descriptor.format;
        Self {
            size: [descriptor.size.width, descriptor.size.height],
            mips,
            sampler: sampler.clone(),
            mip_format: view_format.filter(|view| view.is_srgb()).unwrap_or(format),
            is_excluded: choice.is_excluded,
            is_pixel_art,
            after_draws: is_written && choice.after_draws,
            descriptor: descriptor.clone(),
        }
    }

    /// Whether texture coordinates beyond the image are clamped.
    pub(super) fn is_clamped(&self) -> bool {
        let modes = [self.sampler.address_mode_u, self.sampler.address_mode_v];
        modes.iter().any(|mode| {
            matches!(
                mode,
                ImageAddressMode::ClampToEdge | ImageAddressMode::ClampToBorder
            )
        })
    }

    /// Whether the image is left as it is.
    pub(super) fn is_left_alone(&self) -> bool {
        self.is_excluded || self.is_pixel_art
    }

    /// The sampler with a higher anisotropy; `None` where it has that already, or filters otherwise than linearly,
    /// which the graphics interfaces forbid with anisotropy.
    pub(super) fn with_anisotropy(&self, clamp: u16) -> Option<ImageSamplerDescriptor> {
        let sampler = &self.sampler;
        let filters = [
            sampler.mag_filter,
            sampler.min_filter,
            sampler.mipmap_filter,
        ];
        let is_linear = filters
            .iter()
            .all(|filter| matches!(filter, ImageFilterMode::Linear));
        let is_raised = is_linear && !self.is_excluded && sampler.anisotropy_clamp < clamp;
        is_raised.then(|| ImageSamplerDescriptor {
            anisotropy_clamp: clamp,
            ..sampler.clone()
        })
    }
}

/// All images of the app.
#[derive(Debug, Default)]
pub(super) struct Images {
    /// The sampler of images without one of their own.
    pub(super) default_sampler: ImageSamplerDescriptor,
    shapes: HashMap<AssetId<Image>, ImageShape>,
}

impl Images {
    pub(super) fn get(&self, id: AssetId<Image>) -> Option<&ImageShape> {
        self.shapes.get(&id)
    }

    #[cfg(test)]
    pub(super) fn insert(&mut self, id: AssetId<Image>, shape: ImageShape) {
        self.shapes.insert(id, shape);
    }

    /// Looks at an image anew, and returns whether it is another one than before.
    pub(super) fn update(
        &mut self,
        id: AssetId<Image>,
        images: &Assets<Image>,
        overrides: &EwaOverrides,
        support: Option<&MipSupport>,
    ) -> bool {
        let shape = images.get(id).map(|image| {
            ImageShape::new(image, overrides.image(id), &self.default_sampler, support)
        });
        let previous = match shape {
            Some(shape) => self.shapes.insert(id, shape),
            None => self.shapes.remove(&id),
        };
        previous.as_ref() != self.shapes.get(&id)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// An image of this size with a sampler.
    pub(in crate::material) fn shape(size: u32, sampler: ImageSamplerDescriptor) -> ImageShape {
        let mut image = Image::default();
        image.texture_descriptor.size.width = size;
        image.texture_descriptor.size.height = size;
        image.sampler = ImageSampler::Descriptor(sampler);
        ImageShape::new(&image, EwaImage::default(), &default(), None)
    }

    #[test]
    fn only_linear_samplers_get_anisotropy_and_never_less_than_they_have() {
        let raised = |sampler, clamp| {
            let sampler = shape(4, sampler).with_anisotropy(clamp);
            sampler.map(|sampler| sampler.anisotropy_clamp)
        };
        assert_eq!(raised(ImageSamplerDescriptor::linear(), 16), Some(16));
        assert_eq!(raised(ImageSamplerDescriptor::linear(), 1), None);
        assert_eq!(raised(ImageSamplerDescriptor::nearest(), 16), None);
        let has_more = ImageSamplerDescriptor {
            anisotropy_clamp: 8,
            ..ImageSamplerDescriptor::linear()
        };
        assert_eq!(raised(has_more, 4), None);
    }

    #[test]
    fn what_a_game_draws_or_shows_as_pixel_art_is_left_alone() {
        let of = |image: &Image, choice| {
            ImageShape::new(image, choice, &ImageSamplerDescriptor::linear(), None).mips
        };
        let target = Image::new_target_texture(64, 64, TextureFormat::Rgba8UnormSrgb, None);
        let asked = EwaImage {
            after_draws: true,
            ..default()
        };
        let without = MipReport::Without;
        assert_eq!(of(&target, default()), without(NoMips::WrittenOnGpu));
        assert_eq!(of(&target, asked), without(NoMips::NoRenderer));
        let mut image = Image::default();
        assert_eq!(of(&image, EwaImage::EXCLUDED), without(NoMips::Excluded));
        image.sampler = ImageSampler::nearest();
        assert_eq!(of(&image, default()), without(NoMips::NearestSampler));
        image.texture_descriptor.mip_level_count = 3;
        assert_eq!(of(&image, default()), MipReport::Own(3));
    }
}
