//! Given colours, pixel by pixel, through a packed camera.

use bevy::{
    asset::RenderAssetUsages,
    camera::{Hdr, Viewport, visibility::RenderLayers},
    image::ImageSampler,
    prelude::*,
    render::{
        render_resource::{Extent3d, TextureDimension, TextureFormat},
        view::Msaa,
    },
};
use bevy_frugal_lab::headless::{
    HeadlessApp, HeadlessSettings, LabTarget, TargetFormat, pixel_camera,
};
use bevy_ycocg_fb::{
    CameraState, FrameBufferQuality, FrameBufferReport, YCoCgFrameBuffer, YCoCgFrameBufferPlugin,
};

/// Cameras that see one unlit quad each, scene-linear.
pub struct Flat {
    app: HeadlessApp,
    target: [u32; 2],
    size: [u32; 2],
    offset: [u32; 2],
    cameras: Vec<Entity>,
    material: Handle<StandardMaterial>,
}

impl Flat {
    /// A camera that fills the viewport of `size` pixels at `offset` of its target with `colors`.
    pub fn new(target: [u32; 2], size: [u32; 2], offset: [u32; 2], colors: &[[f32; 3]]) -> Self {
        let settings = HeadlessSettings {
            format: TargetFormat::Float32,
            ..HeadlessSettings::with_size(target[0], target[1])
        };
        let app = HeadlessApp::new(settings, |app| {
            app.add_plugins(YCoCgFrameBufferPlugin);
        });
        let mut flat = Self {
            app: app.expect("a headless app"),
            target,
            size,
            offset,
            cameras: Vec::new(),
            material: Handle::default(),
        };
        flat.add_camera(size, offset, colors);
        flat.app.run_until_ready(200).expect("it is ready");
        flat
    }

    /// Adds a camera beside the others; [`packed`](Self::packed) gives the picture of the first.
    pub fn add_camera(&mut self, size: [u32; 2], offset: [u32; 2], colors: &[[f32; 3]]) {
        let world = self.app.world_mut();
        let image = world.add_asset(float_image(size, colors));
        let mesh = world.add_asset(Rectangle::new(size[0] as f32, size[1] as f32));
        let material = world.add_asset::<StandardMaterial>(StandardMaterial {
            base_color_texture: Some(image),
            unlit: true,
            ..default()
        });
        let layer = RenderLayers::layer(self.cameras.len() + 1);
        world.spawn((
            Mesh3d(mesh),
            MeshMaterial3d(material.clone()),
            layer.clone(),
        ));
        let camera = Camera {
            order: self.cameras.len() as isize,
            viewport: Some(Viewport {
                physical_position: offset.into(),
                physical_size: size.into(),
                ..default()
            }),
            ..default()
        };
        let view = pixel_camera(world.resource::<LabTarget>(), size);
        let camera = world.spawn(view).insert((camera, Hdr, layer)).id();
        if self.cameras.is_empty() {
            self.material = material;
        }
        self.cameras.push(camera);
    }

    /// Puts `count` more quads of the same colours before the first.
    pub fn stack(&mut self, count: usize, alpha_mode: AlphaMode) {
        let [width, height] = self.size;
        let world = self.app.world_mut();
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        let material = StandardMaterial {
            alpha_mode,
            ..materials.get(&self.material).expect("the material").clone()
        };
        let material = materials.add(material);
        let mesh = world.add_asset(Rectangle::new(width as f32, height as f32));
        for i in 0..count {
            world.spawn((
                Mesh3d(mesh.clone()),
                MeshMaterial3d(material.clone()),
                Transform::from_xyz(0.0, 0.0, 1.0 + i as f32),
                RenderLayers::layer(1),
            ));
        }
    }

    /// Samples a pixel, of all cameras.
    pub fn set_msaa(&mut self, msaa: Msaa) {
        for &camera in &self.cameras {
            self.app.world_mut().entity_mut(camera).insert(msaa);
        }
    }

    /// What the first camera makes of its colours, all of them packed.
    pub fn packed(&mut self, settings: YCoCgFrameBuffer) -> Vec<[f32; 3]> {
        self.colors(settings.into(), CameraState::Packed(settings.format))
    }

    /// What the first camera makes of its colours, all of them in this state.
    pub fn colors(&mut self, quality: FrameBufferQuality, expected: CameraState) -> Vec<[f32; 3]> {
        for &camera in &self.cameras {
            self.app.world_mut().entity_mut(camera).insert(quality);
        }
        self.app.render_frames(3).expect("three frames");
        for &camera in &self.cameras {
            let report = self.app.world().get::<FrameBufferReport>(camera);
            assert_eq!(report.map(|report| &report.state), Some(&expected));
        }
        let picture = self.app.capture_f32().expect("a picture");
        let [width, height] = self.size;
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        pixels
            .map(|(x, y)| {
                let index = (self.offset[1] + y) * self.target[0] + self.offset[0] + x;
                let [r, g, b, _] = picture.pixels[index as usize];
                [r, g, b]
            })
            .collect()
    }
}

fn float_image(size: [u32; 2], colors: &[[f32; 3]]) -> Image {
    let texels = colors
        .iter()
        .flat_map(|&[r, g, b]| [r, g, b, 1.0])
        .flat_map(f32::to_le_bytes);
    let mut image = Image::new(
        Extent3d {
            width: size[0],
            height: size[1],
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        texels.collect(),
        TextureFormat::Rgba32Float,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.sampler = ImageSampler::nearest();
    image
}

/// Multiples of 1/64 up to 4: their luminance and chrominance are exact in 16-bit floats.
pub fn random_colors(size: [u32; 2], seed: u64) -> Vec<[f32; 3]> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) % 257
    };
    (0..size[0] * size[1])
        .map(|_| [random(), random(), random()].map(|n| n as f32 / 64.0))
        .collect()
}
