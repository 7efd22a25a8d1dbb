//! Meshes that are hardly any.

use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};

use super::stage::{Middle, Props, difference, full_app, picture};
use crate::support::gpu;

/// A mesh of positions alone, or with all that materials read.
fn mesh(positions: Vec<[f32; 3]>, indices: Option<Vec<u32>>, is_full: bool) -> Mesh {
    let count = positions.len();
    let mut mesh = Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::default(),
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    if is_full {
        mesh.insert_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 1.0, 0.0]; count]);
        mesh.insert_attribute(Mesh::ATTRIBUTE_UV_0, vec![[0.5, 0.5]; count]);
    }
    if let Some(indices) = indices {
        mesh.insert_indices(Indices::U32(indices));
    }
    mesh
}

#[test]
fn meshes_that_are_hardly_any() {
    let _gpu = gpu();
    let mut app = full_app();
    let before = picture(&mut app, 60);
    let corner = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let meshes = [
        ("nothing", mesh(Vec::new(), None, true)),
        ("no indices", mesh(corner.to_vec(), Some(Vec::new()), true)),
        ("a point", mesh(vec![[0.5; 3]; 3], None, true)),
        (
            "a line",
            mesh(
                vec![[0.0; 3], [1.0; 3], [2.0; 3]],
                Some(vec![0, 1, 2]),
                true,
            ),
        ),
        ("positions alone", mesh(corner.to_vec(), None, false)),
        (
            "the same corner thrice",
            mesh(corner.to_vec(), Some(vec![1, 1, 1]), true),
        ),
        (
            "no numbers",
            mesh(
                vec![[f32::NAN; 3], [1.0, 0.0, 0.0], [f32::INFINITY, 1.0, 0.0]],
                None,
                true,
            ),
        ),
        (
            "a thousand kilometres",
            mesh(
                corner.map(|c| c.map(|v| 1e6 * (v - 0.3))).to_vec(),
                Some(vec![0, 1, 2, 2, 1, 0]),
                true,
            ),
        ),
    ];
    for (name, mesh) in meshes {
        println!("{name}");
        let world = app.world_mut();
        let mesh = world.add_asset(mesh);
        let props = world.resource::<Props>();
        let (wavelet, ewa) = (props.wavelet.clone(), props.ewa.clone());
        let things = [
            world
                .spawn((Mesh3d(mesh.clone()), MeshMaterial3d(wavelet)))
                .id(),
            world.spawn((Mesh3d(mesh), MeshMaterial3d(ewa))).id(),
        ];
        picture(&mut app, 4);
        for thing in things {
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
    let world = app.world_mut();
    let mut meshes = world.query_filtered::<Entity, With<Mesh3d>>();
    for thing in meshes.iter(world).collect::<Vec<_>>() {
        world.despawn(thing);
    }
    let empty = picture(&mut app, 4);
    let first = empty[0];
    assert!(empty.iter().all(|p| (p - first).abs().max_element() < 1e-3));
    let world = app.world_mut();
    let cube = world.add_asset(Cuboid::default());
    let material = world.resource::<Props>().wavelet.clone();
    world.spawn((Middle, Mesh3d(cube), MeshMaterial3d(material)));
    let filled = picture(&mut app, 8);
    assert!(
        filled
            .iter()
            .any(|p| (p - first).abs().max_element() > 0.01)
    );
}
