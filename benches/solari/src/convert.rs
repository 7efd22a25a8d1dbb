//! Converts a scene of boxes to what `bevy_solari` draws.

use bevy::prelude::*;
use bevy_frugal_lab::boxes::BoxScene;
use bevy_solari::scene::RaytracingMesh3d;

/// Radius of the spheres that replace point lights, in metres.
const LIGHT_RADIUS: f32 = 0.02;

/// Gives the boxes of a scene their rays, its sky an environment map, and its point lights a size.
///
/// `bevy_solari` has directional lights, emissive meshes and one environment map. A point light becomes a
/// sphere that emits its intensity; no camera sees it, as it is only in what rays hit.
pub fn for_rays(world: &mut World, scene: &BoxScene, camera: Entity) {
    let mut boxes = world.query::<(Entity, &Mesh3d)>();
    let boxes: Vec<_> = boxes
        .iter(world)
        .map(|(entity, mesh)| (entity, mesh.0.clone()))
        .collect();
    let mut meshes = world.resource_mut::<Assets<Mesh>>();
    for (_, mesh) in &boxes {
        if let Some(mut mesh) = meshes.get_mut(mesh) {
            add_tangents(&mut mesh);
        }
    }
    for (entity, mesh) in boxes {
        world.entity_mut(entity).insert(RaytracingMesh3d(mesh));
    }
    for light in &scene.point_lights {
        spawn_sphere(world, light.position, light.intensity_cd);
    }
    // Rays find the shadows.
    let mut suns = world.query::<&mut DirectionalLight>();
    for mut sun in suns.iter_mut(world) {
        sun.shadow_maps_enabled = false;
    }
    let brightest = scene.sky_radiance.max_element();
    if brightest > 0.0 {
        let color = LinearRgba::from_vec3(scene.sky_radiance / brightest);
        let mut images = world.resource_mut::<Assets<Image>>();
        let sky = EnvironmentMapLight {
            intensity: brightest,
            ..EnvironmentMapLight::solid_color(&mut images, color)
        };
        world.entity_mut(camera).insert(sky);
    }
}

/// The vertex format of rays has tangents; what they are matters to normal maps alone.
fn add_tangents(mesh: &mut Mesh) {
    let tangents = vec![[1.0, 0.0, 0.0, 1.0]; mesh.count_vertices()];
    mesh.insert_attribute(Mesh::ATTRIBUTE_TANGENT, tangents);
}

fn spawn_sphere(world: &mut World, position: Vec3, intensity_cd: Vec3) {
    let sphere = Sphere::new(LIGHT_RADIUS).mesh();
    let mut mesh = sphere.ico(2).expect("a few triangles");
    let triangles = mesh.triangles().expect("a list of triangles");
    let area: f32 = triangles.map(|triangle| area(triangle.vertices)).sum();
    add_tangents(&mut mesh);
    // A convex body shows a quarter of its surface on average.
    let radiance = 4.0 / area * intensity_cd;
    let material = StandardMaterial {
        base_color: Color::BLACK,
        emissive: LinearRgba::from_vec3(radiance),
        reflectance: 0.0,
        perceptual_roughness: 1.0,
        ..default()
    };
    let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
    let material = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(material);
    world.spawn((
        RaytracingMesh3d(mesh),
        MeshMaterial3d(material),
        Transform::from_translation(position),
    ));
}

fn area([a, b, c]: [Vec3; 3]) -> f32 {
    0.5 * (b - a).cross(c - a).length()
}
