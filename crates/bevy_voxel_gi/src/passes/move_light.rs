//! Moves the light that pixels read with the levels that have moved, so that what stays in a level keeps its light.

use bevy::{
    prelude::*,
    render::{
        render_asset::RenderAssets,
        render_resource::{
            Extent3d, Origin3d, TexelCopyTextureInfo, Texture, TextureAspect, TextureDescriptor,
            TextureDimension, TextureFormat, TextureUsages,
        },
        renderer::{RenderContext, RenderDevice},
        texture::GpuImage,
    },
};

use crate::{extract::place_volume::ExtractedVolume, prepare::plan::FramePlan};

pub(crate) fn move_light(
    mut context: RenderContext,
    plan: Res<FramePlan>,
    volume: Res<ExtractedVolume>,
    images: Res<RenderAssets<GpuImage>>,
    device: Res<RenderDevice>,
) {
    let (Some(work), Some(volume)) = (plan.work, &volume.0) else {
        return;
    };
    let Some(light) = images.get(&volume.texture) else {
        return;
    };
    let resolution = volume.settings.resolution;
    let moves = (0..).zip(work.moves).take(volume.lit().len());
    let moves = moves.filter_map(|(level, by)| Some((level, Overlap::of(by, resolution)?)));
    let mut moves = moves.peekable();
    if moves.peek().is_none() {
        return;
    }
    // A texture cannot be copied to itself.
    let size = Extent3d {
        width: resolution,
        height: 2 * resolution,
        depth_or_array_layers: 3 * resolution,
    };
    let before = device.create_texture(&TextureDescriptor {
        label: Some("voxel_gi_light_before"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: TextureDimension::D3,
        format: TextureFormat::Rgba16Float,
        usage: TextureUsages::COPY_SRC | TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let encoder = context.command_encoder();
    for (level, overlap) in moves {
        let level = UVec3::new(0, 0, 3 * resolution * level);
        let (whole, start) = (at(&light.texture, level), at(&before, UVec3::ZERO));
        encoder.copy_texture_to_texture(whole, start, size);
        for face in 0..6 {
            let face = resolution * UVec3::new(0, face % 2, face / 2);
            let from = at(&before, face + overlap.from);
            let to = at(&light.texture, level + face + overlap.to);
            encoder.copy_texture_to_texture(from, to, overlap.size);
        }
    }
}

fn at(texture: &Texture, UVec3 { x, y, z }: UVec3) -> TexelCopyTextureInfo<'_> {
    TexelCopyTextureInfo {
        texture,
        mip_level: 0,
        origin: Origin3d { x, y, z },
        aspect: TextureAspect::All,
    }
}

/// The voxels that are in a level before and after it has moved.
#[derive(Debug, PartialEq, Eq)]
struct Overlap {
    /// The first of them before.
    from: UVec3,
    /// The same voxel after.
    to: UVec3,
    size: Extent3d,
}

impl Overlap {
    /// `None` if the level has not moved, or so far that there are none.
    fn of(by: IVec3, resolution: u32) -> Option<Self> {
        let distance = by.abs().as_uvec3();
        let size = UVec3::splat(resolution).saturating_sub(distance);
        (by != IVec3::ZERO && size.cmpgt(UVec3::ZERO).all()).then(|| Self {
            from: by.max(IVec3::ZERO).as_uvec3(),
            to: (-by).max(IVec3::ZERO).as_uvec3(),
            size: Extent3d {
                width: size.x,
                height: size.y,
                depth_or_array_layers: size.z,
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn voxels_stay_where_they_are_in_the_world() {
        for by in [IVec3::new(2, 0, -3), IVec3::new(0, -7, 1), IVec3::X] {
            let overlap = Overlap::of(by, 8).expect("some stay");
            let Extent3d {
                width,
                height,
                depth_or_array_layers,
            } = overlap.size;
            let size = UVec3::new(width, height, depth_or_array_layers);
            assert_eq!(overlap.from.as_ivec3() - overlap.to.as_ivec3(), by);
            assert_eq!(overlap.from.max(overlap.to) + size, UVec3::splat(8));
        }
        for by in [IVec3::ZERO, IVec3::new(0, 8, 0), IVec3::splat(-1_000_000)] {
            assert_eq!(Overlap::of(by, 8), None, "{by}");
        }
    }
}
