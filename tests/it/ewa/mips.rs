//! The mip levels that the GPU generates are those of the reference, for whatever a game's textures are.

use bevy::{
    asset::RenderAssetUsages,
    image::{ImageSampler, ToExtents},
    prelude::*,
    render::render_resource::{
        TextureDimension, TextureFormat, TextureUsages, TextureViewDescriptor, TextureViewDimension,
    },
};
use bevy_ewa::{
    EwaImage, EwaOverrides, EwaPlugin, MipReport,
    mips::{self, MipContent, NoMips, TexelFormat, texel::Storage},
};

use super::{Floor, checkered, colored, texture};
use crate::support::{gpu, psnr};

const UNORM8: TexelFormat = TexelFormat {
    channels: 4,
    storage: Storage::Unorm8,
    srgb: false,
};
const SRGB: TexelFormat = TexelFormat {
    srgb: true,
    ..UNORM8
};
const SRGB_TEXTURE: TextureFormat = TextureFormat::Rgba8UnormSrgb;

/// A floor without the plugin's filter at first.
fn floor() -> Floor {
    Floor::new(Some(EwaPlugin::OPT_IN), checkered(true))
}

/// Noise of few steps and many sizes, the same every time.
fn noise(i: u32) -> u8 {
    let mixed = i.wrapping_mul(0x9E37_79B9) ^ (i >> 3).wrapping_mul(0x85EB_CA6B);
    (mixed >> 21) as u8
}

fn image(size: [u32; 2], layers: u32, format: TextureFormat, data: Vec<u8>) -> Image {
    let size = UVec3::new(size[0], size[1], layers).to_extents();
    let usages = RenderAssetUsages::default();
    Image::new(size, TextureDimension::D2, data, format, usages)
}

/// The levels that the GPU has of a base colour or a normal map, after those that it was given.
fn generated(floor: &mut Floor, image: Image, material: StandardMaterial) -> Vec<Vec<u8>> {
    let bytes = image.texture_descriptor.format.block_copy_size(None);
    let bytes = bytes.expect("an uncompressed format");
    let image = floor.app.world_mut().add_asset(image);
    let mut material = material;
    match &mut material.normal_map_texture {
        Some(normal_map) => *normal_map = image.clone(),
        None => material.base_color_texture = Some(image.clone()),
    }
    floor.lay(|_| material);
    floor.all(EwaPlugin::default().all_materials);
    let levels = super::mips(floor.app.world(), &image).expect("a report");
    let MipReport::Generated(levels) = levels else {
        panic!("{levels:?}");
    };
    let level = |level| floor.app.read_level(&image, level, bytes).expect("a level");
    (1..levels).map(|n| level(n).1).collect()
}

fn expected(size: [u32; 2], format: TexelFormat, data: &[u8], content: MipContent) -> Vec<Vec<u8>> {
    let chain = mips::generate_mip_chain(size, format, data.to_vec(), content).expect("a chain");
    let mut rest = &chain.data[data.len()..];
    let mut levels = Vec::new();
    for level in 1..chain.levels {
        let [width, height] = size.map(|side| (side >> level).max(1) as usize);
        let (first, others) = rest.split_at(width * height * format.bytes());
        levels.push(first.to_vec());
        rest = others;
    }
    levels
}

/// The largest difference of two levels, in steps of 8 bits.
fn difference(a: &[u8], b: &[u8]) -> u8 {
    assert_eq!(a.len(), b.len());
    let differences = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b));
    differences.max().unwrap_or(0)
}

#[test]
fn levels_are_those_of_the_reference_for_all_contents_and_sizes() {
    let _gpu = gpu();
    let mut floor = floor();
    let blend = || StandardMaterial {
        alpha_mode: AlphaMode::Blend,
        ..default()
    };
    let normals = || StandardMaterial {
        normal_map_texture: Some(default()),
        ..default()
    };
    for size in [[64, 64], [37, 51], [1, 9], [130, 3]] {
        let texels = size[0] * size[1];
        let data: Vec<u8> = (0..texels * 4).map(noise).collect();
        let red = TexelFormat {
            channels: 1,
            ..UNORM8
        };
        let [values, transparent] = [MipContent::Values, MipContent::Transparent];
        for (format, reference, materials) in [
            (
                TextureFormat::Rgba8UnormSrgb,
                SRGB,
                vec![(default(), values), (blend(), transparent)],
            ),
            (
                TextureFormat::Rgba8Unorm,
                UNORM8,
                vec![
                    (default(), values),
                    (blend(), transparent),
                    (normals(), MipContent::Normals),
                ],
            ),
            (TextureFormat::R8Unorm, red, vec![(default(), values)]),
        ] {
            for (material, content) in materials {
                let bytes = texels as usize * reference.channels;
                let image = image(size, 1, format, data[..bytes].to_vec());
                let actual = generated(&mut floor, image, material);
                let expected = expected(size, reference, &data[..bytes], content);
                assert_eq!(actual.len(), expected.len());
                assert!(actual.len() > 2);
                for (actual, expected) in actual.iter().zip(&expected) {
                    let difference = difference(actual, expected);
                    assert!(
                        difference <= 1,
                        "{size:?} {format:?} {content:?}: {difference}"
                    );
                }
            }
        }
    }
}

#[test]
fn floats_are_exact_to_a_thousandth() {
    let _gpu = gpu();
    let mut floor = floor();
    let size = [20, 12];
    let values: Vec<f32> = (0..size[0] * size[1] * 4)
        .map(|i| f32::from(noise(i)) * 40.0)
        .collect();
    let format = TexelFormat {
        channels: 4,
        storage: Storage::Float32,
        srgb: false,
    };
    let mut data = Vec::new();
    format.encode(&values, &mut data);
    let expected = expected(size, format, &data, MipContent::Values);
    let image = image(size, 1, TextureFormat::Rgba32Float, data);
    let actual = generated(&mut floor, image, default());
    for (actual, expected) in actual.iter().zip(&expected) {
        for (a, b) in format.decode(actual).iter().zip(format.decode(expected)) {
            assert!((a - b).abs() <= 1e-3 * b.abs().max(1.0), "{a} {b}");
        }
    }
}

/// The sRGB of a texture may be that of its view only.
#[test]
fn srgb_texels_are_averaged_in_linear_light_whatever_the_view_is() {
    let _gpu = gpu();
    let mut floor = floor();
    let stripes = [[0, 0, 0, 255], [255; 4]].concat().repeat(32);
    let mut image = image([8, 8], 1, TextureFormat::Rgba8Unorm, stripes);
    image.texture_descriptor.view_formats = &[TextureFormat::Rgba8UnormSrgb];
    image.texture_view_descriptor = Some(TextureViewDescriptor {
        format: Some(TextureFormat::Rgba8UnormSrgb),
        ..default()
    });
    let actual = generated(&mut floor, image, default());
    // The mean of the codes is 128.
    assert!(
        difference(&actual[2], &[188, 188, 188, 255]) <= 1,
        "{actual:?}"
    );
}

#[test]
fn alpha_masks_keep_their_coverage() {
    let _gpu = gpu();
    let mut floor = floor();
    const SIZE: u32 = 128;
    // Blades of grass on transparent magenta: 18% of the area.
    let texel = |i: u32| match (i % SIZE + i / SIZE / 3) % 11 {
        0 | 1 => [60, 120, 40, 255],
        _ => [255, 0, 255, 0],
    };
    let data: Vec<u8> = (0..SIZE * SIZE).flat_map(texel).collect();
    for cutoff in [0.25, 0.5, 0.8] {
        let image = image([SIZE; 2], 1, TextureFormat::Rgba8UnormSrgb, data.clone());
        let mask = StandardMaterial {
            alpha_mode: AlphaMode::Mask(cutoff),
            ..default()
        };
        let actual = generated(&mut floor, image, mask);
        let whole = visible(&data, SIZE, cutoff);
        // The means of these blades are one value in levels of 4 x 4 and less.
        for (level, texels) in actual.iter().enumerate().take(4) {
            let side = SIZE >> (level + 1);
            let part = visible(texels, side, cutoff);
            let is_kept = (part - whole).abs() < 0.01;
            assert!(is_kept, "{cutoff}, {side}: {part} for {whole}");
            let is_green =
                |texel: &[u8]| difference(&texel[..3], &[60, 120, 40]) <= 2 || texel[3] == 0;
            assert!(texels.chunks_exact(4).all(is_green), "magenta bleeds");
        }
    }
}

/// The part of the area where bilinearly filtered alpha reaches the cutoff, of 8 x 8 points a texel.
fn visible(texels: &[u8], side: u32, cutoff: f32) -> f64 {
    let alpha = image::RgbaImage::from_raw(side, side, texels.to_vec()).expect("a level");
    let at = |x: f32, y: f32| {
        let (left, top) = (x.floor(), y.floor());
        let load = |x: f32, y: f32| {
            let last = side as f32 - 1.0;
            let texel = alpha.get_pixel(x.clamp(0.0, last) as u32, y.clamp(0.0, last) as u32);
            f32::from(texel[3]) / 255.0
        };
        let row = |y| load(left, y).lerp(load(left + 1.0, y), x - left);
        row(top).lerp(row(top + 1.0), y - top)
    };
    let points = side * 8;
    let position = |i: u32| (i as f32 + 0.5) / 8.0 - 0.5;
    let covered = (0..points * points)
        .filter(|i| at(position(i % points), position(i / points)) >= cutoff)
        .count();
    covered as f64 / f64::from(points * points)
}

#[test]
fn layers_of_an_array_have_levels_of_their_own() {
    let _gpu = gpu();
    let mut floor = floor();
    let layer = |n: u8| {
        [[n, 255 - n, n, 255], [n, 0, n, 255]]
            .concat()
            .repeat(8 * 4)
    };
    let data = [layer(10), layer(200), layer(90)].concat();
    let mut array = image([8, 8], 3, TextureFormat::Rgba8Unorm, data);
    // A `StandardMaterial` shows one layer.
    array.texture_view_descriptor = Some(TextureViewDescriptor {
        dimension: Some(TextureViewDimension::D2),
        ..default()
    });
    let actual = generated(&mut floor, array, default());
    let last = [10_u8, 200, 90].map(|n| [n, (255 - n).div_ceil(2), n, 255]);
    assert_eq!(actual.len(), 3);
    assert!(
        difference(&actual[2], last.as_flattened()) <= 1,
        "{:?}",
        actual[2]
    );
}

#[test]
fn a_texture_without_mips_shows_those_it_should_have() {
    let _gpu = gpu();
    let plugin = Some(EwaPlugin::elliptical());
    let with = Floor::new(plugin, checkered(true)).picture();
    let mut floor = Floor::new(plugin, checkered(false));
    let made = floor.picture();
    assert!(made == with, "{} dB", psnr(&made, &with));
    // And back to Bevy's own, and on again.
    let stock = Floor::new(None, checkered(false)).picture();
    assert!(floor.all(None) == stock);
    assert!(floor.all(plugin.and_then(|plugin| plugin.all_materials)) == with);
}

#[test]
fn a_texture_of_materials_that_did_not_ask_gets_none() {
    let _gpu = gpu();
    let mut floor = Floor::new(Some(EwaPlugin::OPT_IN), checkered(false));
    let stock = Floor::new(None, checkered(false)).picture();
    assert!(floor.picture() == stock);
}

#[test]
fn the_report_says_what_each_texture_got_and_why_not() {
    let _gpu = gpu();
    let mut floor = floor();
    let size = [16, 16];
    let plain = || image(size, 1, SRGB_TEXTURE, vec![90; 16 * 16 * 4]);
    let mut nearest = plain();
    nearest.sampler = ImageSampler::nearest();
    let mut storage = plain();
    storage.texture_descriptor.format = TextureFormat::Rgba8Unorm;
    storage.texture_descriptor.usage |= TextureUsages::STORAGE_BINDING;
    let compressed = image(size, 1, TextureFormat::Bc1RgbaUnorm, vec![0; 16 * 16 / 2]);
    let shared_exponent = image(size, 1, TextureFormat::Rgb9e5Ufloat, vec![0; 16 * 16 * 4]);
    let target = Image::new_target_texture(16, 16, SRGB_TEXTURE, None);
    let with_levels = texture(true, SRGB_TEXTURE, |_, _| [9; 4]);
    let use_nearest = EwaImage {
        use_nearest: true,
        ..default()
    };
    let atlas = EwaImage::atlas(UVec2::splat(4));
    let (generated, without) = (MipReport::Generated, MipReport::Without);
    let format = |format| without(NoMips::Format(format));
    let cases = [
        (plain(), default(), generated(5)),
        (plain(), EwaImage::EXCLUDED, without(NoMips::Excluded)),
        (plain(), atlas, generated(3)),
        (nearest.clone(), default(), without(NoMips::NearestSampler)),
        (nearest, use_nearest, generated(5)),
        (target, default(), without(NoMips::WrittenOnGpu)),
        (storage, default(), without(NoMips::WrittenOnGpu)),
        (compressed, default(), format(TextureFormat::Bc1RgbaUnorm)),
        (
            shared_exponent,
            default(),
            format(TextureFormat::Rgb9e5Ufloat),
        ),
        (with_levels, default(), MipReport::Own(7)),
        (Image::default(), default(), without(NoMips::OneTexel)),
    ];
    for (image, choice, expected) in cases {
        let format = image.texture_descriptor.format;
        let world = floor.app.world_mut();
        let image = world.add_asset(image);
        let mut overrides = world.resource_mut::<EwaOverrides>();
        overrides.set_image(&image, choice);
        floor.lay(|_| colored(image.clone()));
        floor.all(EwaPlugin::default().all_materials);
        let actual = super::mips(floor.app.world(), &image);
        assert_eq!(actual, Some(expected), "{format:?} {choice:?}");
    }
}
