//! Only what has changed is voxelised: after any motion the light is that of a new app.

use bevy::{
    camera::{primitives::Aabb, visibility::NoFrustumCulling},
    light::NotShadowCaster,
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};
use bevy_voxel_gi::{Follow, NotVoxelized, VoxelGiVolume};

use super::{fixture::*, history::copied, room::image};
use crate::support::triangle_mesh;

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
    let model = model(world, Cuboid::from_size(size), emitting(0.0, color));
    world
        .spawn((model, Transform::from_translation(center)))
        .id()
}

/// A room without a ceiling with things in it, some of which move: their entities.
fn room(world: &mut World) -> Vec<Entity> {
    floor(world);
    let red = LinearRgba::rgb(20.0, 2.0, 1.0);
    for side in [-1.0, 1.0] {
        let (wall, low) = (Vec3::new(0.1, 1.8, 3.6), Vec3::new(3.6, 0.8, 0.15));
        block_of(world, 0.7, Vec3::new(1.8 * side, 0.9, 0.0), wall);
        block_of(world, 0.7, Vec3::new(0.0, 0.4, 1.75 * side), low);
        // Strips that fill a part of voxels, beside and behind what moves.
        let strip = Vec3::new(0.05, 0.05, 2.0);
        emissive(world, Vec3::new(0.4 * side, 0.9, 0.3), strip, red);
    }
    let green = LinearRgba::rgb(0.5, 9.0, 2.0);
    let caster = block(world, Vec3::new(0.5, 0.3, -0.5), Vec3::new(0.5, 0.6, 0.3));
    let no_caster = block_of(world, 0.9, Vec3::new(-0.7, 0.5, 0.6), Vec3::splat(0.4));
    world.entity_mut(no_caster).insert(NotShadowCaster);
    let lamp = emissive(world, Vec3::new(0.0, 0.7, 0.0), Vec3::splat(0.15), green);
    world.spawn((
        point_light(3000.0, 8.0),
        Transform::from_xyz(0.2, 1.6, 0.1),
        Visibility::Visible,
    ));
    vec![caster, no_caster, lamp]
}

/// The light of all levels, and what divides their voxels.
fn settled_light(app: &mut HeadlessApp) -> [Vec<f32>; 2] {
    frames(app, 2);
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

/// Moves things and the camera about, and compares the light with that of a new app now and then.
fn move_about(volume: VoxelGiVolume, camera_moves: bool) {
    let mut app = app_with(|_| ());
    let movers = room(app.world_mut());
    app.world_mut().spawn(volume);
    ready(&mut app);
    let [mut before, _] = settled_light(&mut app);
    let mut random = Random(7);
    for round in 0..3 {
        for _ in 0..4 {
            let world = app.world_mut();
            for &entity in &movers {
                let by = 0.3 * random.vector();
                let mut pose = pose(world, entity);
                pose.translation = (pose.translation + by)
                    .clamp(Vec3::new(-1.2, 0.2, -1.2), Vec3::new(1.2, 1.2, 1.2));
                pose.rotate_y(0.5 * random.next());
            }
            // An emissive block that pulses has itself voxelised anew, and nothing else.
            let green = 9.0 + 5.0 * random.next();
            edit_material(world, movers[2], |material| material.emissive.green = green);
            if camera_moves {
                let by = Vec3::new(1.0, 0.2, 1.0) * random.vector();
                let mut camera = camera_pose(world);
                camera.translation = (camera.translation + by)
                    .clamp(Vec3::new(-2.0, 3.0, -2.0), Vec3::new(2.0, 4.0, 2.0));
            }
            frames(&mut app, 1);
        }
        // Light that moves with a volume keeps its mean; another lamp begins anew, in both apps.
        let [moved, _] = settled_light(&mut app);
        let world = app.world_mut();
        let mut lamps = world.query::<&mut PointLight>();
        lamps.single_mut(world).expect("a lamp").intensity += 500.0;
        let [found, dividers] = settled_light(&mut app);
        println!(
            "light that has moved: {:.6}",
            relative_difference(&found, &moved)
        );
        let mut new = copied(&mut app);
        let place = *camera_pose(app.world_mut());
        *camera_pose(new.world_mut()) = place;
        ready(&mut new);
        let [anew, new_dividers] = settled_light(&mut new);
        let (wrong, effect) = (
            relative_difference(&anew, &found),
            relative_difference(&anew, &before),
        );
        println!("round {round}: {wrong:.6} of an effect of {effect:.5}");
        assert!(effect > 0.01, "round {round}: {effect}");
        assert!(wrong < 1e-4, "round {round}: {wrong}");
        assert!(dividers == new_dividers, "round {round}");
        before = found;
    }
}

fn camera_pose(world: &mut World) -> Mut<'_, Transform> {
    let mut cameras = world.query_filtered::<&mut Transform, With<Camera3d>>();
    cameras.single_mut(world).expect("a camera")
}

#[test]
#[ignore = "long: flights"]
fn after_things_have_moved_the_light_is_that_of_a_new_app() {
    move_about(under_sky(0.5), false);
}

#[test]
#[ignore = "long: flights"]
fn after_a_flight_of_cascades_the_light_is_that_of_a_new_app() {
    let volume = VoxelGiVolume {
        size: 1.5,
        cascades: 3,
        follow: Follow::Camera,
        ..under_sky(0.5)
    };
    move_about(volume, true);
}

fn light_at(points: &[Vec2], app: &mut HeadlessApp) -> Vec<f32> {
    let picture = picture(app);
    let light = points.iter().map(|p| at(&picture, p.x, p.y).element_sum());
    light.collect()
}

/// Relative change of the light of points from frame to frame, root mean square and greatest, while something moves.
fn change_of(
    points: &[Vec2],
    app: &mut HeadlessApp,
    count: u32,
    mut step: impl FnMut(&mut World, u32),
) -> (f32, f32) {
    let mut previous = light_at(points, app);
    let (mut most, mut squares) = (0.0_f32, 0.0);
    for frame in 0..count {
        step(app.world_mut(), frame);
        frames(app, 1);
        let now = light_at(points, app);
        for (a, b) in previous.iter().zip(&now) {
            let change = (b - a).abs() / a;
            most = most.max(change);
            squares += change * change;
        }
        previous = now;
    }
    let mean = (squares / (count as usize * points.len()) as f32).sqrt();
    println!("change from frame to frame: {mean:.4}, {most:.4} at most");
    (mean, most)
}

/// The room with three cascades around an entity at this x, settled.
fn room_with_cascades(x: f32) -> (Borrowed, Entity) {
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
    ready(&mut app);
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
#[ignore = "long: flights"]
fn light_changes_slowly_where_cascades_fly_past() {
    let (mut app, leader) = room_with_cascades(-1.5);
    let (mean, most) = change_of(&floor_points(), &mut app, 60, |world, _| {
        pose(world, leader).translation.x += 0.05;
    });
    assert!(mean < 0.005 && most < 0.03, "{mean} {most}");
}

/// Empty voxels that stay in a level keep their light when it steps, except for the eighth that each frame updates.
#[test]
fn a_level_that_steps_computes_the_light_of_new_empty_voxels_alone() {
    let (mut app, leader) = room_with_cascades(-0.5);
    let before = read_texels(&mut app);
    // Two voxels of the smallest cascade.
    pose(app.world_mut(), leader).translation.x += 0.25;
    frames(&mut app, 1);
    let after = read_texels(&mut app);
    let is_empty = |texel: &Vec4| (1e-6..0.002).contains(&texel.w);
    let (mut kept, mut stay, mut new) = (0, 0, 0);
    for (i, faces) in after.iter().enumerate() {
        for (face, texel) in faces.iter().enumerate().filter(|(_, t)| is_empty(t)) {
            if i % 16 >= 14 {
                new += 1;
            } else {
                stay += usize::from(is_empty(&before[i + 2][face]));
                kept += usize::from(*texel == before[i + 2][face]);
            }
        }
    }
    println!("{kept} of {stay} empty faces keep their light, {new} are new");
    assert!(stay > 5000 && new > 700, "{stay} {new}");
    assert!(kept * 10 > stay * 8, "{kept} of {stay}");
}

/// What is in no voxel, as a view model or particles, has the light of the empty voxels around. It stays the same from
/// frame to frame, and where the cascades follow something.
#[test]
#[ignore = "long: flights"]
fn what_is_not_voxelized_does_not_flicker_where_cascades_move() {
    let (mut app, leader) = room_with_cascades(0.9);
    let middle = Vec3::new(1.1, 0.9, 1.1);
    let plate = block(app.world_mut(), middle, Vec3::new(0.6, 0.02, 0.6));
    app.world_mut().entity_mut(plate).insert(NotVoxelized);
    pose(app.world_mut(), leader).translation = middle - Vec3::X * 0.2;
    frames(&mut app, 2);
    settle(&mut app);
    let point = |i: i32| middle.xz() + Vec2::new((i % 5 - 2) as f32, (i / 5 - 2) as f32) * 0.1;
    let points: Vec<_> = (0..25).map(point).collect();
    let (mean, most) = change_of(&points, &mut app, 40, |world, frame| {
        pose(world, leader).translation.x += if frame < 20 { 0.02 } else { 0.0 };
    });
    assert!(mean < 0.0015 && most < 0.015, "{mean} {most}");
}

/// After a cut all voxels of the cascades are new, and have no light to keep.
#[test]
#[ignore = "long: a flight"]
fn after_a_cut_of_the_camera_light_is_soon_what_it_is_at_rest() {
    let (mut app, leader) = room_with_cascades(40.0);
    pose(app.world_mut(), leader).translation.x = 0.1;
    let points = floor_points();
    let soon = [8, 22].map(|count| {
        frames(&mut app, count);
        light_at(&points, &mut app)
    });
    settle(&mut app);
    frames(&mut app, 1);
    let at_rest = light_at(&points, &mut app);
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
    let mut app = app_with(|_| ());
    let world = app.world_mut();
    room(world);
    let mover = block(world, Vec3::new(1.6, 0.1, 1.5), Vec3::splat(0.12));
    world.spawn(under_sky(0.5));
    ready(&mut app);
    settle(&mut app);
    let points: Vec<_> = (0..36)
        .map(|i| Vec2::new((i % 6) as f32, (i / 6) as f32) * 0.45 - Vec2::splat(1.6))
        .collect();
    let (mean, most) = change_of(&points, &mut app, 90, |world, frame| {
        if frame < 20 {
            pose(world, mover).translation.y += 0.01;
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
    triangle_mesh(PrimitiveTopology::TriangleList, positions)
        .with_inserted_indices(Indices::U32(indices))
        .with_computed_normals()
}

/// Half a million triangles in one mesh, in a volume of 16 m and 32^3 voxels.
fn large_level() -> (Borrowed, Entity) {
    let mut app = app_with(|_| ());
    let world = app.world_mut();
    let model = model(world, hills(512, 14.0), matt_material(0.5));
    let level = world.spawn(model).id();
    settings(world).resolution = 32;
    world.spawn(sky_volume(16.0, 1.0));
    (app, level)
}

/// Triangles of the large level.
const LEVEL: u64 = 2 * 512 * 512;

/// Asserts that a block is voxelised with what is around it, but not the level.
#[track_caller]
fn assert_little(triangles: u64) {
    assert!((64..LEVEL / 20).contains(&triangles), "{triangles}");
}

/// Changes something in some frames; the median milliseconds of the passes of voxelisation, which are known in later
/// frames, and the number of triangles that were voxelised.
fn voxelized(app: &mut HeadlessApp, mut change: impl FnMut(&mut World)) -> (f64, u64) {
    let mut times = Vec::new();
    for _ in 0..6 {
        change(app.world_mut());
        let (_, spans) = app.measure_spans(1).expect("frames");
        let passes = ["clear", "voxelize", "surfaces"].map(|pass| format!("voxel_gi_{pass}"));
        let times_of_passes = passes.iter().filter_map(|pass| spans.get(pass));
        times.push(times_of_passes.sum::<f64>());
    }
    times.sort_by(f64::total_cmp);
    frames(app, 4);
    (times[times.len() / 2], report(app).voxelized_triangles)
}

#[test]
#[ignore = "long: a large level"]
fn a_small_thing_that_moves_in_a_large_level_has_little_voxelised() {
    let (mut app, level) = large_level();
    let mover = block(app.world_mut(), Vec3::new(0.0, 0.5, 0.0), Vec3::ONE);
    ready(&mut app);
    let mut step = 0.0;
    let (some, triangles) = voxelized(&mut app, |world| {
        step += 0.3;
        pose(world, mover).translation.x = step;
    });
    let (all, whole) = voxelized(&mut app, |world| {
        step += 0.1;
        let color = Color::linear_rgb(step % 1.0, 0.5, 0.5);
        edit_material(world, level, |material| material.base_color = color);
    });
    println!("{triangles} triangles in {some:.2} ms, {whole} in {all:.2} ms");
    assert_eq!(whole, LEVEL + 64);
    assert_little(triangles);
    // What is never culled has no `Aabb`, as view models have none.
    app.world_mut()
        .entity_mut(mover)
        .insert(NoFrustumCulling)
        .remove::<Aabb>();
    frames(&mut app, 4);
    let (_, triangles) = voxelized(&mut app, |world| {
        step -= 0.2;
        pose(world, mover).translation.x = step;
    });
    println!("{triangles} triangles of what is never culled");
    assert_little(triangles);
}

/// Textures that come with what is streamed in, and those that are painted on.
#[test]
#[ignore = "long: a large level"]
fn new_textures_of_a_small_thing_in_a_large_level_have_little_voxelised() {
    let (mut app, _) = large_level();
    let world = app.world_mut();
    let thing = block(world, Vec3::new(0.0, 0.5, 0.0), Vec3::ONE);
    let texture = |red: u8| image(UVec2::splat(8), |_, _| [red, 90, 90, 255]);
    let painted = world.add_asset(texture(0));
    let set_texture = |world: &mut World, texture: Handle<Image>| {
        edit_material(world, thing, |material| {
            material.base_color_texture = Some(texture);
        });
    };
    set_texture(world, painted.clone());
    let before = at(&settled(&mut app), 1.0, 0.0);
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
        let other = world.add_asset(texture(red));
        set_texture(world, other);
    });
    println!(
        "{painted_on} and {other} triangles, red light {} {}",
        before.x, after.x
    );
    assert!(after.x > 1.02 * before.x, "{before} {after}");
    for triangles in [painted_on, other] {
        assert_little(triangles);
    }
}

/// The brightest one gives the unit of emission: the others are written anew in the new unit, but nothing else is.
#[test]
#[ignore = "long: a large level"]
fn an_emissive_block_that_brightens_in_a_large_level_has_little_voxelised() {
    let (mut app, _) = large_level();
    let world = app.world_mut();
    let color = LinearRgba::rgb(100.0, 0.0, 0.0);
    emissive(world, Vec3::new(2.3, 0.5, 0.0), Vec3::splat(0.3), color);
    let brighter = emissive(world, Vec3::new(0.0, 0.5, 0.0), Vec3::splat(0.3), color);
    let beside = at(&settled(&mut app), 1.7, 0.0);
    let (_, triangles) = voxelized(&mut app, |world| {
        edit_material(world, brighter, |material| material.emissive.green += 300.0);
    });
    println!("{triangles} triangles");
    assert_little(triangles);
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
    let (mut app, _) = large_level();
    let world = app.world_mut();
    let mut random = Random(3);
    let body = model(world, Cuboid::from_length(0.1), matt_material(0.8));
    let bodies: Vec<_> = (0..2 * BODIES)
        .map(|i| {
            // Above the hills, and as many outside of the volume.
            let outside = if i % 2 == 0 { 0.0 } else { 30.0 };
            let at = Vec3::new(6.5, 1.0, 6.5) * random.vector() + Vec3::Y * (3.0 + outside);
            let place = Transform::from_translation(at);
            world.spawn((body.clone(), place)).id()
        })
        .collect();
    // Characters, of which half move, too. They are apart from each other.
    let joint = |i: u64| {
        let row = if i < CHARACTERS { -6.5 } else { 5.5 };
        Transform::from_xyz(1.5 * (i % CHARACTERS) as f32 - 7.0, row, 6.5)
    };
    let joints: Vec<_> = (0..2 * CHARACTERS)
        .map(|i| world.spawn(joint(i)).id())
        .collect();
    let first = skinned_cuboid(world, [joints[0]; 2], body.1.0.clone());
    for joint in &joints {
        let mut character = first.clone();
        character.2.joints = vec![*joint; 2];
        world.spawn(character);
    }
    ready(&mut app);
    let moving = &joints[CHARACTERS as usize..];
    let (time, triangles) = voxelized(&mut app, |world| {
        for &entity in bodies.iter().chain(moving) {
            pose(world, entity).translation.y += 0.05;
        }
    });
    println!("{triangles} triangles, {time:.2} ms");
    assert_eq!(triangles, 64 * (BODIES + CHARACTERS));
}
