//! What the cases share.

use bevy::{
    camera::Viewport, ecs::entity::EntityHashMap, prelude::*, render::render_resource::Extent3d,
};
use bevy_frugal_lab::{
    boxes::{BoxScene, spawn_box_scene},
    headless::{HeadlessApp, HeadlessSettings, TargetFormat},
};
use bevy_voxel_gi::{
    Sky, VoxelGiPlugin, VoxelGiReport, VoxelGiSettings, VoxelGiState, VoxelGiVolume,
    reference::{IrradianceField, VolumeGrid},
};

/// Frames in which everything is loaded and compiled.
const MAX_FRAMES: u32 = 200;

/// A scene of boxes without a volume, ready.
pub fn box_app(scene: &BoxScene) -> HeadlessApp {
    let settings = HeadlessSettings {
        format: TargetFormat::Float32,
        ..HeadlessSettings::with_size(scene.camera.width, scene.camera.height)
    };
    let mut app = HeadlessApp::new(settings, |app| {
        app.add_plugins(VoxelGiPlugin);
    })
    .expect("no adapter");
    spawn_box_scene(app.world_mut(), scene);
    app.run_until_ready(MAX_FRAMES)
        .expect("the scene is not ready");
    app
}

/// Sets the settings; a volume around a scene.
pub fn volume(
    app: &mut HeadlessApp,
    scene: &BoxScene,
    settings: VoxelGiSettings,
) -> (VoxelGiVolume, Transform) {
    let (center, size) = scene.volume(settings.resolution);
    app.world_mut().insert_resource(settings);
    let sky = LinearRgba::from_vec3(scene.sky_radiance);
    let volume = VoxelGiVolume {
        sky: Some(Sky::uniform(sky)),
        ..VoxelGiVolume::fixed(size)
    };
    (volume, Transform::from_translation(center))
}

/// Renders until the light has settled; the number of frames. Cameras draw one pixel meanwhile, since on a
/// software driver a frame's time is that of its pixels, and then a whole picture.
pub fn settle(app: &mut HeadlessApp) -> u32 {
    let one_pixel = Viewport {
        physical_size: UVec2::ONE,
        ..default()
    };
    let mut viewports = EntityHashMap::default();
    let world = app.world_mut();
    for (camera, mut settings) in world.query::<(Entity, &mut Camera)>().iter_mut(world) {
        viewports.insert(camera, settings.viewport.replace(one_pixel.clone()));
    }
    let frames = settle_in_view(app);
    let world = app.world_mut();
    for (camera, mut settings) in world.query::<(Entity, &mut Camera)>().iter_mut(world) {
        settings.viewport = viewports.remove(&camera).flatten();
    }
    app.render_frames(1).expect("a frame failed");
    frames
}

/// Whether the light has settled.
pub fn has_settled(app: &HeadlessApp) -> bool {
    app.world().resource::<VoxelGiReport>().state == VoxelGiState::Settled
}

/// The same with whole pictures, for light that depends on what cameras see.
pub fn settle_in_view(app: &mut HeadlessApp) -> u32 {
    for frame in 1..400 {
        app.render_frames(1).expect("a frame failed");
        if has_settled(app) {
            return frame;
        }
    }
    panic!("not settled: {:?}", app.world().resource::<VoxelGiReport>());
}

/// The picture.
pub fn picture(app: &mut HeadlessApp) -> Vec<Vec3> {
    let image = app.capture_f32().expect("no picture");
    image
        .pixels
        .iter()
        .map(|p| Vec3::new(p[0], p[1], p[2]))
        .collect()
}

/// What the volume adds to a picture: with it less without it.
pub fn indirect(app: &mut HeadlessApp, volume: impl Bundle) -> Vec<Vec3> {
    app.render_frames(2).expect("a frame failed");
    let without = picture(app);
    let entity = app.world_mut().spawn(volume).id();
    settle(app);
    let with = picture(app);
    app.world_mut().despawn(entity);
    with.iter().zip(without).map(|(a, b)| a - b).collect()
}

/// What Bevy samples of the volume, as it is in memory, and its size.
fn read_light(app: &mut HeadlessApp) -> (Extent3d, Vec<u8>) {
    let world = app.world_mut();
    let handle = world
        .query::<&bevy::light::IrradianceVolume>()
        .single(world)
        .expect("one volume")
        .voxels
        .clone();
    app.read_texture(&handle, 8).expect("the GPU answers")
}

/// What Bevy samples of the volume, as it is in memory: all levels.
pub fn light_texture_bytes(app: &mut HeadlessApp) -> Vec<u8> {
    let (size, bytes) = read_light(app);
    // Only the first texels of the last slice are written.
    let slice = (8 * size.width * size.height) as usize;
    bytes[..bytes.len() - slice].to_vec()
}

/// Six faces a voxel of what Bevy samples of the volume: light times weight, and weight.
pub fn read_texels(app: &mut HeadlessApp) -> Vec<[Vec4; 6]> {
    let (r, texel) = read_volume(app);
    let faces = |[x, y, z]: [u32; 3]| {
        std::array::from_fn(|face| {
            let face = face as u32;
            texel(x, y + (face & 1) * r, z + (face >> 1) * r)
        })
    };
    voxels(r).map(faces).collect()
}

/// The same as the reference has it, of the volume that a scene takes.
pub fn read_field(app: &mut HeadlessApp, scene: &BoxScene, resolution: u32) -> IrradianceField {
    let (center, size) = scene.volume(resolution);
    IrradianceField {
        grid: VolumeGrid {
            min: center - 0.5 * size,
            voxel_size: size / resolution as f32,
            resolution,
        },
        texels: read_texels(app),
    }
}

/// The places of what divides each voxel from its neighbours, of a volume of one level.
pub fn read_dividers(app: &mut HeadlessApp) -> Vec<Vec3> {
    let (r, texel) = read_volume(app);
    let dividers = |[x, y, z]: [u32; 3]| {
        let pair = texel(x, 2 * y + z / 2 % 2, 3 * r + z / 4);
        let along_xy = if z % 2 == 0 { pair.xy() } else { pair.zw() };
        let parts = (64.0 * along_xy).map(|place| place - place.floor());
        along_xy.extend((128.0 * parts.x + 8.0 * parts.y - 38.5) / 59.0)
    };
    voxels(r).map(dividers).collect()
}

fn voxels(r: u32) -> impl Iterator<Item = [u32; 3]> {
    (0..r * r * r).map(move |i| [i % r, i / r % r, i / (r * r)])
}

/// The resolution of the volume, and its texels.
fn read_volume(app: &mut HeadlessApp) -> (u32, impl Fn(u32, u32, u32) -> Vec4) {
    let (size, bytes) = read_light(app);
    let texel = move |x: u32, y: u32, z: u32| {
        let at = (((z * size.height + y) * size.width + x) * 8) as usize;
        let channel = |c: usize| {
            half::f16::from_le_bytes([bytes[at + 2 * c], bytes[at + 2 * c + 1]]).to_f32()
        };
        Vec4::new(channel(0), channel(1), channel(2), channel(3))
    };
    (size.width, texel)
}
