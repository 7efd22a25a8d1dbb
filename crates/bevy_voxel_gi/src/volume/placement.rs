//! Where the volume is, and the light probe through which Bevy reads it.

use bevy::{
    asset::RenderAssetUsages,
    image::{ImageAddressMode, ImageSampler, ImageSamplerDescriptor},
    light::{IrradianceVolume, LightProbe},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat, TextureUsages},
};
use bevy_frugal_hooks::{PatchState, ShaderPatches};

use super::STORAGE_SCALE;
use crate::{
    receive::RECEIVER_PATCH,
    settings::{VoxelGiVolume, VoxelLight},
};

/// The volume that lights the app, where it is now.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlacedVolume {
    /// With every field in range.
    pub settings: VoxelGiVolume,
    /// Centre of all cascades.
    pub center: Vec3,
    /// What Bevy samples; see [`texture_size`].
    pub texture: Handle<Image>,
    /// The pixel's shader knows our layout; else it is that of a plain irradiance volume.
    pub patched: bool,
    /// Exposure of the camera, for emission that is not meant to be exposed.
    pub exposure: f32,
}

impl PlacedVolume {
    /// Half the edge of the largest cascade in metres.
    pub fn outer_half_size(&self) -> f32 {
        0.5 * self.settings.size * self.outer_scale()
    }

    /// How much larger the largest cascade is than the smallest.
    fn outer_scale(&self) -> f32 {
        (1 << (self.settings.cascades - 1)) as f32
    }
}

/// The volume in use, if there is one.
#[derive(Resource, Default)]
pub(crate) struct ActiveVolume {
    pub volume: Option<PlacedVolume>,
    /// The user's entity.
    owner: Option<Entity>,
    /// Ours, with the irradiance volume.
    probe: Option<Entity>,
}

/// Texels of the texture: per cascade six ambient-cube faces as Bevy's irradiance volumes have
/// them, (R, 2 R, 3 R), one cascade behind the other; and, where the pixel's shader is ours, one
/// more slice that says so (its depth is then no multiple of three, as no irradiance volume's is).
pub(crate) fn texture_size(settings: &VoxelGiVolume, patched: bool) -> Extent3d {
    let r = settings.resolution;
    Extent3d {
        width: r,
        height: 2 * r,
        depth_or_array_layers: if patched {
            3 * r * settings.cascades + 1
        } else {
            3 * r
        },
    }
}

/// Chooses the volume and keeps its texture and its probe in step with it.
pub(crate) fn place_volume(
    mut commands: Commands,
    mut active: ResMut<ActiveVolume>,
    volumes: Query<(Entity, &VoxelGiVolume, &GlobalTransform), Without<IrradianceVolume>>,
    transforms: Query<&GlobalTransform, Without<IrradianceVolume>>,
    cameras: Query<(&Camera, Option<&bevy::camera::Exposure>), With<Camera3d>>,
    patches: Res<ShaderPatches>,
    mut images: ResMut<Assets<Image>>,
    mut probes: Query<(&mut IrradianceVolume, &mut Transform, &mut GlobalTransform)>,
) {
    let active = &mut *active;
    let patched = match patches.state(RECEIVER_PATCH) {
        Some(PatchState::Applied) => true,
        Some(PatchState::Pending) => return,
        _ => false,
    };
    if volumes.iter().len() > 1 {
        warn_once!(
            "voxel GI: there is more than one VoxelGiVolume; only the one spawned first lights \
             the scene. Use its `cascades` to cover more of the world"
        );
    }
    // Entities are ordered by index, which is reused: keep the one that is in use.
    let chosen = active
        .owner
        .and_then(|owner| volumes.get(owner).ok())
        .or_else(|| volumes.iter().min_by_key(|(entity, ..)| *entity));
    let Some((owner, settings, transform)) = chosen else {
        if let Some(probe) = active.probe.take() {
            commands.entity(probe).despawn();
        }
        (active.volume, active.owner) = (None, None);
        return;
    };
    let mut settings = settings.clamped();
    if !patched && settings.cascades > 1 {
        warn_once!("voxel GI: Bevy's shader is not the one expected; one cascade only");
        settings.cascades = 1;
    }
    if let VoxelLight::GlobalIllumination {
        solver: crate::settings::Solver::Propagate { .. },
        ..
    } = settings.light
    {
        settings.cascades = 1;
    }
    let anchor = settings
        .follow
        .and_then(|entity| transforms.get(entity).ok())
        .unwrap_or(transform)
        .translation();
    let center = snapped(anchor, &settings);
    let exposure = cameras
        .iter()
        .find(|(camera, _)| camera.is_active)
        .and_then(|(_, exposure)| exposure.copied())
        .unwrap_or_default()
        .exposure();
    let size = texture_size(&settings, patched);
    let kept = active.volume.as_ref().filter(|old| {
        images
            .get(&old.texture)
            .is_some_and(|image| image.texture_descriptor.size == size)
            && old.patched == patched
    });
    let texture = match kept {
        Some(old) => old.texture.clone(),
        None => images.add(texture(size)),
    };
    let volume = PlacedVolume {
        settings,
        center,
        texture,
        patched,
        exposure,
    };
    let irradiance_volume = IrradianceVolume {
        voxels: volume.texture.clone(),
        intensity: volume.settings.intensity / STORAGE_SCALE,
        affects_lightmapped_meshes: true,
    };
    let at =
        Transform::from_translation(center).with_scale(Vec3::splat(2.0 * volume.outer_half_size()));
    match active.probe.and_then(|probe| probes.get_mut(probe).ok()) {
        Some((mut probe, mut transform, mut global)) => {
            if probe.voxels != irradiance_volume.voxels
                || probe.intensity != irradiance_volume.intensity
            {
                *probe = irradiance_volume;
            }
            if *transform != at {
                *transform = at;
                *global = at.into();
            }
        }
        None => {
            let probe = commands.spawn((
                Name::new("voxel GI probe"),
                irradiance_volume,
                LightProbe::new(),
                at,
                GlobalTransform::from(at),
            ));
            active.probe = Some(probe.id());
        }
    }
    active.owner = Some(owner);
    active.volume = Some(volume);
}

/// The nearest whole voxel of the largest cascade, so that what is voxelised does not swim as the
/// volume moves.
fn snapped(anchor: Vec3, settings: &VoxelGiVolume) -> Vec3 {
    let anchor = if anchor.is_finite() {
        anchor
    } else {
        Vec3::ZERO
    };
    if settings.follow.is_none() {
        return anchor;
    }
    let step = settings.voxel_size() * (1 << (settings.cascades - 1)) as f32;
    (anchor / step).round() * step
}

fn texture(size: Extent3d) -> Image {
    let mut image = Image::new_uninit(
        size,
        TextureDimension::D3,
        TextureFormat::Rgba16Float,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.texture_descriptor.label = Some("voxel_gi_light");
    image.texture_descriptor.usage = TextureUsages::TEXTURE_BINDING
        | TextureUsages::STORAGE_BINDING
        | TextureUsages::COPY_SRC
        | TextureUsages::COPY_DST;
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::ClampToEdge,
        address_mode_v: ImageAddressMode::ClampToEdge,
        address_mode_w: ImageAddressMode::ClampToEdge,
        ..ImageSamplerDescriptor::linear()
    });
    image
}
