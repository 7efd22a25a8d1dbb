//! Light has the colour of the surface: palettes, maps, masks and vertex colours in a closed room, each against the same
//! room with a material for each colour.

use std::sync::OnceLock;

use bevy::{
    asset::RenderAssetUsages,
    image::{ImageAddressMode, ImageSampler, ImageSamplerDescriptor},
    mesh::{MeshCompressionArgs, UvChannel},
    prelude::*,
    render::render_resource::TextureFormat,
};
use bevy_voxel_gi::{MeshVoxelMaterial, VoxelGiLight, VoxelMaterialPlugin};
use bevy_wavelet_tex::{
    WaveletExtension, WaveletStandardMaterial, WaveletStorage, WaveletTexPlugin, WaveletTexture,
    codec::{encoder::encode_rgb8, image::ColorSpace, rate::Rate, settings::EncodeSettings},
};

use super::{
    fixture::*,
    room::{
        PALETTE, Quad, around_room, assert_close, ceiling_light, compressed_palette, image,
        in_palette, in_room, matt_with, mesh, on_floor, on_floor_without_light, palette,
        palette_of_file, quad, room, spawn, spawn_colored, square, textured, whole, without_colors,
    },
};
use crate::support::drawn;

/// The light of a room with a material for each colour.
fn of_six_materials() -> [Vec3; 3] {
    static LIGHT: OnceLock<[Vec3; 3]> = OnceLock::new();
    *LIGHT.get_or_init(|| {
        on_floor(|world| {
            for quad in room() {
                spawn_colored(world, quad);
            }
        })
    })
}

/// Asserts that it is the light of this room, too.
fn assert_as_six_materials(what: &str, build: impl FnOnce(&mut World)) {
    assert_close(what, on_floor(build), of_six_materials(), 0.02);
}

#[test]
fn a_palette_gives_the_light_of_a_material_for_each_colour() {
    let expected = of_six_materials();
    assert!(
        expected[0].x > 1.2 * expected[0].y,
        "the left is red: {expected:?}"
    );
    assert!(
        expected[2].y > 1.1 * expected[2].x,
        "the right is green: {expected:?}"
    );
    let gpu_only = || Image {
        asset_usage: RenderAssetUsages::RENDER_WORLD,
        ..palette()
    };
    let rows = [
        ("RGBA8", palette(), false),
        ("one mesh", palette(), true),
        ("only on the GPU", gpu_only(), true),
        ("BC7", compressed_palette(), true),
        ("BC7 in a KTX2 file", palette_of_file(), true),
    ];
    for (what, image, is_one_mesh) in drawn(1, rows) {
        assert_as_six_materials(what, |world| {
            let material = textured(world, image);
            let room = room();
            let parts = if is_one_mesh { room.len() } else { 1 };
            for quads in room.chunks(parts) {
                let mesh = without_colors(mesh(quads, in_palette));
                spawn(world, mesh, material.clone());
            }
        });
    }
}

/// Encodes an image as a wavelet texture.
fn wavelet_texture(world: &mut World, image: &Image) -> Handle<WaveletTexture> {
    let texels = image.data.as_ref().expect("data").as_chunks::<4>().0;
    let pixels: Vec<_> = texels.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect();
    let is_srgb = image.texture_descriptor.format.is_srgb();
    let settings = EncodeSettings {
        rate: Rate::Color5,
        color_space: if is_srgb {
            ColorSpace::Srgb
        } else {
            ColorSpace::Linear
        },
        ..default()
    };
    let size = [image.width(), image.height()];
    let encoded = encode_rgb8(&pixels, size, &settings).expect("an image");
    world.resource_scope(|world, mut textures: Mut<Assets<WaveletTexture>>| {
        let mut images = world.resource_mut::<Assets<Image>>();
        WaveletTexture::add(&encoded, WaveletStorage::Blocks, &mut textures, &mut images)
    })
}

#[test]
fn wavelet_textures_give_the_light_of_the_images() {
    let glow = image(UVec2::new(64, 16), |x, _| {
        [[0, 200, 90, 255], [20, 20, 20, 255]][usize::from(x < 32)]
    });
    let mut half_metal = image(UVec2::splat(16), |_, _| [0, 255, 128, 255]);
    half_metal.texture_descriptor.format = TextureFormat::Rgba8Unorm;
    let base = matt_with(StandardMaterial {
        emissive: LinearRgba::rgb(50.0, 40.0, 80.0),
        metallic: 1.0,
        ..default()
    });
    let lit = |is_wavelet: bool| {
        let mut app = app_with(|app| {
            app.add_plugins((
                WaveletTexPlugin,
                VoxelMaterialPlugin::<WaveletStandardMaterial>::default(),
            ));
        });
        let world = app.world_mut();
        let mesh = Mesh3d(world.add_asset(without_colors(mesh(&room(), in_palette))));
        let base = base.clone();
        if is_wavelet {
            let extension = WaveletExtension {
                base_color: Some(wavelet_texture(world, &palette())),
                emissive: Some(wavelet_texture(world, &glow)),
                metallic_roughness: Some(wavelet_texture(world, &half_metal)),
                ..default()
            };
            let material = WaveletStandardMaterial { base, extension };
            let material = world.add_asset::<WaveletStandardMaterial>(material);
            world.spawn((mesh, MeshMaterial3d(material)));
        } else {
            let material = StandardMaterial {
                base_color_texture: Some(world.add_asset(palette())),
                emissive_texture: Some(world.add_asset(glow.clone())),
                metallic_roughness_texture: Some(world.add_asset(half_metal.clone())),
                ..base
            };
            let material = world.add_asset::<StandardMaterial>(material);
            world.spawn((mesh, MeshMaterial3d(material)));
        }
        ceiling_light(world);
        in_room(&mut app)
    };
    assert_close("wavelet textures", lit(true), lit(false), 0.02);
}

/// As under the floors of most levels.
#[test]
#[ignore = "long: settles twice"]
fn ground_under_a_floor_does_not_darken_it() {
    let floor_over = |ground: Option<Quad>| {
        on_floor(|world| {
            // Voxels of a quarter of a metre: the ground is in those of the floor.
            settings(world).resolution = 20;
            for quad in room().into_iter().chain(ground) {
                spawn_colored(world, quad);
            }
        })
    };
    let dark = (square(Vec3::Y * -1.9, Vec3::Y, 1.8), Vec3::Y, 3);
    let (actual, expected) = (floor_over(Some(dark)), floor_over(None));
    println!("{actual:?} for {expected:?}");
    assert_close("dark ground", actual, expected, 0.02);
}

#[test]
#[ignore = "long: settles for each format"]
fn vertex_colors_of_every_format_count_where_they_are() {
    let quantized = |quantization| {
        let mut mesh = mesh(&room(), in_palette);
        mesh.quantize_colors(quantization).expect("colours");
        mesh
    };
    use bevy::mesh::AttributeQuantization::{Float16, Unorm8, Unorm16};
    for (what, mesh) in [
        ("Float32", mesh(&room(), in_palette)),
        ("Float16", quantized(Float16)),
        ("Unorm16", quantized(Unorm16)),
        ("Unorm8", quantized(Unorm8)),
    ] {
        assert_as_six_materials(what, |world| {
            spawn(world, mesh, StandardMaterial::default());
        });
    }
}

#[test]
fn compressed_vertices_are_voxelized_with_their_textures() {
    for (what, has_colors) in [("texture", false), ("colours", true)] {
        assert_as_six_materials(what, |world| {
            let (mut mesh, material) = if has_colors {
                (mesh(&room(), in_palette), StandardMaterial::default())
            } else {
                let mesh = without_colors(mesh(&room(), in_palette));
                (mesh, textured(world, palette()))
            };
            mesh.compress_mesh(&MeshCompressionArgs::regular())
                .expect("vertices");
            spawn(world, mesh, material);
        });
    }
}

/// Coordinates beyond the texture, in another set, and moved by a transform of the material.
#[test]
fn coordinates_repeat_mirror_and_move_as_in_the_picture() {
    let with_address = |mode| Image {
        sampler: ImageSampler::Descriptor(ImageSamplerDescriptor {
            address_mode_u: mode,
            address_mode_v: mode,
            ..default()
        }),
        ..palette()
    };
    let moved =
        |by: Vec2, scale: Vec2| move |quad: &Quad| in_palette(quad).map(|uv| by + scale * uv);
    let repeated = mesh(&room(), moved(Vec2::new(-5.0, 7.0), Vec2::ONE));
    let mirrored = mesh(&room(), moved(Vec2::new(4.0, 2.0), Vec2::new(-1.0, 1.0)));
    let mut second = mesh(&room(), in_palette);
    let uvs = second
        .remove_attribute(Mesh::ATTRIBUTE_UV_0)
        .expect("coordinates");
    let unused = vec![[0.9, 0.9]; uvs.len()];
    second.insert_attribute(Mesh::ATTRIBUTE_UV_0, unused);
    second.insert_attribute(Mesh::ATTRIBUTE_UV_1, uvs);
    let transformed = mesh(&room(), moved(Vec2::new(0.25, 0.0), Vec2::new(0.5, 1.0)));
    let transform = bevy::math::Affine2::from_scale_angle_translation(
        Vec2::new(2.0, 1.0),
        0.0,
        Vec2::new(-0.5, 0.0),
    );
    use {ImageAddressMode as Mode, UvChannel::*};
    let rows = [
        ("repeat", repeated, Mode::Repeat, Uv0, default()),
        ("mirror", mirrored, Mode::MirrorRepeat, Uv0, default()),
        ("second set", second, Mode::ClampToEdge, Uv1, default()),
        ("transform", transformed, Mode::ClampToEdge, Uv0, transform),
    ];
    for (what, mesh, mode, channel, uv_transform) in drawn(1, rows) {
        assert_as_six_materials(what, |world| {
            let material = StandardMaterial {
                base_color_channel: channel,
                uv_transform,
                ..textured(world, with_address(mode))
            };
            spawn(world, without_colors(mesh), material);
        });
    }
}

/// The floor's light in a gray room whose left wall glows, all of it emission.
fn lit_by_wall(glow: impl FnOnce(&mut World, Quad) -> StandardMaterial) -> [Vec3; 3] {
    let gray = StandardMaterial::from_color(LinearRgba::gray(0.5));
    on_floor_without_light(|world| {
        let quads = room();
        for other in &quads[1..] {
            spawn(world, quad(*other), gray.clone());
        }
        let material = StandardMaterial {
            base_color: gray.base_color,
            ..glow(world, quads[0])
        };
        spawn(world, quad(quads[0]), material);
    })
}

#[test]
fn an_emissive_map_shines_from_where_it_glows() {
    let glow = LinearRgba::rgb(300.0, 200.0, 100.0);
    let expected = lit_by_wall(|world, (corners, normal, _)| {
        let center = corners.iter().sum::<Vec3>() / 4.0 + 0.001 * normal;
        let glowing = (square(center, normal, 0.45), normal, 0);
        spawn(world, quad(glowing), emitting(0.5, glow));
        StandardMaterial::default()
    });
    assert!(expected[0].x > 1.4 * expected[2].x, "{expected:?}");
    let actual = lit_by_wall(|world, _| {
        let map = image(UVec2::splat(64), |x, y| {
            let is_lit = (24..40).contains(&x) && (24..40).contains(&y);
            [[0, 0, 0, 255], [255; 4]][usize::from(is_lit)]
        });
        StandardMaterial {
            emissive: glow,
            emissive_texture: Some(world.add_asset(map)),
            ..default()
        }
    });
    assert_close("emissive map", actual, expected, 0.05);
}

#[test]
fn a_texture_of_two_halves_lights_both_sides_by_its_halves() {
    let half = |left: bool| {
        let edge = if left { -1.8 } else { 0.0 };
        let corners = [[0.0, -1.8], [1.8, -1.8], [1.8, 1.8], [0.0, 1.8]];
        let corners = corners.map(|[x, y]| Vec3::new(edge + x, y, -1.75));
        (corners, Vec3::Z, if left { 1 } else { 2 })
    };
    let wall = (square(Vec3::new(0.0, 0.0, -1.75), Vec3::Z, 1.8), Vec3::Z, 0);
    let lit = |build: &dyn Fn(&mut World)| {
        on_floor(|world| {
            for side in room().into_iter().filter(|side| side.1 != Vec3::Z) {
                let model = model(world, quad(side), matt_material(0.5));
                world.spawn(model);
            }
            build(world);
        })
    };
    let expected = lit(&|world| {
        for quad in [half(true), half(false)] {
            spawn_colored(world, quad);
        }
    });
    let actual = lit(&|world| {
        let halves = image(UVec2::new(128, 16), |x, _| {
            let [r, g, b] = PALETTE[1 + x as usize / 64];
            [r, g, b, 255]
        });
        let material = textured(world, halves);
        let coordinates = |quad: &Quad| quad.0.map(|corner| Vec2::new((corner.x + 1.8) / 3.6, 0.5));
        spawn(world, without_colors(mesh(&[wall], coordinates)), material);
    });
    assert_close("two halves", actual, expected, 0.02);
}

/// Light through a roof with holes, under a sky of 1, before any light of Bevy's.
fn under_fence(build: impl FnOnce(&mut World)) -> (f32, f32) {
    let light = lit_floor(|world| {
        settings(world).resolution = 32;
        build(world);
    });
    (at(&light, -0.5, 0.0).x, at(&light, 0.5, 0.0).x)
}

/// Bars of 1 m just above the floor: holes are where texels are cut out.
#[test]
#[ignore = "long: settles for each alpha mode"]
fn a_mask_has_holes_where_its_texels_are_cut_out() {
    let roof = |low: f32, high: f32| {
        let corners = [[low, -1.8], [high, -1.8], [high, 1.8], [low, 1.8]];
        (corners.map(|[x, z]| Vec3::new(x, 0.3, z)), Vec3::Y, 0)
    };
    let spawn_hidden = |world: &mut World, mesh: Mesh, material: StandardMaterial| {
        let material = StandardMaterial {
            base_color: LinearRgba::gray(0.2).into(),
            cull_mode: None,
            ..material
        };
        let roof = spawn(world, without_colors(mesh), material);
        world.entity_mut(roof).insert(hidden());
    };
    let (dark, bright) = under_fence(|world| {
        for low in [-1.0, 1.0] {
            spawn_hidden(world, mesh(&[roof(low, low + 1.0)], whole), default());
        }
    });
    let (masked_dark, masked_bright) = under_fence(|world| {
        // Opaque from -1 to 0 and from 1 to 2: every other metre. What is cut out is red and does not count.
        let bars = Image {
            sampler: ImageSampler::Descriptor(ImageSamplerDescriptor {
                address_mode_u: ImageAddressMode::Repeat,
                ..default()
            }),
            ..image(UVec2::new(64, 4), |x, _| {
                if x < 32 { [255; 4] } else { [255, 0, 0, 0] }
            })
        };
        let coordinates = |quad: &Quad| quad.0.map(|corner| Vec2::new((corner.x + 1.0) / 2.0, 0.5));
        let material = StandardMaterial {
            alpha_mode: AlphaMode::Mask(0.5),
            ..textured(world, bars)
        };
        spawn_hidden(world, mesh(&[roof(-1.0, 2.0)], coordinates), material);
    });
    assert!(bright > 2.0 * dark, "bars of light: {bright} beside {dark}");
    assert!(
        (masked_dark / dark - 1.0).abs() < 0.05,
        "{masked_dark} for {dark}"
    );
    assert!(
        (masked_bright / bright - 1.0).abs() < 0.05,
        "{masked_bright} for {bright}"
    );
}

/// An image that is painted on gives another light; the light of one that is at rest settles.
#[test]
fn an_image_that_changes_is_read_again() {
    let mut app = app();
    let world = app.world_mut();
    let texture = world.add_asset(image(UVec2::splat(8), |_, _| [255, 0, 0, 255]));
    let material = StandardMaterial {
        emissive_texture: Some(texture.clone()),
        ..emitting(0.5, LinearRgba::rgb(100.0, 100.0, 100.0))
    };
    for side in room() {
        spawn(world, quad(side), material.clone());
    }
    world.spawn(around_room());
    let red = at(&settled(&mut app), 0.0, 0.0);
    assert!(red.x > 1.0 && red.z < 1e-3 * red.x, "{red}");
    let mut images = app.world_mut().resource_mut::<Assets<Image>>();
    let mut painted = images.get_mut(&texture).expect("the image");
    painted.data = image(UVec2::splat(8), |_, _| [0, 0, 255, 255]).data;
    drop(painted);
    frames(&mut app, 2);
    settle(&mut app);
    let blue = at(&picture(&mut app), 0.0, 0.0);
    assert!((blue.z / red.x - 1.0).abs() < 0.01, "{blue} for {red}");
    assert!(blue.x < 1e-3 * blue.z, "{blue}");
}

/// A game may let a light or an emissive mesh give half of its light to volumes.
#[test]
#[ignore = "long: settles for each choice"]
fn a_game_chooses_how_much_things_give() {
    let of_room = |factor: Option<f32>| {
        on_floor_without_light(|world| {
            let material = emitting(0.5, LinearRgba::rgb(10.0, 20.0, 30.0));
            let glowing = spawn(world, without_colors(mesh(&room(), whole)), material);
            let light = ceiling_light(world);
            if let Some(factor) = factor {
                world.entity_mut(glowing).insert(MeshVoxelMaterial {
                    emission_factor: Some(factor),
                    ..default()
                });
                world.entity_mut(light).insert(VoxelGiLight { factor });
            }
        })
    };
    let whole_light = of_room(None);
    let half = of_room(Some(0.5));
    assert_close("half", half, whole_light.map(|light| 0.5 * light), 0.005);
    let none = of_room(Some(0.0));
    assert!(
        none.iter().all(|light| light.max_element() < 1e-4),
        "{none:?}"
    );
}
