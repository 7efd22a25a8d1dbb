//! Images that become wavelet textures when assets are processed, without a GPU, and the crate beside Bevy's own saver.

use std::{path::Path, process::Command, time::Duration};

use bevy::{
    app::TaskPoolPlugin,
    asset::{AssetMode, AssetServer, LoadState, processor::AssetProcessor},
    image::{CompressedImageFormats, Image, ImageLoader},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_frugal_lab::content;
use bevy_wavelet_tex::{
    WaveletProcessor, WaveletQuality, WaveletRole, WaveletSaver, WaveletSaverSettings,
    WaveletTexture,
    asset::WaveletTextureLoader,
    codec::{
        decoder::decode,
        image::{ColorSpace, Content},
        rate::Rate,
    },
    file,
};
use image::{DynamicImage, ImageFormat, RgbImage};

use crate::support::{Folder, image_file, psnr, skipped};

/// The file of the example and of the page about encoding, for a smaller normal map.
fn meta() -> String {
    let meta = include_str!("../../../examples/source_assets/bricks.jpg.meta");
    meta.replace("role: Color", "role: Normal")
        .replace("Some(1024)", "Some(32)")
}

#[test]
fn a_meta_file_makes_an_image_a_wavelet_texture() {
    let normals = content::bricks(64, 48, 3).normal;
    processed("wall.png", &image_file(normals.clone(), ImageFormat::Png));
    processed("wall.jpg", &image_file(normals.clone(), ImageFormat::Jpeg));
}

/// Processes and loads a normal map of 64 x 48 pixels.
fn processed(name: &str, bytes: &[u8]) {
    let folder = Folder::new(name);
    let assets = folder.0.join("assets");
    std::fs::create_dir_all(&assets).expect("a folder");
    std::fs::write(assets.join(name), bytes).expect("a file");
    std::fs::write(assets.join(format!("{name}.meta")), meta()).expect("a file");

    let mut app = App::new();
    app.add_plugins((
        TaskPoolPlugin::default(),
        AssetPlugin {
            file_path: assets.to_string_lossy().into_owned(),
            processed_file_path: folder.0.join("processed").to_string_lossy().into_owned(),
            mode: AssetMode::Processed,
            watch_for_changes_override: Some(false),
            use_asset_processor_override: Some(true),
            ..default()
        },
    ))
    .init_asset::<Image>()
    .init_asset::<WaveletTexture>()
    .register_asset_loader(ImageLoader::new(CompressedImageFormats::NONE))
    .register_asset_loader(WaveletTextureLoader::new(None, 8192))
    .register_asset_processor::<WaveletProcessor>(WaveletSaver.into());
    app.finish();
    app.cleanup();
    assert!(app.world().contains_resource::<AssetProcessor>());
    let server = app.world().resource::<AssetServer>();
    let texture: Handle<WaveletTexture> = server.load(name.to_string());
    for _ in 0..1000 {
        app.update();
        let server = app.world().resource::<AssetServer>();
        match server.load_state(&texture) {
            LoadState::Loaded => break,
            LoadState::Failed(error) => panic!("{error}"),
            _ => std::thread::sleep(Duration::from_millis(5)),
        }
    }
    let textures = app.world().resource::<Assets<WaveletTexture>>();
    let texture = textures.get(&texture).expect("loaded in time");
    assert_eq!(texture.content, Content::Normal);
    assert_eq!(texture.color_space, ColorSpace::Linear);
    assert_eq!(texture.size, [32, 24]);
    let processed = std::fs::read(folder.0.join("processed").join(name)).expect("processed");
    assert_eq!(file::read(&processed).expect("a texture").size, [32, 24]);
}

fn bevy_image(size: [u32; 2], format: TextureFormat, data: Vec<u8>) -> Image {
    let size = Extent3d {
        width: size[0],
        height: size[1],
        depth_or_array_layers: 1,
    };
    let mut image = Image::new_uninit(size, TextureDimension::D2, format, default());
    image.data = Some(data);
    image
}

#[test]
fn the_saver_keeps_given_mips_and_reads_every_plain_format() {
    // Level 1 is another picture, as a hand-made mip could be.
    let levels = [vec![200u8; 64 * 64 * 4], vec![40u8; 32 * 32 * 4]].concat();
    let image = bevy_image([64, 64], TextureFormat::Rgba8UnormSrgb, levels);
    let settings = WaveletSaverSettings::default();
    let bytes = settings.encode(&image, "a.png").expect("encoded");
    let texture = file::read(&bytes).expect("a texture");
    assert_eq!(texture.levels, 2);
    for (level, expected) in [(0, 200), (1, 40)] {
        let decoded = decode(&texture, level);
        for pixel in decoded.to_rgba8(texture.content) {
            assert!(
                pixel[..3].iter().all(|v| v.abs_diff(expected) <= 1),
                "{pixel:?}"
            );
        }
    }
    for (format, bytes) in [
        (TextureFormat::R8Unorm, 1),
        (TextureFormat::Rg8Unorm, 2),
        (TextureFormat::Rgba8Unorm, 4),
        (TextureFormat::R16Unorm, 2),
        (TextureFormat::Rgba16Unorm, 8),
    ] {
        let image = bevy_image([9, 5], format, vec![100; 45 * bytes]);
        let file = settings.encode(&image, "b.png").expect("encoded");
        assert_eq!(
            file::read(&file).expect("a texture").size,
            [9, 5],
            "{format:?}"
        );
    }
}

#[test]
fn a_game_reads_files_compressed_with_zstandard() {
    let bytes = include_bytes!("../../../fuzz/corpus/read/zstd.wtex");
    let texture = file::read(bytes).expect("a texture");
    assert_eq!(texture.size, [9, 5]);
    assert!(texture.gpu_bytes() > 0);
}

#[test]
fn two_channels_are_unit_normals() {
    let pairs = (0..16 * 16).flat_map(|i| [128 + (i % 16) as u8, 128 - (i / 16) as u8]);
    let image = bevy_image([16, 16], TextureFormat::Rg8Unorm, pairs.collect());
    let settings = WaveletSaverSettings {
        role: WaveletRole::Normal,
        quality: WaveletQuality::Rate(Rate::Normal8),
        ..default()
    };
    let bytes = settings.encode(&image, "n.ktx2").expect("encoded");
    let texture = file::read(&bytes).expect("a texture");
    let decoded = decode(&texture, 0);
    let pairs = image.data.as_deref().expect("pixels").as_chunks::<2>().0;
    for ([x, y, z, _], [r, g]) in decoded.to_rgba8(texture.content).into_iter().zip(pairs) {
        assert!(
            x.abs_diff(*r) <= 2 && y.abs_diff(*g) <= 2,
            "{x} {y}, {r} {g}"
        );
        assert!(z > 250, "{z}");
    }
}

#[test]
fn a_wanted_quality_takes_the_smallest_rate_that_reaches_it() {
    let photo = content::photo_like(96, 64, 5);
    let rgba = DynamicImage::from(photo.clone()).into_rgba8().into_raw();
    let image = bevy_image([96, 64], TextureFormat::Rgba8UnormSrgb, rgba);
    let saved = |quality| {
        let settings = WaveletSaverSettings {
            quality,
            ..default()
        };
        let bytes = settings.encode(&image, "a.png").expect("encoded");
        let texture = file::read(&bytes).expect("a texture");
        let decoded = decode(&texture, 0);
        let decoded = decoded.to_rgba8(texture.content);
        let rgb = decoded.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]);
        let picture = RgbImage::from_raw(96, 64, rgb.collect()).expect("as many pixels");
        (texture.gpu_bytes(), psnr(&photo, &picture))
    };
    let rates: Vec<_> = Rate::of(Content::Color)
        .map(|rate| saved(WaveletQuality::Rate(rate)))
        .collect();
    let best = rates.iter().map(|rate| rate.1).fold(0.0, f64::max);
    let all = rates.iter().map(|rate| rate.1 - 0.01);
    for min_psnr in all.chain([0.0, best + 10.0]) {
        let expected = rates.iter().find(|rate| rate.1 >= min_psnr);
        let expected = expected.or(rates.last()).expect("a rate");
        assert_eq!(
            saved(WaveletQuality::MinPsnr(min_psnr)),
            *expected,
            "{min_psnr}"
        );
    }
}

#[test]
fn what_cannot_be_saved_is_named() {
    let floats = bevy_image([2, 2], TextureFormat::Rgba32Float, vec![0; 64]);
    let bytes = bevy_image([2, 2], TextureFormat::Rgba8Unorm, vec![0; 16]);
    let short = bevy_image([2, 2], TextureFormat::Rgba8Unorm, vec![0; 8]);
    let wrong_rate = WaveletSaverSettings {
        role: WaveletRole::Mask,
        quality: WaveletQuality::Rate(Rate::Color3),
        ..default()
    };
    let any = WaveletSaverSettings::default();
    let blocks = bevy_image([4, 4], TextureFormat::Bc7RgbaUnormSrgb, vec![0; 16]);
    for (settings, image, words) in [
        (any, &floats, "Rgba32Float"),
        (any, &blocks, "block-compressed: encode the original"),
        (any, &short, "should have 4 pixels"),
        (wrong_rate, &bytes, "possible are gray2, gray3"),
    ] {
        let error = settings
            .encode(image, "x.png")
            .expect_err("refused")
            .to_string();
        assert!(
            error.contains("'x.png'") && error.contains(words),
            "{error}"
        );
    }
}

/// Features of Bevy can bring the same native libraries, and cargo refuses two crates that link one: what it says when
/// it resolves a game with a feature of Bevy and the crate with these features.
fn resolve(feature: &str, features: &str) -> Result<(), String> {
    let workspace = Path::new(bevy_frugal_lab::ROOT);
    let name = format!("resolve-{feature}-{features}");
    let folder = Folder::new(&name).with("lib.rs", b"");
    let manifest = format!(
        "[package]\n\
         name = 'probe'\n\
         edition = '2024'\n\
         [lib]\n\
         path = 'lib.rs'\n\
         [workspace]\n\
         [dependencies]\n\
         bevy = {{ version = '0.20.1', default-features = false, features = ['{feature}'] }}\n\
         bevy_wavelet_tex = {{ path = '{}', features = [{features}] }}\n",
        workspace.join("crates/bevy_wavelet_tex").display()
    );
    let lock = std::fs::read(workspace.join("Cargo.lock")).expect("a lock file");
    let folder = folder
        .with("Cargo.toml", manifest.as_bytes())
        .with("Cargo.lock", &lock);
    let cargo = std::env::var_os("CARGO").unwrap_or("cargo".into());
    let mut update = Command::new(cargo);
    // This downloads nothing but the registry's entries of what is new.
    update
        .args(["update", "--workspace"])
        .current_dir(&folder.0);
    let output = update.output().expect("cargo runs");
    if output.status.success() {
        return Ok(());
    }
    Err(String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn a_game_can_have_bevys_compressed_image_saver() {
    match resolve("compressed_image_saver", "") {
        Ok(()) => {}
        Err(error) if error.contains("links to the native library") => panic!("{error}"),
        Err(error) => return skipped(&format!("bevy_wavelet_tex beside Bevy: {error}")),
    }
    // The test would see a conflict, which only the encoder has.
    let error = resolve("compressed_image_saver", "'encode'").expect_err("two BC7 encoders");
    assert!(error.contains("`bc7e`"), "{error}");
}
