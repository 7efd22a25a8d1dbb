//! The shaders against the crate's reference in plain Rust.

use std::f32::consts::PI;

use bevy::prelude::*;
use bevy_frugal_lab::boxes::{BoxScene, SceneBox, TracedScene, cornell_box, visible_walls};
use bevy_voxel_gi::{
    Bounces, Solver, VoxelGiSettings, VoxelGiState, VoxelLight,
    reference::{
        IrradianceField, Light, Material, Propagation, PropagationSettings, RayTracing,
        RayTracingSettings, SETTLE, Triangle, Voxels, ambient_occlusion, dividers::dividers,
    },
};

use super::fixture::*;

/// Light is stored as 16-bit floats times this.
const STORAGE_SCALE: f32 = 1.0 / 64.0;

fn triangles_and_materials(scene: &BoxScene) -> (Vec<Triangle>, Vec<Material>) {
    let mesh = Mesh::from(Cuboid::from_size(Vec3::splat(2.0)));
    let triangles_of = |(material, part): (u32, &SceneBox)| {
        let place = Transform::from_translation(part.center)
            .with_rotation(part.rotation())
            .with_scale(part.half);
        triangles(&mesh, place.compute_affine(), material)
    };
    let triangles = (0..).zip(&scene.boxes).flat_map(triangles_of);
    let materials = scene.boxes.iter().map(|part| Material {
        albedo: part.albedo,
        emission: Vec3::ZERO,
    });
    (triangles.collect(), materials.collect())
}

fn lights(scene: &BoxScene) -> Vec<Light> {
    let suns = scene
        .directional_lights
        .iter()
        .map(|sun| Light::Directional {
            direction: sun.direction.normalize(),
            illuminance: sun.illuminance_lux,
        });
    let points = scene.point_lights.iter().map(|light| Light::Point {
        position: light.position,
        intensity: light.intensity_cd,
        cone: None,
        near: 0.0,
    });
    suns.chain(points).collect()
}

/// Frames after which light is compared: while the first rays are traced, and settled.
const EARLY: u32 = 15;

/// The fields of the reference, early and settled, and what divides its voxels.
fn expected(scene: &BoxScene, settings: &VoxelGiSettings) -> ([IrradianceField; 2], Vec<Vec3>) {
    let resolution = settings.resolution;
    let grid = grid(scene, resolution);
    let (triangles, materials) = triangles_and_materials(scene);
    let voxels = Voxels::new(grid, &triangles);
    let sky = scene.sky_radiance;
    let lights = lights(scene);
    let traced = |rays| {
        let settings = RayTracingSettings { rays, ..default() };
        RayTracing::new(&voxels, &materials, &lights, sky, settings)
    };
    let mut ray_tracing = match settings.light {
        VoxelLight::GlobalIllumination {
            solver: Solver::Propagate { iterations },
            ..
        } => {
            let settings = PropagationSettings {
                steps: iterations,
                ..default()
            };
            let direct = traced(0);
            let mut light = Propagation::new(&direct, &voxels, &materials, sky, settings);
            light.run();
            return ([light.field(), light.field()], dividers(&voxels));
        }
        VoxelLight::GlobalIllumination {
            solver: Solver::Trace { rays },
            ..
        } => traced(rays),
        VoxelLight::AmbientOcclusion { radius, rays } => {
            let settings = RayTracingSettings { rays, ..default() };
            ambient_occlusion(&voxels, sky, radius / grid.voxel_size, settings)
        }
    };
    let fields = [EARLY, SETTLE - EARLY].map(|frames| {
        for _ in 0..frames {
            ray_tracing.step();
        }
        ray_tracing.field()
    });
    (fields, dividers(&voxels))
}

fn compare(name: &str, light: VoxelLight, most_error: f32, change: impl FnOnce(&mut BoxScene)) {
    let mut scene = TracedScene::read(name).expect("a scene").scene;
    change(&mut scene);
    // As voxels store it: light of many bounces multiplies what differs.
    let steps = Vec3::new(2047.0, 2047.0, 1023.0);
    for part in &mut scene.boxes {
        part.albedo = (part.albedo * steps).round() / steps;
    }
    let settings = VoxelGiSettings {
        resolution: 16,
        light,
        ..default()
    };
    let (expected, dividers) = expected(&scene, &settings);
    let mut app = box_app(&scene);
    let volume = volume(&mut app, &scene, settings);
    app.world_mut().spawn(volume);
    let mut count = 0;
    // The report is that of the frame before.
    while count + 1 < EARLY {
        frames(&mut app, 1);
        count += u32::from(report(&app).state != VoxelGiState::Absent);
    }
    compare_dividers(name, &read_dividers(&mut app), &dividers);
    // Rare bright rays count as changes at first.
    for (expected, most_error) in expected.iter().zip([2.0 * most_error, most_error]) {
        compare_texels(name, &read_texels(&mut app), expected, most_error);
        settle(&mut app);
    }
}

fn compare_dividers(name: &str, found: &[Vec3], expected: &[Vec3]) {
    let pairs = || found.iter().zip(expected).enumerate();
    let wrong: Vec<_> = pairs()
        .filter(|(_, (found, expected))| !found.abs_diff_eq(**expected, 0.004))
        .collect();
    let dividers = pairs().filter(|(_, (_, expected))| expected.max_element() > -0.5);
    println!("{name}: {} voxels are divided", dividers.count());
    for (index, (found, expected)) in &wrong {
        println!("voxel {:?}: {found} for {expected}", expected_voxel(*index));
    }
    assert!(wrong.is_empty(), "{name}: {} are wrong", wrong.len());
}

fn compare_texels(name: &str, found: &[[Vec4; 6]], expected: &IrradianceField, most_error: f32) {
    let (mut weights_differ, mut surfaces) = (0, 0);
    let (mut absolute, mut difference, mut total) = (0.0, 0.0, 0.0);
    for (index, (found, expected)) in found.iter().zip(&expected.texels).enumerate() {
        for face in 0..6 {
            let (f, e) = (found[face], expected[face]);
            if e.w > 0.5 || f.w > 0.5 {
                surfaces += 1;
                if (e.w - f.w).abs() > 0.1 {
                    weights_differ += 1;
                    if weights_differ < 12 {
                        println!("voxel {:?} face {face}: {f} for {e}", expected_voxel(index));
                    }
                }
            }
            if e.w < 0.5 {
                continue;
            }
            let e = e.truncate() / PI;
            let f = f.truncate() / STORAGE_SCALE;
            absolute += (f - e).abs().element_sum();
            difference += (f - e).element_sum();
            total += e.element_sum();
        }
    }
    println!(
        "{name}: {weights_differ} of {surfaces} weights differ; error {:.4}, bias {:.4}",
        absolute / total,
        difference / total
    );
    assert!(
        weights_differ * 100 < surfaces,
        "{weights_differ} of {surfaces}"
    );
    assert!(absolute / total < most_error);
}

fn expected_voxel(index: usize) -> UVec3 {
    let i = u32::try_from(index).unwrap_or(0);
    UVec3::new(i % 16, i / 16 % 16, i / 256)
}

/// Thin walls along x and z on a floor, with the light on one side of both.
fn thin_walls() -> BoxScene {
    let part = |center, half| scene_box(center, half, Vec3::new(0.7, 0.6, 0.5));
    let mut scene = cornell_box();
    scene.boxes = vec![
        part([0.0, -0.2, 0.0], [3.0, 0.2, 3.0]),
        part([0.1, 0.8, 0.0], [0.04, 0.8, 3.0]),
        part([0.0, 0.8, -0.9], [3.0, 0.8, 0.05]),
    ];
    scene.point_lights.truncate(1);
    scene.point_lights[0].position = Vec3::new(1.2, 1.1, 0.9);
    let (eye, target) = (Vec3::new(1.5, 7.0, 2.5), Vec3::new(0.0, 0.2, 0.0));
    look(&mut scene, eye, target, 128);
    scene
}

/// From what the volume stores, pixels beside thin walls get what `divided_irradiance` computes of it.
#[test]
fn pixels_read_what_the_reference_does() {
    const RESOLUTION: u32 = 16;
    let scene = thin_walls();
    let settings = VoxelGiSettings {
        resolution: RESOLUTION,
        ..default()
    };
    let mut app = box_app(&scene);
    let volume = volume(&mut app, &scene, settings);
    let found = {
        let without = picture(&mut app);
        app.world_mut().spawn(volume);
        settle(&mut app);
        difference(&picture(&mut app), &without)
    };
    let field = read_field(&mut app, &scene, RESOLUTION);
    let dividers = read_dividers(&mut app);
    let (mut divided, mut plain, mut total) = (0.0, 0.0, 0.0);
    for (wall, found) in visible_walls(&scene).iter().zip(&found) {
        let Some(wall) = wall else {
            continue;
        };
        let radiance = |irradiance: Vec3| wall.albedo * irradiance / STORAGE_SCALE;
        let (at, normal) = (wall.position, wall.normal);
        let to_viewer = (scene.camera.eye - at).normalize();
        let expected = radiance(field.divided_irradiance(&dividers, at, normal, to_viewer));
        divided += (found - expected).abs().element_sum();
        let undivided = radiance(field.irradiance(at, normal, 0.0));
        plain += (found - undivided).abs().element_sum();
        total += expected.element_sum();
    }
    println!(
        "pixels differ by {:.2}%, and by {:.2}% from what does not know of dividers",
        100.0 * divided / total,
        100.0 * plain / total
    );
    // Edges of walls are in other pixels.
    assert!(divided < 0.0015 * total, "{divided} of {total}");
    assert!(plain > 10.0 * divided, "{plain} {divided}");
}

#[test]
fn cornell_box_as_in_the_reference() {
    compare("cornell_point", VoxelLight::default(), 0.001, |_| ());
}

#[test]
fn colonnade_as_in_the_reference() {
    compare("colonnade", VoxelLight::default(), 0.0006, |_| ());
}

#[test]
fn room_as_in_the_reference() {
    compare("sunlit_room", VoxelLight::default(), 0.0012, |_| ());
}

/// Where few rays see the sky, and those bring much, most frames have too little light and are no
/// change for that.
#[test]
fn noise_is_no_change() {
    compare("colonnade", VoxelLight::default(), 0.002, |scene| {
        scene.directional_lights.clear();
        for part in &mut scene.boxes {
            part.albedo = Vec3::ZERO;
        }
    });
}

/// Where light goes from wall to wall many times small errors add up.
#[test]
fn bright_walls_are_as_in_the_reference() {
    compare("cornell_point", VoxelLight::default(), 0.0006, |scene| {
        for part in &mut scene.boxes {
            part.albedo = Vec3::splat(0.9);
        }
    });
}

#[test]
fn occlusion_is_as_in_the_reference() {
    let occlusion = occlusion(0.7, 16);
    for name in ["cornell_point", "sunlit_room"] {
        compare(name, occlusion, 0.0003, |scene| {
            scene.sky_radiance = Vec3::ONE;
        });
    }
}

#[test]
fn propagated_light_is_as_in_the_reference() {
    for name in ["cornell_point", "colonnade"] {
        let propagated =
            global_illumination(Solver::Propagate { iterations: 48 }, Bounces::Endless);
        compare(name, propagated, 0.0006, |_| ());
    }
}
