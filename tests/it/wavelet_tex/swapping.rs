//! Textures that change while they are shown: loaded anew, or put in the place of others.

use bevy::{asset::AssetServer, math::Vec2, prelude::*};
use bevy_frugal_lab::{
    content,
    headless::{AwaitedAssets, Rgba32FImage},
};
use bevy_wavelet_tex::{
    WaveletExtension, WaveletFilter, WaveletGltf, WaveletStandardMaterial, WaveletTexture,
    codec::image::{ColorSpace, Content, WaveletImage},
    file,
};
use image::{DynamicImage, ImageFormat, RgbImage};

use super::{
    driver::Driver,
    loading::Folder,
    modes::chroma_rounding,
    scene::{STEP, decoded_by, difference, encoded, gpu_with_all_planes, linear},
    viewer::Viewer,
};

const SIZE: [u32; 2] = [64, 48];

fn pictures() -> [RgbImage; 2] {
    [3, 9].map(|seed| content::photo_like(SIZE[0], SIZE[1], seed))
}

/// Whether a picture is that texture, unlit and pixel by pixel.
fn is(shown: &Rgba32FImage, image: &WaveletImage, driver: &Driver) -> bool {
    let (_, pixels) = linear(image, decoded_by(driver, image, 0));
    let found = difference(shown, |x, y| pixels[(y * SIZE[0] + x) as usize]);
    found.largest <= 2.0 * STEP + chroma_rounding(image)
}

fn await_texture(viewer: &mut Viewer, path: &str) -> Handle<WaveletTexture> {
    let world = viewer.app.world_mut();
    let texture = world.resource::<AssetServer>().load(path.to_string());
    let mut awaited = world.resource_mut::<AwaitedAssets>();
    awaited.0.push(texture.clone().untyped());
    texture
}

#[test]
fn a_texture_that_is_loaded_anew_is_shown() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let driver = Driver::new();
    let images = pictures().map(|p| encoded(&p, Content::Color, ColorSpace::Srgb));
    // Of another content and size: other images in other slots.
    let gray = encoded(&pictures()[0], Content::Gray, ColorSpace::Srgb);
    let folder = Folder::new("reload").with("a.wtex", &file::write(&images[0]));
    let mut viewer = Viewer::with_settings(SIZE, folder.settings());
    let texture = await_texture(&mut viewer, "a.wtex");
    let shown = viewer.show_material(WaveletStandardMaterial {
        base: StandardMaterial {
            unlit: true,
            ..default()
        },
        extension: WaveletExtension {
            base_color: Some(texture),
            filter: WaveletFilter::Nearest,
            ..default()
        },
    });
    assert!(is(&shown, &images[0], &driver));
    for next in [&images[1], &gray] {
        std::fs::write(folder.0.join("a.wtex"), file::write(next)).expect("written");
        viewer
            .app
            .world()
            .resource::<AssetServer>()
            .reload("a.wtex");
        let mut shown_at_last = false;
        for _ in 0..100 {
            viewer.app.render_frames(1).expect("frames");
            let shown = viewer.app.capture_f32().expect("a picture");
            if is(&shown, next, &driver) {
                shown_at_last = true;
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        assert!(shown_at_last, "{:?} is not shown", next.content);
    }
}

#[test]
fn a_gltf_scene_takes_the_textures_beside_its_images() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let driver = Driver::new();
    let [original, other] = pictures();
    let mut png = std::io::Cursor::new(Vec::new());
    DynamicImage::from(original)
        .write_to(&mut png, ImageFormat::Png)
        .expect("a PNG");
    // Another picture, so that one sees which is shown.
    let image = encoded(&other, Content::Color, ColorSpace::Srgb);
    let folder = Folder::new("gltf")
        .with("wall.png", png.get_ref())
        .with("wall.wtex", &file::write(&image))
        .with("bare.png", png.get_ref());
    let mut viewer = Viewer::with_settings(SIZE, folder.settings());
    let world = viewer.app.world_mut();
    let mut spawn = |picture: &str, x: f32| {
        let texture = world.resource::<AssetServer>().load(picture.to_string());
        let mut awaited = world.resource_mut::<AwaitedAssets>();
        awaited.0.push(texture.clone().untyped());
        let material = StandardMaterial {
            base_color_texture: Some(texture),
            unlit: true,
            ..default()
        };
        let material = world
            .resource_mut::<Assets<StandardMaterial>>()
            .add(material);
        let mesh: Mesh = Rectangle::from_size(Vec2::new(SIZE[0] as f32, SIZE[1] as f32)).into();
        let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
        let root = world
            .spawn((
                WaveletGltf {
                    filter: WaveletFilter::Nearest,
                },
                Transform::from_xyz(x, 0.0, 1.0),
                Visibility::default(),
            ))
            .id();
        let middle = world
            .spawn((Transform::default(), Visibility::default(), ChildOf(root)))
            .id();
        world
            .spawn((Mesh3d(mesh), MeshMaterial3d(material), ChildOf(middle)))
            .id()
    };
    let with = spawn("wall.png", 0.0);
    let without = spawn("bare.png", 1000.0);
    for _ in 0..100 {
        viewer.app.render_frames(1).expect("frames");
        let mesh = viewer.app.world().entity(with);
        if mesh.contains::<MeshMaterial3d<WaveletStandardMaterial>>() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    viewer.app.run_until_ready(200).expect("ready");
    let shown = viewer.app.capture_f32().expect("a picture");
    let world = viewer.app.world();
    assert!(
        !world
            .entity(with)
            .contains::<MeshMaterial3d<StandardMaterial>>()
    );
    assert!(is(&shown, &image, &driver));
    // What has no wavelet texture stays as it is.
    let bare = world.entity(without);
    assert!(bare.contains::<MeshMaterial3d<StandardMaterial>>());
    assert!(!bare.contains::<MeshMaterial3d<WaveletStandardMaterial>>());
}
