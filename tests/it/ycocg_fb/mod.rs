//! Packed frame buffers: pictures against those of Bevy's own, of a scene with a camera that can be changed between them.

mod cameras;
mod effects;
mod exact;
mod fallback;
mod formats;
mod games;
mod materials;
mod switching;

use bevy::{
    asset::RenderAssetUsages,
    camera::{Hdr, ImageRenderTarget, RenderTarget},
    ecs::system::EntityCommands,
    prelude::*,
    render::{RenderApp, render_resource::TextureFormat, renderer::RenderAdapter, view::Msaa},
};
use bevy_frugal_lab::{
    content,
    headless::{HeadlessApp, HeadlessSettings, LabTarget},
};
use bevy_ycocg_fb::{
    CameraState, FallbackReason, FrameBufferQuality, FrameBufferReport, PackedFormat,
    YCoCgFrameBuffer, YCoCgFrameBufferPlugin,
    reference::pack::{linear_from_srgb, srgb_from_linear},
};
use image::RgbImage;

use crate::support::{
    keep,
    pool::{Borrowed, Pool},
    psnr,
};

/// The camera of the scene.
#[derive(Component)]
pub struct TestCamera;

static LIT: Pool = Pool::new(|| build(small(), |_| ()), begin_lit);

/// A headless app with a scene and one camera.
pub struct Studio {
    pub app: Borrowed,
    pub camera: Entity,
}

impl Studio {
    /// The lit scene in 128 x 96 pixels, in an app that tests share.
    pub fn lit() -> Self {
        Self::in_app(LIT.app())
    }

    /// Builds a scene of 128 x 96 pixels.
    pub fn new(scene: impl FnOnce(&mut App)) -> Self {
        Self::with_settings(small(), scene)
    }

    /// Builds a scene.
    pub fn with_size(width: u32, height: u32, scene: impl FnOnce(&mut App)) -> Self {
        Self::with_settings(HeadlessSettings::with_size(width, height), scene)
    }

    pub fn with_settings(settings: HeadlessSettings, scene: impl FnOnce(&mut App)) -> Self {
        let app = build(settings, |app| {
            app.add_systems(Startup, spawn_camera);
            scene(app);
        });
        Self::in_app(app.into())
    }

    fn in_app(mut app: Borrowed) -> Self {
        app.run_until_ready(5000).expect("the scene is ready");
        let world = app.world_mut();
        let camera = world
            .query_filtered::<Entity, With<TestCamera>>()
            .single(world)
            .expect("one camera");
        Self { app, camera }
    }

    /// Changes the camera.
    pub fn camera(&mut self, change: impl FnOnce(&mut EntityCommands)) -> &mut Self {
        let world = self.app.world_mut();
        change(&mut world.commands().entity(self.camera));
        world.flush();
        self
    }

    /// `Hdr` or not, and how many samples.
    pub fn mode(&mut self, hdr: bool, msaa: Msaa) -> &mut Self {
        self.camera(|camera| {
            camera.insert(msaa);
            if hdr {
                camera.insert(Hdr);
            } else {
                camera.remove::<Hdr>();
            }
        })
    }

    /// The picture by Bevy itself.
    pub fn plain(&mut self) -> RgbImage {
        self.set_quality(self.camera, None);
        self.picture()
    }

    /// The picture of a packed camera; it must be one.
    pub fn packed(&mut self, settings: impl Into<FrameBufferQuality>) -> RgbImage {
        let picture = self.quality(settings.into());
        let state = self.state();
        assert!(matches!(state, Some(CameraState::Packed(_))), "{state:?}");
        picture
    }

    /// The picture of a camera of this quality.
    pub fn quality(&mut self, quality: FrameBufferQuality) -> RgbImage {
        self.set_quality(self.camera, Some(quality));
        self.picture()
    }

    /// The picture of a camera that Bevy draws in `Rg11b10Ufloat`; it must be one.
    pub fn rg11b10ufloat(&mut self) -> RgbImage {
        let picture = self.quality(FrameBufferQuality::Compact);
        assert_eq!(self.state(), Some(CameraState::Rg11b10Ufloat));
        picture
    }

    /// Demands that a camera of a quality, which it gets, draws the reference with this PSNR in dB.
    pub fn check(
        &mut self,
        name: &str,
        reference: &RgbImage,
        quality: impl Into<FrameBufferQuality>,
        least_db: f64,
    ) {
        let picture = match quality.into() {
            FrameBufferQuality::Compact => self.rg11b10ufloat(),
            quality => self.packed(quality),
        };
        assert_like(name, reference, &picture, least_db);
    }

    /// Demands that a camera of a quality is Bevy's own for this reason.
    pub fn check_fallback(
        &mut self,
        quality: impl Into<FrameBufferQuality>,
        reason: FallbackReason,
    ) {
        assert_eq!(self.fallback(quality.into()), reason);
    }

    /// Demands that a camera of a quality is Bevy's own, and returns for which reason.
    pub fn fallback(&mut self, quality: FrameBufferQuality) -> FallbackReason {
        let reference = self.plain();
        // More frames than the reason needs.
        self.quality(quality);
        let picture = self.picture();
        let state = self.state();
        let Some(CameraState::Fallback(reason)) = state else {
            panic!("{quality:?}: {state:?}");
        };
        // Without a clear colour each frame is drawn over the last.
        if reason != FallbackReason::NoClear {
            assert!(picture == reference, "{quality:?} changed it: {reason}");
        }
        reason
    }

    /// A second camera, which draws to an image of this size from another side.
    pub fn spawn_to_image(
        &mut self,
        size: [u32; 2],
        camera: impl Bundle,
    ) -> (Entity, Handle<Image>) {
        let world = self.app.world_mut();
        let format = TextureFormat::Rgba8UnormSrgb;
        let image = world.add_asset(Image::new_target_texture(size[0], size[1], format, None));
        let target = RenderTarget::Image(ImageRenderTarget::from(image.clone()));
        let from_aside = Transform::from_xyz(2.5, 1.4, 1.0).looking_at(Vec3::ZERO, Vec3::Y);
        (world.spawn((target, from_aside, camera)).id(), image)
    }

    /// The picture as things are.
    pub fn picture(&mut self) -> RgbImage {
        self.app.render_frames(3).expect("three frames");
        self.app.capture_rgb8().expect("a picture")
    }

    /// Whether the adapter has so many samples a pixel in this format and in those of Bevy.
    pub fn supports_samples(&mut self, format: PackedFormat, samples: u32) -> bool {
        let world = self.app.app_mut().sub_app(RenderApp).world();
        let adapter = world.resource::<RenderAdapter>();
        [
            format.texture_format(),
            TextureFormat::Rgba16Float,
            TextureFormat::Depth32Float,
        ]
        .into_iter()
        .all(|format| {
            let features = adapter.get_texture_format_features(format);
            features.flags.sample_count_supported(samples)
        })
    }

    /// What became of the camera.
    pub fn state(&self) -> Option<CameraState> {
        self.state_of(self.camera)
    }

    pub fn state_of(&self, camera: Entity) -> Option<CameraState> {
        let report = self.app.world().get::<FrameBufferReport>(camera);
        report.map(|report| report.state.clone())
    }

    pub fn report(&self) -> Option<&FrameBufferReport> {
        self.app.world().get(self.camera)
    }

    /// Adds a camera that draws to the picture, too, after the first one.
    pub fn spawn_beside(&mut self, camera: Camera, bundle: impl Bundle) -> Entity {
        let world = self.app.world_mut();
        let target = world.resource::<LabTarget>().0.clone();
        let camera = Camera { order: 1, ..camera };
        world.spawn((camera, target, bundle)).id()
    }

    /// Gives a camera a quality, or takes it away.
    pub fn set_quality(&mut self, camera: Entity, quality: Option<FrameBufferQuality>) {
        let mut camera = self.app.world_mut().entity_mut(camera);
        match quality {
            Some(quality) => camera.insert(quality),
            None => camera.remove::<FrameBufferQuality>(),
        };
    }
}

/// The quality of a packed camera with the default settings.
pub fn packing() -> FrameBufferQuality {
    YCoCgFrameBuffer::default().into()
}

fn small() -> HeadlessSettings {
    HeadlessSettings::with_size(128, 96)
}

fn build(mut settings: HeadlessSettings, scene: impl FnOnce(&mut App)) -> HeadlessApp {
    settings.asset_folder = concat!(env!("CARGO_MANIFEST_DIR"), "/it/ycocg_fb").into();
    HeadlessApp::new(settings, |app| {
        app.add_plugins(YCoCgFrameBufferPlugin);
        scene(app);
    })
    .expect("a headless app")
}

fn begin_lit(world: &mut World) {
    spawn_camera(world);
    spawn_lit_scene(world);
}

fn spawn_camera(world: &mut World) {
    let target = world.resource::<LabTarget>().0.clone();
    world.spawn((
        TestCamera,
        Camera3d::default(),
        target,
        Msaa::Off,
        Transform::from_xyz(0.0, 1.6, 3.2).looking_at(Vec3::new(0.0, 0.4, 0.0), Vec3::Y),
    ));
}

/// Gives a camera components as they are by default.
pub fn with<B: Bundle + Default>(camera: &mut EntityCommands) {
    camera.insert(B::default());
}

pub fn without<B: Bundle>(camera: &mut EntityCommands) {
    camera.remove::<B>();
}

/// Changes what the camera is cleared to.
pub fn clear_to(camera: &mut EntityCommands, color: ClearColorConfig) {
    // Changed in place: a new `Camera` would not know the size of its target.
    camera
        .entry::<Camera>()
        .and_modify(move |mut camera| camera.clear_color = color);
}

/// Demands this PSNR in dB.
pub fn assert_like(name: &str, reference: &RgbImage, picture: &RgbImage, least_db: f64) {
    keep(&format!("{name}, bevy"), reference);
    keep(name, picture);
    let psnr_db = psnr(reference, picture);
    println!("{name}: {psnr_db:.2} dB");
    assert!(psnr_db >= least_db, "{name}: {psnr_db:.2} dB");
}

/// What Bevy's camera sees in a picture of 128 x 96 pixels, each of them the mean of `scale` x
/// `scale` tone-mapped ones.
pub fn supersampled(scene: impl FnOnce(&mut App), scale: u32) -> RgbImage {
    let large = Studio::with_size(128 * scale, 96 * scale, scene)
        .mode(true, Msaa::Off)
        .plain();
    RgbImage::from_fn(128, 96, |x, y| {
        let mut sum = [0.0; 3];
        for (dx, dy) in (0..scale * scale).map(|i| (i % scale, i / scale)) {
            let pixel = large.get_pixel(x * scale + dx, y * scale + dy);
            for (sum, channel) in sum.iter_mut().zip(pixel.0) {
                *sum += linear_from_srgb(f32::from(channel) / 255.0);
            }
        }
        let count = (scale * scale) as f32;
        image::Rgb(sum.map(|sum| (srgb_from_linear(sum / count) * 255.0).round() as u8))
    })
}

/// Puts a mesh of a material into the scene.
pub fn spawn_mesh<M: Material>(
    world: &mut World,
    mesh: impl Into<Mesh>,
    material: M,
    place: Transform,
) -> Entity {
    let mesh = world.add_asset::<Mesh>(mesh);
    let material = world.add_asset::<M>(material);
    let mesh = (Mesh3d(mesh), MeshMaterial3d(material), place);
    world.spawn(mesh).id()
}

/// A very bright rectangle, turned, before black.
pub fn bright_edge_scene(app: &mut App) {
    app.insert_resource(ClearColor(Color::BLACK));
    app.add_systems(Startup, |world: &mut World| {
        let material = StandardMaterial {
            base_color: Color::linear_rgb(1000.0, 600.0, 200.0),
            unlit: true,
            ..default()
        };
        let place = Transform::from_xyz(0.0, 0.6, 0.0).with_rotation(Quat::from_rotation_z(0.2));
        spawn_mesh(world, Rectangle::new(1.6, 1.0), material, place);
    });
}

/// Coloured objects on a brick floor in the sun, one of them emissive.
pub fn lit_scene(app: &mut App) {
    app.add_systems(Startup, spawn_lit_scene);
}

fn spawn_lit_scene(world: &mut World) {
    let bricks = world.add_asset(srgb_image(content::bricks(128, 128, 7).color));
    let floor = StandardMaterial {
        base_color_texture: Some(bricks),
        perceptual_roughness: 0.9,
        ..default()
    };
    let plane = Plane3d::default().mesh().size(4.0, 4.0);
    spawn_mesh(world, plane, floor, Transform::IDENTITY);
    let objects = [
        (Vec3::new(-0.9, 0.4, 0.0), Color::srgb(0.9, 0.15, 0.1), 0.0),
        (Vec3::new(0.0, 0.4, -0.5), Color::srgb(0.1, 0.7, 0.2), 0.0),
        (Vec3::new(0.9, 0.4, 0.1), Color::srgb(0.15, 0.25, 0.9), 0.0),
        (Vec3::new(0.1, 0.3, 0.8), Color::srgb(1.0, 0.6, 0.1), 4.0),
    ];
    for (position, color, emission) in objects {
        let material = StandardMaterial {
            base_color: color,
            emissive: color.to_linear() * emission,
            ..default()
        };
        let rotation = Quat::from_euler(EulerRot::YXZ, position.x + 0.5, 0.4, 0.2);
        let place = Transform::from_translation(position).with_rotation(rotation);
        spawn_mesh(world, Cuboid::from_length(0.55), material, place);
    }
    world.spawn((
        DirectionalLight {
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(2.0, 3.0, 1.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

/// As a texture of colours.
pub fn srgb_image(image: RgbImage) -> Image {
    Image::from_dynamic(image.into(), true, RenderAssetUsages::RENDER_WORLD)
}
