//! What the settings do: bounces, round-robin updates, stochastic voxelisation, memory, a budget of time.

use bevy::prelude::*;
use bevy_voxel_gi::{
    Bounces, DebugField, Solver, VoxelAlbedo, VoxelGiBudget, VoxelGiBudgetPlugin, VoxelGiDebug,
    VoxelGiVolume, Voxelizer,
    budget::BudgetChoice,
    reference::{RayTracing, RayTracingSettings, VolumeGrid, Voxels},
};

use super::fixture::*;
use crate::support::drawn;

/// A closed room whose walls all emit the same light and reflect half: each bounce adds half of the one before, and
/// everywhere it is the same.
#[test]
fn each_bounce_adds_its_light() {
    let mut app = app();
    let world = app.world_mut();
    let material = world.add_asset::<StandardMaterial>(emitting(0.5, LinearRgba::WHITE));
    for (center, size) in [
        (Vec3::new(0.0, -0.2, 0.0), Vec3::new(3.8, 0.4, 3.8)),
        (Vec3::new(0.0, 1.7, 0.0), Vec3::new(3.8, 0.4, 3.8)),
        (Vec3::new(1.7, 0.75, 0.0), Vec3::new(0.4, 2.3, 3.8)),
        (Vec3::new(-1.7, 0.75, 0.0), Vec3::new(0.4, 2.3, 3.8)),
        (Vec3::new(0.0, 0.75, 1.7), Vec3::new(3.8, 2.3, 0.4)),
        (Vec3::new(0.0, 0.75, -1.7), Vec3::new(3.8, 2.3, 0.4)),
    ] {
        let wall = block(world, center, size);
        let material = MeshMaterial3d(material.clone());
        world.entity_mut(wall).insert(material);
    }
    ready(&mut app);
    let mut light_of = |bounces: Bounces| {
        settings(app.world_mut()).light = global_illumination(Solver::default(), bounces);
        let volume = app.world_mut().spawn(small_volume()).id();
        settle(&mut app);
        // The top of the floor, in the middle of the room.
        let texel = read_texels(&mut app)[(8 * 16 + 7) * 16 + 8][2];
        app.world_mut().despawn(volume);
        frames(&mut app, 3);
        texel.x / texel.w
    };
    let once = light_of(Bounces::Count(1));
    assert!(once > 0.0);
    let rows = [
        (Bounces::Count(2), 1.5),
        (Bounces::Count(3), 1.75),
        (Bounces::Count(8), 2.0 - 0.5_f32.powi(7)),
        (Bounces::Endless, 2.0),
    ];
    for (bounces, expected) in drawn(1, rows) {
        let found = light_of(bounces) / once;
        println!("{bounces:?}: {found}, expected {expected}");
        assert!(
            (found / expected - 1.0).abs() < 0.005,
            "{bounces:?}: {found}"
        );
    }
}

#[test]
#[ignore = "long: settles slowly"]
fn round_robin_updates_converge_to_the_same_light() {
    let [whole, round_robin] = [1, 8].map(|update_interval| {
        let (mut app, ..) = floor_under_sky(usual_block);
        settings(app.world_mut()).update_interval = update_interval;
        ready(&mut app);
        settle(&mut app);
        read_texels(&mut app)
    });
    // Of surfaces and of empty voxels: how much the light differs, and how much there is.
    let mut kinds = [[0.0; 2]; 2];
    for (a, b) in whole.iter().flatten().zip(round_robin.iter().flatten()) {
        assert_eq!(a.w == 0.0, b.w == 0.0, "{a} {b}");
        let [difference, sum] = &mut kinds[usize::from(a.w < SURFACE)];
        if a.w > 0.0 && b.w > 0.0 {
            *difference += (a.x / a.w - b.x / b.w).abs();
            *sum += a.x / a.w;
        }
    }
    let [surfaces, empty] = kinds.map(|[difference, sum]| difference / sum);
    println!("surfaces {surfaces}, empty {empty}");
    assert!(surfaces < 0.002 && empty < 0.005, "{surfaces} {empty}");
}

/// In the next frame, wherever it was.
#[test]
fn light_of_removed_meshes_is_cleared() {
    let mut app = app();
    let gone = block(app.world_mut(), Vec3::splat(0.1), Vec3::splat(1.1));
    app.world_mut().spawn(under_sky(1.0));
    ready(&mut app);
    settle(&mut app);
    let surfaces = |texels: &[[Vec4; 6]]| {
        let faces = texels.iter().flatten();
        faces.filter(|texel| texel.w > SURFACE).count()
    };
    // It moves, so that its last light is not the first after a pause, when everything is updated.
    for step in 0..12 {
        pose(app.world_mut(), gone).translation.x = 0.1 + 0.5 * (step as f32).sin();
        frames(&mut app, 1);
    }
    assert!(surfaces(&read_texels(&mut app)) > 100);
    app.world_mut().despawn(gone);
    frames(&mut app, 2);
    assert_eq!(surfaces(&read_texels(&mut app)), 0);
}

/// Above the weight of voxels without surfaces, by far.
const HALF: f32 = 0.5;

#[test]
fn points_are_those_of_the_reference() {
    const POINTS: u32 = 3;
    let mut app = app();
    let world = app.world_mut();
    let mesh = Sphere::new(1.3).mesh().uv(24, 12);
    let triangles = triangles(&mesh, default(), 0);
    let material = MeshMaterial3d(matt(world, 0.5));
    let mesh = Mesh3d(world.add_asset(mesh));
    world.spawn((mesh, material));
    settings(world).voxelizer = Voxelizer::Stochastic { points: POINTS };
    world.spawn(under_sky(1.0));
    settle(&mut app);
    let (volume, settings) = (small_volume(), settings(app.world_mut()));
    let grid = VolumeGrid {
        min: Vec3::splat(-0.5 * volume.size),
        voxel_size: volume.voxel_size(&settings),
        resolution: settings.resolution,
    };
    let voxels = Voxels::from_points(grid, &triangles, POINTS);
    let mut light = RayTracing::new(&voxels, &[], &[], Vec3::ONE, RayTracingSettings::default());
    for _ in 0..12 {
        light.step();
    }
    let found = read_texels(&mut app);
    let expected = light.field().texels;
    let (mut surfaces, mut differences) = (0, 0);
    for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
        let [found, expected] = [found.w, expected.w].map(|weight| weight > HALF);
        surfaces += u32::from(expected);
        differences += u32::from(found != expected);
    }
    println!("{differences} of {surfaces} faces differ");
    assert!(surfaces > 300 && 50 * differences < surfaces);
}

/// The faces of the floor's top that have a surface, the picture, and the albedo that the voxels show.
fn seen_floor(voxelizer: Voxelizer, albedo: VoxelAlbedo) -> (usize, Vec<Vec3>, Vec<Vec3>) {
    const LAYER: usize = 7;
    const TOP: usize = 2;
    let mut app = deferred_app();
    let world = app.world_mut();
    floor(world);
    let mut settings = settings(world);
    (settings.voxelizer, settings.albedo) = (voxelizer, albedo);
    world.spawn(under_sky(1.0));
    ready(&mut app);
    settle_in_view(&mut app);
    let light = picture(&mut app);
    let texels = read_texels(&mut app);
    let is_surface = |index: &usize| index / 16 % 16 == LAYER && texels[*index][TOP].w > HALF;
    let surfaces = (0..texels.len()).filter(is_surface).count();
    let field = DebugField::Albedo;
    camera(app.world_mut()).insert(VoxelGiDebug { field });
    frames(&mut app, 3);
    (surfaces, light, picture(&mut app))
}

/// The twelve triangles of a floor with a point each are no floor, but what the camera sees is, with its albedo.
#[test]
#[ignore = "long: settles for each"]
fn what_cameras_see_is_occupied() {
    let points = Voxelizer::Stochastic { points: 1 };
    let (whole, ..) = seen_floor(Voxelizer::Conservative, VoxelAlbedo::Material);
    let (sparse, ..) = seen_floor(points, VoxelAlbedo::Material);
    let (seen, light, albedo) = seen_floor(points, VoxelAlbedo::Reprojected);
    println!("{seen} of {whole} faces, {sparse} by points alone");
    assert!(100 * seen > 95 * whole && 10 * sparse < whole);
    for (x, z) in [(0.0, 0.0), (-1.2, 0.7), (1.0, -1.0)] {
        let (light, albedo) = (at(&light, x, z), at(&albedo, x, z));
        println!("light {light}, albedo {albedo}");
        assert!((light - 1.0).abs().max_element() < 0.02, "{light}");
        assert!((albedo - 1.0).abs().max_element() < 0.05, "{albedo}");
    }
}

/// Bytes a voxel of a volume of 16^3 that traces rays: 8 of occupancy, 4 of slots, 4 of work and 52 of texture; then
/// for 1.5 slots 4 of surface, 8 of radiance, 8 of colours, twice 16 of irradiance and 4 of work each.
pub const WITH_LIGHT: u64 = 8 + 4 + 4 + 52 + 3 * (4 + 8 + 8 + 2 * 16 + 4) / 2;

/// One to three slices, as the depth of the texture is one more than a multiple of three, and what is small.
const LAST_SLICES: u64 = 3 * 16 * 32 * 8 + 1024;

/// The texture of up to 128 materials.
const MATERIALS: u64 = 128 * 6 * 16;

fn assert_in(memory: u64, expected: u64) {
    println!("{memory} bytes, expected {expected}");
    assert!(
        (expected..expected + LAST_SLICES).contains(&memory),
        "{memory} for {expected}"
    );
}

/// A volume of 16^3 voxels, or as many cascades of it as are in the report, takes these bytes a voxel, the
/// texture's last slices, and little else.
pub fn assert_memory(app: &HeadlessApp, bytes_per_voxel: u64) {
    assert_in(report(app).memory, 4096 * bytes_per_voxel + MATERIALS);
}

#[test]
fn each_solver_has_the_memory_that_it_needs() {
    let mut app = app_with(|_| ());
    floor(app.world_mut());
    let light = |solver| global_illumination(solver, Bounces::Endless);
    let occlusion = occlusion(0.5, 8);
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
        frames(&mut app, 3);
    }
}

/// Small boxes in 14 x 14 x 14 voxels of their own have more faces than a volume of 16^3 has slots for at first.
#[test]
#[ignore = "long: thousands of boxes"]
fn slots_grow_with_the_surfaces() {
    const ALONG: i16 = 14;
    const FACES: usize = 6 * (ALONG as usize).pow(3);
    let mut app = app_with(|_| ());
    let world = app.world_mut();
    let material = MeshMaterial3d(matt(world, 0.5));
    let mesh = Mesh3d(world.add_asset(Cuboid::from_length(0.1)));
    let place = |i: i16| 0.25 * (f32::from(i % ALONG) - 6.5);
    world.spawn_batch((0..ALONG.pow(3)).map(move |i| {
        let at = Transform::from_xyz(place(i), place(i / ALONG), place(i / ALONG / ALONG));
        (mesh.clone(), material.clone(), at)
    }));
    app.world_mut().spawn(under_sky(1.0));
    settle(&mut app);
    let texels = read_texels(&mut app);
    let is_lit = |light: &&Vec4| light.w > SURFACE && light.x > 0.0;
    assert_eq!(texels.iter().flatten().filter(is_lit).count(), FACES);
    let slots = (6_u64 * 4096 + 1).next_multiple_of(32);
    let grown = 4096 * WITH_LIGHT + (slots - 6144) * 56 + MATERIALS;
    assert_in(report(&app).memory, grown);
}

#[test]
#[ignore = "long: the default volume"]
fn the_default_takes_at_most_12_mib_in_a_large_level_too() {
    let mut app = app_with(|_| ());
    *settings(app.world_mut()) = default();
    floor(app.world_mut());
    app.world_mut().spawn(VoxelGiVolume::default());
    let mut memory = || {
        ready(&mut app);
        frames(&mut app, 3);
        // It reaches out of the cascades, so there is a level around them from now on.
        let size = Vec3::new(300.0, 1.0, 300.0);
        block(app.world_mut(), -2.0 * Vec3::Y, size);
        report(&app).memory as f64 / f64::from(1 << 20)
    };
    let [alone, with_a_level] = [memory(), memory()];
    println!("{alone:.2} MiB, {with_a_level:.2} with a level around it");
    assert!((10.0..11.0).contains(&alone), "{alone}");
    assert!((11.0..=12.0).contains(&with_a_level), "{with_a_level}");
}

/// The quality level after so many frames with a budget.
fn level_after(app: &mut HeadlessApp, milliseconds: f32, count: u32) -> usize {
    let budget = VoxelGiBudget { milliseconds };
    app.world_mut().insert_resource(budget);
    frames(app, count);
    quality_level(app).map_or(0, |(level, _)| level)
}

fn quality_level(app: &HeadlessApp) -> Option<(usize, usize)> {
    app.world().resource::<BudgetChoice>().quality_level()
}

#[test]
fn a_budget_chooses_by_measured_times() {
    let mut app = app_with(|app| {
        app.add_plugins(VoxelGiBudgetPlugin);
    });
    floor(app.world_mut());
    usual_block(app.world_mut());
    settings(app.world_mut()).pause_when_settled = false;
    app.world_mut().spawn(under_sky(1.0));
    ready(&mut app);
    assert_eq!(quality_level(&app), None);
    // The adapter of the tests has time stamps.
    let lavish = level_after(&mut app, 1e6, 120);
    let (_, count) = quality_level(&app).expect("one");
    assert_eq!(lavish + 1, count, "all that there is");
    let frugal = level_after(&mut app, 1e-6, 120);
    assert_eq!(frugal, 0, "as little as there is");
    let back = level_after(&mut app, 1e6, 60);
    assert!(back > 0, "{back}");
    assert!(report(&app).memory > 0);
    // Without a budget the app's own settings count.
    app.world_mut().remove_resource::<VoxelGiBudget>();
    frames(&mut app, 2);
    assert_eq!(quality_level(&app), None);
}
