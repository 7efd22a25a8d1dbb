//! The materials, lights and skins of Bevy as the volume extracts them.

use std::f32::consts::PI;

use bevy::{
    camera::visibility::NoFrustumCulling,
    image::Image,
    mesh::{
        VertexAttributeValues,
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    pbr::DefaultOpaqueRendererMethod,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_ewa::{EwaPlugin, EwaSettings, EwaStandardMaterial};
use bevy_frugal_lab::headless::HeadlessApp;
use bevy_voxel_gi::{MeshVoxelMaterial, VoxelMaterialPlugin};

use super::{
    scene::{app, app_with, at, block, block_of, floor, hidden, matt, small_volume, under_sky},
    support::{picture, settle},
};
use crate::support::gpu;

fn settled(app: &mut HeadlessApp) -> Vec<Vec3> {
    app.run_until_ready(200).expect("not ready");
    settle(app);
    picture(app)
}

/// A roof over the floor's middle that the camera does not see.
fn roof(world: &mut World, material: Handle<StandardMaterial>) -> Entity {
    let mesh = world
        .resource_mut::<Assets<Mesh>>()
        .add(Cuboid::new(1.5, 0.2, 1.5));
    world
        .spawn((
            Mesh3d(mesh),
            MeshMaterial3d(material),
            hidden(),
            Transform::from_xyz(0.0, 0.7, 0.0),
        ))
        .id()
}

/// The floor's middle under a roof of this material and a sky of 1.
fn under_roof(material: StandardMaterial) -> Vec3 {
    let mut app = app();
    let world = app.world_mut();
    floor(world);
    let material = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(material);
    roof(world, material);
    world.spawn(under_sky(1.0));
    at(&settled(&mut app), 0.0, 0.0)
}

#[test]
fn forward_and_deferred_receive_the_same() {
    let _gpu = gpu();
    let pictures = [false, true].map(|deferred| {
        let mut app = app_with(|app| {
            if deferred {
                app.insert_resource(DefaultOpaqueRendererMethod::deferred());
            }
        });
        if deferred {
            let world = app.world_mut();
            let camera = world
                .query_filtered::<Entity, With<Camera3d>>()
                .single(world)
                .expect("a camera");
            world.entity_mut(camera).insert((
                bevy::core_pipeline::prepass::DepthPrepass,
                bevy::core_pipeline::prepass::DeferredPrepass,
            ));
        }
        floor(app.world_mut());
        block(app.world_mut(), Vec3::new(1.0, 0.5, 0.1), Vec3::splat(1.1));
        app.world_mut().spawn(under_sky(1.0));
        settled(&mut app)
    });
    for x in [-1.0, 0.0, 0.3] {
        let [forward, deferred] = [0, 1].map(|i| at(&pictures[i], x, 0.1).x);
        // The buffer of deferred materials has 8 bits a channel.
        assert!((forward - deferred).abs() < 0.01, "{forward} {deferred}");
        assert!(forward > 0.3);
    }
}

#[test]
fn surfaces_give_their_colour_and_transparent_ones_do_not_occlude() {
    let _gpu = gpu();
    let black = under_roof(StandardMaterial {
        base_color: Color::BLACK,
        ..default()
    });
    let red = under_roof(StandardMaterial {
        base_color: LinearRgba::rgb(1.0, 0.0, 0.0).into(),
        ..default()
    });
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
    let texture = |image: &mut dyn FnMut(u32) -> [u8; 4]| {
        let data = (0..64).flat_map(image).collect();
        let size = Extent3d {
            width: 8,
            height: 8,
            depth_or_array_layers: 1,
        };
        Image::new(
            size,
            TextureDimension::D2,
            data,
            TextureFormat::Rgba8UnormSrgb,
            default(),
        )
    };
    let _gpu = gpu();
    let shades = [
        // A checkerboard of black and white, and its mean in linear light.
        texture(&mut |i| {
            if (i + i / 8) % 2 == 0 {
                [255; 4]
            } else {
                [0, 0, 0, 255]
            }
        }),
        texture(&mut |_| [188, 188, 188, 255]),
    ]
    .map(|image| {
        let mut app = app();
        let world = app.world_mut();
        floor(world);
        let image = world.resource_mut::<Assets<Image>>().add(image);
        let material = world
            .resource_mut::<Assets<StandardMaterial>>()
            .add(StandardMaterial {
                base_color_texture: Some(image),
                ..default()
            });
        roof(world, material);
        world.spawn(under_sky(1.0));
        at(&settled(&mut app), 0.0, 0.0).x
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
    let _gpu = gpu();
    let red = LinearRgba::rgb(0.8, 0.1, 0.1);
    let wanted = under_roof(StandardMaterial {
        base_color: red.into(),
        ..default()
    });
    let mut app = app();
    let world = app.world_mut();
    floor(world);
    let material = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(StandardMaterial::default());
    let roof = roof(world, material);
    world.spawn(under_sky(1.0));
    let white = at(&settled(&mut app), 0.0, 0.0);
    app.world_mut().entity_mut(roof).insert(of_color(red));
    app.render_frames(3).expect("frames that see the change");
    let found = at(&settled(&mut app), 0.0, 0.0);
    assert!(
        found.distance(wanted) < 0.01 * wanted.length(),
        "{found} {wanted}"
    );
    assert!(
        found.distance(white) > 0.05 * white.length(),
        "{found} {white}"
    );
    app.world_mut()
        .entity_mut(roof)
        .remove::<MeshVoxelMaterial>();
    app.render_frames(3).expect("frames that see the change");
    let found = at(&settled(&mut app), 0.0, 0.0);
    assert!(
        found.distance(white) < 0.01 * white.length(),
        "{found} {white}"
    );
}

fn plain(color: LinearRgba) -> StandardMaterial {
    StandardMaterial {
        base_color: color.into(),
        ..default()
    }
}

/// Adds a material of another type.
fn filtered(world: &mut World, color: LinearRgba) -> MeshMaterial3d<EwaStandardMaterial> {
    let base = plain(color);
    let extension = EwaSettings::default().into();
    let mut materials = world.resource_mut::<Assets<EwaStandardMaterial>>();
    MeshMaterial3d(materials.add(EwaStandardMaterial { base, extension }))
}

#[test]
fn materials_that_nobody_knows_are_gray_or_what_their_mesh_says() {
    let _gpu = gpu();
    let red = LinearRgba::rgb(0.8, 0.1, 0.1);
    let [gray, wanted] = [LinearRgba::gray(0.5), red].map(|color| under_roof(plain(color)));
    let mut app = app_with(|app| {
        app.add_plugins(EwaPlugin::OPT_IN);
    });
    let world = app.world_mut();
    floor(world);
    let material = filtered(world, LinearRgba::WHITE);
    let roof = roof(world, default());
    let mut entity = world.entity_mut(roof);
    entity
        .remove::<MeshMaterial3d<StandardMaterial>>()
        .insert(material);
    world.spawn(under_sky(1.0));
    let mut looks_like = |own: Option<MeshVoxelMaterial>, wanted: Vec3| {
        let mut entity = app.world_mut().entity_mut(roof);
        match own {
            Some(own) => entity.insert(own),
            None => entity.remove::<MeshVoxelMaterial>(),
        };
        app.run_until_ready(200).expect("ready");
        app.render_frames(3).expect("frames that see the change");
        let found = at(&settled(&mut app), 0.0, 0.0);
        assert!(
            found.distance(wanted) < 0.01 * wanted.length(),
            "{own:?}: {found} {wanted}"
        );
    };
    let said = Some(of_color(red));
    for (own, wanted) in [(None, gray), (said, wanted), (None, gray), (said, wanted)] {
        looks_like(own, wanted);
    }
}

#[test]
fn a_mesh_that_changes_its_type_of_material_changes_its_colour() {
    let _gpu = gpu();
    let [red, green] = [
        LinearRgba::rgb(0.8, 0.1, 0.1),
        LinearRgba::rgb(0.1, 0.8, 0.1),
    ];
    let [under_red, under_green] = [red, green].map(|color| under_roof(plain(color)));
    let mut app = app_with(|app| {
        app.add_plugins((
            EwaPlugin::OPT_IN,
            VoxelMaterialPlugin::<EwaStandardMaterial>::default(),
        ));
    });
    let world = app.world_mut();
    floor(world);
    let filtered = filtered(world, green);
    let material = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(plain(red));
    let roof = roof(world, material.clone());
    world.spawn(under_sky(1.0));
    // Each change takes the old material away first, also where it comes back at once.
    for (is_filtered, wanted) in [
        (false, under_red),
        (true, under_green),
        (true, under_green),
        (false, under_red),
        (false, under_red),
        (true, under_green),
    ] {
        let mut entity = app.world_mut().entity_mut(roof);
        entity.remove::<(
            MeshMaterial3d<StandardMaterial>,
            MeshMaterial3d<EwaStandardMaterial>,
        )>();
        if is_filtered {
            entity.insert(filtered.clone());
        } else {
            entity.insert(MeshMaterial3d(material.clone()));
        }
        app.run_until_ready(200).expect("ready");
        app.render_frames(3).expect("frames that see the change");
        let found = at(&settled(&mut app), 0.0, 0.0);
        assert!(
            found.distance(wanted) < 0.01 * wanted.length(),
            "{is_filtered}: {found} {wanted}"
        );
    }
}

#[test]
fn emissive_surfaces_light_the_scene() {
    let _gpu = gpu();
    let mut app = app();
    let world = app.world_mut();
    floor(world);
    // A ceiling of 1 cd/m² over the whole volume, which the camera does not see. The exposure is 1.
    let material = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(StandardMaterial {
            base_color: Color::BLACK,
            emissive: LinearRgba::rgb(1.0, 2.0, 0.0),
            ..default()
        });
    let mesh = world
        .resource_mut::<Assets<Mesh>>()
        .add(Cuboid::new(3.9, 0.2, 3.9));
    world.spawn((
        Mesh3d(mesh),
        MeshMaterial3d(material.clone()),
        hidden(),
        Transform::from_xyz(0.0, 0.5, 0.0),
    ));
    world.spawn(small_volume());
    let found = at(&settled(&mut app), 0.0, 0.0);
    // Above the floor's middle nearly all directions meet it.
    assert!((0.85..=1.01).contains(&found.x), "{found}");
    assert!(
        (found.y / found.x - 2.0).abs() < 0.02 && found.z == 0.0,
        "{found}"
    );
    // Later edits arrive.
    let mut materials = app.world_mut().resource_mut::<Assets<StandardMaterial>>();
    materials.get_mut(&material).expect("it").emissive = LinearRgba::BLACK;
    app.render_frames(3).expect("a frame");
    settle(&mut app);
    assert!(at(&picture(&mut app), 0.0, 0.0).max_element() < 1e-3);
}

/// The light that a lit wall of albedo 1/2 reflects to the floor.
fn thrown_by(light: impl Bundle) -> f32 {
    let mut app = app();
    let world = app.world_mut();
    // The floor reflects nothing, and the light shines on the wall alone.
    block_of(
        world,
        0.5,
        Vec3::new(1.0, 1.0, 0.0),
        Vec3::new(0.4, 1.8, 3.6),
    );
    let plate = block(world, Vec3::new(-0.5, -0.05, 0.0), Vec3::new(2.4, 0.1, 3.6));
    let material = matt(world, 1.0);
    world.entity_mut(plate).insert(MeshMaterial3d(material));
    world.spawn(light);
    let volume = world.spawn(small_volume()).id();
    let with = at(&settled(&mut app), 0.2, 0.0);
    app.world_mut().despawn(volume);
    app.render_frames(3).expect("a frame");
    (with - at(&picture(&mut app), 0.2, 0.0)).x
}

#[test]
fn lights_of_all_kinds_light_the_wall_alike() {
    let _gpu = gpu();
    // Each gives the wall's middle, 1 m above the floor, 100 lux, from far away.
    let towards_wall = Transform::from_xyz(-9.2, 1.0, 0.0).looking_to(Vec3::X, Vec3::Y);
    let candela = 100.0 * 10.0 * 10.0;
    let sun = thrown_by((
        DirectionalLight {
            illuminance: 100.0,
            ..default()
        },
        towards_wall,
    ));
    let point = thrown_by((
        PointLight {
            intensity: candela * 4.0 * PI,
            range: 1e4,
            ..default()
        },
        towards_wall,
    ));
    let spot = thrown_by((
        SpotLight {
            intensity: candela * 4.0 * PI,
            range: 1e4,
            inner_angle: 0.3,
            outer_angle: 0.31,
            ..default()
        },
        towards_wall,
    ));
    assert!(sun > 1.0, "{sun}");
    assert!((point / sun - 1.0).abs() < 0.05, "{point} {sun}");
    assert!((spot / point - 1.0).abs() < 0.02, "{spot} {point}");
}

/// A flat box that two joints move, each by half.
pub fn skinned_cuboid() -> Mesh {
    let mut mesh = Mesh::from(Cuboid::new(1.5, 0.2, 1.5));
    let count = mesh.count_vertices();
    mesh.insert_attribute(
        Mesh::ATTRIBUTE_JOINT_INDEX,
        VertexAttributeValues::Uint16x4(vec![[0, 1, 0, 0]; count]),
    );
    mesh.insert_attribute(
        Mesh::ATTRIBUTE_JOINT_WEIGHT,
        vec![[0.5_f32, 0.5, 0.0, 0.0]; count],
    );
    mesh
}

#[test]
fn skinned_meshes_occlude_where_their_joints_put_them() {
    let _gpu = gpu();
    let mut app = app();
    let world = app.world_mut();
    floor(world);
    let mesh = world.resource_mut::<Assets<Mesh>>().add(skinned_cuboid());
    let material = matt(world, 0.0);
    let joints = [Vec3::new(-2.0, 0.7, 0.0), Vec3::new(0.0, 0.7, 0.0)]
        .map(|at| world.spawn(Transform::from_translation(at)).id());
    let inverse_bindposes = world
        .resource_mut::<Assets<SkinnedMeshInverseBindposes>>()
        .add(SkinnedMeshInverseBindposes::from(vec![Mat4::IDENTITY; 2]));
    world.spawn((
        Mesh3d(mesh),
        MeshMaterial3d(material),
        hidden(),
        NoFrustumCulling,
        SkinnedMesh {
            inverse_bindposes,
            joints: joints.to_vec(),
        },
    ));
    world.spawn(under_sky(1.0));
    let found = settled(&mut app);
    let (under, beside) = (at(&found, -1.0, 0.0).x, at(&found, 1.0, 0.0).x);
    assert!(under < 0.7 * beside, "{under} {beside}");
    // The other joint takes it along.
    let mut transform = app
        .world_mut()
        .get_mut::<Transform>(joints[0])
        .expect("a joint");
    transform.translation.x = 2.0;
    app.render_frames(3).expect("a frame");
    settle(&mut app);
    let found = picture(&mut app);
    let (left, under) = (at(&found, -1.0, 0.0).x, at(&found, 1.0, 0.0).x);
    assert!(under < 0.7 * left, "{under} {left}");
}
