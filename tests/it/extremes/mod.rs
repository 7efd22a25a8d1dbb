//! The edges of the plugins' domains, with all four in one app: sizes, magnitudes, geometry that is
//! none, values that are no numbers, and hundreds of switches. Whatever is put in, the picture is
//! finite, as near to Bevy's own as it should be, and nothing is left behind.
//!
//! What each plugin does at the edges that are its own is beside its other tests (`tests/it`,
//! `crates/*/tests`); `docs/extremes.md` lists all.

mod stage;

use std::ops::Range;

use bevy::{
    ecs::{component::Mutable, query::QueryFilter},
    math::Affine2,
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};
use bevy_frugal_lab::headless::HeadlessApp;
use bevy_voxel_gi::VoxelGiVolume;

use self::stage::{
    ALL, Eye, Middle, Props, all, app, change_filtered, change_materials, difference, full_app,
    picture, switch,
};
use crate::support::{drawn, gpu, gpu_alone, triangle_mesh};

/// Asserts that the picture with these plugins is Bevy's but for this share, and finite with all of them.
fn assert_as_bevys(size: [u32; 2], texture: [u32; 2], plugins: [bool; 4], most: f32) {
    let mut app = app(size, texture);
    let what = format!("picture of {size:?}, texture of {texture:?}");
    app.run_until_ready(200).expect("ready");
    let bevy = picture(&mut app, 1);
    switch(app.world_mut(), plugins);
    app.run_until_ready(200).expect("ready");
    let actual = difference(&bevy, &picture(&mut app, 1));
    println!("{what}: {actual}");
    assert!(actual < most, "{what}: {actual}");
    switch(app.world_mut(), ALL);
    app.run_until_ready(200).expect("ready");
    picture(&mut app, 3);
}

#[test]
fn pictures_of_any_size_are_bevys_own_but_for_a_little() {
    let _gpu = gpu();
    // A pixel alone has no neighbour to take its chrominance from, and EWA filters textures otherwise.
    let rows = [
        ([1, 1], 0.19),
        ([1, 9], 0.042),
        ([9, 1], 0.021),
        ([2, 3], 0.016),
        ([33, 17], 0.097),
        ([257, 2], 0.0003),
    ];
    for (size, most) in drawn(1, rows) {
        // Without GI, which adds light.
        assert_as_bevys(size, [32, 32], [true, true, true, false], most);
    }
}

#[test]
fn textures_of_any_size_are_bevys_own_but_for_a_little() {
    let _gpu = gpu();
    let rows = [
        ([1, 1], 0.001),
        ([1, 64], 0.055),
        ([64, 1], 0.09),
        ([2, 2], 0.001),
        ([3, 5], 0.013),
        ([127, 33], 0.012),
        ([2048, 1], 0.006),
    ];
    for (texture, most) in drawn(1, rows) {
        // Without EWA: of textures so long and thin, Bevy's own filter leaves a blur.
        assert_as_bevys([48, 32], texture, [true, true, false, false], most);
    }
}

const MAGNITUDES: [f32; 8] = [
    0.0,
    1e-30,
    1e-7,
    1e7,
    1e30,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
];

/// Asserts that every magnitude leaves the picture finite, and that it heals once it is gone.
fn endures(app: &mut HeadlessApp, what: &str, usual: f32, set: fn(&mut World, f32)) {
    set(app.world_mut(), usual);
    let before = picture(app, 60);
    for value in MAGNITUDES {
        println!("{what}: {value}");
        set(app.world_mut(), value);
        picture(app, 3);
    }
    set(app.world_mut(), usual);
    let left = difference(&before, &picture(app, 60));
    println!("{what}: {left} once it is gone");
    assert!(left < 0.02, "{what} leaves something behind: {left}");
}

/// Changes each component of this kind.
fn change_components<C, F>(world: &mut World, change: impl Fn(&mut C))
where
    C: Component<Mutability = Mutable>,
    F: QueryFilter,
{
    for entity in all::<(With<C>, F)>(world) {
        change(&mut world.get_mut::<C>(entity).expect("it"));
    }
}

/// What is changed, its usual value, and how it is set.
type Row = (&'static str, f32, fn(&mut World, f32));

const VALUES: [Row; 7] = [
    ("emission", 0.0, |world, value| {
        let emissive = LinearRgba::rgb(value, 0.5 * value, 0.0);
        change_materials(world, |base| base.emissive = emissive);
    }),
    ("texture coordinates", 4.0, |world, value| {
        let scale = Affine2::from_scale(Vec2::splat(value));
        change_materials(world, |base| base.uv_transform = scale);
    }),
    ("base colour", 0.8, |world, value| {
        let color = Color::linear_rgb(value, 1.0, 0.5);
        change_filtered(world, |base| base.base_color = color);
    }),
    ("illuminance", 8000.0, |world, value| {
        change_components::<DirectionalLight, ()>(world, |light| light.illuminance = value);
    }),
    ("pose", 1.0, |world, value| {
        change_components::<Transform, With<Middle>>(world, |pose| {
            pose.scale = Vec3::new(value, 1.0, 1.0);
            pose.translation.z = if value == 1.0 { 0.0 } else { value };
        });
    }),
    ("camera", 3.0, |world, value| {
        change_components::<Transform, With<Eye>>(world, |pose| {
            pose.translation = Vec3::new(0.3, 1.2, value);
        });
    }),
    ("volume", 8.0, |world, value| {
        change_components::<VoxelGiVolume, ()>(world, |volume| volume.size = value);
    }),
];

#[test]
fn values_of_any_magnitude() {
    let _gpu = gpu();
    let mut app = full_app();
    for (what, usual, set) in drawn(2, VALUES) {
        endures(&mut app, what, usual, set);
    }
}

/// A mesh with all that materials read.
fn mesh(positions: &[[f32; 3]]) -> Mesh {
    let count = positions.len();
    triangle_mesh(PrimitiveTopology::TriangleList, positions.to_vec())
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 1.0, 0.0]; count])
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, vec![[0.5, 0.5]; count])
}

fn indexed(positions: &[[f32; 3]], indices: &[u32]) -> Mesh {
    mesh(positions).with_inserted_indices(Indices::U32(indices.to_vec()))
}

#[test]
fn meshes_that_are_hardly_any() {
    let _gpu = gpu();
    let mut app = full_app();
    let before = picture(&mut app, 60);
    let corner = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let alone = triangle_mesh(PrimitiveTopology::TriangleList, corner.to_vec());
    let line = [[0.0; 3], [1.0; 3], [2.0; 3]];
    let no_numbers = [[f32::NAN; 3], [1.0, 0.0, 0.0], [f32::INFINITY, 1.0, 0.0]];
    let large = corner.map(|c| c.map(|v| 1e6 * (v - 0.3)));
    let meshes = [
        ("nothing", mesh(&[])),
        ("no indices", indexed(&corner, &[])),
        ("a point", mesh(&[[0.5; 3]; 3])),
        ("a line", indexed(&line, &[0, 1, 2])),
        ("positions alone", alone),
        ("the same corner thrice", indexed(&corner, &[1, 1, 1])),
        ("no numbers", mesh(&no_numbers)),
        (
            "a thousand kilometres",
            indexed(&large, &[0, 1, 2, 2, 1, 0]),
        ),
    ];
    for (name, mesh) in meshes {
        println!("{name}");
        let world = app.world_mut();
        let mesh = Mesh3d(world.add_asset(mesh));
        let props = world.resource::<Props>();
        let (wavelet, ewa) = (props.wavelet.clone(), props.ewa.clone());
        let wavelet = world.spawn((mesh.clone(), MeshMaterial3d(wavelet))).id();
        let ewa = world.spawn((mesh, MeshMaterial3d(ewa))).id();
        picture(&mut app, 4);
        for thing in [wavelet, ewa] {
            app.world_mut().despawn(thing);
        }
    }
    let left = difference(&before, &picture(&mut app, 60));
    assert!(left < 0.02, "something is left behind: {left}");
}

#[test]
fn a_scene_that_is_emptied_and_filled_again() {
    let _gpu = gpu();
    let mut app = full_app();
    picture(&mut app, 2);
    for thing in all::<With<Mesh3d>>(app.world_mut()) {
        app.world_mut().despawn(thing);
    }
    let empty = picture(&mut app, 4);
    let difference = |p: &Vec3| (p - empty[0]).abs().max_element();
    assert!(empty.iter().all(|p| difference(p) < 1e-3));
    let world = app.world_mut();
    let cube = world.add_asset(Cuboid::default());
    let material = world.resource::<Props>().wavelet.clone();
    world.spawn((Middle, Mesh3d(cube), MeshMaterial3d(material)));
    let filled = picture(&mut app, 8);
    assert!(filled.iter().any(|p| difference(p) > 0.01));
}

/// Memory of this process in bytes, where the system tells; on a software driver that of the GPU
/// is part of it.
fn resident_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/statm").ok()?;
    let pages: u64 = text.split(' ').nth(1)?.parse().ok()?;
    Some(4096 * pages)
}

/// All combinations, in an order that has no system.
fn combination(step: u32) -> [bool; 4] {
    let bits = step.wrapping_mul(2_654_435_761) >> 28;
    [0, 1, 2, 3].map(|i| bits >> i & 1 == 1)
}

#[test]
#[ignore = "long: 700 frames"]
fn hundreds_of_switches_leave_nothing_behind() {
    let _gpu = gpu_alone();
    let mut app = app([32, 16], [16, 16]);
    app.run_until_ready(200).expect("ready");
    let toggle = |app: &mut HeadlessApp, steps: Range<u32>| {
        for step in steps {
            switch(app.world_mut(), combination(step));
            app.render_frames(1).expect("a frame");
        }
        switch(app.world_mut(), [false; 4]);
        picture(app, 4)
    };
    // Pipelines, caches and pools are made once.
    let before = toggle(&mut app, 0..200);
    let entities = app.world().entities().count_spawned();
    let memory = resident_bytes();
    let after = toggle(&mut app, 200..700);
    assert_eq!(app.world().entities().count_spawned(), entities);
    let found = difference(&before, &after);
    assert!(
        found == 0.0,
        "the picture without plugins has changed: {found}"
    );
    if let (Some(before), Some(after)) = (memory, resident_bytes()) {
        let growth = after.saturating_sub(before);
        println!("{} KiB more after 500 switches", growth / 1024);
        assert!(growth < 16 << 20, "{} KiB more", growth / 1024);
    }
}
