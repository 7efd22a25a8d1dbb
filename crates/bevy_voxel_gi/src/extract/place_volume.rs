//! Chooses the active volumes, places their levels in the world, and extracts them.

use std::cmp::Reverse;

use bevy::{
    camera::{Exposure, RenderTarget, visibility::RenderLayers},
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass},
    ecs::{change_detection::Tick, system::SystemChangeTick},
    light::Atmosphere,
    prelude::*,
    render::{Extract, renderer::RenderDevice},
};
use bevy_frugal_hooks::{PatchState, ShaderPatches};

use super::{
    device_limits::{allocatable_resolution, bindable_albedo, is_supported, warn_of_unsupported},
    game_sky::{AtmosphereMap, CameraSky, ambient_sky},
    lights::ExtractedLights,
    meshes::ExtractedScene,
    placement::{PlacedLevel, PlacedVolume, cascades, snapped, step, supported},
    probe::{light_texture, texture_size},
};
use crate::{
    budget::BudgetChoice,
    gpu_types::MAX_LIT_LEVELS,
    receive::{ENVIRONMENT_PATCH, LIGHTING_PATCH, RECEIVER_PATCH},
    settings::{Follow, Receiver, VoxelAlbedo, VoxelGiSettings, VoxelGiVolume},
};

/// The active volumes, if there are any.
#[derive(Resource, Default)]
pub(crate) struct ActiveVolume {
    pub volume: Option<PlacedVolume>,
    /// See [`PlacedVolume`].
    has_had_cascades: bool,
    has_had_levels: bool,
    /// Number of frames in which an atmosphere has changed.
    sky_revision: u64,
}

type VolumeParts = (
    Entity,
    Ref<'static, VoxelGiVolume>,
    &'static GlobalTransform,
    Option<&'static RenderLayers>,
    Option<&'static InheritedVisibility>,
);

/// What decides whose exposure counts, and which meshes and lights do.
type CameraParts = (
    Entity,
    &'static Camera,
    Option<&'static Exposure>,
    Option<&'static RenderLayers>,
    Option<&'static RenderTarget>,
);

/// Chooses the active volumes and their placement, and allocates their texture.
pub(crate) fn place_volume(
    mut active: ResMut<ActiveVolume>,
    volumes: Query<VolumeParts>,
    transforms: Query<&GlobalTransform>,
    names: Query<NameOrEntity>,
    cameras: Query<CameraParts, With<Camera3d>>,
    (skies, global_ambient, new_atmospheres, atmosphere_maps): (
        Query<CameraSky>,
        Option<Res<GlobalAmbientLight>>,
        Query<(), Changed<Atmosphere>>,
        Query<&AtmosphereMap>,
    ),
    prepass_cameras: Query<
        (Entity, &Camera, &GlobalTransform),
        (With<DepthPrepass>, With<DeferredPrepass>),
    >,
    patches: Res<ShaderPatches>,
    settings: Res<VoxelGiSettings>,
    mut images: ResMut<Assets<Image>>,
    budget: Option<Res<BudgetChoice>>,
    device: Option<Res<RenderDevice>>,
    now: SystemChangeTick,
) {
    let active = &mut *active;
    let patched = match patches.state(RECEIVER_PATCH) {
        Some(PatchState::Applied) => true,
        Some(PatchState::Pending) => return,
        _ => false,
    };
    // Entity indices are reused: they give the order only of volumes that are spawned at once.
    let is_shown =
        |visible: &Option<&InheritedVisibility>| visible.is_none_or(|visible| visible.get());
    let mut all: Vec<_> = volumes.iter().filter(|parts| is_shown(&parts.4)).collect();
    let age = |added: Tick| now.this_run().get().wrapping_sub(added.get());
    all.sort_by_key(|(entity, volume, ..)| (Reverse(age(volume.added())), entity.index()));
    let Some((_, _, _, layers, _)) = all.first() else {
        active.volume = None;
        return;
    };
    if let Some(limits) = device.as_ref().map(|device| device.limits())
        && !is_supported(&limits)
    {
        warn_of_unsupported(&limits);
        active.volume = None;
        return;
    }
    let mut settings = supported(settings.clamped(), patched);
    if let Some(device) = &device {
        settings.albedo = bindable_albedo(settings.albedo, &device.limits());
    }
    let lightmaps = patches.state(LIGHTING_PATCH);
    if settings.affects_lightmapped_meshes && matches!(lightmaps, Some(PatchState::Refused(_))) {
        warn_once!(
            "voxel GI: Bevy's lighting is not the one this plugin was made for, so \
             `affects_lightmapped_meshes` has no effect"
        );
    }
    let specular = patches.refused(&[RECEIVER_PATCH, LIGHTING_PATCH, ENVIRONMENT_PATCH]);
    if settings.specular_light && specular.is_some() {
        warn_once!(
            "voxel GI: Bevy's lighting is not the one this plugin was made for, so `specular_light` has no \
             effect; use reflection probes"
        );
        settings.specular_light = false;
    }
    let layers = layers.cloned().unwrap_or_default();
    if !patched && all.len() > 1 {
        warn_once!(
            "voxel GI: Bevy's irradiance volume shader is not the one this plugin was made for, \
             so only the VoxelGiVolume spawned first lights the scene"
        );
        all.truncate(1);
    }
    let clamped = |own: &VoxelGiVolume| {
        let own = own.clamped();
        let cascades = cascades(&own, settings.light, patched);
        VoxelGiVolume { cascades, ..own }
    };
    let level_count = all
        .iter()
        .map(|(_, own, ..)| u64::from(clamped(own).cascades));
    let level_count = level_count.sum::<u64>().min(MAX_LIT_LEVELS as u64);
    let resolution = device.map_or(settings.resolution, |device| {
        allocatable_resolution(&settings, level_count, patched, &device.limits())
    });
    let main_camera = main_camera(&cameras, &layers);
    let camera_sky = main_camera.and_then(|camera| skies.get(camera).ok());
    let own_sky = ambient_sky(camera_sky.as_ref(), global_ambient.as_deref());
    let name = |volume| names.get(volume).map(|it| it.to_string());
    let volumes = all.len();
    let mut levels = Vec::new();
    for (owner, own, transform, own_layers, _) in all {
        let own = clamped(&own);
        if *own_layers.unwrap_or_default() != layers {
            warn_once!(
                "voxel GI: all VoxelGiVolumes share their render layers; those of the one spawned \
                 first are used, which {} does not have. Give all of them the same `RenderLayers`",
                name(owner).unwrap_or_default()
            );
        }
        if levels.len() + own.cascades as usize > MAX_LIT_LEVELS {
            warn_once!(
                "voxel GI: there are more than {MAX_LIT_LEVELS} cubes in total (volumes times their \
                 `cascades`); the volumes spawned last are left out, from {} on. Use fewer cascades, or \
                 despawn volumes that are far away",
                name(owner).unwrap_or_default()
            );
            break;
        }
        let followed = match own.follow {
            Follow::Nothing => None,
            Follow::Camera => main_camera,
            Follow::Entity(entity) => Some(entity),
        };
        let anchor = followed
            .and_then(|entity| transforms.get(entity).ok())
            .unwrap_or(transform)
            .translation();
        let focus = if anchor.is_finite() {
            anchor
        } else {
            Vec3::ZERO
        };
        levels.extend((0..own.cascades).map(|cascade| {
            let step = step(&own, cascade, resolution);
            PlacedLevel {
                owner,
                center: snapped(focus, step),
                focus,
                step,
                size: own.size * (1 << cascade) as f32,
                sky: own.sky.unwrap_or(own_sky),
                sees_map: own.sky.is_none(),
                intensity: own.intensity,
                is_outer: false,
            }
        }));
    }
    levels.sort_by(|a, b| a.size.total_cmp(&b.size));
    let own_settings = VoxelGiSettings {
        resolution,
        ..settings
    };
    let settings = match budget.and_then(|budget| budget.chosen()) {
        Some(chosen) => chosen.applied(&own_settings),
        None => own_settings.clone(),
    };
    let exposure = main_camera.and_then(|camera| cameras.get(camera).ok());
    let exposure = exposure.and_then(|(_, _, exposure, ..)| exposure.copied());
    let exposure = exposure.unwrap_or_default().exposure();
    let atmosphere = atmosphere_maps.iter().find_map(AtmosphereMap::image);
    let sees_map = levels.iter().any(|level| level.sees_map);
    let sky_map = camera_sky.and_then(|sky| sky.map(atmosphere).filter(|_| sees_map));
    active.sky_revision += u64::from(!new_atmospheres.is_empty());
    let layers_of_cameras = cameras
        .iter()
        .map(|(.., own_layers, _)| own_layers.unwrap_or_default())
        .filter(|own_layers| own_layers.intersects(&layers));
    let scene_layers = layers_of_cameras.fold(layers.clone(), |all, own| all.union(own));
    let viewpoints: Vec<_> = match settings.albedo {
        VoxelAlbedo::Reprojected => prepass_cameras
            .iter()
            .sort::<Entity>()
            .filter(|(_, camera, _)| camera.is_active)
            .map(|(.., transform)| *transform)
            .collect(),
        _ => Vec::new(),
    };
    if settings.albedo == VoxelAlbedo::Reprojected && viewpoints.is_empty() {
        warn_once!(
            "voxel GI: `VoxelAlbedo::Reprojected` takes albedo from cameras with `DepthPrepass` and \
             `DeferredPrepass`, and no active camera has both; the colours of materials are used. \
             Add both to a camera"
        );
    }
    let size = texture_size(&settings, levels.len(), patched);
    let fits = |old: &&PlacedVolume| {
        let image = images.get(&old.texture);
        image.is_some_and(|image| image.texture_descriptor.size == size) && old.patched == patched
    };
    let texture = match active.volume.as_ref().filter(fits) {
        Some(old) => old.texture.clone(),
        None => images.add(light_texture(size)),
    };
    active.has_had_cascades |= levels.len() > 1;
    active.has_had_levels |= volumes > 1 || settings.receiver == Receiver::PerPixel;
    active.volume = Some(PlacedVolume {
        has_had_cascades: active.has_had_cascades,
        has_had_levels: active.has_had_levels,
        levels,
        settings,
        own_settings,
        texture,
        patched,
        sky_map,
        sky_revision: active.sky_revision,
        exposure,
        layers,
        scene_layers,
        viewpoints,
    });
}

/// The camera that shows the volumes with these layers.
fn main_camera(
    cameras: &Query<CameraParts, With<Camera3d>>,
    layers: &RenderLayers,
) -> Option<Entity> {
    // Pictures in images are previews, portraits or maps, if there is a camera that draws to a window, too. The order
    // of a query changes with components that have nothing to do with light.
    cameras
        .iter()
        .filter(|(_, camera, ..)| camera.is_active)
        .max_by_key(|(entity, camera, _, own_layers, target)| {
            let sees = own_layers.unwrap_or_default().intersects(layers);
            let to_window = target.is_none_or(|target| matches!(target, RenderTarget::Window(_)));
            (sees, to_window, camera.order, *entity)
        })
        .map(|(entity, ..)| entity)
}

/// The active volumes of this frame, if there are any.
#[derive(Resource, Default)]
pub(crate) struct ExtractedVolume(pub Option<PlacedVolume>);

/// Extracts them; where there is none, forgets the scene, whose changes are not followed then.
pub(crate) fn extract_volume(
    mut volume: ResMut<ExtractedVolume>,
    active: Extract<Res<ActiveVolume>>,
    (mut scene, mut lights): (ResMut<ExtractedScene>, ResMut<ExtractedLights>),
) {
    if volume.0.is_some() && active.volume.is_none() {
        *scene = default();
        *lights = default();
    }
    volume.0.clone_from(&active.volume);
}

#[cfg(test)]
mod tests {
    use bevy::ecs::system::RunSystemOnce;

    use super::*;

    #[test]
    fn the_main_camera_is_that_to_the_window_whatever_previews_there_are() {
        let mut world = World::new();
        let camera = |world: &mut World, order: isize| {
            let camera = Camera { order, ..default() };
            world.spawn((Camera3d::default(), camera)).id()
        };
        let found = |world: &mut World| {
            let main = |cameras: Query<CameraParts, With<Camera3d>>| {
                main_camera(&cameras, &RenderLayers::default())
            };
            world.run_system_once(main).expect("a query")
        };
        let expected = camera(&mut world, 0);
        assert_eq!(found(&mut world), Some(expected));
        // Later ones: a preview into an image, the hands of a player in other layers, and one that is off.
        let preview = camera(&mut world, 5);
        let image = RenderTarget::Image(Handle::default().into());
        world.entity_mut(preview).insert(image);
        let hands = camera(&mut world, 6);
        world.entity_mut(hands).insert(RenderLayers::layer(1));
        let inactive = camera(&mut world, 7);
        world.get_mut::<Camera>(inactive).expect("it").is_active = false;
        assert_eq!(found(&mut world), Some(expected));
        let later = camera(&mut world, 1);
        assert_eq!(found(&mut world), Some(later));
    }
}
