//! Tests of the reference against path-traced light (`tests/data`), also with stochastic voxelisation, with and without
//! what the camera sees (thesis 6.4.3 and 6.5.2).

use crate::support::{self, Truth, for_visibility, propagation, traced, traced_field};
use bevy_voxel_gi::reference::{
    FACES, IrradianceField, Material, RayTracing, RayTracingSettings, SETTLE, Triangle, VolumeGrid,
    Voxels,
    propagate::{basis, cosine_lobe},
    rays::{hash_unit, sphere_ray},
    trace::RaySample,
};
use glam::{UVec2, Vec3, Vec4};
use std::f32::consts::PI;

fn ray_tracing(truth: &Truth, voxels: &Voxels, settings: RayTracingSettings) -> IrradianceField {
    traced_field(truth.ray_tracing(voxels, settings), SETTLE)
}

fn propagate(truth: &Truth, voxels: &Voxels, steps: u32) -> IrradianceField {
    let mut flow = propagation(voxels, &truth.materials, &truth.lights, truth.sky, steps);
    flow.run();
    flow.field()
}

fn compare(truth: &Truth, what: &str, field: &IrradianceField) -> (f32, f32) {
    let (error, bias) = truth.compare(|p, n| field.irradiance(p, n, 0.0));
    let (e, b) = (100.0 * error, 100.0 * bias);
    println!("{:14} {what:32} error {e:6.2}% bias {b:6.2}%", truth.name);
    (error, bias)
}

/// The thesis's method, for comparison: radiance in spherical harmonics from rays that start half a
/// voxel's diagonal away from the centre of every voxel (6.6.1), read by Eq. 6.14 and 6.15 half a voxel
/// in front of the surface. The light at the hits is that of `ray_tracing`, with all bounces.
fn thesis(truth: &Truth, grid: VolumeGrid, ray_tracing: &RayTracing, rays: u32) -> (f32, f32) {
    let stored: Vec<[Vec4; 3]> = (0..grid.len())
        .map(|voxel| {
            let mut sum = [Vec4::ZERO; 3];
            for i in 0..rays {
                let direction = sphere_ray(i, rays, hash_unit(voxel as u32));
                let origin = grid.voxel(voxel).as_vec3() + 0.5 + direction * 0.75f32.sqrt();
                let radiance = match ray_tracing.arriving(origin, direction) {
                    RaySample::Light(radiance) => radiance,
                    RaySample::BackFace(_) | RaySample::Invalid => Vec3::ZERO,
                };
                for (channel, value) in sum.iter_mut().zip(radiance.to_array()) {
                    *channel += basis(direction) * (value * 4.0 * PI / rays as f32);
                }
            }
            sum
        })
        .collect();
    let sample = |position: Vec3| {
        let mut sum = [Vec4::ZERO; 3];
        for (index, weight) in grid.around_position(position) {
            for (sum, value) in sum.iter_mut().zip(stored[index]) {
                *sum += value * weight;
            }
        }
        sum
    };
    truth.compare(|p, n| {
        let at = grid.to_grid(p) + 0.5 * n;
        let lobe = cosine_lobe(n);
        let mut sum = Vec3::ZERO;
        let mut total = 0.0;
        for direction in FACES {
            let weight = direction.dot(n).max(0.0);
            if weight > 0.0 {
                sum +=
                    weight * Vec3::from_array(sample(at + direction).map(|c| c.dot(lobe).max(0.0)));
                total += weight;
            }
        }
        sum / total
    })
}

/// With eight times the rays of the default, the error of the thesis's method is still at least twice as
/// large.
#[test]
#[ignore = "long: eight times the rays"]
fn the_thesis_way_is_farther_from_the_truth() {
    for (truth, voxels, light) in support::settled() {
        let (error, bias) = thesis(truth, voxels.grid, light, 256);
        let (e, b) = (100.0 * error, 100.0 * bias);
        println!("{:14} thesis error {e:6.2}% bias {b:6.2}%", truth.name);
        let (ours, _) = compare(truth, "ray_tracing", &light.field());
        assert!(2.0 * ours < error, "{}: {ours} and {error}", truth.name);
    }
}

/// Bounds slightly above the measured errors, with and without visibility tests in the receiver: at most 2.3, 2.7
/// and 3.4%, where the goals were 15, 20 and 25.
fn assert_near(truth: &Truth, (error, bias): (f32, f32)) {
    let most = match truth.name.as_str() {
        "sunlit_room" => 0.036,
        _ => 0.028,
    };
    let name = &truth.name;
    assert!(error < most && bias.abs() < 0.01, "{name}: {error}, {bias}");
}

/// At 32^3 with the default settings.
#[test]
fn ray_tracing_is_near_the_truth() {
    for (truth, _, light) in support::settled() {
        assert_near(truth, compare(truth, "ray_tracing", &light.field()));
    }
}

/// Wherever walls, floors and their edges are in their voxels. Without the heights of planes the mean errors were 4.3, 4.2
/// and 11.0%, the largest 5.1, 5.8 and 18.1%.
#[test]
#[ignore = "long: six resolutions of each scene"]
fn no_resolution_is_unlucky() {
    const RESOLUTIONS: [u32; 6] = [14, 15, 17, 18, 19, 22];
    let bounds = [(0.036, 0.048), (0.038, 0.046), (0.052, 0.06)];
    for (truth, (mean_error, largest_error)) in support::all().iter().zip(bounds) {
        let errors = RESOLUTIONS.map(|resolution| {
            let voxels = truth.voxels(resolution);
            let field = ray_tracing(truth, &voxels, RayTracingSettings::default());
            compare(truth, &format!("ray_tracing {resolution}^3"), &field).0
        });
        let mean = errors.iter().sum::<f32>() / errors.len() as f32;
        let largest = errors.into_iter().fold(0.0, f32::max);
        println!("{:14} mean {mean:.4}, largest {largest:.4}", truth.name);
        assert!(
            mean < mean_error && largest < largest_error,
            "{}: {errors:?}",
            truth.name
        );
    }
}

/// Receivers with visibility tests have the same error, without the leaks (see `ray_tracing.rs`).
#[test]
#[ignore = "long: a settled volume of each scene"]
fn visible_voxels_are_as_near_the_truth() {
    let settings = for_visibility();
    for truth in support::all() {
        let voxels = truth.voxels(32);
        let field = ray_tracing(truth, &voxels, settings);
        let (error, bias) =
            truth.compare(|p, n| field.visible_irradiance(&voxels, p, n, truth.to_viewer(p)));
        let (e, b) = (100.0 * error, 100.0 * bias);
        println!("{:14} visible error {e:6.2}% bias {b:6.2}%", truth.name);
        assert_near(truth, (error, bias));
    }
}

/// Propagation has no goal of its own; this detects regressions.
#[test]
#[ignore = "long: 128 steps in each scene"]
fn propagation_keeps_its_distance_from_the_truth() {
    for truth in support::all() {
        let field = propagate(truth, &truth.voxels(32), 128);
        let (error, _) = compare(truth, "propagate", &field);
        assert!(error < 0.45, "{}", truth.name);
    }
}

/// Propagation is the worse choice at every resolution and with any count of steps: its least error is at least 2.5 times
/// that of 8 rays at 16^3, which take a fraction of the time.
#[test]
#[ignore = "long: six fields of each scene"]
fn rays_are_nearer_the_truth_than_propagation_at_any_level() {
    for truth in support::all() {
        let settings = RayTracingSettings {
            rays: 8,
            ..Default::default()
        };
        let field = ray_tracing(truth, &truth.voxels(16), settings);
        let (traced, _) = compare(truth, "ray_tracing 16^3, 8 rays", &field);
        let mut least = f32::INFINITY;
        for resolution in [12, 16, 24] {
            let voxels = truth.voxels(resolution);
            for steps in [resolution, 2 * resolution] {
                let name = format!("propagate {resolution}^3, {steps} steps");
                let (error, _) = compare(truth, &name, &propagate(truth, &voxels, steps));
                least = least.min(error);
            }
        }
        assert!(2.5 * traced < least, "{}: {traced}, {least}", truth.name);
    }
}

/// Quads along an edge of a box's face, as meshes of games are.
const QUADS: u32 = 16;
/// Pixels along an edge of the camera's picture.
const PIXELS: u32 = 256;

/// The triangles of a scene's boxes, finer.
fn tessellated(truth: &Truth) -> Vec<Triangle> {
    let mut all = vec![];
    for quad in truth.triangles.chunks_exact(2) {
        let [a, b, c] = quad[0].corners;
        let d = quad[1].corners[2];
        let at = |i: u32, j: u32| {
            let (u, v) = (i as f32 / QUADS as f32, j as f32 / QUADS as f32);
            a.lerp(b, u).lerp(d.lerp(c, u), v)
        };
        for (i, j) in (0..QUADS * QUADS).map(|k| (k % QUADS, k / QUADS)) {
            let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            all.extend([1, 2].map(|k| Triangle {
                corners: [corners[0], corners[k], corners[k + 1]],
                ..quad[0]
            }));
        }
    }
    all
}

/// Adds what the scene's camera sees.
fn mark_visible(voxels: &mut Voxels, truth: &Truth) {
    let scale = truth.size as f32 / PIXELS as f32;
    for i in 0..PIXELS * PIXELS {
        let pixel = (UVec2::new(i % PIXELS, i / PIXELS).as_vec2() + 0.5) * scale;
        if let Some((position, normal, material)) = truth.see(pixel) {
            voxels.mark_visible(position, normal, material);
        }
    }
}

/// The same voxels, where all faces that the camera does not see are neutral gray, as in the thesis.
fn gray_where_unseen(voxels: &Voxels, truth: &Truth) -> (Voxels, Vec<Material>) {
    let mut seen = Voxels::empty(voxels.grid);
    mark_visible(&mut seen, truth);
    let mut materials = truth.materials.clone();
    let gray = materials.len() as u32;
    materials.push(Material {
        albedo: Vec3::splat(0.5),
        emission: Vec3::ZERO,
    });
    let mut voxels = voxels.clone();
    let faces = voxels.material_areas.iter_mut().flatten();
    for (areas, seen) in faces.zip(seen.packed_surfaces.iter().flatten()) {
        if *seen == 0 {
            for one in areas {
                one.material = gray;
            }
        }
    }
    (voxels, materials)
}

fn error(truth: &Truth, what: &str, voxels: &Voxels, materials: &[Material]) -> f32 {
    let light = traced(voxels, materials, &truth.lights, truth.sky);
    compare(truth, what, &traced_field(light, SETTLE)).0
}

/// With 16 points on each triangle of a fine mesh the error is that of the conservative voxeliser to a tenth, and with
/// what the camera sees within 1.9 times of it. With 4 points, what the camera sees helps where it looks, but not in the
/// room, whose light comes through what it does not see. Where unseen faces are neutral gray, as in the thesis, the
/// conservative voxeliser's own error more than doubles.
#[test]
#[ignore = "long: five voxelisations of each scene"]
fn points_on_fine_meshes_and_visible_pixels() {
    for truth in support::all() {
        let conservative = truth.voxels(32);
        let error = |what: &str, voxels: &Voxels| error(truth, what, voxels, &truth.materials);
        let wanted = error("conservative", &conservative);
        let (gray, materials) = gray_where_unseen(&conservative, truth);
        let unseen = self::error(truth, "conservative, unseen gray", &gray, &materials);
        assert!(unseen > 2.0 * wanted, "{}: {unseen} {wanted}", truth.name);
        let triangles = tessellated(truth);
        let [few, many] = [4, 16].map(|count| {
            let mut voxels = Voxels::from_points(conservative.grid, &triangles, count);
            let alone = error(&format!("{count} points"), &voxels);
            mark_visible(&mut voxels, truth);
            let seen = error(&format!("{count} points and visible pixels"), &voxels);
            (alone / wanted, seen / wanted)
        });
        assert!(many.0 < 1.1 && many.1 < 1.9, "{}: {many:?}", truth.name);
        if truth.name != "sunlit_room" {
            assert!(few.1 < few.0 && few.1 < 2.1, "{}: {few:?}", truth.name);
        }
    }
}
