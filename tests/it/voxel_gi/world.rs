//! The world outside of volumes: rays see it, and pixels do not end at an edge.

use bevy::{
    asset::RenderAssetUsages,
    camera::ScalingMode,
    image::ToExtents,
    light::{Atmosphere, AtmosphereEnvironmentMapLight, Skybox, atmosphere::ScatteringMedium},
    pbr::AtmosphereSettings,
    prelude::*,
    render::render_resource::{
        TextureDimension, TextureFormat, TextureViewDescriptor, TextureViewDimension,
    },
};
use bevy_frugal_lab::{
    boxes::{BoxScene, agreement, block_means, cornell_box, trace},
    headless::HeadlessApp,
    path_tracer::TraceSettings,
};
use bevy_voxel_gi::{Sky, VoxelGiVolume};

use super::fixture::*;
use crate::support::drawn;

/// A closed hall of 12 m whose floor's top is at y = 0, with or without its ceiling.
fn hall(world: &mut World, has_ceiling: bool) {
    const WALL: f32 = 0.3;
    let mut slab = |center: Vec3, size: Vec3| {
        block_of(world, 0.5, center, size);
    };
    let flat = Vec3::new(12.0 + 2.0 * WALL, WALL, 12.0 + 2.0 * WALL);
    slab(Vec3::Y * -0.5 * WALL, flat);
    if has_ceiling {
        slab(Vec3::Y * (6.0 + 0.5 * WALL), flat);
    }
    for side in [-1.0, 1.0] {
        let at = side * (6.0 + 0.5 * WALL);
        slab(Vec3::new(at, 3.0, 0.0), Vec3::new(WALL, 6.0, flat.z));
        slab(Vec3::new(0.0, 3.0, at), Vec3::new(12.0, 6.0, WALL));
    }
}

#[test]
fn a_sealed_hall_around_a_volume_is_dark_and_an_open_one_is_not() {
    let added = |has_ceiling: bool| {
        let mut app = app();
        hall(app.world_mut(), has_ceiling);
        app.world_mut().spawn(sun(10.0, Vec3::new(0.3, -1.0, 0.2)));
        ready(&mut app);
        let found = indirect(&mut app, under_sky(1.0));
        [(0.0, 0.0), (1.5, -1.5), (-1.2, 0.8)].map(|(x, z)| at(&found, x, z).x)
    };
    let dark = added(true);
    assert!(dark.iter().all(|light| light.abs() < 0.01), "{dark:?}");
    let open = added(false);
    assert!(open.iter().all(|light| *light > 0.3), "{open:?}");
}

/// A room whose walls lie on borders of sub-voxels but for a small turn, as the reference traces it.
#[test]
fn a_room_that_is_turned_a_little_is_dark() {
    for degrees in [0.02f32, 1.0, 1.5] {
        let mut app = app();
        let world = app.world_mut();
        let mut room = Mesh::from(Cuboid::from_length(2.75));
        room.invert_winding().expect("triangles");
        let room = model(world, room, matt_material(0.5));
        let axis = Vec3::new(1.0, 0.7, -0.4).normalize();
        let turn = Quat::from_axis_angle(axis, degrees.to_radians());
        world.spawn((room, Transform::from_rotation(turn)));
        world.spawn(under_sky(1.0));
        settle(&mut app);
        let texels = read_texels(&mut app);
        let faces = texels.iter().flatten().filter(|face| face.w > 0.5);
        let light: Vec<f32> = faces.map(|face| face.x).collect();
        let mean = light.iter().sum::<f32>() / light.len() as f32;
        println!("{degrees} degrees: {mean} in {} faces", light.len());
        assert!(
            light.len() > 500 && mean < 5e-4,
            "{degrees} degrees: {mean}"
        );
    }
}

/// A cube map with this radiance in each direction of the world.
fn cube_map(world: &mut World, radiance: impl Fn(Vec3) -> f32) -> Handle<Image> {
    const SIZE: u32 = 32;
    let texel = |face: u32, x: u32, y: u32| {
        let [u, v] = [x, y].map(|at| (2.0 * at as f32 + 1.0) / SIZE as f32 - 1.0);
        let cube = match face {
            0 => Vec3::new(1.0, -v, -u),
            1 => Vec3::new(-1.0, -v, u),
            2 => Vec3::new(u, 1.0, v),
            3 => Vec3::new(u, -1.0, -v),
            4 => Vec3::new(u, -v, 1.0),
            _ => Vec3::new(-u, -v, -1.0),
        };
        // Cube maps are left-handed.
        radiance(cube * Vec3::new(1.0, 1.0, -1.0))
    };
    let faces = (0..6).flat_map(|face| (0..SIZE * SIZE).map(move |i| (face, i % SIZE, i / SIZE)));
    let texels = faces.flat_map(|(face, x, y)| {
        let gray = half::f16::from_f32(texel(face, x, y));
        [gray, gray, gray, half::f16::ONE].map(half::f16::to_le_bytes)
    });
    let mut image = Image::new(
        UVec3::new(SIZE, SIZE, 6).to_extents(),
        TextureDimension::D2,
        texels.flatten().collect(),
        TextureFormat::Rgba16Float,
        RenderAssetUsages::default(),
    );
    image.texture_view_descriptor = Some(TextureViewDescriptor {
        dimension: Some(TextureViewDimension::Cube),
        ..default()
    });
    world.add_asset(image)
}

/// A floor of 20 m, of which the camera sees `width` metres.
fn wide_floor(app: &mut HeadlessApp, width: f32) {
    let world = app.world_mut();
    let size = Vec3::new(20.0, 0.2, 20.0);
    block_of(world, 0.5, Vec3::new(0.0, -0.1, 0.0), size);
    let mut camera = camera(world);
    let scaling_mode = ScalingMode::Fixed {
        width,
        height: width,
    };
    camera.insert(Projection::from(OrthographicProjection {
        scaling_mode,
        ..OrthographicProjection::default_3d()
    }));
}

/// All of a floor is as bright as Bevy alone has it, in a volume, at its edge, outside, and in several volumes.
fn a_floor_without_an_edge(light: impl Fn(&mut World)) {
    let mut app = app();
    wide_floor(&mut app, 12.0);
    light(app.world_mut());
    ready(&mut app);
    let alone = picture(&mut app);
    let expected = at(&alone, 0.0, 0.0).x;
    assert!(expected > 0.2, "{expected}");
    let at_x = |size: f32, x: f32| (VoxelGiVolume::fixed(size), Transform::from_xyz(x, 0.0, 0.0));
    let follows = VoxelGiVolume {
        size: 2.0,
        ..default()
    };
    for (what, volumes) in [
        ("a volume", vec![at_x(4.0, 0.0)]),
        ("cascades around the camera", vec![(follows, default())]),
        (
            "three volumes",
            vec![at_x(4.0, 0.0), at_x(3.0, 0.0), at_x(2.0, 4.0)],
        ),
        ("a volume out of view", vec![at_x(2.0, 8.0)]),
    ] {
        let world = app.world_mut();
        let volumes: Vec<_> = { volumes.into_iter() }
            .map(|volume| world.spawn(volume).id())
            .collect();
        settle(&mut app);
        for (pixel, (found, alone)) in picture(&mut app).iter().zip(&alone).enumerate() {
            let wrong = (*found / *alone - 1.0).abs().max_element();
            assert!(wrong < 0.012, "{found} for {alone} at {pixel} with {what}");
        }
        for volume in volumes {
            app.world_mut().despawn(volume);
        }
        frames(&mut app, 3);
    }
}

#[test]
#[ignore = "long: a large volume"]
fn a_floor_under_an_environment_map_has_no_edge() {
    a_floor_without_an_edge(|world| {
        let map = cube_map(world, |_| 1.0);
        camera(world).insert(EnvironmentMapLight {
            diffuse_map: map.clone(),
            specular_map: map,
            intensity: 1.0,
            ..default()
        });
    });
}

#[test]
#[ignore = "long: many frames"]
fn a_floor_in_ambient_light_has_no_edge() {
    a_floor_without_an_edge(|world| {
        world.insert_resource(GlobalAmbientLight {
            brightness: 1.0,
            ..default()
        });
    });
}

/// Boxes on a floor in a corner of walls, under a sky whose quarter at +X and +Z is bright.
fn under_a_bright_quarter() -> BoxScene {
    let mut scene = cornell_box();
    let gray = |center, half, albedo| scene_box(center, half, Vec3::splat(albedo));
    scene.boxes = vec![
        gray([0.0, -0.2, 0.0], [4.0, 0.2, 4.0], 0.6),
        gray([-3.8, 1.5, 0.0], [0.2, 1.5, 4.0], 0.7),
        gray([0.0, 1.5, -3.8], [4.0, 1.5, 0.2], 0.3),
        gray([0.5, 0.8, 0.7], [0.8, 0.8, 0.8], 0.5),
        gray([-1.6, 0.4, 1.9], [0.5, 0.4, 0.7], 0.8),
    ];
    scene.boxes[3].rotate_y_deg = 30.0;
    (scene.point_lights, scene.directional_lights) = (vec![], vec![]);
    scene.sky_radiance = Vec3::splat(1.0);
    scene.sky_quarter = Vec3::splat(9.0);
    let (eye, target) = (Vec3::new(5.0, 6.0, 5.5), Vec3::new(-0.4, 0.3, -0.4));
    look(&mut scene, eye, target, 64);
    scene
}

#[test]
fn rays_see_the_games_own_sky_as_it_is_turned() {
    let scene = under_a_bright_quarter();
    let settings = TraceSettings {
        samples: 512,
        ..default()
    };
    let truth = trace(&scene, &settings);
    let truth = block_means(&truth.indirect, scene.camera.width);
    let mut app = box_app(&scene);
    let (center, size) = scene.volume(32);
    for (what, turn) in drawn(1, [("as it is", 0.0), ("turned", 2.0)]) {
        let rotation = Quat::from_rotation_y(turn);
        let world = app.world_mut();
        let map = cube_map(world, |direction| {
            0.5 * scene.stage().sky(rotation * direction).x
        });
        camera(world).insert(Skybox {
            image: Some(map),
            brightness: 2.0,
            rotation,
        });
        let volume = VoxelGiVolume::fixed(size);
        let found = indirect(&mut app, (volume, Transform::from_translation(center)));
        let found = agreement(&found, scene.camera.width, &truth);
        println!("{what}: {found:?}");
        assert!(found.relative_error < 0.05, "{what}: {found:?}");
    }
}

#[test]
fn a_sky_that_changes_is_seen_anew() {
    let mut app = app();
    wide_floor(&mut app, 4.0);
    let world = app.world_mut();
    let map = cube_map(world, |_| 1.0);
    let skybox = |image: &Handle<Image>, brightness| Skybox {
        image: Some(image.clone()),
        brightness,
        rotation: Quat::IDENTITY,
    };
    camera(world).insert(skybox(&map, 1.0));
    world.spawn(VoxelGiVolume::fixed(4.0));
    let check = |app: &mut HeadlessApp, expected: f32, what: &str| {
        let found = at(&settled(app), 0.5, 0.5).x;
        assert!((found / expected - 1.0).abs() < 0.01, "{found} {what}");
    };
    check(&mut app, 0.5, "at first");
    camera(app.world_mut()).insert(skybox(&map, 3.0));
    check(&mut app, 1.5, "when it is brighter");
    let brighter = cube_map(app.world_mut(), |_| 4.0);
    let mut images = app.world_mut().resource_mut::<Assets<Image>>();
    let image = images.get(&brighter).expect("an image").clone();
    images.insert(&map, image).expect("its place");
    check(&mut app, 6.0, "when its image is another one");
    camera(app.world_mut()).remove::<Skybox>();
    app.world_mut().insert_resource(GlobalAmbientLight {
        brightness: 2.0,
        ..default()
    });
    check(&mut app, 0.4524, "when there is ambient light alone");
    // Another one by hand.
    let world = app.world_mut();
    let mut volumes = world.query::<&mut VoxelGiVolume>();
    volumes.single_mut(world).expect("one").sky =
        Some(Sky::uniform(LinearRgba::rgb(5.0, 5.0, 5.0)));
    check(&mut app, 2.5, "by hand");
}

/// A floor in the light of an atmosphere alone is about as bright as Bevy has it, also where the camera only shows it.
#[test]
#[ignore = "long: many frames"]
fn rays_see_the_atmosphere() {
    let mut app = app_with(|_| ());
    wide_floor(&mut app, 4.0);
    let world = app.world_mut();
    let mut media = world.resource_mut::<Assets<ScatteringMedium>>();
    let medium = media.add(ScatteringMedium::earth(64, 64));
    world.spawn(Atmosphere::earth(medium));
    world.spawn(sun(1000.0, Vec3::new(-1.0, -0.4, -0.3)));
    camera(world).insert(AtmosphereSettings::default());
    let light_of = |app: &mut HeadlessApp| {
        app.render_frames(30).expect("frames");
        at(&picture(app), 0.0, 0.0)
    };
    let sun_alone = light_of(&mut app);
    camera(app.world_mut()).insert(AtmosphereEnvironmentMapLight::default());
    ready(&mut app);
    let by_bevy = light_of(&mut app) - sun_alone;
    app.world_mut().spawn(VoxelGiVolume::fixed(4.0));
    settle(&mut app);
    let lit = light_of(&mut app) - sun_alone;
    camera(app.world_mut()).remove::<AtmosphereEnvironmentMapLight>();
    app.render_frames(5).expect("frames");
    settle(&mut app);
    let shown = light_of(&mut app) - sun_alone;
    println!("{by_bevy} by Bevy, {lit} by the volume, {shown} where it is only shown");
    for found in [lit, shown] {
        let wrong = (found / by_bevy - 1.0).abs().max_element();
        assert!(wrong < 0.1, "{found} for {by_bevy}");
    }
}
