//! The maps of surfaces, as they are and encoded, and materials of wavelet textures.

use std::{
    collections::{HashMap, hash_map::Entry},
    hash::Hash,
};

use bevy::{
    ecs::system::SystemParam,
    image::{ImageAddressMode, ImageSampler},
    prelude::*,
};
use bevy_wavelet_tex::{
    WaveletAddressMode, WaveletExtension, WaveletFilter, WaveletStandardMaterial, WaveletStorage,
    WaveletTexture,
    codec::{
        image::{ColorSpace, Content, WaveletImage},
        rate::Rate,
        settings::{Effort, EncodeSettings},
    },
};
use image::{RgbaImage, buffer::ConvertBuffer};

use crate::content::{self, encoded, wavelets};

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    Color,
    Normal,
    /// Where it is.
    Mask,
}

/// The maps of surfaces.
#[derive(Resource)]
pub struct Maps<S: Send + Sync + 'static> {
    maps: HashMap<(S, Role), RgbaImage>,
    /// Colours with the mask as their alpha, as a `StandardMaterial` wants them.
    masked: HashMap<S, RgbaImage>,
    encoded: HashMap<(S, Role, Rate, Effort), WaveletImage>,
}

impl<S: Copy + Eq + Hash + Send + Sync + 'static> Maps<S> {
    pub fn empty() -> Self {
        Self {
            maps: HashMap::new(),
            masked: HashMap::new(),
            encoded: HashMap::new(),
        }
    }

    pub fn add(&mut self, surface: S, role: Role, pixels: RgbaImage) {
        self.maps.insert((surface, role), pixels);
    }

    /// Adds the maps of a material, the mask where it is to have holes.
    pub fn add_material(&mut self, surface: S, material: content::Material, has_holes: bool) {
        if has_holes {
            self.masked.insert(surface, material.masked_color());
            self.add(surface, Role::Mask, material.mask.convert());
        }
        self.add(surface, Role::Color, material.color.convert());
        self.add(surface, Role::Normal, material.normal.convert());
    }

    pub fn get(&self, surface: S, role: Role) -> Option<&RgbaImage> {
        self.maps.get(&(surface, role))
    }

    /// A texture as Bevy has it, RGBA8 with a full chain of mips; none where a surface has no such map.
    pub fn uncompressed(&self, surface: S, role: Role, repeats: bool) -> Option<Image> {
        let pixels = match role {
            Role::Color => self.masked.get(&surface),
            Role::Normal | Role::Mask => None,
        };
        let pixels = pixels.or_else(|| self.get(surface, role))?;
        let mut image = content::mipped_texture(pixels, role == Role::Color);
        if let ImageSampler::Descriptor(sampler) = &mut image.sampler
            && !repeats
        {
            sampler.set_address_mode(ImageAddressMode::ClampToEdge);
        }
        Some(image)
    }

    /// The same encoded, colours at this rate.
    fn encoded(
        &mut self,
        surface: S,
        role: Role,
        color: Rate,
        effort: Effort,
    ) -> Option<&WaveletImage> {
        let pixels = self.maps.get(&(surface, role))?;
        let (rate, color_space) = match role {
            Role::Color => (color, ColorSpace::Srgb),
            Role::Normal => (Rate::usual(Content::Normal), ColorSpace::Linear),
            Role::Mask => (Rate::usual(Content::Gray), ColorSpace::Linear),
        };
        match self.encoded.entry((surface, role, rate, effort)) {
            Entry::Occupied(known) => Some(known.into_mut()),
            Entry::Vacant(vacant) => {
                let settings = EncodeSettings {
                    effort,
                    ..wavelets(rate, color_space)
                };
                // A picture of the user's can be too large.
                let encoded = encoded(pixels, &settings).inspect_err(|error| eprintln!("{error}"));
                Some(vacant.insert(encoded.ok()?))
            }
        }
    }
}

/// How wavelet textures are encoded, stored and filtered.
#[derive(Clone, Copy)]
pub struct Wavelets {
    pub color: Rate,
    pub effort: Effort,
    pub storage: WaveletStorage,
    pub filter: WaveletFilter,
}

/// What it takes to make a material of wavelet textures.
#[derive(SystemParam)]
pub struct WaveletMaterials<'w, S: Send + Sync + 'static> {
    pub maps: ResMut<'w, Maps<S>>,
    images: ResMut<'w, Assets<Image>>,
    textures: ResMut<'w, Assets<WaveletTexture>>,
    materials: ResMut<'w, Assets<WaveletStandardMaterial>>,
}

impl<S: Copy + Eq + Hash + Send + Sync + 'static> WaveletMaterials<'_, S> {
    /// The material of a surface whose texture repeats or does not, and the bytes of its textures.
    pub fn make(
        &mut self,
        surface: S,
        repeats: bool,
        base: StandardMaterial,
        with: Wavelets,
    ) -> (Handle<WaveletStandardMaterial>, u64) {
        let mut bytes = 0;
        let mut add = |role| {
            let image = self.maps.encoded(surface, role, with.color, with.effort)?;
            let texture =
                WaveletTexture::add(image, with.storage, &mut self.textures, &mut self.images);
            bytes += self.textures.get(&texture).map_or(0, |t| t.gpu_bytes) as u64;
            Some(texture)
        };
        let extension = WaveletExtension {
            base_color: add(Role::Color),
            normal: add(Role::Normal),
            mask: add(Role::Mask),
            filter: with.filter,
            address_mode: match repeats {
                true => WaveletAddressMode::Repeat,
                false => WaveletAddressMode::ClampToEdge,
            },
            ..default()
        };
        let material = WaveletStandardMaterial { base, extension };
        (self.materials.add(material), bytes)
    }
}
