//! Tests of walls: what is lit on one side of them is dark on the other.

use crate::support::{
    Solid, for_visibility, gray, point_light, solid, sun, traced, traced_field, triangles,
    unit_grid,
};
use bevy_voxel_gi::reference::{IrradianceField, RayTracing, Voxels, dividers::dividers};
use glam::{Mat3, Vec3};
use std::f32::consts::PI;

/// A wall that is lit on one side is dark on the other (thesis Fig. 6.20), however thin.
#[test]
fn no_light_comes_through_a_wall() {
    for thickness in [0.05, 0.5, 1.0, 1.7] {
        let wall = solid(
            Vec3::new(7.2, -1.0, -1.0),
            Vec3::new(7.2 + thickness, 20.0, 20.0),
        );
        let voxels = Voxels::new(unit_grid(16), &wall);
        let light = [sun(Vec3::NEG_X, 1e5)];
        let materials = gray(0.9, 0.0);
        let ray_tracing = traced(&voxels, &materials, &light, Vec3::ZERO);
        let lit = ray_tracing.surfaces.iter().zip(&ray_tracing.direct);
        for (surface, direct) in lit {
            let wanted = if surface.normal == Vec3::X { 1e5 } else { 0.0 };
            assert_eq!(direct.x, wanted, "thickness {thickness}");
        }
        let field = traced_field(ray_tracing, 12);
        for y in [2.0, 8.1, 13.0] {
            let found = field.irradiance(Vec3::new(7.2, y, 7.7), Vec3::NEG_X, 0.0);
            assert_eq!(found, Vec3::ZERO, "thickness {thickness}");
        }
    }
}

/// At the foot of a wall, what leaks to the dark side is what is reflected there.
#[test]
fn the_foot_of_a_wall_is_dark() {
    let wall = solid(Vec3::new(7.3, 1.2, -1.0), Vec3::new(7.6, 20.0, 20.0));
    let floor = solid(Vec3::new(-1.0, 0.2, -1.0), Vec3::new(20.0, 1.2, 20.0));
    let voxels = Voxels::new(unit_grid(16), &[wall, floor].concat());
    let light = [point_light(Vec3::new(12.0, 8.0, 8.0), 1e3)];
    let materials = gray(0.7, 0.0);
    let field = traced_field(traced(&voxels, &materials, &light, Vec3::ZERO), 12);
    let dividers = dividers(&voxels);
    let at = |x: f32| {
        let place = Vec3::new(x, 1.2, 8.0);
        field
            .divided_irradiance(&dividers, place, Vec3::Y, Vec3::Y)
            .x
            / at_lit(&field)
    };
    let places = [7.2, 7.0, 6.7, 6.5, 6.2, 6.0, 5.0, 3.0].map(at);
    println!("share of the lit side's light, away from the wall: {places:?}");
    assert!(places.is_sorted_by(|a, b| *a >= b - 1e-6), "{places:?}");
    assert!(places[0] < 0.03 && places[6] < 0.01, "{places:?}");
}

/// Where receivers know what divides voxels, or test their visibility, the dark side is dark wherever the wall is in its
/// voxels, and however thin it is.
#[test]
fn divided_and_visible_irradiance_do_not_leak_at_the_foot_of_a_wall() {
    let floor = solid(Vec3::new(-1.0, 0.2, -1.0), Vec3::new(20.0, 1.2, 20.0));
    let settings = for_visibility();
    let mut worst = [0.0f32; 3];
    for (x, thickness) in [
        (7.1, 0.1),
        (7.3, 0.1),
        (7.3, 0.3),
        (7.45, 0.1),
        (7.6, 0.1),
        (7.85, 0.1),
        (7.3, 0.8),
    ] {
        let wall = solid(
            Vec3::new(x, 1.2, -1.0),
            Vec3::new(x + thickness, 20.0, 20.0),
        );
        let voxels = Voxels::new(unit_grid(16), &[wall, floor.clone()].concat());
        let light = [point_light(Vec3::new(12.0, 8.0, 8.0), 1e3)];
        let materials = gray(0.7, 0.0);
        let plain = traced_field(traced(&voxels, &materials, &light, Vec3::ZERO), 12);
        let field = RayTracing::new(&voxels, &materials, &light, Vec3::ZERO, settings);
        let field = traced_field(field, 12);
        let lit = at_lit(&plain);
        let dividers = dividers(&voxels);
        let shares = |x: f32, side: f32| {
            let place = Vec3::new(x, 1.2, 8.0);
            let viewer = Vec3::new(0.7 * side, 0.7, 0.1).normalize();
            let up = Vec3::Y;
            let plain_light = plain.irradiance(place, up, 0.0).x;
            let divided = plain.divided_irradiance(&dividers, place, up, viewer).x;
            let visible = field.visible_irradiance(&voxels, place, up, viewer).x;
            [plain_light, divided, visible].map(|light| light / lit)
        };
        for distance in [0.05, 0.2, 0.4, 0.6, 0.8, 1.0, 1.5, 2.0, 4.0] {
            let found = shares(x - distance, -1.0);
            worst = std::array::from_fn(|i| worst[i].max(found[i]));
        }
        for distance in [0.05, 0.3, 0.6, 1.0] {
            let [_, divided, visible] = shares(x + thickness + distance, 1.0);
            for found in [visible, divided] {
                assert!(
                    (0.9..1.1).contains(&found),
                    "{x} {thickness} {distance}: {visible} {divided}"
                );
            }
        }
    }
    println!(
        "largest share of the lit side's light: plain {}, divided {}, visible {}",
        worst[0], worst[1], worst[2]
    );
    assert!(
        worst[0] > 0.3 && worst[1] < 0.07 && worst[2] < 0.05,
        "{worst:?}"
    );
}

/// The same for a wall that is turned about the vertical. In the sub-voxels that it fills itself, some places are taken
/// for its other side.
#[test]
fn visible_irradiance_does_not_leak_at_the_foot_of_a_turned_wall() {
    let floor = solid(Vec3::new(-9.0, 0.2, -9.0), Vec3::new(25.0, 1.2, 25.0));
    let settings = for_visibility();
    let mut worst = [0.0f32; 2];
    for (angle, thickness) in [(0.2, 0.1), (0.5, 0.1), (0.5, 0.3), (PI / 4.0, 0.1)] {
        let turned = Mat3::from_rotation_y(angle);
        let center = Vec3::new(8.03, 0.0, 8.21);
        let wall = triangles(&Solid {
            center: center + Vec3::Y * 8.0,
            half: Vec3::new(0.5 * thickness, 9.0, 30.0),
            rotation: turned,
            material: 0,
        });
        let voxels = Voxels::new(unit_grid(16), &[wall, floor.clone()].concat());
        let light = [point_light(center + turned * Vec3::new(4.0, 8.0, 0.0), 1e3)];
        let materials = gray(0.7, 0.0);
        let light = RayTracing::new(&voxels, &materials, &light, Vec3::ZERO, settings);
        let field = traced_field(light, 12);
        let visible = |across: f32, along: f32| {
            let place = center + turned * Vec3::new(across, 1.2, along);
            let viewer = turned * Vec3::new(0.7 * across.signum(), 0.7, 0.1).normalize();
            field.visible_irradiance(&voxels, place, Vec3::Y, viewer).x
        };
        let lit = visible(2.0, 0.0);
        for along in [-1.7, -0.6, 0.0, 0.45, 1.3] {
            for distance in [0.05, 0.2, 0.4, 0.6, 0.8, 1.0, 1.5, 2.0] {
                let leak = visible(-0.5 * thickness - distance, along) / lit;
                let worst = if distance < 0.1 {
                    &mut worst[0]
                } else {
                    &mut worst[1]
                };
                *worst = worst.max(leak);
            }
        }
    }
    println!(
        "largest share of the lit side's light: in its own sub-voxels {}, farther {}",
        worst[0], worst[1]
    );
    assert!(worst[0] < 0.27 && worst[1] < 0.02, "{worst:?}");
}

/// A box over a gap of less than a voxel covers a part of the floor's voxels: their light is that of the part in front
/// of it, wherever its edge is.
#[test]
fn visible_irradiance_is_not_black_below_the_edge_of_a_box() {
    let floor = solid(Vec3::new(-1.0, 0.2, -1.0), Vec3::new(20.0, 1.2, 20.0));
    let materials = gray(0.5, 0.0);
    let settings = for_visibility();
    let viewer = Vec3::new(1.0, 0.3, 0.1).normalize();
    for gap in [0.35, 0.5] {
        for edge in [8.0, 8.25, 8.4, 8.6, 8.8] {
            let low = Vec3::new(2.0, 1.2 + gap, 2.0);
            let low_box = solid(low, Vec3::new(edge, 6.0, 14.0));
            let voxels = Voxels::new(unit_grid(16), &[low_box, floor.clone()].concat());
            let light = RayTracing::new(&voxels, &materials, &[], Vec3::ONE, settings);
            let field = traced_field(light, 16);
            let light = [-0.2, 0.5].map(|x| {
                let place = Vec3::new(edge + x, 1.2, 8.0);
                field.visible_irradiance(&voxels, place, Vec3::Y, viewer).x / PI
            });
            println!("gap {gap}, edge {edge}: {light:.2?}");
            assert!((0.6..0.8).contains(&light[1]), "{gap} {edge}: {light:?}");
            assert!(light[0] > 0.8 * light[1], "{gap} {edge}: {light:?}");
        }
    }
}

/// The walls of a room without a light go on into a bright one above: right under the ceiling they are black, wherever the
/// ceiling is in its voxels, and the upper one's are bright right above its floor. What leaks comes from the ceiling, which
/// sees voxels of the walls that are in both rooms.
#[test]
fn no_light_comes_around_a_ceiling() {
    let wall = solid(Vec3::new(-1.0, -1.0, -1.0), Vec3::new(2.6, 20.0, 20.0));
    let mut worst = 0.0f32;
    for (bottom, thickness) in [
        (7.0, 0.1),
        (7.1, 0.3),
        (7.2, 0.1),
        (7.3, 0.1),
        (7.39, 0.1),
        (7.45, 0.1),
        (7.7, 0.6),
        (7.9, 0.05),
    ] {
        let top = bottom + thickness;
        let ceiling = solid(Vec3::new(2.0, bottom, -1.0), Vec3::new(20.0, top, 20.0));
        let voxels = Voxels::new(unit_grid(16), &[wall.clone(), ceiling].concat());
        let lights = [point_light(Vec3::new(6.0, 11.0, 8.0), 1e4)];
        let materials = gray(0.7, 0.0);
        let field = traced_field(traced(&voxels, &materials, &lights, Vec3::ZERO), 12);
        let dividers = dividers(&voxels);
        let light = |y: f32| {
            let place = Vec3::new(2.6, y, 8.0);
            field
                .divided_irradiance(&dividers, place, Vec3::X, Vec3::X)
                .x
        };
        let bright = light(top + 1.5);
        for distance in [0.02, 0.2, 0.4, 0.6, 0.9] {
            let (below, above) = (light(bottom - distance), light(top + distance));
            worst = worst.max(below / bright);
            assert!(
                above > 0.5 * bright,
                "{bottom} {distance}: {above} for {bright}"
            );
        }
    }
    println!("largest share of the upper room's light under a ceiling: {worst:.4}");
    assert!(worst < 0.009, "{worst}");
}

fn at_lit(field: &IrradianceField) -> f32 {
    field.irradiance(Vec3::new(8.6, 1.2, 8.0), Vec3::Y, 0.0).x
}
