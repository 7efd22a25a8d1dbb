//! Holes cut by masks, colours of vertices, targets of morphs, and what cameras see of surfaces.

use std::f32::consts::PI;

use bevy::{
    camera::visibility::NoFrustumCulling,
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass},
    image::ImageSampler,
    mesh::morph::{MeshMorphWeights, MorphAttributes},
    pbr::DefaultOpaqueRendererMethod,
    prelude::*,
    render::render_resource::{Extent3d, Face, TextureDimension, TextureFormat},
};
use bevy_frugal_lab::headless::HeadlessApp;
use bevy_voxel_gi::{DebugField, MeshVoxelMaterial, VoxelAlbedo, VoxelGiDebug};

use super::{
    scene::{app, app_with, at, floor, hidden, matt, settings, under_sky},
    support::{picture, settle, settle_in_view},
};
use crate::support::gpu;

fn settled(app: &mut HeadlessApp) -> Vec<Vec3> {
    app.run_until_ready(200).expect("not ready");
    settle(app);
    picture(app)
}

/// A plate over the floor's middle that the camera does not see, of this mesh.
fn plate(world: &mut World, mesh: Mesh, material: Handle<StandardMaterial>) -> Entity {
    let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
    world
        .spawn((
            Mesh3d(mesh),
            MeshMaterial3d(material),
            hidden(),
            NoFrustumCulling,
            Transform::from_xyz(0.0, 0.4, 0.0),
        ))
        .id()
}

/// A texture of 8 x 8 texels of one colour, opaque where this says so.
fn texture(color: [u8; 3], opaque: impl Fn(u32) -> bool) -> Image {
    let data = (0..64)
        .flat_map(|i| {
            [
                color[0],
                color[1],
                color[2],
                if opaque(i) { 255 } else { 0 },
            ]
        })
        .collect();
    let size = Extent3d {
        width: 8,
        height: 8,
        depth_or_array_layers: 1,
    };
    let mut image = Image::new(
        size,
        TextureDimension::D2,
        data,
        TextureFormat::Rgba8UnormSrgb,
        default(),
    );
    image.sampler = ImageSampler::nearest();
    image
}

/// The floor's middle under a black plate with holes, below a sky of 1.
fn under_mask(alpha_mode: AlphaMode, opaque: impl Fn(u32) -> bool) -> f32 {
    let mut app = app();
    let world = app.world_mut();
    floor(world);
    let image = world
        .resource_mut::<Assets<Image>>()
        .add(texture([0; 3], opaque));
    let material = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(StandardMaterial {
            base_color_texture: Some(image),
            alpha_mode,
            cull_mode: None,
            double_sided: true,
            ..default()
        });
    plate(
        world,
        Plane3d::default().mesh().size(3.0, 3.0).into(),
        material,
    );
    world.spawn(under_sky(1.0));
    at(&settled(&mut app), 0.0, 0.0).x
}

#[test]
fn masks_let_as_much_light_through_as_they_have_holes() {
    let _gpu = gpu();
    let mask = AlphaMode::Mask(0.5);
    let solid = under_mask(mask, |_| true);
    let half = under_mask(mask, |i| (i + i / 8) % 2 == 0);
    let quarter = under_mask(mask, |i| i % 4 == 0);
    let none = under_mask(mask, |_| false);
    let to_coverage = under_mask(AlphaMode::AlphaToCoverage, |i| (i + i / 8) % 2 == 0);
    println!("solid {solid}, half {half}, quarter {quarter}, none {none}");
    assert!((none - 1.0).abs() < 0.02, "{none}");
    let expected = |coverage: f32| none + coverage * (solid - none);
    assert!((half - expected(0.5)).abs() < 0.1, "{solid} {half} {none}");
    assert!(
        (quarter - expected(0.25)).abs() < 0.1,
        "{solid} {quarter} {none}"
    );
    assert!((to_coverage - half).abs() < 0.01, "{to_coverage} {half}");
}

#[test]
fn vertex_colors_tint_what_is_reflected() {
    let _gpu = gpu();
    let [white, red] = [[1.0, 1.0, 1.0, 1.0], [1.0, 0.25, 0.0, 1.0]].map(|color: [f32; 4]| {
        let mut app = app();
        let world = app.world_mut();
        floor(world);
        let mesh = Mesh::from(Cuboid::new(1.5, 0.2, 1.5));
        let count = mesh.count_vertices();
        let mesh = mesh.with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, vec![color; count]);
        let material = matt(world, 0.8);
        plate(world, mesh, material.clone());
        // The same material on a mesh without: it keeps its own colour.
        let other = Mesh::from(Cuboid::new(0.3, 0.2, 0.3));
        let other = plate(world, other, material);
        world
            .entity_mut(other)
            .insert(Transform::from_xyz(1.6, 0.4, 1.6));
        world.spawn(under_sky(1.0));
        at(&settled(&mut app), 0.0, 0.0)
    });
    let dark = white.x - 0.1;
    assert!((red.x / white.x - 1.0).abs() < 0.02, "{red} {white}");
    assert!(
        red.y < 0.97 * white.y && red.z < red.y,
        "{red} {white} {dark}"
    );
}

#[test]
fn morphed_meshes_occlude_where_their_targets_put_them() {
    let _gpu = gpu();
    let mut app = app();
    let world = app.world_mut();
    floor(world);
    let mut mesh = Mesh::from(Cuboid::new(1.5, 0.2, 1.5));
    let count = mesh.count_vertices();
    // One target to the left, one to the right.
    let to = |x: f32| MorphAttributes {
        position: Vec3::new(x, 0.0, 0.0),
        ..default()
    };
    let targets = [to(-2.0), to(2.0)]
        .map(|target| vec![target; count])
        .concat();
    mesh.set_morph_targets(targets);
    let material = matt(world, 0.0);
    let entity = plate(world, mesh, material);
    world.entity_mut(entity).insert(MeshMorphWeights::Value {
        weights: vec![0.5, 0.0],
    });
    world.spawn(under_sky(1.0));
    let found = settled(&mut app);
    let (left, right) = (at(&found, -1.0, 0.0).x, at(&found, 1.0, 0.0).x);
    assert!(left < 0.7 * right, "{left} {right}");
    app.world_mut()
        .entity_mut(entity)
        .insert(MeshMorphWeights::Value {
            weights: vec![0.0, 0.5],
        });
    app.render_frames(3).expect("a frame");
    settle(&mut app);
    let found = picture(&mut app);
    let (left, right) = (at(&found, -1.0, 0.0).x, at(&found, 1.0, 0.0).x);
    assert!(right < 0.7 * left, "{left} {right}");
}

/// A target that displaces by many times the mesh's own size.
#[test]
fn a_morphed_mesh_leaves_nothing_where_it_was() {
    let _gpu = gpu();
    let mut app = app();
    let world = app.world_mut();
    floor(world);
    let mut mesh = Mesh::from(Cuboid::new(0.6, 0.2, 0.6));
    let far = MorphAttributes {
        position: Vec3::X * 3.0,
        ..default()
    };
    mesh.set_morph_targets(vec![far; mesh.count_vertices()]);
    let material = matt(world, 0.0);
    let entity = plate(world, mesh, material);
    let with_weight = |weight: f32| MeshMorphWeights::Value {
        weights: vec![weight],
    };
    world.entity_mut(entity).insert(with_weight(0.0));
    world.spawn(under_sky(1.0));
    let expected = settled(&mut app);
    for weight in [0.45, 0.0] {
        let world = app.world_mut();
        world.entity_mut(entity).insert(with_weight(weight));
        app.render_frames(3).expect("a frame");
        settle(&mut app);
    }
    let found = picture(&mut app);
    for (found, expected) in found.iter().zip(&expected) {
        assert!((found.x - expected.x).abs() < 1e-3, "{found} {expected}");
    }
}

/// The albedo in the voxels of a floor whose left half is green and right half red by its texture, as the
/// debug view shows it; or of one of which voxels know only `own`.
fn shown_albedo(
    albedo: VoxelAlbedo,
    own: Option<Vec3>,
    with_prepass: bool,
    is_visible: bool,
) -> Vec<Vec3> {
    let mut app = app_with(|app| {
        if with_prepass {
            app.insert_resource(DefaultOpaqueRendererMethod::deferred());
        }
    });
    let world = app.world_mut();
    let camera = world
        .query_filtered::<Entity, With<Camera3d>>()
        .single(world)
        .expect("a camera");
    if with_prepass {
        world
            .entity_mut(camera)
            .insert((DepthPrepass, DeferredPrepass));
    }
    let mut image = texture([0; 3], |_| true);
    for (i, texel) in (0_u32..).zip(image.data.as_mut().expect("texels").chunks_exact_mut(4)) {
        texel[usize::from(i % 8 < 4)] = 255;
    }
    let image = world.resource_mut::<Assets<Image>>().add(image);
    let material = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(StandardMaterial {
            base_color_texture: Some(image),
            perceptual_roughness: 1.0,
            reflectance: 0.0,
            ..default()
        });
    let mesh = world
        .resource_mut::<Assets<Mesh>>()
        .add(Plane3d::default().mesh().size(3.6, 3.6).build());
    let floor = world
        .spawn((
            Mesh3d(mesh),
            MeshMaterial3d(material),
            Transform::from_xyz(0.0, 0.05, 0.0),
            MeshVoxelMaterial {
                albedo: own,
                ..default()
            },
        ))
        .id();
    if !is_visible {
        world.entity_mut(floor).insert(hidden());
    }
    settings(world).albedo = albedo;
    let volume = world.spawn(under_sky(1.0)).id();
    app.run_until_ready(200).expect("not ready");
    settle_in_view(&mut app);
    // What is no longer seen is remembered.
    let world = app.world_mut();
    world.entity_mut(floor).insert(hidden());
    world.entity_mut(volume).insert(under_sky(2.0));
    app.render_frames(8).expect("a frame");
    let world = app.world_mut();
    world.entity_mut(camera).insert(VoxelGiDebug {
        field: DebugField::Albedo,
    });
    app.render_frames(3).expect("a frame");
    picture(&mut app)
}

fn is_about(found: Vec3, expected: Vec3) {
    let wrong = (found - expected).abs().max_element();
    assert!(wrong < 0.05, "{found} instead of {expected}");
}

#[test]
fn what_cameras_see_is_the_albedo_and_else_that_of_materials() {
    let _gpu = gpu();
    let (green, red, gray) = (Vec3::Y, Vec3::X, Vec3::splat(0.5));
    let own = Vec3::new(0.1, 0.2, 0.8);
    for (albedo, own, with_prepass, is_visible, [left, right]) in [
        (VoxelAlbedo::Material, None, false, true, [green, red]),
        (VoxelAlbedo::Material, Some(own), true, true, [own; 2]),
        (VoxelAlbedo::Neutral, None, true, true, [gray; 2]),
        (
            VoxelAlbedo::Reprojected,
            Some(own),
            true,
            true,
            [green, red],
        ),
        // Without a G-buffer nothing is seen, nor what no camera draws.
        (VoxelAlbedo::Reprojected, Some(own), false, true, [own; 2]),
        (VoxelAlbedo::Reprojected, Some(own), true, false, [own; 2]),
    ] {
        let found = shown_albedo(albedo, own, with_prepass, is_visible);
        is_about(at(&found, -1.0, 0.0), left);
        is_about(at(&found, 1.0, 0.0), right);
    }
}

/// A roof with one side is as dark below as one with two: its back is black. So it is five voxels above the floor and
/// two.
#[test]
fn back_faces_are_black() {
    let _gpu = gpu();
    let two_sides = StandardMaterial {
        base_color: Color::BLACK,
        reflectance: 0.0,
        cull_mode: None,
        ..default()
    };
    let one_side = StandardMaterial {
        cull_mode: Some(Face::Back),
        ..two_sides.clone()
    };
    let up = Quat::IDENTITY;
    let down = Quat::from_rotation_x(PI);
    // The middle's light is the sky less the form factor of the roof.
    for (height, middle, allowed) in [(1.27, 0.474, 0.004), (0.51, 0.128, 0.009)] {
        let sides = [
            (two_sides.clone(), up),
            (one_side.clone(), up),
            (one_side.clone(), down),
        ];
        let shades = sides.map(|(sides, way)| {
            let mut app = app();
            let world = app.world_mut();
            floor(world);
            let material = world.resource_mut::<Assets<StandardMaterial>>().add(sides);
            let mesh = Plane3d::default().mesh().size(2.4, 2.4).into();
            let roof = plate(world, mesh, material);
            let place = Transform::from_xyz(0.0, height, 0.0).with_rotation(way);
            world.entity_mut(roof).insert(place);
            world.spawn(under_sky(1.0));
            let light = settled(&mut app);
            [0.0, 0.7, 1.2, 1.6].map(|x| at(&light, x, 0.0).x)
        });
        println!("{height} m: {shades:?}");
        assert!((shades[0][0] - middle).abs() < 0.05, "{height}: {shades:?}");
        for of_one_side in &shades[1..] {
            for (one, two) in of_one_side.iter().zip(&shades[0]) {
                assert!((one - two).abs() < allowed, "{height}: {shades:?}");
            }
        }
    }
}

/// A white ball under a uniform sky is as bright as that everywhere.
#[test]
fn curved_surfaces_do_not_shade_themselves() {
    let _gpu = gpu();
    let mut app = app();
    let world = app.world_mut();
    let material = matt(world, 1.0);
    let mesh = Sphere::new(1.3).mesh().ico(8).expect("few triangles");
    let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
    world.spawn((Mesh3d(mesh), MeshMaterial3d(material)));
    world.spawn(under_sky(1.0));
    let light = settled(&mut app);
    let ball: Vec<f32> = light.iter().map(|p| p.x).filter(|x| *x > 0.0).collect();
    let least = ball.iter().copied().fold(f32::INFINITY, f32::min);
    let most = ball.iter().copied().fold(0.0, f32::max);
    println!("{} pixels from {least} to {most}", ball.len());
    assert!(
        ball.len() > 300 && least > 0.99 && most < 1.005,
        "{least} {most}"
    );
}
