//! Files, good and bad, and adapters without BC.

use std::{
    path::PathBuf,
    sync::{
        Arc,
        atomic::{AtomicU32, Ordering},
    },
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
    headless::{AwaitedAssets, HeadlessApp, HeadlessError, HeadlessSettings, LabTarget},
    metrics::compare,
};
use bevy_wavelet_tex::{
    WaveletExtension, WaveletFilter, WaveletLoaderSettings, WaveletStandardMaterial,
    WaveletStorage, WaveletTexPlugin, WaveletTexture,
    asset::WaveletTextureLoader,
    codec::{
        color::srgb_from_linear,
        decoder::decode,
        image::{ColorSpace, Content},
    },
    file,
};
use image::RgbImage;

use super::{
    driver::Driver,
    modes::chroma_rounding,
    scene::{MAX_FRAMES, STEP, decoded_by, encoded, gpu_with_all_planes, picture, render_quad},
};
use crate::support::{gpu, logs::warned_of};

/// A folder of assets that goes with the test.
pub struct Folder(pub PathBuf);

impl Folder {
    pub fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("wtex-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a temporary folder");
        Self(folder)
    }

    pub fn with(self, name: &str, bytes: &[u8]) -> Self {
        std::fs::write(self.0.join(name), bytes).expect("a file");
        self
    }

    pub fn settings(&self) -> HeadlessSettings {
        HeadlessSettings {
            asset_folder: self.0.to_string_lossy().into_owned(),
            ..HeadlessSettings::with_size(16, 16)
        }
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

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
    let mut app = HeadlessApp::new(settings, |app| {
        app.add_plugins(WaveletTexPlugin);
    })
    .expect("adapter");
    let texture: Handle<WaveletTexture> = app
        .world()
        .resource::<AssetServer>()
        .load_builder()
        .with_settings(move |s: &mut WaveletLoaderSettings| s.decode_on_load = decode_on_load)
        .load("a.wtex");
    app.world_mut()
        .resource_mut::<AwaitedAssets>()
        .0
        .push(texture.clone().untyped());
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

    let (app, texture, ready) = load(folder.settings(), false);
    ready.expect("ready");
    assert_eq!(storage(&app, &texture), WaveletStorage::Blocks);
    let server = app.world().resource::<AssetServer>();
    assert!(server.get_handle::<Image>("a.wtex#luma").is_some());
    assert!(server.get_handle::<Image>("a.wtex#chroma").is_some());
    drop(app);

    let (app, texture, ready) = load(folder.settings(), true);
    ready.expect("ready");
    assert_eq!(storage(&app, &texture), WaveletStorage::Decoded);
    drop(app);

    let without_bc = HeadlessSettings {
        disabled_features: wgpu::Features::TEXTURE_COMPRESSION_BC,
        ..folder.settings()
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
    let _gpu = gpu();
    let folder = Folder::new("max-size").with("a.wtex", &file_bytes());
    let mut app = HeadlessApp::new(folder.settings(), |app| {
        app.add_plugins(WaveletTexPlugin);
    })
    .expect("adapter");
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
        let mut found = [0; 2];
        for _ in 0..500 {
            app.render_frames(1).expect("frames");
            let textures = app.world().resource::<Assets<WaveletTexture>>();
            if let Some(texture) = textures.get(&texture) {
                found = texture.size;
                if found == size {
                    assert_eq!(texture.storage, WaveletStorage::Blocks);
                    gpu_bytes.push(texture.gpu_bytes);
                    break;
                }
            }
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        assert_eq!(found, size, "at most {most}");
    }
    println!("bytes on the GPU: {gpu_bytes:?}");
    assert!(gpu_bytes[1] * 3 < gpu_bytes[0] && gpu_bytes[2] < gpu_bytes[1]);
    assert_eq!(gpu_bytes[3], gpu_bytes[0]);
}

#[test]
fn textures_and_materials_can_be_inspected() {
    let _gpu = gpu();
    let app = HeadlessApp::new(HeadlessSettings::with_size(1, 1), |app| {
        app.add_plugins(WaveletTexPlugin);
    })
    .expect("adapter");
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
        let mut app = HeadlessApp::new(folder.settings(), |app| {
            app.add_plugins(WaveletTexPlugin);
        })
        .expect("adapter");
        let server = app.world().resource::<AssetServer>();
        server.register_loader(WaveletTextureLoader::new(None, limit));
        let texture: Handle<WaveletTexture> = server.load("a.wtex");
        let mut awaited = app.world_mut().resource_mut::<AwaitedAssets>();
        awaited.0.push(texture.clone().untyped());
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
            ..folder.settings()
        };
        let mut app = HeadlessApp::new(settings, |app| {
            app.add_plugins(WaveletTexPlugin);
        })
        .expect("adapter");
        let world = app.world_mut();
        let target = world.resource::<LabTarget>().0.clone();
        world.spawn((
            Camera3d::default(),
            target,
            Transform::from_xyz(0.0, 0.0, 1.0),
        ));
        world.spawn((DirectionalLight::default(), Transform::default()));
        let server = world.resource::<AssetServer>();
        let [color, normal] = ["a.wtex", "normals.wtex"].map(|name| server.load(name));
        let mut awaited = world.resource_mut::<AwaitedAssets>();
        awaited
            .0
            .extend([&color, &normal].map(|t| t.clone().untyped()));
        let extension = WaveletExtension {
            base_color: Some(color.clone()),
            normal: Some(normal.clone()),
            ..default()
        };
        let base = StandardMaterial::default();
        let mut materials = world.resource_mut::<Assets<WaveletStandardMaterial>>();
        let material = materials.add(WaveletStandardMaterial { base, extension });
        let quad = Mesh::from(Rectangle::new(2.0, 2.0)).with_generated_tangents();
        let quad = world
            .resource_mut::<Assets<Mesh>>()
            .add(quad.expect("tangents"));
        world.spawn((Mesh3d(quad), MeshMaterial3d(material)));
        app.run_until_ready(MAX_FRAMES).expect("ready");
        app.render_frames(2).expect("frames");
        let picture = app.capture_rgb8().expect("a picture");
        let storages = [color, normal].map(|texture| storage(&app, &texture));
        let limits = app.world().resource::<RenderDevice>().limits();
        (picture, storages, limits)
    };
    let (wanted, storages, limits) = show(None);
    assert_eq!(storages, [WaveletStorage::Blocks; 2]);
    // Enough for those of Bevy with all features that have textures, but not for 16 more.
    let (picture, storages, _) = show(Some(wgpu::Limits {
        max_sampled_textures_per_shader_stage: 32,
        ..limits
    }));
    // Normals have one texture.
    assert_eq!(storages, [WaveletStorage::Decoded, WaveletStorage::Blocks]);
    assert!(warned_of("the device binds at most 32 textures in a stage"));
    let error = compare(&wanted, &picture).expect("equal sizes");
    let contrast = compare(&wanted, &RgbImage::new(16, 16)).expect("equal sizes");
    assert!(
        error.psnr_db > 40.0 && contrast.psnr_db < 20.0,
        "{} dB, {} dB to black",
        error.psnr_db,
        contrast.psnr_db
    );
}

#[test]
fn without_bc_the_picture_is_the_same() {
    let _gpu = gpu();
    let folder = Folder::new("without-bc").with("a.wtex", &file_bytes());
    let show = |settings: HeadlessSettings| {
        // One pixel each: with weights that round, the bound below would be none.
        render_quad([93, 61], 1.0, WaveletFilter::Nearest, settings, |world| {
            let texture = world
                .resource::<AssetServer>()
                .load::<WaveletTexture>("a.wtex");
            world
                .resource_mut::<AwaitedAssets>()
                .0
                .push(texture.clone().untyped());
            texture
        })
    };
    let with = show(folder.settings());
    let without = show(HeadlessSettings {
        disabled_features: wgpu::Features::TEXTURE_COMPRESSION_BC,
        ..folder.settings()
    });
    let image = encoded(&picture(), Content::Color, ColorSpace::Srgb);
    let driver = Driver::new();
    let by_driver = decoded_by(&driver, &image, 0);
    let linear = driver.linear_from_srgb();
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
        let (mut app, texture, ready) = load(folder.settings(), false);
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
