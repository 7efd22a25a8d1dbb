//! The sky that a game shows by itself: the environment map of a camera, its atmosphere or its skybox, and ambient light.

use bevy::{
    ecs::query::QueryData,
    light::{
        AmbientLight, AtmosphereEnvironmentMapLight, EnvironmentMapLight,
        GeneratedEnvironmentMapLight, GlobalAmbientLight, Skybox,
    },
    pbr::AtmosphereSettings,
    prelude::*,
};

use super::place_volume::ActiveVolume;
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

/// The components of a camera that show a sky or light by it.
#[derive(QueryData)]
pub(crate) struct CameraSky {
    generated: Option<&'static GeneratedEnvironmentMapLight>,
    environment: Option<&'static EnvironmentMapLight>,
    has_atmosphere: Has<AtmosphereEnvironmentMapLight>,
    shows_atmosphere: Has<AtmosphereSettings>,
    skybox: Option<&'static Skybox>,
    ambient: Option<&'static AmbientLight>,
}

impl CameraSkyItem<'_, '_> {
    /// The map by which Bevy lights what the camera sees, before it is filtered; else what the camera shows, which may be
    /// an atmosphere in this image.
    pub fn map(&self, atmosphere: Option<AssetId<Image>>) -> Option<SkyMap> {
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
        let atmosphere = atmosphere
            .filter(|_| self.shows_atmosphere)
            .map(|image| SkyMap {
                image,
                intensity: 1.0,
                rotation: Quat::IDENTITY,
                is_live: true,
            });
        let skybox = self.skybox.and_then(|skybox| {
            let image = skybox.image.as_ref()?;
            Some(of_light(image, skybox.brightness, skybox.rotation))
        });
        let found = generated.or(environment).or(atmosphere).or(skybox)?;
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

/// The atmosphere as Bevy draws it for an environment map that lights nothing.
#[derive(Component, Default)]
pub(crate) struct AtmosphereMap(Option<Handle<Image>>);

impl AtmosphereMap {
    pub fn image(&self) -> Option<AssetId<Image>> {
        self.0.as_ref().map(Handle::id)
    }
}

/// Keeps an [`AtmosphereMap`] while a volume sees the game's own sky and a camera shows an atmosphere by which it is not lit.
pub(crate) fn keep_atmosphere_map(
    mut commands: Commands,
    active: Res<ActiveVolume>,
    unlit: Query<
        (),
        (
            With<AtmosphereSettings>,
            Without<AtmosphereEnvironmentMapLight>,
        ),
    >,
    mut maps: Query<(
        Entity,
        &mut AtmosphereMap,
        Option<&GeneratedEnvironmentMapLight>,
    )>,
) {
    let volume = active.volume.as_ref();
    let sees_sky = volume.is_some_and(|volume| volume.levels.iter().any(|level| level.sees_map));
    let is_needed = sees_sky && !unlit.is_empty();
    if is_needed && maps.is_empty() {
        commands.spawn((
            Name::new("voxel GI atmosphere"),
            AtmosphereMap::default(),
            AtmosphereEnvironmentMapLight {
                size: UVec2::splat(32),
                ..default()
            },
        ));
    }
    for (entity, mut map, generated) in &mut maps {
        if !is_needed {
            commands.entity(entity).despawn();
        } else if let Some(generated) = generated {
            map.0 = Some(generated.environment_map.clone());
            // Bevy would filter it in each frame.
            commands
                .entity(entity)
                .remove::<(GeneratedEnvironmentMapLight, EnvironmentMapLight)>();
        }
    }
}
