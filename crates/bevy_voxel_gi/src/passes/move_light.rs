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
    // A texture cannot be copied to itself. One face at a time: that is a sixth of the memory of a level.
    let before = device.create_texture(&TextureDescriptor {
        label: Some("voxel_gi_light_before"),
        size: extent(UVec3::splat(resolution)),
        mip_level_count: 1,
        sample_count: 1,
        dimension: TextureDimension::D3,
        format: TextureFormat::Rgba16Float,
        usage: TextureUsages::COPY_SRC | TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let encoder = context.command_encoder();
    for (level, Overlap { from, to, size }) in moves {
        for face in 0..6 {
            let corner = resolution * UVec3::new(0, face % 2, 3 * level + face / 2);
            let copy = at(&before, UVec3::ZERO);
            encoder.copy_texture_to_texture(at(&light.texture, corner + from), copy, extent(size));
            encoder.copy_texture_to_texture(copy, at(&light.texture, corner + to), extent(size));
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

fn extent(size: UVec3) -> Extent3d {
    Extent3d {
        width: size.x,
        height: size.y,
        depth_or_array_layers: size.z,
    }
}

/// The voxels that are in a level before and after it has moved.
#[derive(Debug, PartialEq, Eq)]
struct Overlap {
    /// The first of them before the move.
    from: UVec3,
    /// Where that voxel is after the move.
    to: UVec3,
    size: UVec3,
}

impl Overlap {
    /// `None` if the level has not moved, or so far that there are none.
    fn of(by: IVec3, resolution: u32) -> Option<Self> {
        let distance = by.abs().as_uvec3();
        let size = UVec3::splat(resolution).saturating_sub(distance);
        (by != IVec3::ZERO && size.cmpgt(UVec3::ZERO).all()).then(|| Self {
            from: by.max(IVec3::ZERO).as_uvec3(),
            to: (-by).max(IVec3::ZERO).as_uvec3(),
            size,
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
            assert_eq!(overlap.from.as_ivec3() - overlap.to.as_ivec3(), by);
            assert_eq!(overlap.from.max(overlap.to) + overlap.size, UVec3::splat(8));
        }
        for by in [IVec3::ZERO, IVec3::new(0, 8, 0), IVec3::splat(-1_000_000)] {
            assert_eq!(Overlap::of(by, 8), None, "{by}");
        }
    }
}
