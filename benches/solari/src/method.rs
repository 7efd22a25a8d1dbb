//! The methods that draw the light, by name.

use bevy::{
    camera::CameraMainTextureUsages,
    light::{DirectionalLightShadowMap, PointLightShadowMap},
    pbr::ScreenSpaceAmbientOcclusion,
    prelude::*,
    render::render_resource::TextureUsages,
};
use bevy_frugal_lab::{boxes::BoxScene, stage::StageCamera, tradeoff::voxel_gi::render::placed};
use bevy_solari::{
    SolariPlugins,
    pathtracer::{Pathtracer, PathtracingPlugin},
    realtime::SolariLighting,
};
use bevy_voxel_gi::{VoxelGiPlugin, VoxelGiSettings, VoxelGiVolume};

use crate::{bake::Baked, convert, irradiance_volume, lightmap};

/// A method that draws the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Bevy's direct light alone.
    NoGi,
    /// The same and the constant ambient light that fits the truth best.
    Ambient,
    /// The same with Bevy's ambient occlusion in screen space.
    AmbientAndSsao,
    /// Bevy's lightmaps, path-traced.
    Lightmaps,
    /// Bevy's irradiance volumes, path-traced.
    IrradianceVolume,
    /// `bevy_voxel_gi` at its defaults.
    VoxelGi,
    /// `bevy_solari` at its defaults.
    Solari,
    /// `bevy_solari` with paths shared between pixels and frames.
    SolariRestir,
    /// The path tracer of `bevy_solari`, which holds the conversion of the scene to account.
    SolariPathtracer,
}

impl Method {
    pub const ALL: [Self; 9] = [
        Self::NoGi,
        Self::Ambient,
        Self::AmbientAndSsao,
        Self::Lightmaps,
        Self::IrradianceVolume,
        Self::VoxelGi,
        Self::Solari,
        Self::SolariRestir,
        Self::SolariPathtracer,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::NoGi => "no GI",
            Self::Ambient => "constant ambient light",
            Self::AmbientAndSsao => "ambient light and SSAO",
            Self::Lightmaps => "lightmaps",
            Self::IrradianceVolume => "irradiance volume",
            Self::VoxelGi => "bevy_voxel_gi",
            Self::Solari => "bevy_solari",
            Self::SolariRestir => "bevy_solari ReSTIR",
            Self::SolariPathtracer => "bevy_solari path tracer",
        }
    }

    /// Whether `bevy_solari` draws.
    pub fn traces_rays(self) -> bool {
        matches!(
            self,
            Self::Solari | Self::SolariRestir | Self::SolariPathtracer
        )
    }

    /// Whether a frame has so much noise that the mean of many is compared too.
    pub fn is_noisy(self) -> bool {
        matches!(self, Self::Solari | Self::SolariRestir)
    }

    /// Whether its picture can be compared: the path tracer alone sees the spheres that replace point lights.
    pub fn draws(self, scene: &BoxScene) -> bool {
        self != Self::SolariPathtracer || scene.point_lights.is_empty()
    }

    /// Whether frames come closer to the truth one after the other.
    pub fn converges(self) -> bool {
        self == Self::VoxelGi || self.traces_rays()
    }

    /// Adds the plugins.
    pub fn build(self, app: &mut App) {
        // The lab's shadow maps are smaller than Bevy's defaults, which games have.
        app.insert_resource(DirectionalLightShadowMap::default())
            .insert_resource(PointLightShadowMap::default());
        if self.traces_rays() {
            app.add_plugins(SolariPlugins);
        }
        match self {
            Self::VoxelGi => {
                app.add_plugins(VoxelGiPlugin);
            }
            Self::SolariPathtracer => {
                app.add_plugins(PathtracingPlugin);
            }
            _ => {}
        }
    }

    /// Prepares the scene, once it is spawned, for what will be switched on, and says what was baked; `boxes` are
    /// those of the scene.
    pub fn prepare(self, world: &mut World, scene: &BoxScene, boxes: &[Entity]) -> Option<Baked> {
        let camera = camera(world);
        if self.traces_rays() {
            convert::for_rays(world, scene, camera);
            world
                .entity_mut(camera)
                .insert(CameraMainTextureUsages::default().with(TextureUsages::STORAGE_BINDING));
        }
        if self == Self::AmbientAndSsao {
            world
                .entity_mut(camera)
                .insert(ScreenSpaceAmbientOcclusion::default());
        }
        match self {
            Self::Lightmaps => Some(lightmap::bake(world, scene, boxes)),
            Self::IrradianceVolume => Some(irradiance_volume::bake(world, scene)),
            _ => None,
        }
    }

    /// Begins with no light of earlier frames.
    pub fn switch_on(self, world: &mut World, scene: &BoxScene) {
        let camera = camera(world);
        match self {
            Self::Lightmaps => lightmap::switch(world, true),
            Self::IrradianceVolume => irradiance_volume::switch(world, true),
            Self::VoxelGi => {
                world.spawn(placed(scene, VoxelGiSettings::default().resolution));
            }
            Self::Solari | Self::SolariRestir => {
                world.entity_mut(camera).insert(SolariLighting {
                    restir: self == Self::SolariRestir,
                    ..default()
                });
            }
            Self::SolariPathtracer => {
                world.entity_mut(camera).insert(Pathtracer::default());
            }
            Self::NoGi | Self::Ambient | Self::AmbientAndSsao => {}
        }
    }

    /// Undoes [`switch_on`](Self::switch_on).
    pub fn switch_off(self, world: &mut World) {
        match self {
            Self::Lightmaps => lightmap::switch(world, false),
            Self::IrradianceVolume => irradiance_volume::switch(world, false),
            _ => {}
        }
        let camera = camera(world);
        world
            .entity_mut(camera)
            .remove::<(SolariLighting, Pathtracer)>();
        let mut volumes = world.query_filtered::<Entity, With<VoxelGiVolume>>();
        for volume in volumes.iter(world).collect::<Vec<_>>() {
            world.despawn(volume);
        }
    }
}

fn camera(world: &mut World) -> Entity {
    world
        .query_filtered::<Entity, With<StageCamera>>()
        .single(world)
        .expect("a scene of boxes has one camera")
}
