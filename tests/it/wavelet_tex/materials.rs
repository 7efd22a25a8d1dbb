//! A lit material of wavelet textures looks as the same material of decoded ones.

use bevy::{
    asset::RenderAssetUsages,
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass, MotionVectorPrepass, NormalPrepass},
    light::DirectionalLightShadowMap,
    pbr::DefaultOpaqueRendererMethod,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_frugal_lab::{
    content,
    headless::{HeadlessApp, HeadlessSettings, LabTarget},
    metrics,
};
use bevy_wavelet_tex::{
    WaveletAddressMode, WaveletExtension, WaveletFilter, WaveletStandardMaterial, WaveletStorage,
    WaveletTexPlugin,
    codec::{
        decoder::decode,
        image::{ColorSpace, Content, WaveletImage},
    },
};
use image::{DynamicImage, RgbImage};

use super::scene::{MAX_FRAMES, add_texture, encoded, gpu_with_all_planes};

const SIZE: u32 = 64;

/// How the camera draws.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Path {
    Forward,
    Prepass,
    Deferred,
}

struct Maps {
    color: WaveletImage,
    normal: WaveletImage,
    mask: WaveletImage,
    emissive: WaveletImage,
    metallic_roughness: WaveletImage,
    occlusion: WaveletImage,
}

fn maps() -> Maps {
    let foliage = content::foliage(SIZE, SIZE, 3);
    let mask = DynamicImage::ImageLuma8(foliage.mask).to_rgb8();
    Maps {
        color: encoded(&foliage.color, Content::Color, ColorSpace::Srgb),
        normal: encoded(&foliage.normal, Content::Normal, ColorSpace::Linear),
        mask: encoded(&mask, Content::Gray, ColorSpace::Linear),
        emissive: encoded(&photo(4), Content::Color, ColorSpace::Srgb),
        metallic_roughness: encoded(&photo(5), Content::Color, ColorSpace::Linear),
        occlusion: encoded(&photo(6), Content::Gray, ColorSpace::Linear),
    }
}

fn photo(seed: u64) -> RgbImage {
    content::photo_like(SIZE, SIZE, seed)
}

/// A lit, masked quad that throws its shadow on a wall; `material` gives the quad its material.
fn render(path: Path, material: impl FnOnce(&mut World, StandardMaterial, Entity)) -> RgbImage {
    let mut app = HeadlessApp::new(HeadlessSettings::with_size(96, 72), |app| {
        app.add_plugins(WaveletTexPlugin)
            // Texels on the other side of the mask's cutoff cast shadows no larger than a pixel.
            .insert_resource(DirectionalLightShadowMap::default());
        if path == Path::Deferred {
            app.insert_resource(DefaultOpaqueRendererMethod::deferred());
        }
    })
    .expect("an adapter");
    let world = app.world_mut();
    let target = world.resource::<LabTarget>().0.clone();
    let mut camera = world.spawn((
        Camera3d::default(),
        target,
        Msaa::Off,
        Transform::from_xyz(0.0, 0.0, 2.6).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    match path {
        Path::Forward => {}
        Path::Prepass => drop(camera.insert((DepthPrepass, NormalPrepass, MotionVectorPrepass))),
        Path::Deferred => drop(camera.insert((DepthPrepass, DeferredPrepass))),
    }
    world.spawn((
        DirectionalLight {
            illuminance: 8000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(1.5, 1.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    let wall = world
        .resource_mut::<Assets<Mesh>>()
        .add(Rectangle::new(6.0, 6.0));
    let gray = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(Color::srgb(0.6, 0.6, 0.6));
    world.spawn((
        Mesh3d(wall),
        MeshMaterial3d(gray),
        Transform::from_xyz(0.0, 0.0, -0.4),
    ));

    let mesh = Mesh::from(Rectangle::new(1.6, 1.6))
        .with_generated_tangents()
        .expect("tangents");
    let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
    let quad = world.spawn(Mesh3d(mesh)).id();
    let base = StandardMaterial {
        alpha_mode: AlphaMode::Mask(0.5),
        perceptual_roughness: 0.9,
        metallic: 0.8,
        emissive: LinearRgba::rgb(0.3, 0.3, 0.3),
        ..default()
    };
    material(world, base, quad);
    app.run_until_ready(MAX_FRAMES).expect("ready");
    app.capture_rgb8().expect("a picture")
}

fn with_wavelets(world: &mut World, base: StandardMaterial, quad: Entity) {
    let Maps {
        color,
        normal,
        mask,
        emissive,
        metallic_roughness,
        occlusion,
    } = maps();
    let extension = WaveletExtension {
        base_color: Some(add_texture(world, &color, WaveletStorage::Blocks)),
        normal: Some(add_texture(world, &normal, WaveletStorage::Blocks)),
        mask: Some(add_texture(world, &mask, WaveletStorage::Blocks)),
        emissive: Some(add_texture(world, &emissive, WaveletStorage::Blocks)),
        metallic_roughness: Some(add_texture(
            world,
            &metallic_roughness,
            WaveletStorage::Blocks,
        )),
        occlusion: Some(add_texture(world, &occlusion, WaveletStorage::Blocks)),
        filter: WaveletFilter::Bilinear,
        address_mode: WaveletAddressMode::ClampToEdge,
        ..default()
    };
    let material = world
        .resource_mut::<Assets<WaveletStandardMaterial>>()
        .add(WaveletStandardMaterial { base, extension });
    world.entity_mut(quad).insert(MeshMaterial3d(material));
}

/// The same material with the reference decoder's pixels in ordinary textures.
fn with_decoded(world: &mut World, base: StandardMaterial, quad: Entity) {
    let Maps {
        color,
        normal,
        mask,
        emissive,
        metallic_roughness,
        occlusion,
    } = maps();
    let mut rgba = decode(&color, 0).to_rgba8(Content::Color);
    for (texel, mask) in rgba
        .iter_mut()
        .zip(decode(&mask, 0).to_rgba8(Content::Gray))
    {
        texel[3] = mask[0];
    }
    let normal = decode(&normal, 0).to_rgba8(Content::Normal);
    let mut image = |texels: Vec<[u8; 4]>, format| {
        let size = Extent3d {
            width: SIZE,
            height: SIZE,
            depth_or_array_layers: 1,
        };
        let data = texels.into_flattened();
        let usage = RenderAssetUsages::RENDER_WORLD;
        let image = Image::new(size, TextureDimension::D2, data, format, usage);
        world.resource_mut::<Assets<Image>>().add(image)
    };
    let base = StandardMaterial {
        base_color_texture: Some(image(rgba, TextureFormat::Rgba8UnormSrgb)),
        normal_map_texture: Some(image(normal, TextureFormat::Rgba8Unorm)),
        emissive_texture: Some(image(
            decode(&emissive, 0).to_rgba8(Content::Color),
            TextureFormat::Rgba8UnormSrgb,
        )),
        metallic_roughness_texture: Some(image(
            decode(&metallic_roughness, 0).to_rgba8(Content::Color),
            TextureFormat::Rgba8Unorm,
        )),
        occlusion_texture: Some(image(
            decode(&occlusion, 0).to_rgba8(Content::Gray),
            TextureFormat::Rgba8Unorm,
        )),
        ..base
    };
    let material = world.resource_mut::<Assets<StandardMaterial>>().add(base);
    world.entity_mut(quad).insert(MeshMaterial3d(material));
}

/// A material with one of its maps.
fn only(map: usize, e: WaveletExtension) -> WaveletExtension {
    let kept = |i, texture| if i == map { texture } else { None };
    WaveletExtension {
        base_color: kept(0, e.base_color),
        emissive: kept(1, e.emissive),
        normal: kept(2, e.normal),
        metallic_roughness: kept(3, e.metallic_roughness),
        occlusion: kept(4, e.occlusion),
        mask: kept(5, e.mask),
        ..e
    }
}

/// Each map alone is a pipeline of its own, is seen, and looks as its decoded image does.
#[test]
fn every_map_alone_is_seen() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let wavelet = |map| {
        render(Path::Forward, |world, base, quad| {
            with_wavelets(world, base, quad);
            let mut query = world.query::<&MeshMaterial3d<WaveletStandardMaterial>>();
            let id = query.single(world).expect("the quad").id();
            let mut materials = world.resource_mut::<Assets<WaveletStandardMaterial>>();
            let mut material = materials.get_mut(id).expect("its material");
            material.extension = only(map, material.extension.clone());
        })
    };
    let decoded = |map| {
        render(Path::Forward, |world, base, quad| {
            with_decoded(world, base, quad);
            let mut query = world.query::<(Entity, &MeshMaterial3d<StandardMaterial>)>();
            let all = query.iter(world).find(|(entity, _)| *entity == quad);
            let id = all.expect("the quad").1.id();
            let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
            let mut material = materials.get_mut(id).expect("its material");
            let m = &mut *material;
            let maps = [
                &mut m.emissive_texture,
                &mut m.normal_map_texture,
                &mut m.metallic_roughness_texture,
                &mut m.occlusion_texture,
            ];
            for (i, texture) in (1..).zip(maps) {
                if i != map {
                    *texture = None;
                }
            }
            if map != 0 {
                m.base_color_texture = None;
            } else {
                // The mask is in its alpha.
                m.alpha_mode = AlphaMode::Opaque;
            }
        })
    };
    let none = wavelet(6);
    for (map, name) in [
        "base color",
        "emissive",
        "normal",
        "metallic-roughness",
        "occlusion",
    ]
    .into_iter()
    .enumerate()
    {
        let ours = wavelet(map);
        let seen = metrics::compare(&none, &ours).expect("equal sizes");
        let right = metrics::compare(&decoded(map), &ours).expect("equal sizes");
        println!(
            "{name}: {:.1} dB, {:.1} dB from no map",
            right.psnr_db, seen.psnr_db
        );
        assert!(seen.psnr_db < right.psnr_db - 6.0, "{name} is not seen");
    }
}

#[test]
fn all_maps_look_as_their_decoded_images_in_every_path() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    for path in [Path::Forward, Path::Prepass, Path::Deferred] {
        let wavelet = render(path, with_wavelets);
        let decoded = render(path, with_decoded);
        let bare = render(path, |world, base, quad| {
            let material = world.resource_mut::<Assets<StandardMaterial>>().add(base);
            world.entity_mut(quad).insert(MeshMaterial3d(material));
        });
        let effect = metrics::compare(&bare, &wavelet).expect("equal sizes");
        let (flips, psnr_db) = apart_from_flips(&decoded, &wavelet);
        println!(
            "{path:?}: {psnr_db:.1} dB, {flips} flips, {:.1} dB against no maps",
            effect.psnr_db
        );
        assert!(flips <= 12, "{path:?}: {flips} pixels");
        assert!(psnr_db > 50.0, "{path:?}: {psnr_db} dB");
        assert!(effect.psnr_db < 25.0, "{path:?}: the maps are not seen");
    }
}

/// Pixels at the edges of the mask that fall to the other side of the cutoff, and the PSNR in dB of
/// all others.
fn apart_from_flips(a: &RgbImage, b: &RgbImage) -> (u32, f64) {
    let (mut flips, mut sum, mut count) = (0, 0.0, 0.0);
    for (a, b) in a.pixels().zip(b.pixels()) {
        let differences = [0, 1, 2].map(|c: usize| f64::from(a[c].abs_diff(b[c])));
        if differences.iter().any(|d| *d > 24.0) {
            flips += 1;
        } else {
            sum += differences.map(|d| d * d).iter().sum::<f64>();
            count += 3.0;
        }
    }
    (flips, 10.0 * (255.0 * 255.0 * count / sum).log10())
}
