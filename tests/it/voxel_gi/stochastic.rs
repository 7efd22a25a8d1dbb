//! Stochastic voxelisation: points on triangles, and what cameras see.

use bevy::{
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass},
    pbr::DefaultOpaqueRendererMethod,
    prelude::*,
};
use bevy_voxel_gi::{
    DebugField, VoxelAlbedo, VoxelGiDebug, Voxelizer,
    reference::{RayTracing, RayTracingSettings, Triangle, VolumeGrid, Voxels},
};

use super::{
    scene::{app, app_with, at, floor, matt, settings, small_volume, under_sky},
    support::{picture, read_texels, settle, settle_in_view},
};
use crate::support::gpu;

/// Above the weight of voxels without surfaces.
const SURFACE: f32 = 0.5;

#[test]
fn points_are_those_of_the_reference() {
    const POINTS: u32 = 3;
    let _gpu = gpu();
    let mut app = app();
    let world = app.world_mut();
    let mesh = Sphere::new(1.3).mesh().uv(24, 12);
    let positions = mesh
        .attribute(Mesh::ATTRIBUTE_POSITION)
        .and_then(|values| values.as_float3())
        .expect("positions");
    let indices: Vec<_> = mesh.indices().expect("indices").iter().collect();
    let triangles: Vec<_> = indices
        .chunks_exact(3)
        .map(|corners| Triangle {
            corners: [0, 1, 2].map(|i| Vec3::from(positions[corners[i]])),
            material: 0,
            double_sided: false,
        })
        .collect();
    let material = matt(world, 0.5);
    let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
    world.spawn((Mesh3d(mesh), MeshMaterial3d(material)));
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
        let [found, expected] = [found.w, expected.w].map(|weight| weight > SURFACE);
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
    let mut app = app_with(|app| {
        app.insert_resource(DefaultOpaqueRendererMethod::deferred());
    });
    let world = app.world_mut();
    let camera = world
        .query_filtered::<Entity, With<Camera3d>>()
        .single(world)
        .expect("a camera");
    world
        .entity_mut(camera)
        .insert((DepthPrepass, DeferredPrepass));
    floor(world);
    let mut settings = settings(world);
    (settings.voxelizer, settings.albedo) = (voxelizer, albedo);
    world.spawn(under_sky(1.0));
    app.run_until_ready(200).expect("not ready");
    settle_in_view(&mut app);
    let light = picture(&mut app);
    let texels = read_texels(&mut app);
    let is_surface = |index: &usize| index / 16 % 16 == LAYER && texels[*index][TOP].w > SURFACE;
    let surfaces = (0..texels.len()).filter(is_surface).count();
    let world = app.world_mut();
    world.entity_mut(camera).insert(VoxelGiDebug {
        field: DebugField::Albedo,
    });
    app.render_frames(3).expect("a frame");
    (surfaces, light, picture(&mut app))
}

/// The twelve triangles of a floor with a point each are no floor, but what the camera sees is, with its albedo.
#[test]
fn what_cameras_see_is_occupied() {
    let _gpu = gpu();
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
