//! Holes cut by masks, colours of vertices, targets of morphs, and what cameras see of surfaces.

use std::f32::consts::{FRAC_PI_4, PI};

use bevy::{
    camera::visibility::NoFrustumCulling,
    image::ImageSampler,
    mesh::morph::{MeshMorphWeights, MorphAttributes},
    prelude::*,
    render::render_resource::Face,
};
use bevy_voxel_gi::{DebugField, MeshVoxelMaterial, VoxelAlbedo, VoxelGiDebug};

use super::{
    fixture::*,
    room::{image, textured},
};
use crate::support::drawn;

/// A plate over the floor's middle that the camera does not see, of this mesh.
fn plate(
    world: &mut World,
    mesh: impl Into<Mesh>,
    material: impl Into<StandardMaterial>,
) -> Entity {
    let model = model(world, mesh, material);
    let place = Transform::from_xyz(0.0, 0.4, 0.0);
    let own = (hidden(), NoFrustumCulling, place);
    world.spawn((model, own)).id()
}

/// A texture of 8 x 8 texels.
fn texture(texel: impl Fn(u32, u32) -> [u8; 4]) -> Image {
    Image {
        sampler: ImageSampler::nearest(),
        ..image(UVec2::splat(8), texel)
    }
}

/// The floor's middle under a black plate with holes, below a sky of 1.
fn under_mask(alpha_mode: AlphaMode, opaque: fn(u32, u32) -> bool) -> f32 {
    let found = lit_floor(|world| {
        let mask = texture(|x, y| [0, 0, 0, if opaque(x, y) { 255 } else { 0 }]);
        let material = StandardMaterial {
            alpha_mode,
            cull_mode: None,
            double_sided: true,
            ..textured(world, mask)
        };
        plate(world, Plane3d::default().mesh().size(3.0, 3.0), material)
    });
    at(&found, 0.0, 0.0).x
}

#[test]
fn masks_let_as_much_light_through_as_they_have_holes() {
    let mask = AlphaMode::Mask(0.5);
    let checkered = |x, y| (x + y) % 2 == 0;
    let solid = under_mask(mask, |_, _| true);
    let half = under_mask(mask, checkered);
    let quarter = under_mask(mask, |x, _| x % 4 == 0);
    let none = under_mask(mask, |_, _| false);
    let to_coverage = under_mask(AlphaMode::AlphaToCoverage, checkered);
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
    let [white, red] = [[1.0, 1.0, 1.0, 1.0], [1.0, 0.25, 0.0, 1.0]].map(|color: [f32; 4]| {
        let found = lit_floor(|world| {
            let mesh = Mesh::from(Cuboid::new(1.5, 0.2, 1.5));
            let count = mesh.count_vertices();
            let mesh = mesh.with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, vec![color; count]);
            let colored = plate(world, mesh, matt_material(0.8));
            // The same material on a mesh without: it keeps its own colour.
            let material = world.get::<MeshMaterial3d<StandardMaterial>>(colored);
            let material = material.expect("a material").clone();
            let other = plate(world, Cuboid::new(0.3, 0.2, 0.3), Color::WHITE);
            let place = Transform::from_xyz(1.6, 0.4, 1.6);
            world.entity_mut(other).insert((material, place));
        });
        at(&found, 0.0, 0.0)
    });
    let dark = white.x - 0.1;
    assert!((red.x / white.x - 1.0).abs() < 0.02, "{red} {white}");
    assert!(
        red.y < 0.97 * white.y && red.z < red.y,
        "{red} {white} {dark}"
    );
}

/// A dark box whose corners targets move along x by so much.
fn morphed(world: &mut World, size: Vec3, targets: &[f32], weights: Vec<f32>) -> Entity {
    let mut mesh = Mesh::from(Cuboid::from_size(size));
    let count = mesh.count_vertices();
    let targets = targets.iter().map(|x| MorphAttributes {
        position: *x * Vec3::X,
        ..default()
    });
    mesh.set_morph_targets(targets.flat_map(|target| vec![target; count]).collect());
    let entity = plate(world, mesh, matt_material(0.0));
    let weights = MeshMorphWeights::Value { weights };
    world.entity_mut(entity).insert(weights);
    entity
}

#[test]
fn morphed_meshes_occlude_where_their_targets_put_them() {
    // One target to the left, one to the right.
    let size = Vec3::new(1.5, 0.2, 1.5);
    let (mut app, _, entity) =
        floor_under_sky(|world| morphed(world, size, &[-2.0, 2.0], vec![0.5, 0.0]));
    let found = settled(&mut app);
    let (left, right) = (at(&found, -1.0, 0.0).x, at(&found, 1.0, 0.0).x);
    assert!(left < 0.7 * right, "{left} {right}");
    let weights = vec![0.0, 0.5];
    app.world_mut()
        .entity_mut(entity)
        .insert(MeshMorphWeights::Value { weights });
    let found = settled_again(&mut app);
    let (left, right) = (at(&found, -1.0, 0.0).x, at(&found, 1.0, 0.0).x);
    assert!(right < 0.7 * left, "{left} {right}");
}

/// A target that displaces by many times the mesh's own size.
#[test]
fn a_morphed_mesh_leaves_nothing_where_it_was() {
    let size = Vec3::new(0.6, 0.2, 0.6);
    let (mut app, _, entity) = floor_under_sky(|world| morphed(world, size, &[3.0], vec![0.0]));
    let expected = settled(&mut app);
    for weight in [0.45, 0.0] {
        let weights = vec![weight];
        app.world_mut()
            .entity_mut(entity)
            .insert(MeshMorphWeights::Value { weights });
        frames(&mut app, 3);
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
    let mut app = if with_prepass {
        deferred_app()
    } else {
        app_with(|_| ())
    };
    let world = app.world_mut();
    let halves = texture(|x, _| [[255, 0, 0, 255], [0, 255, 0, 255]][usize::from(x < 4)]);
    let material = StandardMaterial {
        base_color_texture: Some(world.add_asset(halves)),
        ..matt_material(1.0)
    };
    let model = model(world, Plane3d::default().mesh().size(3.6, 3.6), material);
    let own = MeshVoxelMaterial {
        albedo: own,
        ..default()
    };
    let place = Transform::from_xyz(0.0, 0.05, 0.0);
    let floor = world.spawn((model, own, place)).id();
    if !is_visible {
        world.entity_mut(floor).insert(hidden());
    }
    settings(world).albedo = albedo;
    let volume = world.spawn(under_sky(1.0)).id();
    ready(&mut app);
    settle_in_view(&mut app);
    // What is no longer seen is remembered.
    let world = app.world_mut();
    world.entity_mut(floor).insert(hidden());
    world.entity_mut(volume).insert(under_sky(2.0));
    frames(&mut app, 8);
    let field = DebugField::Albedo;
    camera(app.world_mut()).insert(VoxelGiDebug { field });
    frames(&mut app, 3);
    picture(&mut app)
}

fn is_about(found: Vec3, expected: Vec3) {
    let wrong = (found - expected).abs().max_element();
    assert!(wrong < 0.05, "{found} instead of {expected}");
}

#[test]
fn what_cameras_see_is_the_albedo_and_else_that_of_materials() {
    let (green, red, gray) = (Vec3::Y, Vec3::X, Vec3::splat(0.5));
    let own = Vec3::new(0.1, 0.2, 0.8);
    let rows = [
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
    ];
    for (albedo, own, with_prepass, is_visible, [left, right]) in drawn(1, rows) {
        let found = shown_albedo(albedo, own, with_prepass, is_visible);
        is_about(at(&found, -1.0, 0.0), left);
        is_about(at(&found, 1.0, 0.0), right);
    }
}

/// A roof with one side is as dark below as one with two: its back is black. So it is five voxels above the floor and
/// two.
#[test]
fn back_faces_are_black() {
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
    let rows = [(1.27, 0.474, 0.004), (0.51, 0.128, 0.009)];
    for (height, middle, allowed) in drawn(1, rows) {
        let sides = [
            (two_sides.clone(), up),
            (one_side.clone(), up),
            (one_side.clone(), down),
        ];
        let shades = sides.map(|(sides, way)| {
            let light = lit_floor(|world| {
                let roof = plate(world, Plane3d::default().mesh().size(2.4, 2.4), sides);
                let place = Transform::from_xyz(0.0, height, 0.0).with_rotation(way);
                world.entity_mut(roof).insert(place);
            });
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
    let mut app = app();
    let world = app.world_mut();
    let mesh = Sphere::new(1.3).mesh().ico(8).expect("few triangles");
    let model = model(world, mesh, matt_material(1.0));
    world.spawn(model);
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

/// The light of an emissive plate is in proportion to its projected area, at any angle to the voxels.
#[test]
fn tilted_surfaces_emit_by_their_area() {
    let below = |tilt: f32| {
        let mut app = floor_app();
        let world = app.world_mut();
        let bright = emitting(0.0, LinearRgba::rgb(100.0, 100.0, 100.0));
        let plate = plate(world, Plane3d::default().mesh().size(0.4, 0.4), bright);
        let down = Quat::from_rotation_x(PI) * Quat::from_rotation_z(tilt);
        let place = Transform::from_xyz(0.05, 1.3, 0.07).with_rotation(down);
        world.entity_mut(plate).insert(place);
        world.spawn(under_sky(0.0));
        at(&settled(&mut app), 0.0, 0.0).x
    };
    let level = below(0.0);
    for tilt in [0.5, FRAC_PI_4] {
        let share = below(tilt) / level;
        println!("{tilt}: {share} for {}", tilt.cos());
        assert!((share / tilt.cos() - 1.0).abs() < 0.15, "{tilt}: {share}");
    }
}
