//! What a game means by its components.

use std::f32::consts::PI;

use bevy::{
    asset::RenderAssetUsages,
    camera::{
        Exposure,
        visibility::{RenderLayers, VisibilityRange},
    },
    light::{IrradianceVolume, LightProbe, NotShadowCaster, RectLight},
    pbr::{
        Lightmap,
        wireframe::{Wireframe, WireframeColor, WireframePlugin},
    },
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_voxel_gi::MeshVoxelMaterial;

use super::{fixture::*, room::image};

fn near(found: f32, expected: f32, tolerance: f32) {
    assert_near(Vec3::splat(found), expected, tolerance);
}

/// A roof over the floor, which the camera does not see.
fn roof(world: &mut World, edge: f32) -> Entity {
    let roof = block(world, Vec3::Y * 0.7, Vec3::new(edge, 0.2, edge));
    world.entity_mut(roof).insert(hidden());
    roof
}

#[test]
#[ignore = "long: settles for each"]
fn meshes_of_other_layers_are_not_there() {
    let open = lit_floor(|_| ());
    let on_another_layer = lit_floor(|world| {
        let roof = roof(world, 1.5);
        world.entity_mut(roof).insert(RenderLayers::layer(7));
    });
    assert!(on_another_layer == open);
    // Layers that change count at once.
    let (mut app, volume, roof) = floor_under_sky(|world| roof(world, 1.5));
    let shaded = settled(&mut app);
    assert!(at(&shaded, 0.0, 0.0).x < 0.8 * at(&open, 0.0, 0.0).x);
    let mut change = |entity: Entity, layers: RenderLayers| {
        app.world_mut().entity_mut(entity).insert(layers);
        settled_again(&mut app)
    };
    assert!(change(roof, RenderLayers::layer(7)) == open);
    assert!(change(volume, RenderLayers::from_layers(&[0, 7])) == shaded);
    assert!(change(volume, RenderLayers::default()) == open);
}

/// The light of a scene on a floor, with a volume and without.
fn with_volume_and_without(
    build: impl Fn(&mut World),
    volume: impl Fn(&mut World),
) -> [Vec<Vec3>; 2] {
    [true, false].map(|has_volume| {
        let mut app = floor_app();
        let world = app.world_mut();
        build(world);
        if has_volume {
            volume(world);
            return settled(&mut app);
        }
        ready(&mut app);
        picture(&mut app)
    })
}

/// What the walls of a room throw back to its floor, with more in it: the mean of four places.
fn bounce(more: impl Fn(&mut World)) -> f32 {
    let room = |world: &mut World| {
        for (center, size) in [
            (Vec3::X * 1.8, Vec3::new(0.2, 1.8, 3.6)),
            (Vec3::NEG_X * 1.8, Vec3::new(0.2, 1.8, 3.6)),
            (Vec3::Z * 1.8, Vec3::new(3.6, 1.8, 0.2)),
            (Vec3::NEG_Z * 1.8, Vec3::new(3.6, 1.8, 0.2)),
        ] {
            block_of(world, 0.7, center.with_y(0.9), size);
        }
        more(world);
    };
    let [with, without] = with_volume_and_without(room, |world| {
        world.spawn(small_volume());
    });
    let places = [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)];
    let light = places.map(|(x, z)| at(&with, x, z).x - at(&without, x, z).x);
    light.iter().sum::<f32>() / 4.0
}

/// A point light in the middle of the room that nothing nearer than this shadows.
fn lit(world: &mut World, near: f32) -> Entity {
    let light = PointLight {
        shadow_map_near_z: near,
        ..point_light(400.0 * PI, 100.0)
    };
    world
        .spawn((light, Transform::from_xyz(0.0, 1.0, 0.0)))
        .id()
}

#[test]
fn lights_of_other_layers_are_not_there() {
    let bright = bounce(|world| {
        lit(world, 0.4);
    });
    let dark = bounce(|world| {
        let light = lit(world, 0.4);
        world.entity_mut(light).insert(RenderLayers::layer(7));
    });
    assert!(bright > 1.0 && dark == 0.0, "{bright} {dark}");
}

#[test]
fn a_bulb_does_not_catch_its_own_light() {
    let without = bounce(|world| {
        lit(world, 0.4);
    });
    let with = bounce(|world| {
        lit(world, 0.4);
        let bulb = block(world, Vec3::Y, Vec3::splat(0.3));
        world.entity_mut(bulb).insert(hidden());
    });
    // It shades what the walls throw back.
    near(with, without, 0.1);
}

/// The light that walls reflect with a box at a point light: without `NotShadowCaster`, with it, and where nothing
/// nearer to the light than the floor shadows it.
fn with_a_box_at_the_light(albedo: f32, center: Vec3, size: Vec3) -> [f32; 3] {
    [(false, 0.4), (true, 0.4), (false, 1.0)].map(|(casts_none, near)| {
        bounce(|world| {
            lit(world, near);
            let block = block_of(world, albedo, center, size);
            world.entity_mut(block).insert(hidden());
            if casts_none {
                world.entity_mut(block).insert(NotShadowCaster);
            }
        })
    })
}

#[test]
#[ignore = "long: settles for each caster"]
fn what_casts_no_shadow_lets_direct_light_through() {
    let plate = with_a_box_at_the_light(0.0, Vec3::Y * 0.45, Vec3::new(0.9, 0.1, 0.9));
    let shade = with_a_box_at_the_light(0.9, Vec3::Y, Vec3::splat(1.1));
    println!("plate {plate:?}, shade {shade:?}");
    for [shadowed, with, expected] in [plate, shade] {
        assert!(shadowed < 0.9 * expected, "{shadowed} {expected}");
        near(with, expected, 0.02);
    }
    assert_eq!(shade[0], 0.0);
}

/// The sun over a roof, on which a sheet lies that casts no shadow and fills the same voxels.
#[test]
fn what_casts_no_shadow_opens_nothing_that_it_lies_on() {
    let light = |has_roof: bool| {
        bounce(|world| {
            world.spawn(sun(1000.0, Vec3::NEG_Y));
            if has_roof {
                let roof = block(world, Vec3::Y * 1.5, Vec3::new(3.9, 0.2, 3.9));
                world.entity_mut(roof).insert(hidden());
            }
            let sheet = block_of(world, 0.9, Vec3::Y * 1.61, Vec3::new(3.2, 0.02, 3.2));
            let own = (hidden(), NotShadowCaster);
            world.entity_mut(sheet).insert(own);
        })
    };
    let (open, closed) = (light(false), light(true));
    println!("{closed} of {open}");
    assert!(open > 10.0 && closed.abs() < 1e-3 * open, "{closed} {open}");
}

#[test]
fn of_the_levels_of_detail_one_counts() {
    let nearest = lit_floor(|world| roof(world, 1.0));
    let both = lit_floor(|world| {
        for (edge, range) in [(1.0, 0.0..2.0), (2.5, 2.0..100.0)] {
            let range = VisibilityRange::abrupt(range.start, range.end);
            let roof = roof(world, edge);
            world.entity_mut(roof).insert(range);
        }
    });
    assert!(both == nearest);
}

#[test]
fn a_hidden_volume_is_none() {
    let mut app = floor_app();
    let world = app.world_mut();
    let house = world.spawn((Transform::default(), Visibility::Hidden)).id();
    world.spawn((under_sky(1.0), ChildOf(house)));
    ready(&mut app);
    assert!(picture(&mut app).iter().all(|p| *p == Vec3::ZERO));
    app.world_mut()
        .entity_mut(house)
        .insert(Visibility::Inherited);
    near(at(&settled_again(&mut app), 0.0, 0.0).x, 1.0, 0.02);
}

/// The light under a white ceiling, which is lit by a square of 1 m with this radiance that looks up, beside the
/// square.
fn under_ceiling(radiance: f32, is_light: bool) -> [f32; 2] {
    // Whole sub-voxels of the volume.
    let edge = 0.999;
    let build = |world: &mut World| {
        let ceiling = block_of(world, 0.8, Vec3::Y * 1.7, Vec3::new(3.6, 0.2, 3.6));
        world.entity_mut(ceiling).insert(hidden());
        let emissive = LinearRgba::gray(if is_light { 0.0 } else { radiance });
        let mesh = Plane3d::default().mesh().size(edge, edge);
        let square = model(world, mesh, emitting(0.0, emissive));
        world.spawn((square, hidden(), Transform::from_xyz(0.0, 0.52, 0.0)));
        if is_light {
            let light = RectLight {
                intensity: radiance * edge * edge * PI,
                width: edge,
                height: edge,
                range: 1e4,
                ..default()
            };
            let place = Transform::from_xyz(0.0, 0.56, 0.0).looking_to(Vec3::Y, Vec3::Z);
            world.spawn((light, place));
        }
    };
    let [with, without] = with_volume_and_without(build, |world| {
        settings(world).resolution = 32;
        world.spawn(small_volume());
    });
    [1.1, -1.4].map(|x| (at(&with, x, 0.0) - at(&without, x, 0.0)).x)
}

#[test]
#[ignore = "long: light of two scenes"]
fn a_rectangular_light_bounces_like_a_bright_square() {
    let square = under_ceiling(1000.0, false);
    let light = under_ceiling(1000.0, true);
    println!("square {square:?}, light {light:?}");
    for (light, square) in light.into_iter().zip(square) {
        assert!(square > 1.0);
        near(light, square, 0.05);
    }
}

/// The light of a ceiling over the whole floor, with a camera of this exposure.
fn below(exposure: f32, material: StandardMaterial, own: Option<MeshVoxelMaterial>) -> Vec3 {
    let mut app = floor_app();
    let world = app.world_mut();
    let ceiling = model(world, Cuboid::new(3.9, 0.2, 3.9), material);
    let place = Transform::from_xyz(0.0, 0.5, 0.0);
    let ceiling = world.spawn((ceiling, hidden(), place)).id();
    if let Some(own) = own {
        world.entity_mut(ceiling).insert(own);
    }
    for mut known in world.query::<&mut Exposure>().iter_mut(world) {
        known.ev100 = -(1.2 * exposure).log2();
    }
    world.spawn(small_volume());
    at(&settled(&mut app), 0.0, 0.0)
}

#[test]
fn unlit_materials_shine_as_they_look() {
    for exposure in [1.0, 0.125] {
        let found = below(
            exposure,
            StandardMaterial {
                base_color: LinearRgba::rgb(0.5, 0.25, 0.0).into(),
                emissive: LinearRgba::BLUE,
                unlit: true,
                ..default()
            },
            None,
        );
        // The floor is white, and sees hardly anything else.
        assert!((0.42..=0.51).contains(&found.x), "{found}");
        near(found.y, 0.5 * found.x, 0.02);
        assert_eq!(found.z, 0.0);
    }
}

#[test]
fn a_mesh_can_say_what_it_emits() {
    let emissive = Some(LinearRgba::rgb(2.0, 0.0, 0.0));
    let own = MeshVoxelMaterial {
        emissive,
        ..default()
    };
    let dark = StandardMaterial {
        base_color: Color::BLACK,
        emissive: LinearRgba::GREEN,
        ..default()
    };
    let found = below(1.0, dark, Some(own));
    assert!((1.7..=2.02).contains(&found.x), "{found}");
    assert_eq!((found.y, found.z), (0.0, 0.0));
}

#[test]
fn lightmapped_meshes_receive_where_the_volume_says_so() {
    let light = |affects: bool| {
        let mut app = app();
        let world = app.world_mut();
        let image = world.add_asset(image(UVec2::ONE, |_, _| [0, 0, 0, 255]));
        let mesh = Plane3d::default().mesh().size(3.6, 3.6).build();
        let uv = mesh.attribute(Mesh::ATTRIBUTE_UV_0).cloned().expect("UV");
        let mesh = world.add_asset(mesh.with_inserted_attribute(Mesh::ATTRIBUTE_UV_1, uv));
        let material = MeshMaterial3d(matt(world, 1.0));
        let lightmap = Lightmap { image, ..default() };
        world.spawn((Mesh3d(mesh), material, lightmap));
        settings(world).affects_lightmapped_meshes = affects;
        world.spawn(under_sky(1.0));
        at(&settled(&mut app), 0.0, 0.0).x
    };
    assert_eq!(light(false), 0.0);
    near(light(true), 1.0, 0.05);
}

#[test]
fn a_baked_irradiance_volume_lights_what_is_in_it_and_nothing_else() {
    let mut app = app_with(|_| ());
    let world = app.world_mut();
    floor(world);
    world.spawn(under_sky(1.0));
    let alone = settled(&mut app);
    let world = app.world_mut();
    let size = Extent3d {
        width: 1,
        height: 2,
        depth_or_array_layers: 3,
    };
    let voxels = Image::new_fill(
        size,
        TextureDimension::D3,
        &[255, 0, 0, 255],
        TextureFormat::Rgba8Unorm,
        RenderAssetUsages::all(),
    );
    let baked = IrradianceVolume {
        voxels: world.add_asset(voxels),
        intensity: 3.0,
        ..default()
    };
    let place = Transform::from_xyz(1.0, 0.0, 0.0);
    let baked = world.spawn((baked, LightProbe::new(), place)).id();
    let both = settled_again(&mut app);
    // Each volume has the same weight there.
    let inside = at(&both, 1.0, 0.0);
    near(inside.x, 2.0, 0.05);
    near(inside.y, 0.5, 0.05);
    let is_outside = |i: &usize| {
        let across = |i: usize| (i as f32 + 0.5) * 4.0 / SIZE as f32 - 2.0;
        let offset = Vec2::new(across(i % SIZE as usize) - 1.0, across(i / SIZE as usize));
        offset.abs().max_element() > 0.6
    };
    let outside = |picture: &[Vec3]| -> Vec<Vec3> {
        let indices = (0..picture.len()).filter(is_outside);
        indices.map(|i| picture[i]).collect()
    };
    // Where it is not, both ways to find a volume read the same.
    for (with, without) in outside(&both).iter().zip(outside(&alone)) {
        assert!(with.abs_diff_eq(without, 1e-3), "{with} {without}");
    }
    app.world_mut().despawn(baked);
    let after = settled_again(&mut app);
    near(at(&after, 1.0, 0.0).y, at(&alone, 1.0, 0.0).y, 1e-3);
}

#[test]
fn wireframes_that_are_there_before_the_volume() {
    let mut app = app_with(|app| {
        app.add_plugins(WireframePlugin::default());
    });
    let floor = floor(app.world_mut());
    let color = Color::linear_rgb(0.0, 8.0, 0.0);
    let wireframe = (Wireframe, WireframeColor { color });
    app.world_mut().entity_mut(floor).insert(wireframe);
    ready(&mut app);
    let is_green = |p: &&Vec3| p.y > 2.0 && p.x < 1.5;
    let count = |picture: &[Vec3]| picture.iter().filter(is_green).count();
    let lines = count(&picture(&mut app));
    assert!(lines > 20, "{lines}");
    let volume = app.world_mut().spawn(under_sky(1.0)).id();
    let found = settled_again(&mut app);
    assert_eq!(count(&found), lines);
    near(at(&found, 1.0, 0.5).x, 1.0, 0.02);
    app.world_mut().despawn(volume);
    frames(&mut app, 3);
    assert_eq!(count(&picture(&mut app)), lines);
}
