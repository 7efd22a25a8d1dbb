//! Only what has changed is voxelised: after any motion the light is that of a new app.

use bevy::{
    asset::RenderAssetUsages,
    camera::{primitives::Aabb, visibility::NoFrustumCulling},
    light::NotShadowCaster,
    mesh::{
        Indices, PrimitiveTopology,
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    prelude::*,
};
use bevy_frugal_lab::headless::HeadlessApp;
use bevy_voxel_gi::{Follow, NotVoxelized, VoxelGiReport, VoxelGiVolume};

use super::{
    history::copy,
    materials::skinned_cuboid,
    room::image,
    scene::{app_with, at, block, block_of, floor, matt, settings, under_sky},
    support::{has_settled, light_texture_bytes, picture, settle},
};
use crate::support::gpu;

/// Pseudo-random numbers from -1 to 1.
struct Random(u32);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / 8_388_608.0 - 1.0
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }
}

fn emissive(world: &mut World, center: Vec3, size: Vec3, color: LinearRgba) -> Entity {
    let entity = block(world, center, size);
    let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
    let material = materials.add(StandardMaterial {
        base_color: Color::BLACK,
        emissive: color,
        ..default()
    });
    world.entity_mut(entity).insert(MeshMaterial3d(material));
    entity
}

/// A room without a ceiling with things in it, some of which move: their entities.
fn room(world: &mut World) -> Vec<Entity> {
    floor(world);
    let red = LinearRgba::rgb(20.0, 2.0, 1.0);
    for side in [-1.0, 1.0] {
        block_of(
            world,
            0.7,
            Vec3::new(1.8 * side, 0.9, 0.0),
            Vec3::new(0.1, 1.8, 3.6),
        );
        block_of(
            world,
            0.7,
            Vec3::new(0.0, 0.4, 1.75 * side),
            Vec3::new(3.6, 0.8, 0.15),
        );
        // Strips that fill a part of voxels, beside and behind what moves.
        emissive(
            world,
            Vec3::new(0.4 * side, 0.9, 0.3),
            Vec3::new(0.05, 0.05, 2.0),
            red,
        );
    }
    let green = LinearRgba::rgb(0.5, 9.0, 2.0);
    let caster = block(world, Vec3::new(0.5, 0.3, -0.5), Vec3::new(0.5, 0.6, 0.3));
    let no_caster = block_of(world, 0.9, Vec3::new(-0.7, 0.5, 0.6), Vec3::splat(0.4));
    world.entity_mut(no_caster).insert(NotShadowCaster);
    let lamp = emissive(world, Vec3::new(0.0, 0.7, 0.0), Vec3::splat(0.15), green);
    world.spawn((
        PointLight {
            intensity: 3000.0,
            range: 8.0,
            ..default()
        },
        Transform::from_xyz(0.2, 1.6, 0.1),
        Visibility::Visible,
    ));
    vec![caster, no_caster, lamp]
}

/// The light of all levels, and what divides their voxels.
fn settled(app: &mut HeadlessApp) -> [Vec<f32>; 2] {
    app.render_frames(2).expect("frames");
    settle(app);
    let bytes = light_texture_bytes(app);
    let halves = bytes.as_chunks::<2>().0.iter();
    let all: Vec<_> = halves
        .map(|bytes| half::f16::from_le_bytes(*bytes).to_f32())
        .collect();
    // A level takes three and a quarter times its resolution in slices, and up to two more are empty.
    let resolution = 16;
    let slice = 4 * 2 * resolution * resolution;
    let levels = 4 * all.len() / (13 * resolution * slice);
    let (light, dividers) = all.split_at(3 * levels * resolution * slice);
    [light.to_vec(), dividers.to_vec()]
}

/// Mean difference as a share of the mean.
fn difference(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    let of = |values: &mut dyn Iterator<Item = f32>| values.map(f32::abs).sum::<f32>();
    of(&mut a.iter().zip(b).map(|(a, b)| a - b)) / of(&mut b.iter().copied())
}

/// Moves things and the camera about, and compares the light with that of a new app now and then.
fn move_about(volume: VoxelGiVolume, camera_moves: bool) {
    let mut app = app_with(|_| ());
    let movers = room(app.world_mut());
    app.world_mut().spawn(volume);
    app.run_until_ready(200).expect("ready");
    let [mut before, _] = settled(&mut app);
    let mut random = Random(7);
    for round in 0..3 {
        for _ in 0..4 {
            let world = app.world_mut();
            for &entity in &movers {
                let by = 0.3 * random.vector();
                let mut transform = world.get_mut::<Transform>(entity).expect("it");
                transform.translation = (transform.translation + by)
                    .clamp(Vec3::new(-1.2, 0.2, -1.2), Vec3::new(1.2, 1.2, 1.2));
                transform.rotate_y(0.5 * random.next());
            }
            // A lamp that pulses has itself voxelised anew, and nothing else.
            let lamp = movers[2];
            let material = world.get::<MeshMaterial3d<StandardMaterial>>(lamp);
            let material = material.expect("a material").0.clone();
            let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
            let green = 9.0 + 5.0 * random.next();
            materials
                .get_mut(&material)
                .expect("a material")
                .emissive
                .green = green;
            if camera_moves {
                let by = Vec3::new(1.0, 0.2, 1.0) * random.vector();
                let mut camera = camera(world);
                camera.translation = (camera.translation + by)
                    .clamp(Vec3::new(-2.0, 3.0, -2.0), Vec3::new(2.0, 4.0, 2.0));
            }
            app.render_frames(1).expect("a frame");
        }
        // Light that moves with a volume keeps its mean; another lamp begins anew, in both apps.
        let [moved, _] = settled(&mut app);
        let world = app.world_mut();
        let mut lamps = world.query::<&mut PointLight>();
        lamps.single_mut(world).expect("a lamp").intensity += 500.0;
        let [found, dividers] = settled(&mut app);
        println!("light that has moved: {:.6}", difference(&moved, &found));
        let mut new = app_with(|_| ());
        copy(app.world_mut(), new.world_mut());
        let place = *camera(app.world_mut());
        *camera(new.world_mut()) = place;
        new.run_until_ready(200).expect("ready");
        let [anew, new_dividers] = settled(&mut new);
        let (wrong, effect) = (difference(&found, &anew), difference(&before, &anew));
        println!("round {round}: {wrong:.6} of an effect of {effect:.5}");
        assert!(effect > 0.01, "round {round}: {effect}");
        assert!(wrong < 1e-4, "round {round}: {wrong}");
        assert!(dividers == new_dividers, "round {round}");
        before = found;
    }
}

fn camera(world: &mut World) -> Mut<'_, Transform> {
    let mut cameras = world.query_filtered::<&mut Transform, With<Camera3d>>();
    cameras.single_mut(world).expect("a camera")
}

#[test]
fn after_things_have_moved_the_light_is_that_of_a_new_app() {
    let _gpu = gpu();
    move_about(under_sky(0.5), false);
}

#[test]
fn after_a_flight_of_cascades_the_light_is_that_of_a_new_app() {
    let _gpu = gpu();
    let volume = VoxelGiVolume {
        size: 1.5,
        cascades: 3,
        follow: Follow::Camera,
        ..under_sky(0.5)
    };
    move_about(volume, true);
}

/// Relative change of the light of points from frame to frame, root mean square and greatest, while something moves.
fn change_of(
    points: &[Vec2],
    app: &mut HeadlessApp,
    frames: u32,
    mut step: impl FnMut(&mut World, u32),
) -> (f32, f32) {
    let light = |app: &mut HeadlessApp| {
        let picture = picture(app);
        let of_points = points.iter().map(|p| at(&picture, p.x, p.y).element_sum());
        of_points.collect::<Vec<_>>()
    };
    let mut previous = light(app);
    let (mut most, mut squares) = (0.0_f32, 0.0);
    for frame in 0..frames {
        step(app.world_mut(), frame);
        app.render_frames(1).expect("a frame");
        let now = light(app);
        for (a, b) in previous.iter().zip(&now) {
            let change = (b - a).abs() / a;
            most = most.max(change);
            squares += change * change;
        }
        previous = now;
    }
    let mean = (squares / (frames as usize * points.len()) as f32).sqrt();
    println!("change from frame to frame: {mean:.4}, {most:.4} at most");
    (mean, most)
}

/// The room with three cascades around an entity at this x, settled.
fn room_with_cascades(x: f32) -> (HeadlessApp, Entity) {
    let mut app = app_with(|_| ());
    let world = app.world_mut();
    room(world);
    let leader = world.spawn(Transform::from_xyz(x, 0.5, 0.3)).id();
    world.spawn(VoxelGiVolume {
        size: 2.0,
        cascades: 3,
        follow: Follow::Entity(leader),
        ..under_sky(0.5)
    });
    app.run_until_ready(200).expect("ready");
    settle(&mut app);
    (app, leader)
}

/// Points on the floor around the middle of the room.
fn floor_points() -> Vec<Vec2> {
    let point = |i: i32| Vec2::new((i % 7 - 3) as f32, (i / 7 - 3) as f32) * 0.45;
    (0..49).map(point).collect()
}

/// Cascades that fly past leave light where it is: it changes from that of one size of voxels to that of another slowly.
#[test]
fn light_changes_slowly_where_cascades_fly_past() {
    let _gpu = gpu();
    let (mut app, leader) = room_with_cascades(-1.5);
    let (mean, most) = change_of(&floor_points(), &mut app, 60, |world, _| {
        let mut transform = world.get_mut::<Transform>(leader).expect("it");
        transform.translation.x += 0.05;
    });
    assert!(mean < 0.005 && most < 0.03, "{mean} {most}");
}

/// What is in no voxel, as a view model or particles, has the light of the empty voxels around. It stays the same from
/// frame to frame, and where the cascades follow something.
#[test]
fn what_is_not_voxelized_does_not_flicker_where_cascades_move() {
    let _gpu = gpu();
    let (mut app, leader) = room_with_cascades(0.9);
    let middle = Vec3::new(1.1, 0.9, 1.1);
    let plate = block(app.world_mut(), middle, Vec3::new(0.6, 0.02, 0.6));
    app.world_mut().entity_mut(plate).insert(NotVoxelized);
    let mut transform = app.world_mut().get_mut::<Transform>(leader).expect("it");
    transform.translation = middle - Vec3::X * 0.2;
    app.render_frames(2).expect("frames");
    settle(&mut app);
    let point = |i: i32| middle.xz() + Vec2::new((i % 5 - 2) as f32, (i / 5 - 2) as f32) * 0.1;
    let points: Vec<_> = (0..25).map(point).collect();
    let (mean, most) = change_of(&points, &mut app, 40, |world, frame| {
        let mut transform = world.get_mut::<Transform>(leader).expect("it");
        transform.translation.x += if frame < 20 { 0.02 } else { 0.0 };
    });
    assert!(mean < 0.0015 && most < 0.015, "{mean} {most}");
}

/// After a cut all voxels of the cascades are new, and have no light to keep.
#[test]
fn after_a_cut_of_the_camera_light_is_soon_what_it_is_at_rest() {
    let _gpu = gpu();
    let (mut app, leader) = room_with_cascades(40.0);
    let mut transform = app.world_mut().get_mut::<Transform>(leader).expect("it");
    transform.translation.x = 0.1;
    let points = floor_points();
    let light = |app: &mut HeadlessApp, frames: u32| -> Vec<f32> {
        app.render_frames(frames).expect("frames");
        let picture = picture(app);
        let of_points = points.iter().map(|p| at(&picture, p.x, p.y).element_sum());
        of_points.collect()
    };
    let soon = [8, 22].map(|frames| light(&mut app, frames));
    settle(&mut app);
    let at_rest = light(&mut app, 1);
    let [after_8, after_30] = soon.map(|soon| {
        let squares = { soon.iter().zip(&at_rest) }.map(|(a, b)| (a / b - 1.0).powi(2));
        (squares.sum::<f32>() / points.len() as f32).sqrt()
    });
    println!("from the light at rest: {after_8:.4} after 8 frames, {after_30:.4} after 30");
    assert!(after_8 < 0.12 && after_30 < 0.01, "{after_8} {after_30}");
}

/// The light of resting surfaces does not flicker while a small mesh elsewhere begins to move, moves and stops, and until
/// it has converged again.
#[test]
fn light_does_not_flicker_when_something_begins_to_move_or_stops() {
    let _gpu = gpu();
    let mut app = app_with(|_| ());
    let world = app.world_mut();
    room(world);
    let mover = block(world, Vec3::new(1.6, 0.1, 1.5), Vec3::splat(0.12));
    world.spawn(under_sky(0.5));
    app.run_until_ready(200).expect("ready");
    settle(&mut app);
    let points: Vec<_> = (0..36)
        .map(|i| Vec2::new((i % 6) as f32, (i / 6) as f32) * 0.45 - Vec2::splat(1.6))
        .collect();
    let (mean, most) = change_of(&points, &mut app, 90, |world, frame| {
        if frame < 20 {
            let mut transform = world.get_mut::<Transform>(mover).expect("it");
            transform.translation.y += 0.01;
        }
    });
    assert!(mean < 0.005 && most < 0.03, "{mean} {most}");
    assert!(has_settled(&app));
}

/// Hills of 2 n² triangles on a square of this edge in metres.
fn hills(n: u32, edge: f32) -> Mesh {
    let mut positions = Vec::new();
    let mut indices = Vec::new();
    for z in 0..=n {
        for x in 0..=n {
            let p = (Vec2::new(x as f32, z as f32) / n as f32 - 0.5) * edge;
            positions.push([p.x, 0.4 * (1.3 * p.x).sin() * (0.9 * p.y).cos(), p.y]);
            let (a, b) = (z * (n + 1) + x, (z + 1) * (n + 1) + x);
            if x < n && z < n {
                indices.extend([a, b, a + 1, a + 1, b, b + 1]);
            }
        }
    }
    Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::default(),
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
    .with_inserted_indices(Indices::U32(indices))
    .with_computed_normals()
}

/// Half a million triangles in one mesh, in a volume of 16 m and 32^3 voxels.
fn large_level() -> (HeadlessApp, Handle<StandardMaterial>) {
    let mut app = app_with(|_| ());
    let world = app.world_mut();
    let material = matt(world, 0.5);
    let mesh = hills(512, 14.0);
    let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
    world.spawn((Mesh3d(mesh), MeshMaterial3d(material.clone())));
    settings(world).resolution = 32;
    world.spawn(VoxelGiVolume {
        size: 16.0,
        ..under_sky(1.0)
    });
    (app, material)
}

/// Changes something in some frames; the median milliseconds of the passes of voxelisation, which are known in later
/// frames, and the number of triangles that were voxelised.
fn voxelized(app: &mut HeadlessApp, mut change: impl FnMut(&mut World)) -> (f64, u64) {
    let mut times = Vec::new();
    for _ in 0..6 {
        change(app.world_mut());
        let (_, spans) = app.measure_spans(1).expect("frames");
        let passes = ["clear", "voxelize", "surfaces"].map(|pass| format!("voxel_gi_{pass}"));
        times.push(
            passes
                .iter()
                .filter_map(|pass| spans.get(pass))
                .sum::<f64>(),
        );
    }
    times.sort_by(f64::total_cmp);
    app.render_frames(4).expect("frames");
    let report = app.world().resource::<VoxelGiReport>();
    (times[times.len() / 2], report.voxelized_triangles)
}

#[test]
fn a_small_thing_that_moves_in_a_large_level_has_little_voxelised() {
    const LEVEL: u64 = 2 * 512 * 512;
    let _gpu = gpu();
    let (mut app, material) = large_level();
    let mover = block(app.world_mut(), Vec3::new(0.0, 0.5, 0.0), Vec3::ONE);
    app.run_until_ready(200).expect("ready");
    let mut step = 0.0;
    let (some, triangles) = voxelized(&mut app, |world| {
        step += 0.3;
        let mut transform = world.get_mut::<Transform>(mover).expect("it");
        transform.translation.x = step;
    });
    let (all, whole) = voxelized(&mut app, |world| {
        step += 0.1;
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        let color = Color::linear_rgb(step % 1.0, 0.5, 0.5);
        materials.get_mut(&material).expect("it").base_color = color;
    });
    println!("{triangles} triangles in {some:.2} ms, {whole} in {all:.2} ms");
    assert_eq!(whole, LEVEL + 64);
    assert!((64..LEVEL / 20).contains(&triangles), "{triangles}");
    // What is never culled has no `Aabb`, as view models have none.
    app.world_mut()
        .entity_mut(mover)
        .insert(NoFrustumCulling)
        .remove::<Aabb>();
    app.render_frames(4).expect("frames");
    let (_, triangles) = voxelized(&mut app, |world| {
        step -= 0.2;
        let mut transform = world.get_mut::<Transform>(mover).expect("it");
        transform.translation.x = step;
    });
    println!("{triangles} triangles of what is never culled");
    assert!((64..LEVEL / 20).contains(&triangles), "{triangles}");
}

/// Textures that come with what is streamed in, and those that are painted on.
#[test]
fn new_textures_of_a_small_thing_in_a_large_level_have_little_voxelised() {
    const LEVEL: u64 = 2 * 512 * 512;
    let _gpu = gpu();
    let (mut app, _) = large_level();
    let world = app.world_mut();
    let thing = block(world, Vec3::new(0.0, 0.5, 0.0), Vec3::ONE);
    let texture = |red: u8| image(UVec2::splat(8), |_, _| [red, 90, 90, 255]);
    let painted = world.resource_mut::<Assets<Image>>().add(texture(0));
    let material = world.get::<MeshMaterial3d<StandardMaterial>>(thing);
    let material = material.expect("a material").0.clone();
    let set_texture = |world: &mut World, texture: Handle<Image>| {
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        let mut material = materials.get_mut(&material).expect("it");
        material.base_color_texture = Some(texture);
    };
    set_texture(world, painted.clone());
    app.run_until_ready(200).expect("ready");
    settle(&mut app);
    let before = at(&picture(&mut app), 1.0, 0.0);
    let mut red = 0;
    let (_, painted_on) = voxelized(&mut app, |world| {
        red += 42;
        let mut images = world.resource_mut::<Assets<Image>>();
        images.get_mut(&painted).expect("it").data = texture(red).data;
    });
    settle(&mut app);
    let after = at(&picture(&mut app), 1.0, 0.0);
    let (_, other) = voxelized(&mut app, |world| {
        red -= 42;
        let other = world.resource_mut::<Assets<Image>>().add(texture(red));
        set_texture(world, other);
    });
    println!(
        "{painted_on} and {other} triangles, red light {} {}",
        before.x, after.x
    );
    assert!(after.x > 1.02 * before.x, "{before} {after}");
    for triangles in [painted_on, other] {
        assert!((64..LEVEL / 20).contains(&triangles), "{triangles}");
    }
}

/// The brightest one gives the unit of emission: the others are written anew in the new unit, but nothing else is.
#[test]
fn an_emissive_block_that_brightens_in_a_large_level_has_little_voxelised() {
    const LEVEL: u64 = 2 * 512 * 512;
    let _gpu = gpu();
    let (mut app, _) = large_level();
    let world = app.world_mut();
    let color = LinearRgba::rgb(100.0, 0.0, 0.0);
    emissive(world, Vec3::new(2.3, 0.5, 0.0), Vec3::splat(0.3), color);
    let brighter = emissive(world, Vec3::new(0.0, 0.5, 0.0), Vec3::splat(0.3), color);
    let material = world.get::<MeshMaterial3d<StandardMaterial>>(brighter);
    let material = material.expect("a material").0.clone();
    app.run_until_ready(200).expect("ready");
    settle(&mut app);
    let beside = at(&picture(&mut app), 1.7, 0.0);
    let (_, triangles) = voxelized(&mut app, |world| {
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        materials.get_mut(&material).expect("it").emissive.green += 300.0;
    });
    println!("{triangles} triangles");
    assert!((64..LEVEL / 20).contains(&triangles), "{triangles}");
    settle(&mut app);
    let after = at(&picture(&mut app), 1.7, 0.0);
    println!("{beside} {after}");
    assert!(after.y > 1.2 * beside.y, "{beside} {after}");
    assert!((after.x / beside.x - 1.0).abs() < 2e-3, "{beside} {after}");
}

#[test]
fn crowds_have_their_own_triangles_voxelised_and_what_is_near_them() {
    const BODIES: u64 = 1000;
    const CHARACTERS: u64 = 10;
    let _gpu = gpu();
    let (mut app, _) = large_level();
    let world = app.world_mut();
    let mut random = Random(3);
    let mesh = world
        .resource_mut::<Assets<Mesh>>()
        .add(Cuboid::from_length(0.1));
    let material = matt(world, 0.8);
    let bodies: Vec<_> = (0..2 * BODIES)
        .map(|i| {
            // Above the hills, and as many outside of the volume.
            let outside = if i % 2 == 0 { 0.0 } else { 30.0 };
            let at = Vec3::new(6.5, 1.0, 6.5) * random.vector() + Vec3::Y * (3.0 + outside);
            let place = Transform::from_translation(at);
            world
                .spawn((
                    Mesh3d(mesh.clone()),
                    MeshMaterial3d(material.clone()),
                    place,
                ))
                .id()
        })
        .collect();
    // Characters, of which half move, too. They are apart from each other.
    let skinned = world.resource_mut::<Assets<Mesh>>().add(skinned_cuboid());
    let poses = SkinnedMeshInverseBindposes::from(vec![Mat4::IDENTITY; 2]);
    let inverse_bindposes = world.resource_mut::<Assets<_>>().add(poses);
    let mut joints = Vec::new();
    for i in 0..2 * CHARACTERS {
        let row = if i < CHARACTERS { -6.5 } else { 5.5 };
        let at = Vec3::new(1.5 * (i % CHARACTERS) as f32 - 7.0, row, 6.5);
        let joint = world.spawn(Transform::from_translation(at)).id();
        joints.push(joint);
        let skin = SkinnedMesh {
            inverse_bindposes: inverse_bindposes.clone(),
            joints: vec![joint; 2],
        };
        world.spawn((
            Mesh3d(skinned.clone()),
            MeshMaterial3d(material.clone()),
            skin,
        ));
    }
    app.run_until_ready(200).expect("ready");
    let moving = &joints[CHARACTERS as usize..];
    let (time, triangles) = voxelized(&mut app, |world| {
        for &entity in bodies.iter().chain(moving) {
            let mut place = world.get_mut::<Transform>(entity).expect("it");
            place.translation.y += 0.05;
        }
    });
    println!("{triangles} triangles, {time:.2} ms");
    assert_eq!(triangles, 64 * (BODIES + CHARACTERS));
}
