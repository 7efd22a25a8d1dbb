//! The maps of a glTF material, and the wavelet textures that replace their images.

use bevy::{
    asset::{AssetPath, AssetServer, Assets, Handle, LoadState},
    image::{Image, ImageAddressMode, ImageSampler},
    pbr::StandardMaterial,
};

use crate::{
    asset::WaveletTexture,
    codec::image::{ColorSpace, Content},
    file::EXTENSION,
    material::WaveletExtension,
    settings::WaveletAddressMode,
};

/// A map of a glTF material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum GltfMap {
    BaseColor,
    Emissive,
    Normal,
    MetallicRoughness,
    Occlusion,
}

impl GltfMap {
    const ALL: [Self; 5] = [
        Self::BaseColor,
        Self::Emissive,
        Self::Normal,
        Self::MetallicRoughness,
        Self::Occlusion,
    ];

    /// What the map is for, in messages.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::BaseColor => "base colour",
            Self::Emissive => "emissive colour",
            Self::Normal => "normals",
            Self::MetallicRoughness => "metallic and roughness",
            Self::Occlusion => "occlusion",
        }
    }

    pub(super) fn image(self, material: &mut StandardMaterial) -> &mut Option<Handle<Image>> {
        match self {
            Self::BaseColor => &mut material.base_color_texture,
            Self::Emissive => &mut material.emissive_texture,
            Self::Normal => &mut material.normal_map_texture,
            Self::MetallicRoughness => &mut material.metallic_roughness_texture,
            Self::Occlusion => &mut material.occlusion_texture,
        }
    }

    pub(super) fn texture(
        self,
        extension: &mut WaveletExtension,
    ) -> &mut Option<Handle<WaveletTexture>> {
        match self {
            Self::BaseColor => &mut extension.base_color,
            Self::Emissive => &mut extension.emissive,
            Self::Normal => &mut extension.normal,
            Self::MetallicRoughness => &mut extension.metallic_roughness,
            Self::Occlusion => &mut extension.occlusion,
        }
    }

    /// The role by which `wavelet-tex` names the second texture of an image.
    fn role(self) -> &'static str {
        match self {
            Self::BaseColor | Self::Emissive => "color",
            Self::Normal => "normal",
            Self::MetallicRoughness => "data",
            Self::Occlusion => "occlusion",
        }
    }

    /// Whether a texture was encoded for the role of the map.
    fn fits(self, texture: &WaveletTexture) -> bool {
        let is_normal = texture.content == Content::Normal;
        match self {
            Self::Normal => is_normal,
            Self::BaseColor | Self::Emissive => {
                !is_normal && texture.color_space == ColorSpace::Srgb
            }
            Self::MetallicRoughness | Self::Occlusion => {
                !is_normal && texture.color_space == ColorSpace::Linear
            }
        }
    }
}

/// A map while its material is exchanged.
pub(super) struct MapExchange {
    pub(super) map: GltfMap,
    image: Handle<Image>,
    /// Whether the texture of the image's own name is that of another role.
    by_role: bool,
    pub(super) state: MapState,
}

pub(super) enum MapState {
    Loading(Handle<WaveletTexture>),
    /// The texture, and how its image was addressed, or `None` where the material cannot do the same.
    Loaded(Handle<WaveletTexture>, Option<WaveletAddressMode>),
    Failed(String),
}

impl MapExchange {
    /// Begins to load the textures of all maps of a material.
    pub(super) fn all(material: &StandardMaterial, server: &AssetServer) -> Vec<Self> {
        let mut material = material.clone();
        let begin = |map: GltfMap| {
            let image = map.image(&mut material).take()?;
            let texture = server.load(wavelet_path(image.path()?, None));
            Some(Self {
                map,
                image,
                by_role: false,
                state: MapState::Loading(texture),
            })
        };
        GltfMap::ALL.into_iter().filter_map(begin).collect()
    }

    pub(super) fn is_over(&self) -> bool {
        !matches!(self.state, MapState::Loading(_))
    }

    pub(super) fn go_on(
        &mut self,
        server: &AssetServer,
        images: &Assets<Image>,
        textures: &Assets<WaveletTexture>,
    ) {
        let MapState::Loading(handle) = &self.state else {
            return;
        };
        if let LoadState::Failed(error) = server.load_state(handle) {
            self.state = MapState::Failed(error.to_string());
            return;
        }
        let Some(texture) = textures.get(handle) else {
            return;
        };
        if !self.map.fits(texture) {
            self.state = match self.image.path().filter(|_| !self.by_role) {
                Some(path) => {
                    MapState::Loading(server.load(wavelet_path(path, Some(self.map.role()))))
                }
                None => MapState::Failed(format!(
                    "its wavelet texture is not encoded with the role `{}`",
                    self.map.role()
                )),
            };
            self.by_role = true;
            return;
        }
        let address = match images.get(&self.image) {
            Some(image) => address_mode(&image.sampler),
            // Nothing says otherwise.
            None if server.load_state(&self.image).is_failed() => Some(WaveletAddressMode::Repeat),
            None => return,
        };
        self.state = MapState::Loaded(handle.clone(), address);
    }
}

/// How a wavelet material addresses what this sampler does.
fn address_mode(sampler: &ImageSampler) -> Option<WaveletAddressMode> {
    let ImageSampler::Descriptor(sampler) = sampler else {
        // That of Bevy's images where nothing else is set.
        return Some(WaveletAddressMode::ClampToEdge);
    };
    match (sampler.address_mode_u, sampler.address_mode_v) {
        (ImageAddressMode::Repeat, ImageAddressMode::Repeat) => Some(WaveletAddressMode::Repeat),
        (ImageAddressMode::ClampToEdge, ImageAddressMode::ClampToEdge) => {
            Some(WaveletAddressMode::ClampToEdge)
        }
        (ImageAddressMode::MirrorRepeat, ImageAddressMode::MirrorRepeat) => {
            Some(WaveletAddressMode::MirrorRepeat)
        }
        _ => None,
    }
}

/// Path of the wavelet texture of an image. For an image with a label (`model.glb#Texture0`) it is
/// beside the file that contains the image; for an image with a file of its own (`wall.png`) it is
/// that path with another extension. The second texture of an image has its role in its name.
fn wavelet_path(image: &AssetPath<'_>, role: Option<&str>) -> AssetPath<'static> {
    let extension = match role {
        Some(role) => format!("{role}.{EXTENSION}"),
        None => EXTENSION.into(),
    };
    let path = match image.label() {
        Some(label) => {
            let mut name = image.path().as_os_str().to_os_string();
            name.push(format!(".{label}.{extension}"));
            name.into()
        }
        None => image.path().with_extension(extension),
    };
    AssetPath::from(path).with_source(image.source().clone_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_that_the_tool_writes() {
        for (image, role, texture) in [
            ("a/model.glb#Texture0", None, "a/model.glb.Texture0.wtex"),
            (
                "a/model.glb#Texture1",
                Some("normal"),
                "a/model.glb.Texture1.normal.wtex",
            ),
            ("a/wall.png", None, "a/wall.wtex"),
            ("a/wall.v2.png", Some("data"), "a/wall.v2.data.wtex"),
            (
                "remote://m.gltf#Texture12",
                None,
                "remote://m.gltf.Texture12.wtex",
            ),
        ] {
            let found = wavelet_path(&AssetPath::parse(image), role);
            assert_eq!(found, AssetPath::parse(texture));
        }
    }
}
