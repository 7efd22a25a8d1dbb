//! Files, good and bad, and adapters without BC.

use std::sync::{
    Arc,
    atomic::{AtomicU32, Ordering},
};

use bevy::{
    asset::{AssetServer, LoadState, ReflectAsset},
    ecs::reflect::AppTypeRegistry,
    prelude::*,
    reflect::{PartialReflect, ReflectRef, std_traits::ReflectDefault},
    render::renderer::RenderDevice,
};
use bevy_frugal_lab::{
    content,
    headless::{HeadlessApp, HeadlessError, HeadlessSettings, LabTarget, Rgba32FImage},
};
use bevy_wavelet_tex::{
    WaveletExtension, WaveletFilter, WaveletLoaderSettings, WaveletStandardMaterial,
    WaveletStorage, WaveletTexture,
    asset::WaveletTextureLoader,
    codec::{
        color::srgb_from_linear,
        decoder::decode,
        image::{ColorSpace, Content, WaveletImage},
    },
    file,
};
use image::RgbImage;

use super::{
    scene::{
        MAX_FRAMES, STEP, Viewer, app, chroma_rounding, difference, driver_linear_from_srgb,
        encoded, gpu_with_all_planes, linear, picture,
    },
    twin::rectangle,
};
use crate::support::{Folder, gpu, psnr, wait_for, warned_of};

fn file_bytes() -> Vec<u8> {
    file::write(&encoded(&picture(), Content::Color, ColorSpace::Srgb))
}

/// Loads `a.wtex` and waits for it.
fn load(
    settings: HeadlessSettings,
    decode_on_load: bool,
) -> (
    HeadlessApp,
    Handle<WaveletTexture>,
    Result<u32, HeadlessError>,
) {
    let mut app = app(settings);
    let builder = app.world().load_builder();
    let texture = builder
        .with_settings(move |s: &mut WaveletLoaderSettings| s.decode_on_load = decode_on_load)
        .load("a.wtex");
    app.await_asset(&texture);
    let ready = app.run_until_ready(MAX_FRAMES);
    (app, texture, ready)
}

fn storage(app: &HeadlessApp, texture: &Handle<WaveletTexture>) -> WaveletStorage {
    let textures = app.world().resource::<Assets<WaveletTexture>>();
    textures.get(texture).expect("loaded").storage
}

#[test]
fn a_file_is_kept_as_blocks_decoded_on_demand_and_decoded_without_bc() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let folder = Folder::new("storage").with("a.wtex", &file_bytes());

    let (app, texture, ready) = load(folder.settings(16, 16), false);
    ready.expect("ready");
    assert_eq!(storage(&app, &texture), WaveletStorage::Blocks);
    let server = app.world().resource::<AssetServer>();
    assert!(server.get_handle::<Image>("a.wtex#luma").is_some());
    assert!(server.get_handle::<Image>("a.wtex#chroma").is_some());
    drop(app);

    let (app, texture, ready) = load(folder.settings(16, 16), true);
    ready.expect("ready");
    assert_eq!(storage(&app, &texture), WaveletStorage::Decoded);
    drop(app);

    let without_bc = HeadlessSettings {
        disabled_features: wgpu::Features::TEXTURE_COMPRESSION_BC,
        ..folder.settings(16, 16)
    };
    let (app, texture, ready) = load(without_bc, false);
    ready.expect("ready");
    assert!(
        !app.features()
            .contains(wgpu::Features::TEXTURE_COMPRESSION_BC)
    );
    assert_eq!(storage(&app, &texture), WaveletStorage::Decoded);
    assert!(warned_of("lacks TEXTURE_COMPRESSION_BC"));
}

#[test]
fn a_setting_of_the_largest_side_changes_textures_that_are_shown() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let folder = Folder::new("max-size").with("a.wtex", &file_bytes());
    let mut app = app(folder.settings(16, 16));
    let chosen = Arc::new(AtomicU32::new(u32::MAX));
    let read = chosen.clone();
    let server = app.world().resource::<AssetServer>().clone();
    let texture: Handle<WaveletTexture> = server
        .load_builder()
        .with_settings(move |settings: &mut WaveletLoaderSettings| {
            settings.max_size = Some(read.load(Ordering::Relaxed));
        })
        .load("a.wtex");
    let mut gpu_bytes = Vec::new();
    for (most, size) in [
        (u32::MAX, [93, 61]),
        (50, [46, 30]),
        (8, [5, 3]),
        (93, [93, 61]),
    ] {
        chosen.store(most, Ordering::Relaxed);
        server.reload("a.wtex");
        let (storage, bytes) = wait_for(&mut app, |app| {
            let textures = app.world().resource::<Assets<WaveletTexture>>();
            let texture = textures.get(&texture).filter(|t| t.size == size)?;
            Some((texture.storage, texture.gpu_bytes))
        });
        assert_eq!(storage, WaveletStorage::Blocks);
        gpu_bytes.push(bytes);
    }
    println!("bytes on the GPU: {gpu_bytes:?}");
    assert!(gpu_bytes[1] * 3 < gpu_bytes[0] && gpu_bytes[2] < gpu_bytes[1]);
    assert_eq!(gpu_bytes[3], gpu_bytes[0]);
}

#[test]
fn textures_and_materials_can_be_inspected() {
    let _gpu = gpu();
    let app = app(HeadlessSettings::with_size(1, 1));
    let registry = app.world().resource::<AppTypeRegistry>().read();
    for id in [
        std::any::TypeId::of::<WaveletTexture>(),
        std::any::TypeId::of::<WaveletStandardMaterial>(),
    ] {
        assert!(registry.get_type_data::<ReflectAsset>(id).is_some());
    }
    let id = std::any::TypeId::of::<WaveletExtension>();
    let default = registry.get_type_data::<ReflectDefault>(id);
    let mut extension = default.expect("its default").default();
    let filter = WaveletFilter::Anisotropic;
    let bevy::reflect::ReflectMut::Struct(fields) = extension.reflect_mut() else {
        panic!("not a struct");
    };
    let field = fields.field_mut("filter").expect("a field");
    field.apply(filter.as_partial_reflect());
    let extension = extension.downcast::<WaveletExtension>().expect("its type");
    assert_eq!(extension.filter, filter);
    let ReflectRef::Struct(fields) = extension.reflect_ref() else {
        panic!("not a struct");
    };
    assert!(fields.field("base_color").is_some());
}

#[test]
fn a_texture_beyond_the_limits_of_the_device_is_decoded_and_smaller() {
    let _gpu = gpu();
    let folder = Folder::new("limits").with("a.wtex", &file_bytes());
    let load = |limit| {
        let mut app = app(folder.settings(16, 16));
        let server = app.world().resource::<AssetServer>();
        server.register_loader(WaveletTextureLoader::new(None, limit));
        let texture: Handle<WaveletTexture> = app.load("a.wtex");
        app.run_until_ready(MAX_FRAMES).expect("ready");
        let textures = app.world().resource::<Assets<WaveletTexture>>();
        let texture = textures.get(&texture).expect("loaded");
        (texture.storage, texture.size)
    };
    assert_eq!(load(128), (WaveletStorage::Blocks, [93, 61]));
    // Of the luma of 93 x 61 pixels, level 0 takes 48 x 32 texels, and the others lie beside it or below.
    assert_eq!(load(47), (WaveletStorage::Decoded, [46, 30]));
    assert!(warned_of("its coefficients with all mips take"));
    assert!(warned_of("is shown at 46 x 30 pixels instead of 93 x 61"));
}

#[test]
fn a_material_beyond_the_limit_of_bound_textures_is_decoded_and_shown() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let normals = content::bricks(64, 64, 3).normal;
    let normals = encoded(&normals, Content::Normal, ColorSpace::Linear);
    let folder = Folder::new("bound")
        .with("a.wtex", &file_bytes())
        .with("normals.wtex", &file::write(&normals));
    let show = |limits| {
        let settings = HeadlessSettings {
            constrained_limits: limits,
            ..folder.settings(16, 16)
        };
        let mut app = app(settings);
        let [color, normal] = ["a.wtex", "normals.wtex"].map(|name| app.load(name));
        let world = app.world_mut();
        let target = world.resource::<LabTarget>().0.clone();
        world.spawn((
            Camera3d::default(),
            target,
            Transform::from_xyz(0.0, 0.0, 1.0),
        ));
        world.spawn((DirectionalLight::default(), Transform::default()));
        let extension = WaveletExtension {
            base_color: Some(color.clone()),
            normal: Some(normal.clone()),
            ..default()
        };
        let base = StandardMaterial::default();
        let material =
            world.add_asset::<WaveletStandardMaterial>(WaveletStandardMaterial { base, extension });
        let quad = rectangle(world, 2.0);
        world.entity_mut(quad).insert(MeshMaterial3d(material));
        app.run_until_ready(MAX_FRAMES).expect("ready");
        app.render_frames(2).expect("frames");
        let picture = app.capture_rgb8().expect("a picture");
        let storages = [color, normal].map(|texture| storage(&app, &texture));
        let limits = app.world().resource::<RenderDevice>().limits();
        (picture, storages, limits)
    };
    let (expected, storages, limits) = show(None);
    assert_eq!(storages, [WaveletStorage::Blocks; 2]);
    // Enough for those of Bevy with all features that have textures, but not for 16 more.
    let (picture, storages, _) = show(Some(wgpu::Limits {
        max_sampled_textures_per_shader_stage: 32,
        ..limits
    }));
    // Normals have one texture.
    assert_eq!(storages, [WaveletStorage::Decoded, WaveletStorage::Blocks]);
    assert!(warned_of("the device binds at most 32 textures in a stage"));
    let found = psnr(&expected, &picture);
    let to_black = psnr(&expected, &RgbImage::new(16, 16));
    assert!(
        found > 40.0 && to_black < 20.0,
        "{found} dB, {to_black} dB to black"
    );
}

#[test]
fn without_bc_the_picture_is_the_same() {
    let folder = Folder::new("without-bc").with("a.wtex", &file_bytes());
    let viewer = |settings| Viewer::with_settings(gpu(), [93, 61], settings);
    // One pixel each: with weights that round, the bound below would be none.
    let show = |viewer: &mut Viewer| {
        let texture = viewer.app.load("a.wtex");
        viewer.show_texture(texture)
    };
    let without = show(&mut viewer(HeadlessSettings {
        disabled_features: wgpu::Features::TEXTURE_COMPRESSION_BC,
        ..folder.settings(16, 16)
    }));
    let mut viewer = viewer(folder.settings(16, 16));
    let with = show(&mut viewer);
    let image = encoded(&picture(), Content::Color, ColorSpace::Srgb);
    let by_driver = viewer.decoded(&image, 0);
    let linear = driver_linear_from_srgb(&viewer.app);
    let exact = decode(&image, 0);
    // Half floats on the way to the target: relative 2^-11 each, for sRGB at 1 times 1.055 / 2.4.
    let halves = 2.0 * 1.055 / 2.4 / 2048.0;
    for (pixel, (a, b)) in with.pixels.iter().zip(&without.pixels).enumerate() {
        for channel in 0..3 {
            let [a, b] = [a, b].map(|p| srgb_from_linear(p[channel]));
            // The decoder on the CPU has exact texels, but then rounds the pixels to bytes.
            let texels = by_driver.pixels[pixel][channel] - exact.pixels[pixel][channel];
            // They are stored in sRGB, which the driver linearises.
            let byte = (exact.pixels[pixel][channel] * 255.0).round() as usize;
            let srgb = srgb_from_linear(linear[byte]) - byte as f32 * STEP;
            let bound = texels.abs() + 0.5 * STEP + srgb.abs() + halves + chroma_rounding(&image);
            assert!((a - b).abs() <= bound, "pixel {pixel}: {a} and {b}");
        }
    }
}

#[test]
fn a_bad_file_is_named_and_the_app_goes_on() {
    let _gpu = gpu();
    let good = file_bytes();
    let cases: [(&str, Vec<u8>, &str); 4] = [
        ("empty", Vec::new(), "not a wavelet texture"),
        ("truncated", good[..good.len() / 2].to_vec(), "cut short"),
        (
            "png",
            b"\x89PNG\r\n\x1a\n".to_vec(),
            "not a wavelet texture",
        ),
        (
            "newer",
            [&good[..8], &[9, 0], &good[10..]].concat(),
            "version 9 is newer",
        ),
    ];
    for (name, bytes, reason) in cases {
        let folder = Folder::new(name).with("a.wtex", &bytes);
        let (mut app, texture, ready) = load(folder.settings(16, 16), false);
        let error = ready.expect_err(name).to_string();
        assert!(
            error.contains("a.wtex") && error.contains(reason),
            "{name}: {error}"
        );
        let server = app.world().resource::<AssetServer>();
        assert!(matches!(server.load_state(&texture), LoadState::Failed(_)));
        app.render_frames(2).expect("the app goes on");
    }
}

#[test]
fn a_texture_that_is_loaded_anew_is_shown() {
    let Some(gpu) = gpu_with_all_planes() else {
        return;
    };
    let [first, second] = [3, 9].map(|seed| content::photo_like(64, 48, seed));
    let first_image = encoded(&first, Content::Color, ColorSpace::Srgb);
    let folder = Folder::new("reload").with("a.wtex", &file::write(&first_image));
    let mut viewer = Viewer::with_settings(gpu, [64, 48], folder.settings(16, 16));
    let is = |viewer: &Viewer, shown: &Rgba32FImage, image: &WaveletImage| {
        let (_, pixels) = linear(image, viewer.decoded(image, 0));
        let difference = difference(shown, |x, y| pixels[(y * 64 + x) as usize]);
        difference.largest <= 2.0 * STEP + chroma_rounding(image)
    };
    let texture = viewer.app.load("a.wtex");
    let shown = viewer.show_texture(texture);
    assert!(is(&viewer, &shown, &first_image));
    for next in [
        encoded(&second, Content::Color, ColorSpace::Srgb),
        // Of another content: other images in other slots.
        encoded(&first, Content::Gray, ColorSpace::Srgb),
    ] {
        std::fs::write(folder.0.join("a.wtex"), file::write(&next)).expect("written");
        let server = viewer.app.world().resource::<AssetServer>();
        server.reload("a.wtex");
        let mut is_shown = false;
        for _ in 0..100 {
            viewer.app.render_frames(1).expect("frames");
            let shown = viewer.app.capture_f32().expect("a picture");
            if is(&viewer, &shown, &next) {
                is_shown = true;
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        assert!(is_shown, "{:?} is not shown", next.content);
    }
}
