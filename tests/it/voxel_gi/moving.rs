//! Only what has changed is voxelised: after any motion the light is that of a new app.

use bevy::{light::NotShadowCaster, prelude::*};
use bevy_frugal_lab::headless::HeadlessApp;
use bevy_voxel_gi::{Follow, VoxelGiVolume};

use super::{
    history::copy,
    scene::{app_with, at, block, block_of, floor, under_sky},
    support::{light_texture_bytes, picture, settle},
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

/// The light of all levels.
fn settled(app: &mut HeadlessApp) -> Vec<f32> {
    app.render_frames(2).expect("frames");
    settle(app);
    let bytes = light_texture_bytes(app);
    let halves = bytes.as_chunks::<2>().0.iter();
    halves
        .map(|bytes| half::f16::from_le_bytes(*bytes).to_f32())
        .collect()
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
    let mut before = settled(&mut app);
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
        let moved = settled(&mut app);
        let world = app.world_mut();
        let mut lamps = world.query::<&mut PointLight>();
        lamps.single_mut(world).expect("a lamp").intensity += 500.0;
        let found = settled(&mut app);
        println!("light that has moved: {:.6}", difference(&moved, &found));
        let mut new = app_with(|_| ());
        copy(app.world_mut(), new.world_mut());
        let place = *camera(app.world_mut());
        *camera(new.world_mut()) = place;
        new.run_until_ready(200).expect("ready");
        let anew = settled(&mut new);
        let (wrong, effect) = (difference(&found, &anew), difference(&before, &anew));
        println!("round {round}: {wrong:.6} of an effect of {effect:.5}");
        assert!(effect > 0.01, "round {round}: {effect}");
        // The precision of 16-bit floats.
        assert!(wrong < 5e-4, "round {round}: {wrong}");
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

/// What begins to move after a rest does not make the light of all other things flicker.
#[test]
fn light_stays_where_it_is_while_things_far_away_move() {
    let _gpu = gpu();
    let mut app = app_with(|_| ());
    room(app.world_mut());
    let small = block(app.world_mut(), Vec3::new(1.6, 0.1, 1.5), Vec3::splat(0.1));
    app.world_mut().spawn(under_sky(0.5));
    app.run_until_ready(200).expect("ready");
    settle(&mut app);
    let rest = picture(&mut app);
    let mut most = 0.0_f32;
    for step in 0..20 {
        let mut transform = app.world_mut().get_mut::<Transform>(small);
        transform.as_mut().expect("it").translation.z = 1.5 - 0.02 * step as f32;
        app.render_frames(1).expect("a frame");
        let now = picture(&mut app);
        for (x, z) in [(0.0, 0.0), (-1.0, -1.0), (-1.2, 0.4), (0.6, -1.2)] {
            let (before, after) = (at(&rest, x, z), at(&now, x, z));
            most = most.max((after - before).abs().max_element() / before.max_element());
        }
    }
    println!("{most:.4} of the light");
    assert!(most < 0.01, "{most}");
}
