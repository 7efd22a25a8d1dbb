//! What the filter has to know of the images of an app.

use std::collections::HashMap;

use bevy::{
    image::{ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor},
    prelude::*,
};

use crate::mips::lacking::lacks_mips;

/// The size of an image and its sampler.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ImageShape {
    pub size: [u32; 2],
    /// Number of mip levels, also where they are yet to be generated.
    pub levels: u32,
    pub sampler: ImageSamplerDescriptor,
}

impl ImageShape {
    fn of(image: &Image, default_sampler: &ImageSamplerDescriptor) -> Self {
        let descriptor = &image.texture_descriptor;
        let levels = if lacks_mips(image) {
            descriptor.size.max_mips(descriptor.dimension)
        } else {
            descriptor.mip_level_count
        };
        Self {
            size: [descriptor.size.width, descriptor.size.height],
            levels,
            sampler: match &image.sampler {
                ImageSampler::Default => default_sampler.clone(),
                ImageSampler::Descriptor(sampler) => sampler.clone(),
            },
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
        (is_linear && sampler.anisotropy_clamp < clamp).then(|| ImageSamplerDescriptor {
            anisotropy_clamp: clamp,
            ..sampler.clone()
        })
    }
}

/// All images of the app.
#[derive(Debug, Default)]
pub(crate) struct Images {
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

    /// Follows an event, and returns whether an image is another one now.
    pub(super) fn follow(&mut self, event: &AssetEvent<Image>, images: &Assets<Image>) -> bool {
        match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => {
                let Some(image) = images.get(*id) else {
                    return false;
                };
                let shape = ImageShape::of(image, &self.default_sampler);
                let former = self.shapes.insert(*id, shape);
                former.as_ref() != self.shapes.get(id)
            }
            AssetEvent::Removed { id } => self.shapes.remove(id).is_some(),
            AssetEvent::Unused { .. } | AssetEvent::LoadedWithDependencies { .. } => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(sampler: ImageSamplerDescriptor) -> ImageShape {
        ImageShape {
            size: [4; 2],
            levels: 3,
            sampler,
        }
    }

    #[test]
    fn only_linear_samplers_get_anisotropy_and_never_less_than_they_have() {
        let found = |sampler, clamp| {
            let raised = shape(sampler).with_anisotropy(clamp);
            raised.map(|sampler| sampler.anisotropy_clamp)
        };
        assert_eq!(found(ImageSamplerDescriptor::linear(), 16), Some(16));
        assert_eq!(found(ImageSamplerDescriptor::linear(), 1), None);
        assert_eq!(found(ImageSamplerDescriptor::nearest(), 16), None);
        let has_more = ImageSamplerDescriptor {
            anisotropy_clamp: 8,
            ..ImageSamplerDescriptor::linear()
        };
        assert_eq!(found(has_more, 4), None);
    }
}
