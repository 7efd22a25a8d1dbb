//! The light probe through which Bevy reads the volume, and its texture.

use bevy::{
    asset::RenderAssetUsages,
    camera::visibility::RenderLayers,
    image::ImageSampler,
    light::{IrradianceVolume, LightProbe},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat, TextureUsages},
};

use super::place_volume::ActiveVolume;
use crate::settings::{Receiver, VoxelGiSettings};

/// Factor of all stored light, so that 16-bit floats cover the range of a sunlit scene: up to
/// 65504 · 64 = 4.2 million cd/m², down to 64 · 6·10⁻⁸ = 4·10⁻⁶ cd/m².
pub(crate) const STORAGE_SCALE: f32 = 1.0 / 64.0;

/// Size of the texture in texels. Per level there are the six faces of an ambient cube in the layout of
/// Bevy's irradiance volumes, (R, 2 R, 3 R), levels one behind the other. If the patch of Bevy's shader
/// applies, what divides voxels follows, (R, 2 R, R / 4) per level. With
/// [`Receiver::PerPixel`], it is the occupancy masks of sub-voxels instead, (R, 2 R, R) per level. Then the
/// depth is one more than a multiple of three, unlike that of any irradiance volume, and the last slice
/// holds the placement of the levels.
pub(super) fn texture_size(settings: &VoxelGiSettings, levels: usize, patched: bool) -> Extent3d {
    let r = settings.resolution;
    let more = match settings.receiver {
        Receiver::Interpolated => r / 4,
        Receiver::PerPixel => r,
    };
    let depth = match patched {
        false => 3 * r,
        true => ((3 * r + more) * levels as u32).next_multiple_of(3) + 1,
    };
    Extent3d {
        width: r,
        height: 2 * r,
        depth_or_array_layers: depth,
    }
}

/// Creates the texture, uninitialised.
pub(super) fn light_texture(size: Extent3d) -> Image {
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
    // It clamps to the edges.
    image.sampler = ImageSampler::linear();
    image
}

/// Marks the probe: a separate entity, so that the volume's entity may have children and a scale.
#[derive(Component)]
pub(crate) struct VoxelGiProbe;

/// Keeps the probe in sync with the active volumes: its box surrounds all of them.
pub(crate) fn place_probe(
    mut commands: Commands,
    active: Res<ActiveVolume>,
    mut probes: Query<
        (
            Entity,
            &mut IrradianceVolume,
            &mut Transform,
            &mut GlobalTransform,
            &mut RenderLayers,
        ),
        With<VoxelGiProbe>,
    >,
) {
    let Some(volume) = &active.volume else {
        for (probe, ..) in &probes {
            commands.entity(probe).despawn();
        }
        return;
    };
    let light = IrradianceVolume {
        voxels: volume.texture.clone(),
        intensity: if volume.has_had_levels {
            // The shader applies the intensity of each level.
            STORAGE_SCALE.recip()
        } else {
            volume.levels[0].intensity / STORAGE_SCALE
        },
        affects_lightmapped_meshes: volume.settings.affects_lightmapped_meshes,
    };
    let (center, extent) = volume.bounds();
    let at = Transform::from_translation(center).with_scale(extent);
    let Ok((_, mut known, mut transform, mut global, mut layers)) = probes.single_mut() else {
        commands.spawn((
            Name::new("voxel GI probe"),
            VoxelGiProbe,
            light,
            LightProbe::new(),
            at,
            GlobalTransform::from(at),
            volume.layers.clone(),
        ));
        return;
    };
    let is_same = known.voxels == light.voxels
        && known.intensity == light.intensity
        && known.affects_lightmapped_meshes == light.affects_lightmapped_meshes;
    if !is_same {
        *known = light;
    }
    if *transform != at {
        *transform = at;
        // Transforms have been propagated already in this frame.
        *global = at.into();
    }
    layers.set_if_neq(volume.layers.clone());
}
