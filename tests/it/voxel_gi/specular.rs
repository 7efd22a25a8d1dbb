//! Specular light of rough surfaces, against path tracing.

use std::f32::consts::PI;

use bevy::prelude::*;
use bevy_frugal_lab::{
    boxes::{
        BoxGloss, BoxScene, SceneBox, TracedScene, agreement, block_means, cornell_box, trace,
        visible_walls,
    },
    headless::HeadlessSettings,
    path_tracer::TraceSettings,
};
use bevy_voxel_gi::{Receiver, VoxelGiPlugin, VoxelGiSettings};

use super::fixture::*;
use crate::support::{compose::mesh_numbers, composer, gpu};

/// No metal, of Bevy's default reflectance.
fn gloss(roughness: f32) -> BoxGloss {
    BoxGloss {
        roughness,
        reflectance: 0.5,
        is_metal: false,
    }
}

/// A traced scene, all of whose boxes have this gloss.
fn glossy(name: &str, roughness: f32) -> BoxScene {
    let mut scene = TracedScene::read(name).expect("a scene").scene;
    (scene.camera.width, scene.camera.height) = (64, 64);
    for part in &mut scene.boxes {
        part.gloss = Some(gloss(roughness));
    }
    scene
}

/// Gives the camera an even environment map of this radiance, or none.
fn set_map(app: &mut HeadlessApp, radiance: Vec3) {
    let world = app.world_mut();
    let most = radiance.max_element();
    if most == 0.0 {
        camera(world).remove::<EnvironmentMapLight>();
    } else {
        let color = LinearRgba::from_vec3(radiance / most);
        let mut images = world.resource_mut::<Assets<Image>>();
        let map = EnvironmentMapLight::solid_color(&mut images, color).with_intensity(most);
        camera(world).insert(map);
    }
    ready(app);
}

/// Specular light in Bevy, where a volume gives the diffuse one.
struct Specular {
    /// The share that surfaces reflect of an even light.
    share: Vec<Vec3>,
    /// Specular light of the volume.
    found: Vec<Vec3>,
    app: Borrowed,
}

fn specular(scene: &BoxScene, resolution: u32, receiver: Receiver) -> Specular {
    let mut app = box_app(scene);
    let chosen = VoxelGiSettings {
        resolution,
        receiver,
        ..default()
    };
    let volume = volume(&mut app, scene, chosen);
    app.world_mut().spawn(volume);
    let diffuse = settled(&mut app);
    let memory = report(&app).memory;
    set_map(&mut app, Vec3::ONE);
    let share = difference(&picture(&mut app), &diffuse);
    set_map(&mut app, scene.sky_radiance);
    settings(app.world_mut()).specular_light = true;
    let found = difference(&settled(&mut app), &diffuse);
    let after = report(&app).memory;
    assert_eq!(after, memory, "specular light takes no memory");
    Specular { share, found, app }
}

/// The specular light is at most half as wrong as that of an environment map, or as none.
fn assert_halved(name: &str, sky: Option<Vec3>) {
    let mut scene = glossy(name, 0.5);
    scene.sky_radiance = sky.unwrap_or(scene.sky_radiance);
    let settings = TraceSettings {
        samples: 1024,
        ..default()
    };
    let width = scene.camera.width;
    let truth = block_means(&trace(&scene, &settings).specular, width);
    let Specular { share, found, .. } = specular(&scene, 32, Receiver::Interpolated);
    let of_map: Vec<_> = share.iter().map(|s| s * scene.sky_radiance).collect();
    let [off, on] = [&of_map, &found].map(|light| agreement(light, width, &truth));
    println!(
        "{name}, sky {}: without {:.1}% / {:+.1}%, with {:.1}% / {:+.1}%",
        scene.sky_radiance,
        100.0 * off.relative_error,
        100.0 * off.bias,
        100.0 * on.relative_error,
        100.0 * on.bias
    );
    assert!(
        on.relative_error < 0.5 * off.relative_error,
        "{name}: {on:?} {off:?}"
    );
}

#[test]
#[ignore = "long: path tracing"]
fn in_a_room_without_a_sky() {
    assert_halved("cornell_point", None);
}

#[test]
#[ignore = "long: path tracing"]
fn in_a_room_with_a_window_to_the_sky() {
    assert_halved("sunlit_room", Some(Vec3::new(10.0, 12.0, 15.0)));
}

#[test]
#[ignore = "long: a picture of many paths"]
fn in_a_colonnade_under_the_sky() {
    assert_halved("colonnade", None);
}

#[test]
fn the_shader_computes_what_the_reference_does() {
    const RESOLUTION: u32 = 16;
    let roughness = 0.45;
    let scene = glossy("cornell_point", roughness);
    let Specular {
        share,
        found,
        mut app,
    } = specular(&scene, RESOLUTION, Receiver::Interpolated);
    let field = read_field(&mut app, &scene, RESOLUTION);
    let dividers = read_dividers(&mut app);
    // Texels are irradiance over pi times this.
    let scale = PI * 64.0;
    let (mut error, mut total) = (0.0, 0.0);
    for (wall, (found, share)) in visible_walls(&scene).iter().zip(found.iter().zip(&share)) {
        let Some(wall) = wall else {
            continue;
        };
        let to_viewer = (scene.camera.eye - wall.position).normalize();
        let radiance =
            field.specular_radiance(&dividers, wall.position, wall.normal, to_viewer, roughness);
        let expected = radiance * scale;
        let found = found / share.max(Vec3::splat(1e-6));
        error += (found - expected).abs().element_sum();
        total += expected.element_sum();
    }
    println!("the shader differs by {:.2}%", 100.0 * error / total);
    // Edges of walls are in other pixels.
    assert!(error < 0.02 * total, "{error} of {total}");
}

/// A closed room of metal, whose walls are more than two voxels thick.
fn sealed_room() -> BoxScene {
    let mut scene = cornell_box();
    let metal = BoxGloss {
        is_metal: true,
        ..gloss(0.5)
    };
    let sides = [-1.0, 1.0].map(|sign| [0, 1, 2].map(|axis| (axis, sign)));
    let wall = |(axis, sign): (usize, f32)| {
        let (mut center, mut half) = (Vec3::ZERO, Vec3::splat(1.5));
        center[axis] = 1.25 * sign;
        half[axis] = 0.25;
        SceneBox {
            gloss: Some(metal),
            ..scene_box(center.into(), half.into(), Vec3::ONE)
        }
    };
    scene.boxes = sides.concat().into_iter().map(wall).collect();
    scene.point_lights.clear();
    scene.sky_radiance = Vec3::splat(10.0);
    let (eye, target) = (Vec3::new(-0.8, 0.3, 0.8), Vec3::new(0.6, -0.6, -0.6));
    look(&mut scene, eye, target, 64);
    scene
}

#[test]
fn a_sealed_room_is_dark_under_a_bright_environment_map() {
    let scene = sealed_room();
    let Specular { share, found, .. } = specular(&scene, 16, Receiver::PerPixel);
    let map = scene.sky_radiance.x;
    let mean = |light: &[Vec3]| light.iter().map(|l| l.x).sum::<f32>() / light.len() as f32;
    let (without, with) = (map * mean(&share), mean(&found));
    let most = found.iter().map(|light| light.x).fold(0.0, f32::max);
    println!("metal in a sealed room: {without} without, {with} and at most {most} with");
    assert!(without > 0.6 * map, "{without}");
    // Of what is behind a wall, a sixteenth passes where the first plane is in it.
    assert!(
        with.abs() < 1e-3 * without && most < 0.1 * without,
        "{with} {most}"
    );
}

#[test]
fn all_of_bevys_lighting_composes() {
    const LIGHTING: &str = "
        import bevy_pbr::render::{pbr_functions::apply_pbr_lighting, pbr_types::pbr_input_new};
        @fragment
        fn fragment() -> @location(0) vec4<f32> {
            return apply_pbr_lighting(pbr_input_new());
        }";
    const OPTIONAL: [&str; 5] = [
        "ENVIRONMENT_MAP",
        "SCREEN_SPACE_REFLECTIONS",
        "STANDARD_MATERIAL_CLEARCOAT",
        "STANDARD_MATERIAL_ANISOTROPY",
        "MULTIPLE_LIGHT_PROBES_IN_ARRAY",
    ];
    let _gpu = gpu();
    let mut app = HeadlessApp::new(HeadlessSettings::with_size(1, 1), |app| {
        app.add_plugins(VoxelGiPlugin);
    })
    .expect("an app");
    let mut composer = composer(&mut app);
    for chosen in 0..1 << OPTIONAL.len() {
        let mut defs = mesh_numbers();
        let always = [
            "AVAILABLE_STORAGE_BUFFER_BINDINGS__GE_3",
            "AVAILABLE_STORAGE_BUFFER_BINDINGS__GE_6",
            "IRRADIANCE_VOLUME",
            "IRRADIANCE_VOLUMES_ARE_USABLE",
        ];
        let optional = (0..OPTIONAL.len()).filter(|i| chosen >> i & 1 == 1);
        let names: Vec<_> = optional.map(|i| OPTIONAL[i]).chain(always).collect();
        defs.extend(names.iter().map(|&name| name.into()));
        let valid = composer.compose_source(LIGHTING, &defs);
        assert!(valid.is_ok(), "{names:?}: {}", valid.unwrap_err());
    }
}
