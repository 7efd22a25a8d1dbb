//! What the tests share: apps with the right to run them, small scenes (a floor, a wall, a light), and what is read of
//! the picture and of the volume.

use bevy::{
    asset::RenderAssetUsages,
    camera::{Exposure, Viewport, visibility::RenderLayers},
    core_pipeline::{
        prepass::{DeferredPrepass, DepthPrepass},
        tonemapping::{DebandDither, Tonemapping},
    },
    ecs::entity::EntityHashMap,
    image::ToExtents,
    math::Affine3A,
    mesh::{
        VertexAttributeValues,
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    pbr::DefaultOpaqueRendererMethod,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_frugal_lab::{
    boxes::{BoxScene, SceneBox, spawn_box_scene},
    headless::{HeadlessSettings, LabTarget},
};
use bevy_voxel_gi::{
    Bounces, Sky, Solver, VoxelGiPlugin, VoxelGiReport, VoxelGiSettings, VoxelGiState,
    VoxelGiVolume, VoxelLight,
    reference::{IrradianceField, Triangle, VolumeGrid},
};

use crate::support::{float_settings, pool::Pool};

pub use crate::support::pool::Borrowed;
pub use bevy_frugal_lab::headless::HeadlessApp;

/// Edge of the picture in pixels.
pub const SIZE: u32 = 32;

/// Voxels along an edge of a volume, unless a test says otherwise.
pub const RESOLUTION: u32 = 16;

/// Less is the weight of voxels without surfaces.
pub const SURFACE: f32 = 0.003;

static APPS: Pool = Pool::new(|| build(|_| (), |_| ()), begin);

/// An app with the plugin and a camera that sees 4 m x 4 m of the plane y = 0 from straight above,
/// +X to the right and -Z up, at an exposure of 1.
pub fn app() -> Borrowed {
    Borrowed::with_gpu(|| APPS.app())
}

/// The same with more in it, for this test alone.
pub fn app_with(more: impl FnOnce(&mut App)) -> Borrowed {
    app_of(|_| (), more)
}

/// The same with other settings of the headless app.
pub fn app_of(change: impl FnOnce(&mut HeadlessSettings), more: impl FnOnce(&mut App)) -> Borrowed {
    Borrowed::with_gpu(|| unguarded_app(change, more).into())
}

/// The same for a test that has the right to run apps itself.
pub fn unguarded_app(
    change: impl FnOnce(&mut HeadlessSettings),
    more: impl FnOnce(&mut App),
) -> HeadlessApp {
    let mut app = build(change, more);
    begin(app.world_mut());
    app
}

/// The same with a camera whose G-buffer materials write.
pub fn deferred_app() -> Borrowed {
    let mut app = app_with(|app| {
        app.insert_resource(DefaultOpaqueRendererMethod::deferred());
    });
    camera(app.world_mut()).insert((DepthPrepass, DeferredPrepass));
    app
}

fn build(change: impl FnOnce(&mut HeadlessSettings), more: impl FnOnce(&mut App)) -> HeadlessApp {
    let mut settings = float_settings(SIZE, SIZE);
    change(&mut settings);
    HeadlessApp::new(settings, |app| {
        app.add_plugins(VoxelGiPlugin)
            .add_observer(see_what_is_hidden);
        more(app);
    })
    .expect("an adapter")
}

/// The layers of a mesh that cameras do not see and volumes do.
pub fn hidden() -> RenderLayers {
    RenderLayers::layer(5)
}

/// Volumes without layers of their own have those of cameras and of what is hidden from them.
fn see_what_is_hidden(
    added: On<Add<VoxelGiVolume>>,
    with_layers: Query<(), With<RenderLayers>>,
    mut commands: Commands,
) {
    if !with_layers.contains(added.entity) {
        let layers = RenderLayers::default().union(&hidden());
        commands.entity(added.entity).insert(layers);
    }
}

fn begin(world: &mut World) {
    world.insert_resource(GlobalAmbientLight::NONE);
    world.insert_resource(ClearColor(Color::BLACK));
    world.insert_resource(VoxelGiSettings {
        resolution: RESOLUTION,
        ..default()
    });
    let target = world.resource::<LabTarget>().0.clone();
    world.spawn((
        Camera3d::default(),
        bevy::camera::Hdr,
        target,
        Msaa::Off,
        Tonemapping::None,
        DebandDither::Disabled,
        Exposure {
            ev100: -(1.2_f32.log2()),
        },
        Projection::from(OrthographicProjection {
            scaling_mode: bevy::camera::ScalingMode::Fixed {
                width: 4.0,
                height: 4.0,
            },
            ..OrthographicProjection::default_3d()
        }),
        Transform::from_xyz(0.0, 3.9, 0.0).looking_at(Vec3::ZERO, Vec3::NEG_Z),
    ));
}

/// An app with a floor.
pub fn floor_app() -> Borrowed {
    let mut app = app();
    floor(app.world_mut());
    app
}

/// An app with a floor under a uniform sky of 1, and with more; its volume, and what `more` returns.
pub fn floor_under_sky<T>(more: impl FnOnce(&mut World) -> T) -> (Borrowed, Entity, T) {
    let mut app = floor_app();
    let world = app.world_mut();
    let more = more(world);
    let volume = world.spawn(under_sky(1.0)).id();
    (app, volume, more)
}

/// The settled picture of this.
pub fn lit_floor<T>(more: impl FnOnce(&mut World) -> T) -> Vec<Vec3> {
    settled(&mut floor_under_sky(more).0)
}

/// A scene of boxes without a volume, ready.
pub fn box_app(scene: &BoxScene) -> Borrowed {
    Borrowed::with_gpu(|| {
        let settings = float_settings(scene.camera.width, scene.camera.height);
        let mut app = HeadlessApp::new(settings, |app| {
            app.add_plugins(VoxelGiPlugin);
        })
        .expect("an adapter");
        spawn_box_scene(app.world_mut(), scene);
        ready(&mut app);
        app.into()
    })
}

/// A box without gloss.
pub fn scene_box(center: [f32; 3], half: [f32; 3], albedo: Vec3) -> SceneBox {
    SceneBox {
        center: center.into(),
        half: half.into(),
        albedo,
        rotate_y_deg: 0.0,
        gloss: None,
    }
}

/// Places the camera of a scene, with a square picture of this size.
pub fn look(scene: &mut BoxScene, eye: Vec3, target: Vec3, size: u32) {
    (scene.camera.eye, scene.camera.target) = (eye, target);
    (scene.camera.width, scene.camera.height) = (size, size);
}

/// The triangles of a mesh, as the reference voxelises them.
pub fn triangles(mesh: &Mesh, place: Affine3A, material: u32) -> Vec<Triangle> {
    let corners = mesh.attribute(Mesh::ATTRIBUTE_POSITION);
    let corners = corners.and_then(|it| it.as_float3()).expect("positions");
    let indices: Vec<_> = mesh.indices().expect("indices").iter().collect();
    let triangle = |of: &[usize]| Triangle {
        corners: [0, 1, 2].map(|i| place.transform_point3(Vec3::from(corners[of[i]]))),
        material,
        double_sided: false,
    };
    indices.chunks_exact(3).map(triangle).collect()
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

/// The settings of all volumes.
pub fn settings(world: &mut World) -> Mut<'_, VoxelGiSettings> {
    world.resource_mut()
}

pub fn report(app: &HeadlessApp) -> VoxelGiReport {
    *app.world().resource()
}

pub fn global_illumination(solver: Solver, bounces: Bounces) -> VoxelLight {
    VoxelLight::GlobalIllumination { solver, bounces }
}

pub fn occlusion(radius: f32, rays: u32) -> VoxelLight {
    VoxelLight::AmbientOcclusion { radius, rays }
}

/// A small volume of 4 m around the origin.
pub fn small_volume() -> VoxelGiVolume {
    VoxelGiVolume::fixed(4.0)
}

/// The same under a uniform sky.
pub fn under_sky(radiance: f32) -> VoxelGiVolume {
    VoxelGiVolume {
        sky: Some(Sky::uniform(LinearRgba::rgb(radiance, radiance, radiance))),
        ..small_volume()
    }
}

/// A volume of this size in metres, under a uniform sky.
pub fn sky_volume(size: f32, radiance: f32) -> VoxelGiVolume {
    VoxelGiVolume {
        size,
        ..under_sky(radiance)
    }
}

/// The only camera.
pub fn camera(world: &mut World) -> EntityWorldMut<'_> {
    let camera = world
        .query_filtered::<Entity, With<Camera3d>>()
        .single(world);
    world.entity_mut(camera.expect("a camera"))
}

pub fn point_light(lumens: f32, range: f32) -> PointLight {
    PointLight {
        intensity: lumens,
        range,
        ..default()
    }
}

/// A directional light.
pub fn sun(illuminance: f32, direction: Vec3) -> (DirectionalLight, Transform) {
    let light = DirectionalLight {
        illuminance,
        ..default()
    };
    (light, Transform::default().looking_to(direction, Vec3::Z))
}

/// Gives a gray material an emission.
pub fn emitting(albedo: f32, emissive: LinearRgba) -> StandardMaterial {
    StandardMaterial {
        emissive,
        ..StandardMaterial::from_color(LinearRgba::gray(albedo))
    }
}

/// A material without gloss that reflects this share of light.
pub fn matt_material(albedo: f32) -> StandardMaterial {
    StandardMaterial {
        perceptual_roughness: 1.0,
        reflectance: 0.0,
        ..StandardMaterial::from_color(LinearRgba::gray(albedo))
    }
}

pub fn matt(world: &mut World, albedo: f32) -> Handle<StandardMaterial> {
    world.add_asset(matt_material(albedo))
}

pub fn image_of(size: UVec2, format: TextureFormat, texels: Vec<u8>) -> Image {
    let usage = RenderAssetUsages::all();
    Image::new(
        size.to_extents(),
        TextureDimension::D2,
        texels,
        format,
        usage,
    )
}

/// The components of a mesh in this material.
pub fn model(
    world: &mut World,
    mesh: impl Into<Mesh>,
    material: impl Into<StandardMaterial>,
) -> (Mesh3d, MeshMaterial3d<StandardMaterial>) {
    let material = world.add_asset::<StandardMaterial>(material);
    (Mesh3d(world.add_asset(mesh)), MeshMaterial3d(material))
}

/// A dark box.
pub fn block(world: &mut World, center: Vec3, size: Vec3) -> Entity {
    block_of(world, 0.2, center, size)
}

/// A box that reflects this share of light.
pub fn block_of(world: &mut World, albedo: f32, center: Vec3, size: Vec3) -> Entity {
    let model = model(world, Cuboid::from_size(size), matt_material(albedo));
    world
        .spawn((model, Transform::from_translation(center)))
        .id()
}

/// The box from which most tests with one cast a shadow.
pub fn usual_block(world: &mut World) -> Entity {
    block(world, Vec3::new(1.0, 0.5, 0.1), Vec3::splat(1.1))
}

/// A white floor whose top is at y = 0.
pub fn floor(world: &mut World) -> Entity {
    let size = Vec3::new(3.8, 0.5, 3.8);
    block_of(world, 1.0, Vec3::new(0.0, -0.25, 0.0), size)
}

/// A flat box that two joints move, each by half.
pub fn skinned_cuboid(
    world: &mut World,
    joints: [Entity; 2],
    material: Handle<StandardMaterial>,
) -> (Mesh3d, MeshMaterial3d<StandardMaterial>, SkinnedMesh) {
    let mut mesh = Mesh::from(Cuboid::new(1.5, 0.2, 1.5));
    let count = mesh.count_vertices();
    mesh.insert_attribute(
        Mesh::ATTRIBUTE_JOINT_INDEX,
        VertexAttributeValues::Uint16x4(vec![[0, 1, 0, 0]; count]),
    );
    mesh.insert_attribute(
        Mesh::ATTRIBUTE_JOINT_WEIGHT,
        vec![[0.5_f32, 0.5, 0.0, 0.0]; count],
    );
    let poses = SkinnedMeshInverseBindposes::from(vec![Mat4::IDENTITY; 2]);
    let skin = SkinnedMesh {
        inverse_bindposes: world.add_asset(poses),
        joints: joints.to_vec(),
    };
    (
        Mesh3d(world.add_asset(mesh)),
        MeshMaterial3d(material),
        skin,
    )
}

pub fn pose(world: &mut World, entity: Entity) -> Mut<'_, Transform> {
    world.get_mut(entity).expect("a transform")
}

/// Changes the material of an entity, and so of all with that material.
pub fn edit_material(world: &mut World, entity: Entity, edit: impl FnOnce(&mut StandardMaterial)) {
    let material = world.get::<MeshMaterial3d<StandardMaterial>>(entity);
    let material = material.expect("a material").id();
    let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
    edit(&mut materials.get_mut(material).expect("a material"));
}

/// Scales the mesh of an entity, and so of all with that mesh.
pub fn scale_mesh(world: &mut World, entity: Entity, factors: Vec3) {
    let mesh = world.get::<Mesh3d>(entity).expect("a mesh").id();
    let mut meshes = world.resource_mut::<Assets<Mesh>>();
    meshes.get_mut(mesh).expect("a mesh").scale_by(factors);
}

/// Renders until all is loaded and compiled.
pub fn ready(app: &mut HeadlessApp) {
    app.run_until_ready(200).expect("ready");
}

/// Renders frames, in which a change is seen.
pub fn frames(app: &mut HeadlessApp, count: u32) {
    app.render_frames(count).expect("frames");
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
    let count = settle_in_view(app);
    let world = app.world_mut();
    for (camera, mut settings) in world.query::<(Entity, &mut Camera)>().iter_mut(world) {
        settings.viewport = viewports.remove(&camera).flatten();
    }
    frames(app, 1);
    count
}

/// The same with whole pictures, for light that depends on what cameras see.
pub fn settle_in_view(app: &mut HeadlessApp) -> u32 {
    for frame in 1..400 {
        frames(app, 1);
        if has_settled(app) {
            return frame;
        }
    }
    panic!("not settled: {:?}", report(app));
}

/// Whether the light has settled.
pub fn has_settled(app: &HeadlessApp) -> bool {
    report(app).state == VoxelGiState::Settled
}

/// The picture once all is loaded and the light has settled.
pub fn settled(app: &mut HeadlessApp) -> Vec<Vec3> {
    ready(app);
    settle(app);
    picture(app)
}

/// The same after a change, of which a report knows some frames later.
pub fn settled_again(app: &mut HeadlessApp) -> Vec<Vec3> {
    frames(app, 3);
    settle(app);
    picture(app)
}

/// The picture.
pub fn picture(app: &mut HeadlessApp) -> Vec<Vec3> {
    let image = app.capture_f32().expect("a picture");
    let pixels = image.pixels.iter();
    pixels.map(|p| Vec4::from(*p).truncate()).collect()
}

/// The light at a place of the floor: mean of 3 x 3 pixels, x and z in metres.
pub fn at(picture: &[Vec3], x: f32, z: f32) -> Vec3 {
    let pixel = |v: f32| ((v + 2.0) / 4.0 * SIZE as f32).floor() as i32;
    let (column, row) = (pixel(x), pixel(z));
    let mut sum = Vec3::ZERO;
    for dy in -1..=1 {
        for dx in -1..=1 {
            sum += picture[((row + dy) * SIZE as i32 + column + dx) as usize];
        }
    }
    sum / 9.0
}

/// Asserts that every channel is this but for this share of it.
#[track_caller]
pub fn assert_near(found: Vec3, expected: f32, tolerance: f32) {
    let wrong = (found / expected - 1.0).abs().max_element();
    assert!(wrong < tolerance, "{found} instead of {expected}");
}

/// What the volume adds to a picture: with it less without it.
pub fn indirect(app: &mut HeadlessApp, volume: impl Bundle) -> Vec<Vec3> {
    frames(app, 2);
    let without = picture(app);
    let entity = app.world_mut().spawn(volume).id();
    settle(app);
    let with = picture(app);
    app.world_mut().despawn(entity);
    difference(&with, &without)
}

/// The difference of two pictures.
pub fn difference(a: &[Vec3], b: &[Vec3]) -> Vec<Vec3> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// Mean difference as a share of the mean.
pub fn relative_difference(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    differences.sum::<f32>() / a.iter().map(|a| a.abs()).sum::<f32>()
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
    IrradianceField {
        grid: grid(scene, resolution),
        texels: read_texels(app),
    }
}

/// The voxels of the volume that a scene takes.
pub fn grid(scene: &BoxScene, resolution: u32) -> VolumeGrid {
    let (center, size) = scene.volume(resolution);
    VolumeGrid {
        min: center - 0.5 * size,
        voxel_size: size / resolution as f32,
        resolution,
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
