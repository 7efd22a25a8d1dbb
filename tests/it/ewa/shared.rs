//! Maps of one size and UV set, which share a loop, look like maps with loops of their own.

use bevy::{image::Image, prelude::*, render::render_resource::TextureFormat};
use bevy_ewa::{EwaMethod, EwaProbes};

use super::scene::{Floor, checks, texture};
use crate::support::{gpu, keep, psnr};

/// A texture without its coarsest mip levels, so that it differs in shape but hardly in the picture.
fn without_levels(mut image: Image, count: u32) -> Image {
    image.texture_descriptor.mip_level_count -= count;
    // Levels of 1 x 1 texel, of 2 x 2 and so on, of four bytes each.
    let bytes: usize = (0..count).map(|level| 4 << (2 * level)).sum();
    let data = image.data.as_mut().expect("data");
    data.truncate(data.len() - bytes);
    image
}

/// A lit floor with a base colour, emission and normals, whose textures lack so many levels.
fn material(images: &mut Assets<Image>, lacking: [u32; 3]) -> StandardMaterial {
    let [color, emissive, normals] = [
        (
            TextureFormat::Rgba8UnormSrgb,
            [200, 190, 170, 255],
            [20, 30, 60, 255],
        ),
        (
            TextureFormat::Rgba8UnormSrgb,
            [0, 0, 0, 255],
            [40, 90, 20, 255],
        ),
        (
            TextureFormat::Rgba8Unorm,
            [150, 128, 240, 255],
            [106, 128, 240, 255],
        ),
    ]
    .map(|(format, a, b)| texture(true, format, checks(a, b)));
    let mut add = |image, index: usize| Some(images.add(without_levels(image, lacking[index])));
    StandardMaterial {
        base_color_texture: add(color, 0),
        emissive_texture: add(emissive, 1),
        normal_map_texture: add(normals, 2),
        emissive: LinearRgba::gray(0.4),
        base_color: Color::srgb(0.4, 0.4, 0.4),
        perceptual_roughness: 0.8,
        ..default()
    }
}

#[test]
fn shared_maps_look_like_maps_with_loops_of_their_own() {
    let _gpu = gpu();
    for method in [
        EwaMethod::Linear,
        EwaMethod::Approximate {
            probes: EwaProbes::Five,
        },
    ] {
        let mut floor = Floor::filtered(method, |images| material(images, [0; 3]));
        floor.clear();
        let shared = floor.picture();
        let mut with = |change: &dyn Fn(&mut Assets<Image>) -> StandardMaterial| {
            floor.lay(|images| change(images));
            floor.picture()
        };
        let own = with(&|images| material(images, [0, 1, 2]));
        let partly = with(&|images| material(images, [0, 1, 0]));
        // Parallax mapping of no depth changes no coordinates, but the maps are filtered after it.
        let after_parallax = with(&|images| {
            let depth = texture(true, TextureFormat::Rgba8Unorm, |_, _| [0, 0, 0, 255]);
            StandardMaterial {
                depth_map: Some(images.add(depth)),
                parallax_depth_scale: 0.0,
                ..material(images, [0; 3])
            }
        });
        let stock = floor.all(None);
        keep("shared", &shared);
        keep("own", &own);
        let difference = psnr(&shared, &stock);
        for (name, found) in [
            ("own", own),
            ("partly", partly),
            ("parallax", after_parallax),
        ] {
            let found = psnr(&shared, &found);
            println!("{method:?}, {name}: {found:.1} dB; Bevy's own {difference:.1} dB");
            assert!(
                found > difference + 5.0 && difference < 40.0,
                "{method:?}, {name}: {found} dB"
            );
        }
    }
}
