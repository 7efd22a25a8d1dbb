//! Specular light of rough surfaces.

use crate::support::unit_grid;
use bevy_voxel_gi::reference::{IrradianceField, dividers::NOTHING};
use glam::{Vec3, Vec4};
use std::f32::consts::PI;

const RESOLUTION: u32 = 16;
/// Weight of a voxel without a surface.
const EMPTY: f32 = 1.0 / 512.0;

/// Voxels of 1 m without surfaces: irradiance of each face.
fn field(irradiance: impl Fn(Vec3, usize) -> f32) -> IrradianceField {
    let grid = unit_grid(RESOLUTION);
    let texels = (0..grid.len()).map(|index| {
        let center = grid.voxel(index).as_vec3() + 0.5;
        std::array::from_fn(|face| Vec3::splat(irradiance(center, face) * EMPTY).extend(EMPTY))
    });
    IrradianceField {
        grid,
        texels: texels.collect(),
    }
}

static UNDIVIDED: [Vec3; RESOLUTION.pow(3) as usize] =
    [Vec3::splat(NOTHING); RESOLUTION.pow(3) as usize];
const MIDDLE: Vec3 = Vec3::splat(8.0);
/// Seen at 45 degrees: the mirror's direction is between +X and +Y.
const TO_VIEWER: Vec3 = Vec3::new(
    -std::f32::consts::FRAC_1_SQRT_2,
    std::f32::consts::FRAC_1_SQRT_2,
    0.0,
);

/// The specular radiance of a floor at a place.
fn seen(field: &IrradianceField, dividers: &[Vec3], place: Vec3, roughness: f32) -> f32 {
    let radiance = field.specular_radiance(dividers, place, Vec3::Y, TO_VIEWER, roughness);
    radiance.x
}

#[test]
fn even_light_is_seen_as_it_is() {
    let field = field(|_, _| 3.0 * PI);
    for roughness in [0.4, 0.7, 1.0] {
        let seen = seen(&field, &UNDIVIDED, MIDDLE, roughness);
        assert!((seen - 3.0).abs() < 1e-4, "{roughness}: {seen}");
    }
}

#[test]
fn smoother_surfaces_see_more_of_what_they_mirror() {
    // Light from +X only, which a floor does not receive by its normal.
    let field = field(|_, face| if face == 0 { PI } else { 0.0 });
    let seen = |roughness| seen(&field, &UNDIVIDED, MIDDLE, roughness);
    assert_eq!(seen(1.0), 0.0);
    assert!(seen(0.7) > 0.1 && seen(0.4) > seen(0.7) && seen(0.4) < 0.5);
}

#[test]
fn light_behind_a_wall_is_not_seen() {
    // It is bright behind a wall at x = 9.5, dark before it; its far side is a surface, with a weight of 1.
    let mut field = field(|center, _| if center.x > 9.0 { PI } else { 0.0 });
    let open = seen(&field, &UNDIVIDED, MIDDLE, 0.4);
    assert!(open > 0.6, "{open}");
    let grid = field.grid;
    for (index, texel) in field.texels.iter_mut().enumerate() {
        match grid.voxel(index).x {
            9 => *texel = [Vec4::ZERO; 6],
            10 => *texel = [Vec3::splat(PI).extend(1.0); 6],
            _ => {}
        }
    }
    let seen = seen(&field, &UNDIVIDED, MIDDLE, 0.4);
    assert!(seen < 0.02, "{seen}");
}

#[test]
fn the_hemisphere_keeps_to_its_side_of_a_divider() {
    // It is bright beyond x = 8, where something thin divides the voxels.
    let field = field(|center, _| if center.x > 8.0 { PI } else { 0.0 });
    let mut divided = UNDIVIDED;
    for (index, divider) in divided.iter_mut().enumerate() {
        if field.grid.voxel(index).x == 7 {
            divider.x = 0.998;
        }
    }
    let place = Vec3::new(7.9, 8.0, 8.0);
    let seen = |dividers| seen(&field, dividers, place, 1.0);
    assert!(seen(&UNDIVIDED) > 0.3, "{}", seen(&UNDIVIDED));
    assert_eq!(seen(&divided), 0.0);
}
