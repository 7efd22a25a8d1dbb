//! The materials, lights and skins of Bevy as the volume extracts them.

use std::f32::consts::PI;

use bevy::{camera::visibility::NoFrustumCulling, prelude::*};
use bevy_ewa::{EwaPlugin, EwaSettings, EwaStandardMaterial};
use bevy_voxel_gi::{MeshVoxelMaterial, VoxelMaterialPlugin};

use super::{
    fixture::*,
    room::{image, textured},
};

/// A roof over the floor's middle that the camera does not see.
fn roof(world: &mut World, material: impl Into<StandardMaterial>) -> Entity {
    let model = model(world, Cuboid::new(1.5, 0.2, 1.5), material);
    let place = Transform::from_xyz(0.0, 0.7, 0.0);
    world.spawn((model, hidden(), place)).id()
}

/// The floor's middle under a roof of this material and a sky of 1.
fn under_roof(material: impl Into<StandardMaterial>) -> Vec3 {
    at(&lit_floor(|world| roof(world, material)), 0.0, 0.0)
}

/// The same once a change has been seen.
fn under_changed_roof(app: &mut HeadlessApp) -> Vec3 {
    ready(app);
    frames(app, 3);
    at(&settled(app), 0.0, 0.0)
}

#[track_caller]
fn assert_like(found: Vec3, expected: Vec3, what: &str) {
    let is_like = found.distance(expected) < 0.01 * expected.length();
    assert!(is_like, "{what}: {found} {expected}");
}

const RED: LinearRgba = LinearRgba::rgb(0.8, 0.1, 0.1);
const GREEN: LinearRgba = LinearRgba::rgb(0.1, 0.8, 0.1);

#[test]
fn forward_and_deferred_receive_the_same() {
    let [forward, deferred] = [app as fn() -> Borrowed, deferred_app].map(|new_app| {
        let mut app = new_app();
        floor(app.world_mut());
        usual_block(app.world_mut());
        app.world_mut().spawn(under_sky(1.0));
        settled(&mut app)
    });
    for x in [-1.0, 0.0, 0.3] {
        let [forward, deferred] = [&forward, &deferred].map(|found| at(found, x, 0.1).x);
        // The buffer of deferred materials has 8 bits a channel.
        assert!((forward - deferred).abs() < 0.01, "{forward} {deferred}");
        assert!(forward > 0.3);
    }
}

#[test]
fn surfaces_give_their_colour_and_transparent_ones_do_not_occlude() {
    let black = under_roof(Color::BLACK);
    let red = under_roof(Color::linear_rgb(1.0, 0.0, 0.0));
    let metal = under_roof(StandardMaterial {
        metallic: 1.0,
        ..default()
    });
    let glass = under_roof(StandardMaterial {
        base_color: Color::srgba(1.0, 1.0, 1.0, 0.3),
        alpha_mode: AlphaMode::Blend,
        ..default()
    });
    assert!(black.x < 0.7, "{black}");
    // Metal reflects nothing diffusely.
    assert!(
        (metal - black).abs().max_element() < 0.02,
        "{metal} {black}"
    );
    assert!(red.x > 1.1 * black.x, "{red} {black}");
    assert!((red.y / black.y - 1.0).abs() < 0.02, "{red} {black}");
    assert!((glass - 1.0).abs().max_element() < 0.02, "{glass}");
}

#[test]
fn textures_count_as_their_mean() {
    // A checkerboard of black and white, and its mean in linear light.
    let texels: [fn(u32, u32) -> [u8; 4]; 2] = [
        |x, y| {
            if (x + y) % 2 == 0 {
                [255; 4]
            } else {
                [0, 0, 0, 255]
            }
        },
        |_, _| [188, 188, 188, 255],
    ];
    let shades = texels.map(|texel| {
        let found = lit_floor(|world| {
            let material = textured(world, image(UVec2::splat(8), texel));
            roof(world, material)
        });
        at(&found, 0.0, 0.0).x
    });
    assert!((shades[0] / shades[1] - 1.0).abs() < 0.01, "{shades:?}");
}

fn of_color(color: LinearRgba) -> MeshVoxelMaterial {
    MeshVoxelMaterial {
        albedo: Some(color.to_vec3()),
        ..default()
    }
}

#[test]
fn a_mesh_can_say_what_its_albedo_is() {
    let expected = under_roof(Color::from(RED));
    let (mut app, _, roof) = floor_under_sky(|world| roof(world, Color::WHITE));
    let white = at(&settled(&mut app), 0.0, 0.0);
    app.world_mut().entity_mut(roof).insert(of_color(RED));
    let found = under_changed_roof(&mut app);
    assert_like(found, expected, "with an albedo");
    assert!(
        found.distance(white) > 0.05 * white.length(),
        "{found} {white}"
    );
    app.world_mut()
        .entity_mut(roof)
        .remove::<MeshVoxelMaterial>();
    assert_like(under_changed_roof(&mut app), white, "without again");
}

/// Adds a material of another type.
fn filtered(world: &mut World, color: LinearRgba) -> MeshMaterial3d<EwaStandardMaterial> {
    let base = StandardMaterial::from_color(color);
    let extension = EwaSettings::default().into();
    MeshMaterial3d(world.add_asset::<EwaStandardMaterial>(EwaStandardMaterial { base, extension }))
}

#[test]
#[ignore = "long: settles for each"]
fn materials_that_nobody_knows_are_gray_or_what_their_mesh_says() {
    let [gray, expected] = [LinearRgba::gray(0.5), RED].map(|color| under_roof(Color::from(color)));
    let mut app = app_with(|app| {
        app.add_plugins(EwaPlugin::OPT_IN);
    });
    let world = app.world_mut();
    floor(world);
    let material = filtered(world, LinearRgba::WHITE);
    let roof = roof(world, Color::WHITE);
    let mut entity = world.entity_mut(roof);
    entity
        .remove::<MeshMaterial3d<StandardMaterial>>()
        .insert(material);
    world.spawn(under_sky(1.0));
    let own = Some(of_color(RED));
    for (own, expected) in [(None, gray), (own, expected), (None, gray), (own, expected)] {
        let mut entity = app.world_mut().entity_mut(roof);
        match own {
            Some(own) => entity.insert(own),
            None => entity.remove::<MeshVoxelMaterial>(),
        };
        assert_like(under_changed_roof(&mut app), expected, &format!("{own:?}"));
    }
}

#[test]
fn a_mesh_that_changes_its_type_of_material_changes_its_colour() {
    let [under_red, under_green] = [RED, GREEN].map(|color| under_roof(Color::from(color)));
    let mut app = app_with(|app| {
        app.add_plugins((
            EwaPlugin::OPT_IN,
            VoxelMaterialPlugin::<EwaStandardMaterial>::default(),
        ));
    });
    let world = app.world_mut();
    floor(world);
    let filtered = filtered(world, GREEN);
    let roof = roof(world, Color::from(RED));
    let material = world.get::<MeshMaterial3d<StandardMaterial>>(roof);
    let material = material.expect("a material").clone();
    world.spawn(under_sky(1.0));
    // Each change takes the old material away first, also where it comes back at once.
    for is_filtered in [false, true, true, false, false, true] {
        let mut entity = app.world_mut().entity_mut(roof);
        entity.remove::<(
            MeshMaterial3d<StandardMaterial>,
            MeshMaterial3d<EwaStandardMaterial>,
        )>();
        let expected = if is_filtered {
            entity.insert(filtered.clone());
            under_green
        } else {
            entity.insert(material.clone());
            under_red
        };
        let what = format!("filtered: {is_filtered}");
        assert_like(under_changed_roof(&mut app), expected, &what);
    }
}

#[test]
fn emissive_surfaces_light_the_scene() {
    let mut app = floor_app();
    let world = app.world_mut();
    // A ceiling of 1 cd/m² over the whole volume, which the camera does not see. The exposure is 1.
    let material = emitting(0.0, LinearRgba::rgb(1.0, 2.0, 0.0));
    let ceiling = model(world, Cuboid::new(3.9, 0.2, 3.9), material);
    let place = Transform::from_xyz(0.0, 0.5, 0.0);
    let ceiling = world.spawn((ceiling, hidden(), place)).id();
    world.spawn(small_volume());
    let found = at(&settled(&mut app), 0.0, 0.0);
    // Above the floor's middle nearly all directions meet it.
    assert!((0.85..=1.01).contains(&found.x), "{found}");
    assert!(
        (found.y / found.x - 2.0).abs() < 0.02 && found.z == 0.0,
        "{found}"
    );
    // Later edits arrive.
    edit_material(app.world_mut(), ceiling, |material| {
        material.emissive = LinearRgba::BLACK;
    });
    assert!(at(&settled_again(&mut app), 0.0, 0.0).max_element() < 1e-3);
}

/// The light that a lit wall of albedo 1/2 reflects to the floor.
fn thrown_by(light: impl Bundle) -> f32 {
    let mut app = app();
    let world = app.world_mut();
    // The floor reflects nothing, and the light shines on the wall alone.
    let wall = Vec3::new(0.4, 1.8, 3.6);
    block_of(world, 0.5, Vec3::new(1.0, 1.0, 0.0), wall);
    let plate = Vec3::new(2.4, 0.1, 3.6);
    block_of(world, 1.0, Vec3::new(-0.5, -0.05, 0.0), plate);
    // Each gives the wall's middle, 1 m above the floor, 100 lux, from far away.
    let towards_wall = Transform::from_xyz(-9.2, 1.0, 0.0).looking_to(Vec3::X, Vec3::Y);
    world.spawn((light, towards_wall));
    let volume = world.spawn(small_volume()).id();
    let with = at(&settled(&mut app), 0.2, 0.0);
    app.world_mut().despawn(volume);
    frames(&mut app, 3);
    (with - at(&picture(&mut app), 0.2, 0.0)).x
}

#[test]
fn lights_of_all_kinds_light_the_wall_alike() {
    let intensity = 100.0 * 10.0 * 10.0 * 4.0 * PI;
    let sun = thrown_by(DirectionalLight {
        illuminance: 100.0,
        ..default()
    });
    let point = thrown_by(point_light(intensity, 1e4));
    let spot = thrown_by(SpotLight {
        intensity,
        range: 1e4,
        inner_angle: 0.3,
        outer_angle: 0.31,
        ..default()
    });
    assert!(sun > 1.0, "{sun}");
    assert!((point / sun - 1.0).abs() < 0.05, "{point} {sun}");
    assert!((spot / point - 1.0).abs() < 0.02, "{spot} {point}");
}

#[test]
fn skinned_meshes_occlude_where_their_joints_put_them() {
    let (mut app, _, joint) = floor_under_sky(|world| {
        let material = matt(world, 0.0);
        let joints = [-2.0, 0.0].map(|x| world.spawn(Transform::from_xyz(x, 0.7, 0.0)).id());
        let skinned = skinned_cuboid(world, joints, material);
        world.spawn((skinned, hidden(), NoFrustumCulling));
        joints[0]
    });
    let found = settled(&mut app);
    let (under, beside) = (at(&found, -1.0, 0.0).x, at(&found, 1.0, 0.0).x);
    assert!(under < 0.7 * beside, "{under} {beside}");
    // The other joint takes it along.
    pose(app.world_mut(), joint).translation.x = 2.0;
    let found = settled_again(&mut app);
    let (left, under) = (at(&found, -1.0, 0.0).x, at(&found, 1.0, 0.0).x);
    assert!(under < 0.7 * left, "{under} {left}");
}
