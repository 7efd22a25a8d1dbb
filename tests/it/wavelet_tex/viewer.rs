//! A quad that fills a float target and shows one material after the other, without a new app each.

use bevy::{
    camera::Hdr,
    math::Affine2,
    pbr::{MeshMaterial3d, StandardMaterial},
    prelude::*,
};
use bevy_frugal_lab::headless::{
    HeadlessApp, HeadlessSettings, LabTarget, Rgba32FImage, TargetFormat, pixel_camera,
};
use bevy_wavelet_tex::{
    WaveletExtension, WaveletStandardMaterial, WaveletStorage, WaveletTexPlugin,
    codec::image::{Content, WaveletImage},
};

use super::scene::{MAX_FRAMES, add_texture};

/// The app and its quad.
pub struct Viewer {
    pub app: HeadlessApp,
    quad: Entity,
}

impl Viewer {
    /// A target of `size` pixels.
    pub fn new(size: [u32; 2]) -> Self {
        Self::with_settings(size, HeadlessSettings::default())
    }

    pub fn with_settings(size: [u32; 2], settings: HeadlessSettings) -> Self {
        let settings = HeadlessSettings {
            width: size[0],
            height: size[1],
            format: TargetFormat::Float32,
            ..settings
        };
        let mut app = HeadlessApp::new(settings, |app| {
            app.add_plugins(WaveletTexPlugin);
            app.insert_resource(ClearColor(Color::BLACK));
            let camera = pixel_camera(app.world().resource::<LabTarget>(), size);
            app.world_mut().spawn((camera, Hdr));
        })
        .expect("an adapter");
        let world = app.world_mut();
        let mesh: Mesh = Rectangle::new(size[0] as f32, size[1] as f32).into();
        let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
        let quad = world.spawn(Mesh3d(mesh)).id();
        Self { app, quad }
    }

    /// The quad with a texture as base colour, unlit; uv runs from `origin` to `origin + extent`.
    pub fn show(
        &mut self,
        image: &WaveletImage,
        storage: WaveletStorage,
        extension: WaveletExtension,
        [origin, extent]: [Vec2; 2],
    ) -> Rgba32FImage {
        let texture = add_texture(self.app.world_mut(), image, storage);
        self.show_material(WaveletStandardMaterial {
            base: StandardMaterial {
                unlit: true,
                uv_transform: Affine2::from_scale_angle_translation(extent, 0.0, origin),
                alpha_mode: match image.content {
                    Content::ColorAlpha => AlphaMode::Blend,
                    _ => AlphaMode::Opaque,
                },
                ..default()
            },
            extension: WaveletExtension {
                base_color: Some(texture),
                ..extension
            },
        })
    }

    /// The quad with a material.
    pub fn show_material(&mut self, material: WaveletStandardMaterial) -> Rgba32FImage {
        let world = self.app.world_mut();
        let material = world
            .resource_mut::<Assets<WaveletStandardMaterial>>()
            .add(material);
        world.entity_mut(self.quad).insert(MeshMaterial3d(material));
        self.app.run_until_ready(MAX_FRAMES).expect("ready");
        self.app.capture_f32().expect("a picture")
    }
}

/// All of a texture, once.
pub const WHOLE: [Vec2; 2] = [Vec2::ZERO, Vec2::ONE];
