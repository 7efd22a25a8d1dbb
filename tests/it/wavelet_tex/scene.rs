//! A textured quad seen straight on, and the codec's view of it.

use std::{sync::OnceLock, thread};

use bevy::{
    camera::Hdr, image::Image, pbr::StandardMaterial, prelude::*, render::renderer::RenderDevice,
};
use bevy_frugal_lab::{
    content,
    headless::{
        HeadlessApp, HeadlessSettings, LabTarget, Rgba32FImage, TargetFormat, pixel_camera,
    },
};
use bevy_wavelet_tex::{
    WaveletExtension, WaveletFilter, WaveletStandardMaterial, WaveletStorage, WaveletTexPlugin,
    WaveletTexture,
    codec::{
        color::linear_from_srgb,
        decoder::{DecodedImage, decode_with},
        encoder::encode_rgb8,
        image::{ColorSpace, Content, WaveletImage},
        rate::Rate,
        settings::{EncodeSettings, Formats},
    },
    material::storage_on,
};
use image::RgbImage;

use super::driver::Driver;
use crate::support::{Gpu, gpu, skipped};

pub const MAX_FRAMES: u32 = 200;

/// One 8-bit step.
pub const STEP: f32 = 1.0 / 255.0;

/// A picture with all that a photograph has, at a size that no block divides.
pub fn picture() -> RgbImage {
    content::photo_like(93, 61, 7)
}

pub fn encoded(picture: &RgbImage, content: Content, color_space: ColorSpace) -> WaveletImage {
    let settings = EncodeSettings {
        rate: Rate::usual(content),
        color_space,
        formats: Formats::Wavelet,
        ..EncodeSettings::default()
    };
    encoded_with(picture, &settings)
}

pub fn encoded_with(picture: &RgbImage, settings: &EncodeSettings) -> WaveletImage {
    let pixels: Vec<[u8; 3]> = picture.pixels().map(|p| p.0).collect();
    encode_rgb8(&pixels, picture.dimensions().into(), settings).expect("a good image")
}

/// The reference decoder's pixels of a level, from the texels that the driver hands a shader:
/// how those are rounded is up to the driver, and four of them add up in one pixel.
pub fn decoded_by(driver: &Driver, image: &WaveletImage, level: u32) -> DecodedImage {
    decode_with(image, level, |format, blocks, size| {
        driver.decode(format, blocks, size)
    })
}

/// Pixels in linear units, as they would be filtered.
pub fn linear(image: &WaveletImage, decoded: DecodedImage) -> ([u32; 2], Vec<[f32; 3]>) {
    let srgb = image.color_space == ColorSpace::Srgb;
    let linear = |p: [f32; 3]| if srgb { p.map(linear_from_srgb) } else { p };
    (
        decoded.size,
        decoded.pixels.into_iter().map(linear).collect(),
    )
}

/// Waits until an app may run; `None`, with a note, where wavelet textures cannot all be blocks.
pub fn gpu_with_all_planes() -> Option<Gpu> {
    static BINDS: OnceLock<bool> = OnceLock::new();
    let gpu = gpu();
    let binds = BINDS.get_or_init(|| {
        let app = HeadlessApp::new(HeadlessSettings::with_size(16, 16), |_| {});
        let app = app.expect("an adapter");
        storage_on(app.world().resource::<RenderDevice>()) == WaveletStorage::Blocks
    });
    if !binds {
        let thread = thread::current();
        let test = thread.name().unwrap_or("a test of wavelet textures");
        skipped(&format!(
            "{test}: the adapter lacks BC or binds too few textures for all planes"
        ));
        return None;
    }
    Some(gpu)
}

/// Adds an image to a world.
pub fn add_texture(
    world: &mut World,
    image: &WaveletImage,
    storage: WaveletStorage,
) -> Handle<WaveletTexture> {
    world.resource_scope(|world, mut textures: Mut<Assets<WaveletTexture>>| {
        let mut images = world.resource_mut::<Assets<Image>>();
        WaveletTexture::add(image, storage, &mut textures, &mut images)
    })
}

/// Renders a quad that fills a float target of `target` pixels, unlit, `uv` from 0 to `uv_max`.
pub fn render_quad(
    target: [u32; 2],
    uv_max: f32,
    filter: WaveletFilter,
    settings: HeadlessSettings,
    texture: impl FnOnce(&mut World) -> Handle<WaveletTexture>,
) -> Rgba32FImage {
    let settings = HeadlessSettings {
        width: target[0],
        height: target[1],
        format: TargetFormat::Float32,
        ..settings
    };
    let mut app = HeadlessApp::new(settings, |app| {
        app.add_plugins(WaveletTexPlugin);
        let camera = pixel_camera(app.world().resource::<LabTarget>(), target);
        app.world_mut().spawn((camera, Hdr));
    })
    .expect("an adapter");
    let texture = texture(app.world_mut());
    spawn_quad(
        app.world_mut(),
        target,
        uv_max,
        WaveletExtension {
            base_color: Some(texture),
            filter,
            ..default()
        },
    );
    app.run_until_ready(MAX_FRAMES).expect("ready");
    app.capture_f32().expect("a picture")
}

fn spawn_quad(world: &mut World, size: [u32; 2], uv_max: f32, extension: WaveletExtension) {
    let mesh: Mesh = Rectangle::new(size[0] as f32, size[1] as f32).into();
    let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
    let base = StandardMaterial {
        unlit: true,
        uv_transform: bevy::math::Affine2::from_scale(Vec2::splat(uv_max)),
        ..default()
    };
    let material = world
        .resource_mut::<Assets<WaveletStandardMaterial>>()
        .add(WaveletStandardMaterial { base, extension });
    world.spawn((Mesh3d(mesh), MeshMaterial3d(material)));
}

/// How far a picture is from what is expected of it.
pub struct Difference {
    /// Of a channel, the largest.
    pub largest: f32,
    /// Where that is.
    pub at: [u32; 2],
    /// Pixels with a channel that is more than one 8-bit step off, in percent.
    pub percent_beyond_a_step: f32,
}

pub fn difference(picture: &Rgba32FImage, expected: impl Fn(u32, u32) -> [f32; 3]) -> Difference {
    let mut found = Difference {
        largest: 0.0,
        at: [0; 2],
        percent_beyond_a_step: 0.0,
    };
    let percent = 100.0 / picture.pixels.len() as f32;
    for y in 0..picture.height {
        for x in 0..picture.width {
            let actual = picture.pixels[(y * picture.width + x) as usize];
            let mut here = 0.0f32;
            for (a, e) in actual.iter().zip(expected(x, y)) {
                assert!(a.is_finite(), "pixel {x}, {y} is {a}");
                here = here.max((a - e).abs());
            }
            if here > STEP {
                found.percent_beyond_a_step += percent;
            }
            if here > found.largest {
                (found.largest, found.at) = (here, [x, y]);
            }
        }
    }
    found
}
