use std::f32::consts::PI;

use bevy::math::{Vec2, Vec3};
use bevy_frugal_lab::{
    boxes::*,
    path_tracer::{Receiver, TraceSettings, View},
    stage::{SceneDirectionalLight, ScenePointLight},
};
use proptest::prelude::*;

/// A floor, and a block on it that is turned.
fn block_on_floor(albedo: f32) -> BoxScene {
    let mut scene = cornell_box();
    scene.point_lights.clear();
    scene.camera.width = 32;
    scene.camera.height = 32;
    scene.boxes = [
        (Vec3::new(0.0, -0.5, 0.0), Vec3::new(50.0, 0.5, 50.0), 0.0),
        (Vec3::new(0.2, 0.5, 0.0), Vec3::splat(0.5), 25.0),
        (Vec3::new(-0.9, 0.5, -0.4), Vec3::new(0.2, 0.5, 0.2), 0.0),
    ]
    .map(|(center, half, rotate_y_deg)| SceneBox {
        center,
        half,
        albedo: Vec3::splat(albedo),
        rotate_y_deg,
        gloss: None,
    })
    .into();
    scene
}

fn mean(picture: &[Vec3]) -> Vec3 {
    picture.iter().sum::<Vec3>() / picture.len() as f32
}

#[test]
fn white_surfaces_under_an_even_sky_cannot_be_seen() {
    let mut scene = block_on_floor(1.0);
    scene.sky_radiance = Vec3::new(1.0, 2.0, 3.0);
    let settings = TraceSettings {
        depth: 200,
        ..TraceSettings::default()
    };
    let picture = trace(&scene, &settings);
    for pixel in &picture.total {
        assert!(
            (*pixel / scene.sky_radiance - 1.0).abs().max_element() < 0.1,
            "{pixel}"
        );
    }
    let mean = mean(&picture.total) / scene.sky_radiance;
    assert!((mean - 1.0).abs().max_element() < 2e-3, "{mean}");
}

#[test]
fn a_block_alone_under_an_even_sky_shows_albedo_times_sky() {
    let mut scene = block_on_floor(0.4);
    scene.boxes.remove(0);
    scene.boxes.truncate(1);
    scene.sky_radiance = Vec3::splat(5.0);
    let picture = trace(
        &scene,
        &TraceSettings {
            samples: 4,
            ..TraceSettings::default()
        },
    );
    let seen: Vec<_> = picture.indirect.iter().filter(|p| p.x > 0.0).collect();
    assert!(seen.len() > 20, "{} pixels of the block", seen.len());
    // Pixels at its edge see the sky too, which is not in `indirect`.
    let inner = seen.iter().filter(|p| (p.x - 2.0).abs() < 1e-4).count();
    assert!(inner * 2 > seen.len(), "{inner} of {}", seen.len());
    assert!(picture.direct.iter().all(|p| *p == Vec3::ZERO));
}

#[test]
fn lights_light_and_shade_as_the_law_has_it() {
    let mut scene = block_on_floor(0.5);
    // Straight from above onto the floor, but for what is below the blocks.
    scene.camera.eye = Vec3::new(0.0, 8.0, 0.0);
    scene.camera.target = Vec3::ZERO;
    scene.camera.up = Vec3::NEG_Z;
    scene.directional_lights = vec![SceneDirectionalLight {
        direction: Vec3::new(0.0, -3.0, 0.0),
        illuminance_lux: Vec3::splat(7.0),
    }];
    let settings = TraceSettings {
        samples: 1,
        ..TraceSettings::default()
    };
    let sun = trace(&scene, &settings);
    let expected = 0.5 * 7.0 / PI;
    // It grazes the sides of the blocks.
    let is_lit = |p: &Vec3| (p.x - expected).abs() < 1e-4;
    assert!(sun.direct.iter().all(|p| is_lit(p) || p.x < 1e-4));
    let lit = sun.direct.iter().filter(|p| is_lit(p)).count();
    assert!(
        lit * 10 > sun.direct.len() * 8,
        "{lit} of {}",
        sun.direct.len()
    );
    assert!(mean(&sun.indirect).x > 0.0);

    scene.directional_lights.clear();
    scene.boxes.truncate(1);
    scene.point_lights = vec![ScenePointLight {
        position: Vec3::new(0.0, 2.0, 0.0),
        intensity_cd: Vec3::splat(20.0),
    }];
    let lit = trace(&scene, &settings);
    let brightest = lit.direct.iter().map(|p| p.x).fold(0.0, f32::max);
    let expected = 0.5 / PI * 20.0 / 4.0;
    assert!(
        (brightest / expected - 1.0).abs() < 0.02,
        "{brightest} for {expected}"
    );
    // A floor alone receives nothing from itself.
    assert_eq!(mean(&lit.indirect), Vec3::ZERO);

    // Behind a roof it is dark, if that is larger than the floor.
    scene.boxes.push(SceneBox {
        center: Vec3::new(0.0, 1.0, 0.0),
        half: Vec3::new(60.0, 0.1, 60.0),
        albedo: Vec3::ONE,
        rotate_y_deg: 0.0,
        gloss: None,
    });
    scene.camera.eye = Vec3::new(0.0, 0.6, 2.0);
    let dark = trace(&scene, &settings);
    assert!(dark.total.iter().all(|p| *p == Vec3::ZERO));
}

#[test]
#[ignore = "long: many paths"]
fn receivers_have_the_light_of_another_path_tracer() {
    // Noise sets the bounds, and pixels at edges show two walls there.
    let most_errors = [0.05, 0.03, 0.06];
    for (name, most) in TracedScene::NAMES.into_iter().zip(most_errors) {
        let truth = TracedScene::read(name).expect("a scene");
        let walls = visible_walls(&truth.scene);
        let settings = TraceSettings {
            samples: 256,
            ..TraceSettings::default()
        };
        let light = trace_receivers(&truth.scene, &settings, walls.len() as u32, |index, _| {
            let wall = walls[index as usize]?;
            Some(Receiver {
                position: wall.position,
                normal: wall.normal,
            })
        });
        let radiance = |(wall, light): (&Option<WallPoint>, &Option<Vec3>)| {
            wall.zip(*light)
                .map_or(Vec3::ZERO, |(wall, light)| wall.albedo * light)
        };
        let picture: Vec<_> = walls.iter().zip(&light).map(radiance).collect();
        let found = agreement(&picture, truth.scene.camera.width, &truth.indirect);
        println!("{name}: {found:?}");
        assert!(found.relative_error < most, "{name}: {found:?}");
        assert!(found.bias.abs() < 0.02, "{name}: {found:?}");
    }
}

#[test]
fn receivers_of_an_even_sky_have_its_radiance() {
    let mut scene = block_on_floor(0.0);
    scene.sky_radiance = Vec3::new(1.0, 2.0, 3.0);
    let light = trace_receivers(&scene, &TraceSettings::default(), 3, |index, at| {
        let inside = index == 1 || index == 2 && at.x < 0.5;
        (!inside).then_some(Receiver {
            position: Vec3::new(0.0, 3.0, 0.0),
            normal: Vec3::Y,
        })
    });
    assert_eq!(light[1], None);
    for light in [light[0], light[2]] {
        let light = light.expect("a lit receiver") / scene.sky_radiance;
        assert!((light - 1.0).abs().max_element() < 1e-4, "{light}");
    }
}

#[test]
fn receivers_in_boxes_and_under_them_have_no_light() {
    let mut scene = block_on_floor(0.5);
    scene.sky_radiance = Vec3::ONE;
    let block = scene.boxes[1];
    let bottom = Vec3::new(block.center.x, 0.0, block.center.z);
    // The block is rotated about Y, and 1 m wide.
    let points = [(0.49, false), (0.51, true)].map(|(distance, lit)| {
        let side = block.rotation() * Vec3::X;
        [block.center + distance * side, bottom + distance * side].map(|point| (point, lit))
    });
    let points: Vec<_> = points.concat();
    let settings = TraceSettings {
        samples: 16,
        ..TraceSettings::default()
    };
    let light = trace_receivers(&scene, &settings, points.len() as u32, |index, _| {
        Some(Receiver {
            position: points[index as usize].0,
            normal: Vec3::Y,
        })
    });
    for ((point, lit), light) in points.into_iter().zip(light) {
        assert_eq!(light.is_some(), lit, "{point}");
    }
}

#[test]
fn the_same_picture_twice_and_another_with_another_seed() {
    let mut scene = cornell_box();
    (scene.camera.width, scene.camera.height) = (16, 16);
    let settings = TraceSettings {
        samples: 2,
        ..TraceSettings::default()
    };
    let first = trace(&scene, &settings);
    assert!(first == trace(&scene, &settings));
    assert!(
        first
            != trace(
                &scene,
                &TraceSettings {
                    seed: 1,
                    ..settings
                }
            )
    );
}

#[test]
fn it_agrees_with_another_path_tracer() {
    // Noise sets the bounds: light comes by few paths into the room.
    let most_errors = [[0.002, 0.045], [0.002, 0.02], [0.009, 0.065]];
    for (name, [direct, indirect]) in TracedScene::NAMES.into_iter().zip(most_errors) {
        let truth = TracedScene::read(name).expect("a scene");
        let picture = trace(
            &truth.scene,
            &TraceSettings {
                samples: 128,
                ..TraceSettings::default()
            },
        );
        for (part, ours, theirs, error) in [
            ("direct", &picture.direct, &truth.direct, direct),
            ("indirect", &picture.indirect, &truth.indirect, indirect),
        ] {
            let found = agreement(ours, picture.width, theirs);
            println!("{name} {part}: {found:?}");
            assert!(found.relative_error < error, "{name} {part}: {found:?}");
            assert!(found.bias.abs() < 0.01, "{name} {part}: {found:?}");
        }
    }
}

/// A glossy floor alone: [`block_on_floor`] without blocks, under an even sky of radiance 1.
fn glossy_floor(albedo: f32, gloss: BoxGloss) -> BoxScene {
    let mut scene = block_on_floor(albedo);
    scene.boxes.truncate(1);
    scene.boxes[0].gloss = Some(gloss);
    scene.sky_radiance = Vec3::ONE;
    scene.camera.eye = Vec3::new(0.0, 8.0, 0.0);
    scene.camera.target = Vec3::ZERO;
    scene.camera.up = Vec3::NEG_Z;
    scene
}

#[test]
fn gloss_reflects_an_even_sky_on_top_of_diffuse_light() {
    // Seen along the normal, where reflectance is that of F0 less what microfacets shadow.
    let gloss = BoxGloss {
        roughness: 0.3,
        reflectance: 1.0,
        is_metal: false,
    };
    let picture = trace(&glossy_floor(0.5, gloss), &TraceSettings::default());
    let (light, specular) = (mean(&picture.indirect).x, mean(&picture.specular).x);
    assert!((specular / 0.16 - 1.0).abs() < 0.03, "{specular}");
    assert!((light - 0.5 - specular).abs() < 5e-3, "{light}");
    let metal = BoxGloss {
        is_metal: true,
        ..gloss
    };
    let picture = trace(&glossy_floor(0.5, metal), &TraceSettings::default());
    assert_eq!(picture.indirect, picture.specular);
    let specular = mean(&picture.specular).x;
    assert!((specular / 0.5 - 1.0).abs() < 0.02, "{specular}");
}

#[test]
fn a_smooth_floor_mirrors_what_stands_on_it() {
    // A white metal before a black wall, above which there is the sky.
    let gloss = BoxGloss {
        roughness: 0.0,
        reflectance: 0.5,
        is_metal: true,
    };
    let mut scene = glossy_floor(1.0, gloss);
    scene.boxes.push(SceneBox {
        center: Vec3::new(0.0, 5.0, -10.1),
        half: Vec3::new(40.0, 5.0, 0.1),
        albedo: Vec3::ZERO,
        rotate_y_deg: 0.0,
        gloss: None,
    });
    scene.camera.eye = Vec3::new(0.0, 8.0, 0.0);
    scene.camera.target = Vec3::new(0.0, 0.0, -4.0);
    scene.camera.up = Vec3::Y;
    let picture = trace(&scene, &TraceSettings::default());
    let view = View::new(&scene.camera);
    let mut checked = 0;
    for (index, specular) in picture.specular.iter().enumerate() {
        let pixel = Vec2::new((index % 32) as f32, (index / 32) as f32) + 0.5;
        let ray = view.ray(pixel);
        let on_floor = ray.origin - ray.direction * (ray.origin.y / ray.direction.y);
        if on_floor.z < -9.0 {
            continue;
        }
        let height = (on_floor.z + 10.0) / -ray.direction.z * -ray.direction.y;
        if (height - 10.0).abs() < 1.0 || ray.direction.z >= 0.0 {
            continue;
        }
        let expected = if height < 10.0 { 0.0 } else { 1.0 };
        assert!((specular.x - expected).abs() < 0.1, "{on_floor} {specular}");
        checked += 1;
    }
    assert!(checked > 300, "{checked}");
}

proptest! {
    #[test]
    fn arrays_come_back_and_damaged_ones_never_panic(
        floats in prop::collection::vec(any::<f32>(), 0..30),
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..4),
        cut in any::<prop::sample::Index>(),
    ) {
        let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 1, 3), }\n";
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.bytes());
        bytes.extend(floats.iter().flat_map(|f| f.to_le_bytes()));
        let back = parse_npy(&bytes).expect("a good file");
        let back: Vec<u32> = back.iter().flat_map(|v| v.to_array()).map(f32::to_bits).collect();
        let expected: Vec<u32> = floats.iter().map(|f| f.to_bits()).collect();
        prop_assert_eq!(&back, &expected[..floats.len() / 3 * 3]);
        for (at, value) in damage {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        let _ = parse_npy(&bytes[..cut.index(bytes.len() + 1)]);
    }
}

#[test]
fn a_tenth_too_bright() {
    let truth: Vec<Vec3> = (0..64).map(|i| Vec3::splat(1.0 + i as f32)).collect();
    let picture: Vec<Vec3> = truth.iter().map(|t| t * 1.1).collect();
    let found = agreement(&picture, 8, &block_means(&truth, 8));
    assert!((found.relative_error - 0.1).abs() < 1e-6);
    assert!((found.bias - 0.1).abs() < 1e-6);
    assert!((found.percentile_95 - 0.1).abs() < 1e-6);
    assert_eq!(found.black, 0.0);
}

#[test]
fn a_quarter_that_is_black() {
    let truth = vec![Vec3::ONE; 64];
    let mut picture = truth.clone();
    for row in picture.chunks_exact_mut(8).take(4) {
        row[..4].fill(Vec3::ZERO);
    }
    let found = agreement(&picture, 8, &block_means(&truth, 8));
    let expected = Agreement {
        relative_error: 0.25,
        bias: -0.25,
        percentile_95: 1.0,
        black: 0.25,
    };
    assert_eq!(found, expected);
}

#[test]
fn blocks_that_see_nothing_do_not_count() {
    let mut truth = vec![Vec3::ONE; 32];
    let mut picture = truth.clone();
    truth[0] = Vec3::ZERO;
    picture[1] = Vec3::splat(100.0);
    let truth = block_means(&truth, 8);
    assert_eq!(agreement(&picture, 8, &truth), Agreement::default());
}

/// A picture of the box's albedo under light of this irradiance over pi.
fn lit(light: impl Fn(usize, Vec3) -> f32) -> Vec<Vec3> {
    let points = visible_walls(&cornell_box()).into_iter().enumerate();
    points
        .map(|(i, point)| point.map_or(Vec3::ZERO, |p| p.albedo * light(i, p.position)))
        .collect()
}

#[test]
fn light_that_changes_evenly_has_no_noise() {
    let picture = lit(|_, p| 3.0 + p.x + 0.5 * p.y * p.y + 0.3 * p.z * p.x);
    let noise = picture_noise(&picture, &cornell_box(), 32).expect("walls");
    assert!(noise < 1e-4, "{noise}");
}

#[test]
fn a_checkerboard_has_the_noise_of_its_contrast() {
    let picture = lit(|i, _| {
        1.0 + if (i + i / 128).is_multiple_of(2) {
            0.02
        } else {
            -0.02
        }
    });
    let noise = picture_noise(&picture, &cornell_box(), 32).expect("walls");
    assert!((noise - 0.02).abs() < 1e-3, "{noise}");
}
