//! Memory that volumes allocate.

use bevy::prelude::*;
use bevy_frugal_lab::headless::HeadlessApp;
use bevy_voxel_gi::{Bounces, Solver, VoxelGiReport, VoxelGiVolume, VoxelLight};

use super::{
    scene::{app_with, block, floor, matt, settings, under_sky},
    support::{read_texels, settle},
};
use crate::support::gpu;

/// Bytes a voxel of a volume of 16^3 that traces rays: 8 of occupancy, 4 of slots, 4 of work and 52 of texture; then
/// for 1.5 slots 4 of surface, 8 of radiance, 8 of colours, twice 16 of irradiance and 4 of work each.
pub const WITH_LIGHT: u64 = 8 + 4 + 4 + 52 + 3 * (4 + 8 + 8 + 2 * 16 + 4) / 2;

/// One to three slices, as the depth of the texture is one more than a multiple of three, and what is small.
const LAST_SLICES: u64 = 3 * 16 * 32 * 8 + 1024;

/// The texture of up to 128 materials.
const MATERIALS: u64 = 128 * 6 * 16;

/// A volume of 16^3 voxels, or as many cascades of it as are in the report, takes these bytes a voxel, the
/// texture's last slices, and little else.
pub fn assert_memory(app: &HeadlessApp, bytes_per_voxel: u64) {
    let memory = app.world().resource::<VoxelGiReport>().memory;
    let expected = 4096 * bytes_per_voxel + MATERIALS;
    println!("{memory} bytes, expected {expected}");
    assert!(
        (expected..expected + LAST_SLICES).contains(&memory),
        "{memory} for {expected}"
    );
}

#[test]
fn each_solver_has_the_memory_that_it_needs() {
    let _gpu = gpu();
    let mut app = app_with(|_| ());
    floor(app.world_mut());
    let light = |solver| VoxelLight::GlobalIllumination {
        solver,
        bounces: Bounces::Endless,
    };
    let occlusion = VoxelLight::AmbientOcclusion {
        radius: 0.5,
        rays: 8,
    };
    for (light, cascades, bytes) in [
        // Two times the light on its way: 64 bytes, and that which has arrived through six faces.
        (
            light(Solver::Propagate { iterations: 8 }),
            1,
            WITH_LIGHT + 128 + 96,
        ),
        // The second cascade has a quarter of the slots.
        (
            light(Solver::Trace { rays: 8 }),
            2,
            2 * WITH_LIGHT - 3 * 3 * 56 / 8,
        ),
        (occlusion, 1, WITH_LIGHT),
    ] {
        settings(app.world_mut()).light = light;
        let volume = VoxelGiVolume {
            cascades,
            ..under_sky(1.0)
        };
        let volume = app.world_mut().spawn(volume).id();
        settle(&mut app);
        assert_memory(&app, bytes);
        app.world_mut().despawn(volume);
        app.render_frames(3).expect("frames");
    }
}

/// Small boxes in 14 x 14 x 14 voxels of their own have more faces than a volume of 16^3 has slots for at first.
#[test]
fn slots_grow_with_the_surfaces() {
    const ALONG: i16 = 14;
    const FACES: usize = 6 * (ALONG as usize).pow(3);
    /// Less is the weight of voxels without surfaces.
    const SURFACE: f32 = 0.003;
    let _gpu = gpu();
    let mut app = app_with(|_| ());
    let material = matt(app.world_mut(), 0.5);
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    let mesh = meshes.add(Cuboid::from_size(Vec3::splat(0.1)));
    let place = |i: i16| 0.25 * (f32::from(i % ALONG) - 6.5);
    let boxes = (0..ALONG.pow(3)).map(|i| {
        (
            Mesh3d(mesh.clone()),
            MeshMaterial3d(material.clone()),
            Transform::from_xyz(place(i), place(i / ALONG), place(i / ALONG / ALONG)),
        )
    });
    let boxes: Vec<_> = boxes.collect();
    app.world_mut().spawn_batch(boxes);
    app.world_mut().spawn(under_sky(1.0));
    settle(&mut app);
    let is_lit = |light: &&Vec4| light.w > SURFACE && light.x > 0.0;
    let lit = read_texels(&mut app)
        .iter()
        .flatten()
        .filter(is_lit)
        .count();
    assert_eq!(lit, FACES);
    let at_first = 4096 * WITH_LIGHT;
    let memory = app.world().resource::<VoxelGiReport>().memory;
    let slots = (6_u64 * 4096 + 1).next_multiple_of(32);
    let grown = at_first + (slots - 6144) * 56 + MATERIALS;
    assert!(
        (grown..grown + LAST_SLICES).contains(&memory),
        "{memory} for {grown}"
    );
}

#[test]
fn the_default_takes_at_most_12_mib_in_a_large_level_too() {
    let _gpu = gpu();
    let mut app = app_with(|_| ());
    *settings(app.world_mut()) = default();
    floor(app.world_mut());
    app.world_mut().spawn(VoxelGiVolume::default());
    let mut memory = || {
        app.run_until_ready(200).expect("ready");
        app.render_frames(3).expect("frames");
        // It reaches out of the cascades, so there is a level around them from now on.
        let size = Vec3::new(300.0, 1.0, 300.0);
        block(app.world_mut(), -2.0 * Vec3::Y, size);
        app.world().resource::<VoxelGiReport>().memory as f64 / f64::from(1 << 20)
    };
    let [alone, with_a_level] = [memory(), memory()];
    println!("{alone:.2} MiB, {with_a_level:.2} with a level around it");
    assert!((10.0..11.0).contains(&alone), "{alone}");
    assert!((11.0..=12.0).contains(&with_a_level), "{with_a_level}");
}
