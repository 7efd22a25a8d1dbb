use std::{f32::consts::PI, sync::Arc};

use bevy::math::{Quat, Vec2, Vec3, Vec3Swizzles};
use image::{Rgba, RgbaImage};

use bevy_frugal_lab::{
    boxes::{self, cornell_box},
    meshes::{
        MeshScene, SceneMaterial, SceneMesh, ScenePart, SceneTexture, TriangleBvh,
        arcade::{Arcade, ArcadeSettings, ArcadeState},
        town::{Town, TownCamera, TownState},
        trace,
    },
    path_tracer::{Ray, TraceSettings, View},
    stage::{SceneCamera, SceneDirectionalLight, Stage},
};

/// A scene without lights, seen from a point towards another.
fn scene(parts: Vec<ScenePart>, eye: Vec3, target: Vec3) -> MeshScene {
    MeshScene {
        parts,
        stage: Stage {
            point_lights: Vec::new(),
            directional_lights: Vec::new(),
            sky_radiance: Vec3::ZERO,
            sky_quarter: Vec3::ZERO,
            camera: SceneCamera {
                eye,
                target,
                up: Vec3::Z,
                fov_y_deg: 20.0,
                width: 16,
                height: 16,
            },
        },
    }
}

fn part(mesh: SceneMesh, material: SceneMaterial) -> ScenePart {
    ScenePart {
        mesh: Arc::new(mesh),
        material: Arc::new(material),
        translation: Vec3::ZERO,
        rotation: Quat::IDENTITY,
    }
}

fn gray(albedo: f32) -> SceneMaterial {
    SceneMaterial {
        albedo: Vec3::splat(albedo),
        ..SceneMaterial::default()
    }
}

fn mean(picture: &[Vec3]) -> Vec3 {
    picture.iter().sum::<Vec3>() / picture.len() as f32
}

/// A card that lies at this height; its front is above.
fn floor(size: f32, height: f32, material: SceneMaterial) -> ScenePart {
    ScenePart {
        rotation: Quat::from_rotation_x(-0.5 * PI),
        translation: height * Vec3::Y,
        ..part(SceneMesh::card(Vec2::splat(size)), material)
    }
}

#[test]
fn in_a_closed_furnace_light_is_emission_over_absorption() {
    let mut room = SceneMesh::cuboid(Vec3::splat(-1.0), Vec3::new(2.0, 1.5, 1.0));
    for triangle in room.indices.chunks_exact_mut(3) {
        triangle.swap(0, 1);
    }
    for normal in &mut room.normals {
        *normal = -*normal;
    }
    let emission = Vec3::new(1.0, 2.0, 3.0);
    let material = SceneMaterial {
        emission,
        ..gray(0.6)
    };
    let scene = scene(
        vec![part(room, material)],
        Vec3::ZERO,
        Vec3::new(1.0, 0.4, 0.2),
    );
    let settings = TraceSettings {
        depth: 100,
        ..TraceSettings::default()
    };
    let picture = trace(&scene, &settings);
    let total = mean(&picture.total) / emission;
    assert!((total - 1.0 / 0.4).abs().max_element() < 0.01, "{total}");
    // All but the surfaces' own emission is reflected.
    let indirect = mean(&picture.indirect) / emission;
    assert!(
        (indirect - 0.6 / 0.4).abs().max_element() < 0.01,
        "{indirect}"
    );
    assert_eq!(mean(&picture.direct), Vec3::ZERO);
}

#[test]
fn a_square_that_emits_lights_the_floor_by_its_form_factor() {
    let (half, height, emission, albedo) = (0.5_f32, 0.8_f32, 7.0, 0.3);
    let material = SceneMaterial {
        emission: Vec3::splat(emission),
        ..gray(0.0)
    };
    let square = ScenePart {
        rotation: Quat::from_rotation_x(0.5 * PI),
        ..floor(2.0 * half, height, material)
    };
    let parts = vec![floor(20.0, 0.0, gray(albedo)), square];
    // From the side, at the point below the middle of the square.
    let mut scene = scene(parts, Vec3::new(4.0, 0.7, 0.0), Vec3::ZERO);
    scene.stage.camera.up = Vec3::Y;
    scene.stage.camera.fov_y_deg = 0.2;
    let found = mean(&trace(&scene, &TraceSettings::default()).indirect).x;
    // A corner of the square is seen from a quarter of it (J. R. Howell, catalogue of configuration factors).
    let x = half / height;
    let root = (1.0 + x * x).sqrt();
    let form_factor = 4.0 * 2.0 * x / root * (x / root).atan() / (2.0 * PI);
    let expected = albedo * emission * form_factor;
    assert!(
        (found / expected - 1.0).abs() < 5e-3,
        "{found} for {expected}"
    );

    // The back of the square is black and emits nothing.
    scene.parts[1].rotation = Quat::from_rotation_x(-0.5 * PI);
    let dark = trace(&scene, &TraceSettings::default());
    assert_eq!(mean(&dark.total), Vec3::ZERO);
}

#[test]
fn holes_let_through_their_share() {
    // One of four columns is there.
    let texture = RgbaImage::from_fn(8, 8, |x, _| {
        Rgba([255, 255, 255, if x % 4 == 1 { 255 } else { 0 }])
    });
    let mask = SceneMaterial {
        texture: Some(Arc::new(SceneTexture::new(texture))),
        alpha_cutoff: Some(0.5),
        is_double_sided: true,
        ..gray(1.0)
    };
    let parts = vec![floor(8.0, 0.0, gray(0.5)), floor(8.0, 2.0, mask)];
    let mut scene = scene(parts, Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 0.0, 0.001));
    // A whole number of periods is in the picture.
    scene.stage.camera.fov_y_deg = 2.0 * 2.0_f32.atan().to_degrees();
    scene.stage.directional_lights.push(SceneDirectionalLight {
        direction: Vec3::NEG_Y,
        illuminance_lux: Vec3::splat(PI),
    });
    let found = mean(&trace(&scene, &TraceSettings::default()).direct).x;
    assert!((found / (0.5 * 0.75) - 1.0).abs() < 5e-3, "{found}");
}

#[test]
fn rays_hit_the_triangle_that_is_nearest() {
    let mut state = 1_u32;
    let mut number = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    let mut vector = || Vec3::new(number(), number(), number());
    let triangles: Vec<[Vec3; 3]> = (0..300)
        .map(|_| {
            let center = 2.0 * vector();
            [vector(), vector(), vector()].map(|corner| center + 0.3 * corner)
        })
        .collect();
    let bvh = TriangleBvh::new(triangles.iter().copied());
    let mut hits = 0;
    for _ in 0..500 {
        let ray = Ray {
            origin: 4.0 * vector(),
            direction: Vec3::ZERO,
        };
        let ray = Ray {
            direction: (vector() - ray.origin).normalize(),
            ..ray
        };
        let distances = triangles.iter().map(|triangle| distance(ray, *triangle));
        let nearest = distances.fold(f32::INFINITY, f32::min);
        let found = bvh.closest(ray, |_, _| true);
        let blocked = bvh.blocked(ray, 3.0, |_, _| true);
        assert_eq!(blocked, nearest < 3.0);
        let Some(found) = found else {
            assert_eq!(nearest, f32::INFINITY);
            continue;
        };
        hits += 1;
        assert!((found.distance - nearest).abs() < 1e-4);
        let [a, b, c] = triangles[found.triangle as usize];
        let at = a + found.weights.x * (b - a) + found.weights.y * (c - a);
        assert!(at.distance(ray.origin + nearest * ray.direction) < 1e-4);
        // A triangle that is not there is passed.
        let next = bvh.closest(ray, |triangle, _| triangle != found.triangle);
        assert!(next.is_none_or(|next| next.distance >= found.distance));
        assert!(next.is_none_or(|next| next.triangle != found.triangle));
    }
    assert!(hits > 100, "{hits}");
}

/// Distance to a triangle by the ratio of volumes; infinite where the ray passes it.
fn distance(ray: Ray, [a, b, c]: [Vec3; 3]) -> f32 {
    let [origin, direction, a, b, c] = [ray.origin, ray.direction, a, b, c].map(Vec3::as_dvec3);
    let normal = (b - a).cross(c - a);
    let distance = normal.dot(a - origin) / normal.dot(direction);
    let at = origin + distance * direction;
    let inside = [(a, b), (b, c), (c, a)]
        .iter()
        .all(|(from, to)| (*to - *from).cross(at - *from).dot(normal) >= 0.0);
    if inside && distance > 0.0 {
        distance as f32
    } else {
        f32::INFINITY
    }
}

/// All normals are of unit length and on the front side of their triangles.
fn assert_normals_of_fronts(scene: &MeshScene) {
    for (number, part) in scene.parts.iter().enumerate() {
        let mesh = &part.mesh;
        assert_eq!(mesh.positions.len(), mesh.normals.len());
        assert_eq!(mesh.positions.len(), mesh.uvs.len());
        assert!(mesh.positions.iter().all(|at| at.is_finite()));
        for corners in mesh.indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|k| mesh.positions[corners[k] as usize]);
            let front = (b - a).cross(c - a);
            for corner in corners {
                let normal = mesh.normals[*corner as usize];
                assert!((normal.length() - 1.0).abs() < 1e-3, "part {number}");
                // The coarse statue has sharp dents.
                let cosine = normal.dot(front.normalize_or_zero());
                assert!(cosine > -0.5, "part {number}: {cosine}");
            }
        }
    }
}

#[test]
fn the_arcade_is_made_of_what_it_says() {
    let arcade = Arcade::new(ArcadeSettings {
        statue_triangles: 20_000,
        ..ArcadeSettings::default()
    });
    let scene = arcade.scene(ArcadeState::Usual);
    let count = scene.triangle_count();
    assert!((20_000..23_000).contains(&count), "{count}");
    assert_normals_of_fronts(&scene);
    let door = |state| arcade.scene(state).parts[Arcade::DOOR].clone();
    let corner = |part: ScenePart| {
        let world_from_mesh = part.world_from_mesh();
        let positions = part.mesh.positions.iter();
        let places = positions.map(|at| world_from_mesh.transform_point3(*at));
        places.map(|at| at.x).fold(f32::INFINITY, f32::min)
    };
    assert!(corner(door(ArcadeState::Usual)) > 3.99);
    assert!(corner(door(ArcadeState::DoorOpen)) < 3.0);
}

#[test]
fn the_statue_is_closed_and_its_front_is_outside() {
    let arcade = Arcade::new(ArcadeSettings {
        statue_triangles: 20_000,
        ..ArcadeSettings::default()
    });
    let scene = arcade.scene(ArcadeState::Usual);
    let statue = scene
        .parts
        .iter()
        .max_by_key(|part| part.mesh.indices.len());
    let mesh = &statue.expect("a statue").mesh;
    let volume: f32 = mesh
        .indices
        .chunks_exact(3)
        .map(|corners| {
            let [a, b, c] = [0, 1, 2].map(|k| mesh.positions[corners[k] as usize]);
            a.dot(b.cross(c)) / 6.0
        })
        .sum();
    // A tube of 17 cm radius and some 9 m length.
    assert!((0.4..1.2).contains(&volume), "{volume}");
}

#[test]
fn the_same_picture_twice() {
    let arcade = Arcade::new(ArcadeSettings {
        statue_triangles: 2_000,
        picture: 16,
    });
    let settings = TraceSettings {
        samples: 2,
        ..TraceSettings::default()
    };
    let scene = arcade.scene(ArcadeState::DoorOpen);
    assert!(trace(&scene, &settings) == trace(&scene, &settings));
}

#[test]
fn the_town_is_as_large_as_it_says() {
    let scene = Town::new(16).scene(TownState::Usual, TownCamera::Yard);
    let count = scene.triangle_count();
    assert!((20_000..35_000).contains(&count), "{count}");
    let (low, high) = scene.bounds();
    assert!((high - low).xz().abs_diff_eq(Vec2::splat(80.0), 1e-3));
    assert_normals_of_fronts(&scene);
}

#[test]
#[ignore = "long: the town"]
fn no_surfaces_of_the_town_are_in_the_same_place() {
    let town = Town::new(160);
    for camera in TownCamera::ALL {
        let scene = town.scene(TownState::Usual, camera);
        let (mut triangles, mut looks) = (Vec::new(), Vec::new());
        for part in &scene.parts {
            let world_from_mesh = part.world_from_mesh();
            for corners in part.mesh.indices.chunks_exact(3) {
                let corners = [0, 1, 2].map(|k| corners[k] as usize);
                triangles.push(
                    corners.map(|k| world_from_mesh.transform_point3(part.mesh.positions[k])),
                );
                let middle = corners.map(|k| part.mesh.uvs[k]).iter().sum::<Vec2>();
                looks.push((Arc::as_ptr(&part.material), middle));
            }
        }
        let bvh = TriangleBvh::new(triangles.iter().copied());
        let view = View::new(&scene.stage.camera);
        for i in 0..160 * 160 {
            let ray = view.ray(Vec2::new((i % 160) as f32 + 0.4, (i / 160) as f32 + 0.7));
            let Some(first) = bvh.closest(ray, |_, _| true) else {
                continue;
            };
            let normal = |triangle: u32| {
                let [a, b, c] = triangles[triangle as usize];
                (b - a).cross(c - a).normalize_or_zero()
            };
            let looks_else = |triangle: u32| {
                normal(triangle).dot(normal(first.triangle)) > 0.99
                    && looks[triangle as usize] != looks[first.triangle as usize]
            };
            let next = bvh.closest(ray, |triangle, _| looks_else(triangle));
            let next = next.map_or(f32::INFINITY, |next| next.distance);
            let at = ray.origin + first.distance * ray.direction;
            assert!(next - first.distance > 5e-4, "{camera:?}: {at}");
        }
    }
}

#[test]
fn the_corridor_of_the_town_is_sealed_from_the_sky() {
    let town = Town::new(24);
    let light = |state| {
        let mut scene = town.scene(state, TownCamera::Corridor);
        scene.stage.point_lights.clear();
        for part in &mut scene.parts {
            Arc::make_mut(&mut part.material).emission = Vec3::ZERO;
        }
        let settings = TraceSettings {
            samples: 16,
            ..TraceSettings::default()
        };
        mean(&trace(&scene, &settings).total)
    };
    assert_eq!(light(TownState::Usual), Vec3::ZERO);
    assert!(light(TownState::DoorOpen).min_element() > 0.05);
}

#[test]
fn boxes_as_meshes_have_the_light_of_boxes() {
    let boxes = cornell_box();
    let parts = boxes.boxes.iter().map(|solid| ScenePart {
        translation: solid.center,
        rotation: solid.rotation(),
        ..part(
            SceneMesh::cuboid(-solid.half, solid.half),
            SceneMaterial {
                albedo: solid.albedo,
                ..SceneMaterial::default()
            },
        )
    });
    let meshes = MeshScene {
        parts: parts.collect(),
        stage: boxes.stage(),
    };
    let settings = TraceSettings {
        samples: 32,
        ..TraceSettings::default()
    };
    let (solids, meshes) = (boxes::trace(&boxes, &settings), trace(&meshes, &settings));
    for (solids, meshes) in [
        (&solids.direct, &meshes.direct),
        (&solids.indirect, &meshes.indirect),
    ] {
        let change = mean(meshes) / mean(solids) - 1.0;
        assert!(change.abs().max_element() < 2e-3, "{change}");
    }
}
