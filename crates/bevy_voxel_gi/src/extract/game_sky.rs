//! The sky that a game shows by itself: the environment map of a camera, its atmosphere or its skybox, and ambient light.

use bevy::{
    ecs::query::QueryData,
    light::{
        AmbientLight, AtmosphereEnvironmentMapLight, EnvironmentMapLight,
        GeneratedEnvironmentMapLight, GlobalAmbientLight, Skybox,
    },
    prelude::*,
};

use crate::settings::Sky;

/// A cube map that rays see where they leave all levels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SkyMap {
    pub image: AssetId<Image>,
    /// Factor of its texels, in cd/m².
    pub intensity: f32,
    pub rotation: Quat,
    /// Whether the GPU draws it in each frame.
    pub is_live: bool,
}

/// What a camera shows where there is nothing.
#[derive(QueryData)]
pub(crate) struct CameraSky {
    generated: Option<&'static GeneratedEnvironmentMapLight>,
    environment: Option<&'static EnvironmentMapLight>,
    has_atmosphere: Has<AtmosphereEnvironmentMapLight>,
    skybox: Option<&'static Skybox>,
    ambient: Option<&'static AmbientLight>,
}

impl CameraSkyItem<'_, '_> {
    /// The map by which Bevy lights what the camera sees, before it is filtered; else what the camera shows.
    pub fn map(&self) -> Option<SkyMap> {
        let of_light = |image: &Handle<Image>, intensity: f32, rotation: Quat| SkyMap {
            image: image.id(),
            intensity,
            rotation,
            is_live: self.has_atmosphere,
        };
        let generated = self
            .generated
            .map(|map| of_light(&map.environment_map, map.intensity, map.rotation));
        let environment = self
            .environment
            .map(|map| of_light(&map.specular_map, map.intensity, map.rotation));
        let skybox = self.skybox.and_then(|skybox| {
            let image = skybox.image.as_ref()?;
            Some(of_light(image, skybox.brightness, skybox.rotation))
        });
        let found = generated.or(environment).or(skybox)?;
        let is_usable = found.intensity.is_finite() && found.rotation.is_finite();
        (is_usable && found.intensity > 0.0).then_some(found)
    }
}

/// The radiance of the sky under which a matt surface is as bright as in Bevy's ambient light of a brightness of 1.
const AMBIENT: f32 = 0.4524;

/// Ambient light as a sky: that of the camera, else that of all.
pub(super) fn ambient_sky(
    camera: Option<&CameraSkyItem>,
    global: Option<&GlobalAmbientLight>,
) -> Sky {
    let of_camera = camera
        .and_then(|camera| camera.ambient)
        .map(|light| (light.color, light.brightness));
    let of_all = global.map(|light| (light.color, light.brightness));
    let (color, brightness) = of_camera.or(of_all).unwrap_or((Color::BLACK, 0.0));
    Sky::uniform(color.to_linear() * (AMBIENT * brightness)).clamped()
}
