//! Mean colours of images and meshes.

use bevy::{
    mesh::VertexAttributeValues,
    platform::collections::{HashMap, HashSet},
    prelude::*,
};

/// Mean colour of the texels of an image whose alpha is at least a cutoff, and the fraction of texels for
/// which that is so. The key holds the cutoff as the bits of the float.
pub(super) type KnownMeans = HashMap<(AssetId<Image>, u32), (LinearRgba, f32)>;

/// Mean colours of images, linear; computed once for each image and cutoff.
pub struct MeanColors<'a> {
    pub(super) images: &'a Assets<Image>,
    pub(super) known: &'a mut KnownMeans,
    /// The images that were requested.
    pub(super) used: HashSet<AssetId<Image>>,
    /// Whether any requested image is not loaded yet.
    pub(super) waiting: bool,
}

/// Most means that are kept: they are read only where a material changes.
const MOST_MEANS: usize = 4096;

/// A cutoff below every alpha.
const ALL: f32 = -1.0;

impl MeanColors<'_> {
    /// Returns the mean colour of an image; mid gray while it is not loaded, or if it cannot be read
    /// (compressed blocks, or data that is only on the GPU).
    pub fn of(&mut self, handle: &Handle<Image>) -> LinearRgba {
        self.masked(handle, ALL).0
    }

    /// Returns the mean colour of those texels of an image whose alpha is at least `cutoff`, and their
    /// fraction, 0 to 1; mid gray and 1 while the image is not loaded, or if it cannot be read.
    pub fn masked(&mut self, handle: &Handle<Image>, cutoff: f32) -> (LinearRgba, f32) {
        const UNKNOWN: (LinearRgba, f32) = (LinearRgba::rgb(0.5, 0.5, 0.5), 1.0);
        let id = handle.id();
        self.used.insert(id);
        if let Some(&mean) = self.known.get(&(id, cutoff.to_bits())) {
            return mean;
        }
        let Some(image) = self.images.get(id) else {
            self.waiting = true;
            return UNKNOWN;
        };
        let mean = mean_color(image, cutoff).unwrap_or(UNKNOWN);
        // The cutoff of a mask may be animated.
        if self.known.len() >= MOST_MEANS {
            self.known.clear();
        }
        self.known.insert((id, cutoff.to_bits()), mean);
        mean
    }
}

/// Mean of at most 128 x 128 texels, one in each cell of a grid, and the fraction of texels at or above
/// the cutoff; `None` if texels cannot be read.
fn mean_color(image: &Image, cutoff: f32) -> Option<(LinearRgba, f32)> {
    const MOST: u32 = 128;
    let size = image.size();
    let count = size.min(UVec2::splat(MOST));
    let (mut sum, mut counted) = (Vec4::ZERO, 0_u32);
    for y in 0..count.y {
        for x in 0..count.x {
            // At a random position in its cell: a regular grid would hit the same part of every brick.
            let cell = UVec2::new(x, y);
            let (first, end) = (cell * size / count, (cell + 1) * size / count);
            let at = first + scattered(cell) % (end - first).max(UVec2::ONE);
            let texel = image.get_color_at(at.x, at.y).ok()?.to_linear();
            if texel.alpha >= cutoff {
                sum += texel.to_vec4();
                counted += 1;
            }
        }
    }
    let mean = sum / counted.max(1) as f32;
    let share = counted as f32 / (count.x * count.y) as f32;
    mean.is_finite()
        .then(|| (LinearRgba::from_vec4(mean), share))
}

/// Two pseudo-random numbers for a cell (after PCG2D of Jarzynski and Olano, *Hash Functions for GPU
/// Rendering*, JCGT 2020).
fn scattered(cell: UVec2) -> UVec2 {
    let step = |v: UVec2| {
        v.wrapping_mul(UVec2::splat(1_664_525))
            .wrapping_add(UVec2::splat(1_013_904_223))
    };
    let mix = |v: UVec2| v.wrapping_add(UVec2::new(v.y, v.x).wrapping_mul(UVec2::splat(1_664_525)));
    let v = mix(step(cell));
    let v = mix(v ^ (v >> 16));
    v ^ (v >> 16)
}

/// Mean of a mesh's vertex colours, linear; `None` if it has none.
pub(super) fn mean_vertex_color(mesh: &Mesh) -> Option<Vec3> {
    // Fails for meshes whose data is only on the GPU.
    let colors = mesh.try_attribute_option(Mesh::ATTRIBUTE_COLOR).ok()??;
    let VertexAttributeValues::Float32x4(colors) = colors else {
        warn_once!(
            "voxel GI: vertex colours whose format is not Float32x4 are treated as white; store them \
             as Float32x4"
        );
        return None;
    };
    let sum: Vec3 = colors.iter().map(|c| Vec3::new(c[0], c[1], c[2])).sum();
    let mean = sum / colors.len().max(1) as f32;
    mean.is_finite().then(|| mean.clamp(Vec3::ZERO, Vec3::ONE))
}

#[cfg(test)]
mod tests {
    use bevy::{
        asset::RenderAssetUsages,
        mesh::PrimitiveTopology,
        render::render_resource::{Extent3d, TextureDimension, TextureFormat},
    };

    use super::*;

    #[test]
    fn texels_below_the_cutoff_do_not_count() {
        let size = Extent3d {
            width: 2,
            height: 2,
            depth_or_array_layers: 1,
        };
        let texels = vec![
            255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 51,
        ];
        let image = Image::new(
            size,
            TextureDimension::D2,
            texels,
            TextureFormat::Rgba8Unorm,
            RenderAssetUsages::default(),
        );
        let (mean, share) = mean_color(&image, 0.5).expect("readable");
        assert_eq!(share, 0.75);
        let wrong = mean.to_vec3() - Vec3::splat(1.0 / 3.0);
        assert!(wrong.abs().max_element() < 0.01, "{mean:?}");
        assert_eq!(mean_color(&image, 0.1).expect("readable").1, 1.0);
        assert_eq!(mean_color(&image, 2.0).expect("readable").1, 0.0);
    }

    #[test]
    fn an_animated_cutoff_does_not_fill_the_cache() {
        let mut images = Assets::default();
        let image = images.add(Image::default());
        let mut known = KnownMeans::default();
        let mut mean = MeanColors {
            images: &images,
            known: &mut known,
            used: HashSet::default(),
            waiting: false,
        };
        for frame in 0..3 * MOST_MEANS {
            let opaque = mean.masked(&image, frame as f32 * 1e-5);
            assert_eq!(opaque, (LinearRgba::WHITE, 1.0));
        }
        assert!(known.len() <= MOST_MEANS, "{}", known.len());
    }

    #[test]
    fn a_pattern_has_its_mean_whatever_its_period() {
        for period in [2, 3, 4, 8, 16] {
            let stripes = (0..512 * 512).map(|i| if i % 512 % period == 0 { 255 } else { 0 });
            let size = Extent3d {
                width: 512,
                height: 512,
                depth_or_array_layers: 1,
            };
            let image = Image::new(
                size,
                TextureDimension::D2,
                stripes.collect(),
                TextureFormat::R8Unorm,
                RenderAssetUsages::default(),
            );
            let mean = mean_color(&image, 0.0).expect("readable").0.red;
            let wanted = 512_f32.div_euclid(period as f32).ceil() / 512.0;
            assert!(
                (mean / wanted - 1.0).abs() < 0.05,
                "{period}: {mean} {wanted}"
            );
        }
    }

    #[test]
    fn vertex_colors_have_a_mean() {
        let mesh = Mesh::new(PrimitiveTopology::TriangleList, default());
        assert_eq!(mean_vertex_color(&mesh), None);
        let colors = vec![[1.0, 0.0, 0.5, 1.0], [0.0, 0.0, 0.5, 1.0]];
        let mesh = mesh.with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colors);
        assert_eq!(mean_vertex_color(&mesh), Some(Vec3::new(0.5, 0.0, 0.5)));
    }
}
