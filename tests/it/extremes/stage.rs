//! A small scene with everything in it, each plugin with its switch.

use bevy::{
    camera::Hdr, ecs::query::QueryFilter, math::Affine2, prelude::*, render::renderer::RenderDevice,
};
use bevy_ewa::{EwaSettings, EwaStandardMaterial};
use bevy_frugal_lab::{
    content::{add_texture, encoded, mipped_texture, wavelets},
    headless::{HeadlessApp, LabTarget},
    scenes::UNGRADED,
};
use bevy_voxel_gi::{Sky, VoxelGiSettings, VoxelGiVolume};
use bevy_wavelet_tex::{
    WaveletAddressMode, WaveletExtension, WaveletFilter, WaveletStandardMaterial,
    codec::{
        image::ColorSpace,
        rate::Rate,
        settings::{Effort, EncodeSettings},
    },
    material::storage_on,
};
use bevy_ycocg_fb::{FrameBufferQuality, YCoCgFrameBuffer};
use image::RgbaImage;

use crate::support::{add_plugins, float_settings};

/// The camera of the stage.
#[derive(Component)]
pub struct Eye;

/// The box in the middle.
#[derive(Component)]
pub struct Middle;

/// The floor.
#[derive(Component)]
pub struct Floor;

/// What the switches exchange.
#[derive(Resource)]
pub struct Props {
    /// Of the box, Bevy's own.
    pub plain: Handle<StandardMaterial>,
    /// Of the box, from a wavelet texture.
    pub wavelet: Handle<WaveletStandardMaterial>,
    /// Of the floor, Bevy's own.
    pub floor: Handle<StandardMaterial>,
    /// Of the floor, filtered.
    pub ewa: Handle<EwaStandardMaterial>,
}

/// Everything on.
pub const ALL: [bool; 4] = [true; 4];

/// An app with all plugins and the scene, everything off; textures have these sizes.
pub fn app(size: [u32; 2], texture: [u32; 2]) -> HeadlessApp {
    let settings = float_settings(size[0], size[1]);
    let mut app = HeadlessApp::new(settings, add_plugins).expect("an app");
    spawn(app.world_mut(), texture);
    app
}

/// An app of 40 x 24 pixels with everything on, ready.
pub fn full_app() -> HeadlessApp {
    let mut app = app([40, 24], [32, 32]);
    switch(app.world_mut(), ALL);
    app.run_until_ready(300).expect("ready");
    app
}

/// Changes all materials of the plugins.
pub fn change_materials(world: &mut World, change: impl Fn(&mut StandardMaterial)) {
    let mut materials = world.resource_mut::<Assets<WaveletStandardMaterial>>();
    for (_, material) in materials.iter_mut() {
        change(&mut material.base);
    }
    change_filtered(world, change);
}

/// Changes the materials that EWA filters.
pub fn change_filtered(world: &mut World, change: impl Fn(&mut StandardMaterial)) {
    let mut materials = world.resource_mut::<Assets<EwaStandardMaterial>>();
    for (_, material) in materials.iter_mut() {
        change(&mut material.base);
    }
}

fn spawn(world: &mut World, texture: [u32; 2]) {
    world.insert_resource(GlobalAmbientLight {
        brightness: 1000.0,
        ..GlobalAmbientLight::NONE
    });
    world.insert_resource(ClearColor(Color::srgb(0.1, 0.2, 0.3)));
    let [width, height] = texture;
    let pixels = RgbaImage::from_fn(width, height, |x, y| {
        let check = 60 + 150 * u8::from((x / 4 + y / 4) % 2 == 0);
        image::Rgba([check, 30 + check / 2, 90, 255])
    });
    let settings = EncodeSettings {
        effort: Effort::Fast,
        ..wavelets(Rate::Color3, ColorSpace::Srgb)
    };
    let encoded = encoded(&pixels, &settings).expect("a texture");
    let storage = storage_on(world.resource::<RenderDevice>());
    let base_color = add_texture(world, &encoded, storage);
    let image = world.add_asset(mipped_texture(&pixels, true));
    let plain = StandardMaterial {
        base_color_texture: Some(image),
        perceptual_roughness: 1.0,
        ..default()
    };
    let floor = StandardMaterial {
        uv_transform: Affine2::from_scale(Vec2::splat(4.0)),
        ..plain.clone()
    };
    let wavelet = WaveletStandardMaterial {
        base: StandardMaterial {
            base_color_texture: None,
            ..plain.clone()
        },
        extension: WaveletExtension {
            base_color: Some(base_color),
            filter: WaveletFilter::Trilinear,
            address_mode: WaveletAddressMode::Repeat,
            ..default()
        },
    };
    let ewa = EwaStandardMaterial {
        base: floor.clone(),
        extension: EwaSettings::default().into(),
    };
    let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
    let (plain, floor) = (materials.add(plain), materials.add(floor));
    let wavelet = world.add_asset::<WaveletStandardMaterial>(wavelet);
    let ewa = world.add_asset::<EwaStandardMaterial>(ewa);
    let mut meshes = world.resource_mut::<Assets<Mesh>>();
    let cube = meshes.add(Cuboid::default());
    let ground = meshes.add(Plane3d::default().mesh().size(8.0, 8.0));
    world.spawn((
        Middle,
        Mesh3d(cube),
        MeshMaterial3d(plain.clone()),
        Transform::from_xyz(0.0, 0.5, 0.0),
    ));
    world.spawn((Floor, Mesh3d(ground), MeshMaterial3d(floor.clone())));
    world.insert_resource(Props {
        plain,
        wavelet,
        floor,
        ewa,
    });
    world.spawn((
        DirectionalLight {
            illuminance: 8000.0,
            ..default()
        },
        Transform::from_xyz(-1.0, 2.0, 1.5).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    let target = world.resource::<LabTarget>().0.clone();
    world.spawn((
        Eye,
        Camera3d::default(),
        Hdr,
        Msaa::Off,
        target,
        UNGRADED,
        Transform::from_xyz(0.3, 1.2, 3.0).looking_at(Vec3::new(0.0, 0.4, 0.0), Vec3::Y),
    ));
}

/// Switches wavelet textures, the packed frame buffer, EWA and GI.
pub fn switch(world: &mut World, [wavelet, packed, ewa, light]: [bool; 4]) {
    let props = world.resource::<Props>();
    let (plain, textured) = (props.plain.clone(), props.wavelet.clone());
    let (floor, filtered) = (props.floor.clone(), props.ewa.clone());
    for thing in all::<With<Middle>>(world) {
        exchange(world.entity_mut(thing), wavelet, &plain, &textured);
    }
    for thing in all::<With<Floor>>(world) {
        exchange(world.entity_mut(thing), ewa, &floor, &filtered);
    }
    for eye in all::<With<Eye>>(world) {
        let mut eye = world.entity_mut(eye);
        if packed {
            eye.insert(FrameBufferQuality::from(YCoCgFrameBuffer::default()));
        } else {
            eye.remove::<FrameBufferQuality>();
        }
    }
    let volumes = all::<With<VoxelGiVolume>>(world);
    if light && volumes.is_empty() {
        world.resource_mut::<VoxelGiSettings>().resolution = 8;
        world.spawn(VoxelGiVolume {
            sky: Some(Sky::uniform(LinearRgba::rgb(300.0, 400.0, 500.0))),
            ..VoxelGiVolume::fixed(8.0)
        });
    }
    for volume in volumes.into_iter().filter(|_| !light) {
        world.despawn(volume);
    }
}

pub fn all<F: QueryFilter>(world: &mut World) -> Vec<Entity> {
    world.query_filtered::<Entity, F>().iter(world).collect()
}

/// Gives a mesh one of two materials.
fn exchange<M: Material>(
    mut thing: EntityWorldMut,
    on: bool,
    plain: &Handle<StandardMaterial>,
    other: &Handle<M>,
) {
    if on {
        thing.remove::<MeshMaterial3d<StandardMaterial>>();
        thing.insert(MeshMaterial3d(other.clone()));
    } else {
        thing.remove::<MeshMaterial3d<M>>();
        thing.insert(MeshMaterial3d(plain.clone()));
    }
}

/// The picture after a few frames, every value of which is a colour.
pub fn picture(app: &mut HeadlessApp, frames: u32) -> Vec<Vec3> {
    app.render_frames(frames).expect("frames");
    let picture = app.capture_f32().expect("a picture");
    let pixels = picture.pixels.iter();
    let pixels: Vec<_> = pixels.map(|p| Vec4::from(*p).truncate()).collect();
    for (i, pixel) in pixels.iter().enumerate() {
        assert!(pixel.is_finite(), "pixel {i}: {pixel}");
    }
    pixels
}

/// Mean absolute difference over the mean of `a`.
pub fn difference(a: &[Vec3], b: &[Vec3]) -> f32 {
    let sum =
        |values: &mut dyn Iterator<Item = Vec3>| values.map(|v| v.abs().element_sum()).sum::<f32>();
    sum(&mut a.iter().zip(b).map(|(a, b)| a - b)) / sum(&mut a.iter().copied())
}
