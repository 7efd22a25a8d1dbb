//! Tests with curved surfaces, which most game scenes consist of, under a uniform sky.

use crate::support::{for_visibility, gray, quad, solid, traced, traced_field, unit_grid};
use bevy_voxel_gi::reference::{
    IrradianceField, RayTracing, RayTracingSettings, Triangle, Voxels,
    rays::{cosine_ray, hash_unit, sphere_ray},
};
use glam::{IVec3, Vec2, Vec3};
use std::f32::consts::PI;

/// A single-sided closed surface with its front outside: the six faces of a cube, projected to a sphere.
fn ball(center: Vec3, radius: f32) -> Vec<Triangle> {
    const STEPS: i32 = 12;
    let mut all = vec![];
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let at = |u: i32, v: i32| {
                let mut p = Vec3::splat(side);
                p[(axis + 1) % 3] = side * (2.0 * u as f32 / STEPS as f32 - 1.0);
                p[(axis + 2) % 3] = 2.0 * v as f32 / STEPS as f32 - 1.0;
                center + radius * p.normalize()
            };
            for (u, v) in (0..STEPS * STEPS).map(|i| (i % STEPS, i / STEPS)) {
                all.extend(quad(
                    [at(u, v), at(u + 1, v), at(u + 1, v + 1), at(u, v + 1)],
                    0,
                ));
            }
        }
    }
    all
}

/// Mean and least value of 500 directions all around.
fn mean_and_least(value: impl Fn(Vec3) -> f32) -> [f32; 2] {
    let found = (0..500).map(|i| value(sphere_ray(i, 500, 0.3)));
    let least = found.clone().fold(f32::INFINITY, f32::min);
    [found.sum::<f32>() / 500.0, least]
}

fn under_sky(triangles: &[Triangle], resolution: u32) -> IrradianceField {
    let voxels = Voxels::new(unit_grid(resolution), triangles);
    let materials = gray(0.0, 0.0);
    let ray_tracing = traced(&voxels, &materials, &[], Vec3::ONE);
    traced_field(ray_tracing, 16)
}

#[test]
fn a_ball_sees_all_of_the_sky() {
    for radius in [2.0, 3.3, 5.6] {
        let center = Vec3::new(8.1, 7.9, 8.3);
        let field = under_sky(&ball(center, radius), 16);
        let [mean, least] =
            mean_and_least(|n| field.irradiance(center + radius * n, n, 0.0).x / PI);
        println!("ball of {radius}: mean {mean}, least {least}");
        assert!((mean - 1.0).abs() < 0.001 && least > 0.97, "{radius}");
    }
}

/// With emission E and albedo a everywhere inside a ball, the radiance is E / (1 - a).
#[test]
fn a_round_furnace() {
    let center = Vec3::new(8.1, 7.9, 8.3);
    let mut triangles = ball(center, 5.6);
    for triangle in &mut triangles {
        triangle.corners.swap(1, 2);
    }
    let voxels = Voxels::new(unit_grid(16), &triangles);
    let materials = gray(0.5, 1.0);
    let field = traced_field(traced(&voxels, &materials, &[], Vec3::ZERO), 40);
    let [mean, least] =
        mean_and_least(|n| field.irradiance(center + 5.6 * n, -n, 0.0).x / PI / 2.0);
    println!("inside of a ball: mean {mean}, least {least}");
    assert!((mean - 1.0).abs() < 0.003 && least > 0.98);
}

/// Compares the light on hills with their shadows from small steps along each ray.
#[test]
fn hills_shade_each_other() {
    // Hills of a few voxels are hardly resolved.
    for (height, length, allowed) in [(0.6, 4.0, 0.055), (1.2, 5.0, 0.035), (1.5, 8.0, 0.02)] {
        let wave = 2.0 * PI / length;
        let ground = |x: f32, z: f32| 5.3 + height * (wave * x).sin() * (wave * z).sin();
        let at = |i: i32, k: i32| {
            let (x, z) = (0.25 * i as f32, 0.25 * k as f32);
            Vec3::new(x, ground(x, z), z)
        };
        let mut triangles = vec![];
        for i in -4..68 {
            for k in -4..68 {
                let corners = [at(i, k), at(i, k + 1), at(i + 1, k + 1), at(i + 1, k)];
                triangles.extend(quad(corners, 0));
            }
        }
        let field = under_sky(&triangles, 16);
        let (mut error, mut bias, mut sum) = (0.0, 0.0, 0.0);
        for place in 0..200 {
            let x = 4.0 + 8.0 * hash_unit(2 * place);
            let z = 4.0 + 8.0 * hash_unit(2 * place + 1);
            let p = Vec3::new(x, ground(x, z), z);
            let e = 1e-3;
            let slope =
                |dx: f32, dz: f32| (ground(x + dx, z + dz) - ground(x - dx, z - dz)) / (2.0 * e);
            let n = Vec3::new(-slope(e, 0.0), 1.0, -slope(0.0, e)).normalize();
            let open = (0..256u32)
                .filter(|&i| {
                    let ray = cosine_ray(i, 256, 0.4, n);
                    (1..)
                        .map(|s| p + n * 1e-3 + ray * (0.02 * s as f32))
                        .take_while(|q| {
                            q.floor().as_ivec3().cmpge(IVec3::ZERO).all() && q.max_element() < 16.0
                        })
                        .all(|q| q.y > ground(q.x, q.z))
                })
                .count();
            let wanted = open as f32 / 256.0;
            let found = field.irradiance(p, n, 0.0).x / PI;
            error += (found - wanted).abs();
            bias += found - wanted;
            sum += wanted;
        }
        let (error, bias) = (error / sum, bias / sum);
        println!("hills of {height}, {length}: error {error}, bias {bias}");
        assert!(error < allowed, "{height} {length}: {error}");
    }
}

/// Beside a ball and a pillar, the light of receivers with visibility tests changes gradually, from any
/// viewpoint.
#[test]
fn visible_irradiance_changes_gradually() {
    let (center, radius) = (Vec3::new(8.2, 2.0, 8.3), 0.8);
    let viewer = Vec3::new(0.5, 0.8, 0.2).normalize();
    let mut triangles = solid(Vec3::new(-1.0, 0.2, -1.0), Vec3::new(20.0, 1.2, 20.0));
    triangles.extend(ball(center, radius));
    triangles.extend(solid(Vec3::new(3.1, 1.2, 3.3), Vec3::new(3.5, 2.9, 3.7)));
    let is_visible = |at: Vec3| {
        let offset = center - at;
        let is_beside = (offset - viewer * offset.dot(viewer)).length() > radius;
        is_beside && !((2.0..3.5).contains(&at.x) && (2.5..3.7).contains(&at.z))
    };
    let voxels = Voxels::new(unit_grid(16), &triangles);
    let materials = gray(0.3, 0.0);
    let settings = RayTracingSettings {
        rays: 64,
        ..for_visibility()
    };
    let light = RayTracing::new(&voxels, &materials, &[], Vec3::ONE, settings);
    let field = traced_field(light, 16);
    let changes: Vec<f32> = (0..40 * 200)
        .filter_map(|place| {
            let [x, z] = [place % 200, place / 200];
            let at = Vec3::new(1.0 + 0.06 * x as f32, 1.2, 1.0 + 0.3 * z as f32);
            let next = at + 0.06 * Vec3::X;
            let light = |at| field.visible_irradiance(&voxels, at, Vec3::Y, viewer).x / PI;
            (is_visible(at) && is_visible(next)).then(|| light(next) - light(at))
        })
        .collect();
    let squares: f32 = changes.iter().map(|c| c * c).sum();
    let mean = (squares / changes.len() as f32).sqrt();
    let largest = changes.iter().fold(0.0f32, |a, c| a.max(c.abs()));
    println!("changes of {mean} from place to place, at most {largest}");
    assert!(
        changes.len() > 5_000 && mean < 0.0018 && largest < 0.056,
        "{mean} {largest}"
    );
}

/// At the foot of a ball most rays start inside of it or under it: what is seen there is in shadow and not black, wherever
/// it is in its voxels.
#[test]
fn the_foot_of_a_ball_is_in_shadow() {
    let viewer = Vec3::new(0.0, 0.9, 2.0).normalize();
    let (mut dark, mut bright, mut squares, mut count) = (0.0f32, 0.0f32, 0.0, 0);
    for (tests_visibility, x) in [0.0, 0.2, 0.4, 0.64, 0.84]
        .into_iter()
        .flat_map(|x| [(false, x), (true, x)])
    {
        let (center, radius) = (Vec3::new(8.0 + x, 10.08, 8.2), 2.8);
        let mut triangles = solid(Vec3::new(0.4, 5.0, 0.4), Vec3::new(15.6, 7.28, 15.6));
        triangles.extend(ball(center, radius));
        let voxels = Voxels::new(unit_grid(16), &triangles);
        let settings = RayTracingSettings {
            tests_visibility,
            rays: 64,
            ..Default::default()
        };
        let light = RayTracing::new(&voxels, &[gray(0.0, 0.0)[0]], &[], Vec3::ONE, settings);
        let field = traced_field(light, 16);
        for place in 0..64 * 64 {
            let offset = Vec2::new((place % 64) as f32, (place / 64) as f32) / 64.0 - 0.5;
            let at = Vec3::new(center.x + 4.8 * offset.x, 7.28, 10.0 + 10.4 * offset.y);
            let to_center = center - at;
            if to_center.reject_from(viewer).length() < radius + 0.12 || at.z > 15.2 {
                continue;
            }
            let light = if tests_visibility {
                field.visible_irradiance(&voxels, at, Vec3::Y, viewer)
            } else {
                field.irradiance(at, Vec3::Y, 0.0)
            };
            // The sky less the form factor of the ball.
            let error = light.x / PI - (1.0 - (radius / to_center.length()).powi(3));
            dark = dark.min(error);
            bright = bright.max(error);
            squares += error * error;
            count += 1;
        }
    }
    let deviation = (squares / count as f32).sqrt();
    println!("foot of a ball: from {dark:.3} to {bright:.3}, deviation {deviation:.4} of {count}");
    assert!(count > 10_000 && dark > -0.36 && bright < 0.28 && deviation < 0.06);
}
