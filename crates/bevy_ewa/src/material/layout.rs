//! Which maps of a material are filtered together: a part of the key of its pipelines.

use bevy::pbr::StandardMaterial;

use super::{
    images::Images,
    maps::{BASE_COLOR, NORMAL_MAP, SHARABLE, maps},
};
use crate::settings::EwaMaps;

/// How the maps of a material are filtered. Bit n of a mask is map n of `MAPS`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct MapLayout {
    /// Mask of the maps of the same size, mip levels and UV set, which one loop filters.
    pub(super) shared: u32,
    /// Mask of the maps that are filtered each on its own.
    pub(super) own: u32,
    /// Whether the shared maps have the second UV set.
    pub(super) is_shared_uv_b: bool,
    /// Whether parallax mapping changes the texture coordinates.
    pub(super) has_parallax: bool,
    /// Whether a sampler clamps. Large texture coordinates are reduced by whole periods, to stay precise, only
    /// where all textures repeat or mirror: they share the shader defs.
    pub(super) is_clamped: bool,
}

impl MapLayout {
    /// The layout of the chosen maps of a material; without any map where the pipelines are Bevy's own.
    pub(super) fn of(material: &StandardMaterial, chosen: EwaMaps, images: &Images) -> Self {
        let mut layout = Self {
            has_parallax: material.depth_map.is_some(),
            ..Self::default()
        };
        let mut groups = Vec::new();
        for map in maps(material) {
            // Of an unlit material, Bevy shows no other map.
            let is_shown = map.index == BASE_COLOR || !material.unlit;
            if !is_shown || !chosen.contains(map.name()) {
                continue;
            }
            let bit = 1 << map.index;
            let Some(image) = images.get(map.texture.id()) else {
                layout.own |= bit;
                continue;
            };
            if image.is_left_alone() {
                continue;
            }
            layout.own |= bit;
            layout.is_clamped |= image.is_clamped();
            if map.index < SHARABLE {
                let shape = (image.size, image.mips.levels(), map.is_uv_b);
                match groups.iter_mut().find(|(other, _)| *other == shape) {
                    Some((_, mask)) => *mask |= bit,
                    None => groups.push((shape, bit)),
                }
            }
        }
        let largest = groups
            .into_iter()
            .filter(|(_, mask)| mask.count_ones() > 1)
            .reduce(|a, b| {
                if b.1.count_ones() > a.1.count_ones() {
                    b
                } else {
                    a
                }
            });
        if let Some(((_, _, is_uv_b), mask)) = largest {
            layout.shared = mask;
            layout.own &= !mask;
            layout.is_shared_uv_b = is_uv_b;
        }
        layout
    }

    /// The layout of these maps, of the first UV set and repeating, of which those of the first mask share a loop.
    pub const fn of_masks(shared: u32, own: u32) -> Self {
        Self {
            shared,
            own,
            is_shared_uv_b: false,
            has_parallax: false,
            is_clamped: false,
        }
    }

    /// The same layout with or without parallax mapping.
    pub const fn with_parallax(self, has_parallax: bool) -> Self {
        Self {
            has_parallax,
            ..self
        }
    }

    /// Whether the map of this index in `MAPS` is filtered.
    pub(super) fn contains(self, index: usize) -> bool {
        (self.shared | self.own) & (1 << index) != 0
    }

    /// Whether no map is filtered.
    pub(super) fn is_empty(self) -> bool {
        self.shared | self.own == 0
    }

    /// The layout in a prepass or a shadow map, which sample each map on its own, and no others than those of the
    /// base colour's alpha and of normals.
    pub(super) fn in_prepass(self, has_alpha: bool, has_normals: bool) -> Self {
        let mut sampled = 0;
        if has_alpha {
            sampled |= 1 << BASE_COLOR;
        }
        if has_normals {
            sampled |= 1 << NORMAL_MAP;
        }
        Self {
            shared: 0,
            has_parallax: false,
            own: (self.shared | self.own) & sampled,
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use bevy::{
        asset::{AssetId, Handle, uuid::Uuid},
        image::ImageSamplerDescriptor,
        mesh::UvChannel,
    };

    use super::*;
    use crate::material::images::tests::shape;

    fn handle<A: bevy::asset::Asset>(n: u128) -> Handle<A> {
        Handle::from(Uuid::from_u128(n))
    }

    /// Images 1 to 9 of 64 texels, and from 10 on of 32.
    fn images() -> Images {
        let mut images = Images::default();
        for n in 1..20 {
            let side = if n < 10 { 64 } else { 32 };
            let mut sampler = ImageSamplerDescriptor::linear();
            sampler.set_address_mode(bevy::image::ImageAddressMode::Repeat);
            images.insert(AssetId::from(Uuid::from_u128(n)), shape(side, sampler));
        }
        images
    }

    fn material() -> StandardMaterial {
        StandardMaterial {
            base_color_texture: Some(handle(1)),
            emissive_texture: Some(handle(2)),
            normal_map_texture: Some(handle(3)),
            occlusion_texture: Some(handle(4)),
            ..StandardMaterial::default()
        }
    }

    fn masks(material: &StandardMaterial, chosen: EwaMaps) -> (u32, u32) {
        let layout = MapLayout::of(material, chosen, &images());
        (layout.shared, layout.own)
    }

    #[test]
    fn chosen_maps_of_one_size_share_a_loop() {
        assert_eq!(masks(&material(), EwaMaps::default()), (0b111, 0));
        assert_eq!(masks(&material(), EwaMaps::ALL), (0b10111, 0));
        assert_eq!(masks(&material(), EwaMaps::NONE), (0, 0));
        assert_eq!(
            masks(&StandardMaterial::default(), EwaMaps::ALL),
            (0, 0),
            "no maps"
        );
    }

    #[test]
    fn a_map_of_another_size_or_uv_set_or_one_that_is_alone_has_a_loop_of_its_own() {
        let smaller = StandardMaterial {
            normal_map_texture: Some(handle(10)),
            ..material()
        };
        assert_eq!(masks(&smaller, EwaMaps::default()), (0b11, 0b100));
        let second_set = StandardMaterial {
            emissive_channel: UvChannel::Uv1,
            ..material()
        };
        assert_eq!(masks(&second_set, EwaMaps::default()), (0b101, 0b10));
        let alone = StandardMaterial {
            emissive_texture: None,
            normal_map_texture: None,
            ..material()
        };
        assert_eq!(masks(&alone, EwaMaps::default()), (0, 1));
        let unlit = StandardMaterial {
            unlit: true,
            ..material()
        };
        assert_eq!(masks(&unlit, EwaMaps::ALL), (0, 1));
    }

    #[test]
    fn the_second_uv_set_can_be_the_shared_one() {
        let second_set = StandardMaterial {
            base_color_channel: UvChannel::Uv1,
            normal_map_channel: UvChannel::Uv1,
            ..material()
        };
        let layout = MapLayout::of(&second_set, EwaMaps::default(), &images());
        assert_eq!((layout.shared, layout.own), (0b101, 0b10));
        assert!(layout.is_shared_uv_b);
    }

    #[test]
    fn a_prepass_has_the_alpha_and_the_normals_only() {
        let layout = MapLayout::of_masks(0b111, 1 << 9);
        let masks = |alpha, normals| layout.in_prepass(alpha, normals).own;
        assert_eq!(masks(true, true), 0b101);
        assert_eq!(masks(false, true), 0b100);
        assert!(layout.in_prepass(false, false).is_empty());
    }
}
