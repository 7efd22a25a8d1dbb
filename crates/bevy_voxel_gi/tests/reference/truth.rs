//! Tests of the reference against path-traced light (`tests/data`).

use crate::support::{self, Truth};
use bevy_voxel_gi::reference::{
    FACES, IrradianceField, Propagation, PropagationSettings, RayTracing, RayTracingSettings,
    SETTLE, VolumeGrid, Voxels,
    harmonics::{basis, cosine_lobe},
    ray_sample::RaySample,
    rays::{hash_unit, sphere_ray},
};
use glam::{IVec3, Vec3, Vec4};
use std::f32::consts::PI;

fn ray_tracing(truth: &Truth, voxels: &Voxels, settings: RayTracingSettings) -> IrradianceField {
    let mut ray_tracing = truth.ray_tracing(voxels, settings);
    for _ in 0..SETTLE {
        ray_tracing.step();
    }
    ray_tracing.field()
}

fn propagate(truth: &Truth, voxels: &Voxels, steps: u32) -> IrradianceField {
    let ray_tracing = truth.ray_tracing(voxels, RayTracingSettings::default());
    let settings = PropagationSettings {
        steps,
        ..Default::default()
    };
    let mut flow = Propagation::new(&ray_tracing, voxels, &truth.materials, truth.sky, settings);
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
        let p = (position - 0.5).clamp(Vec3::ZERO, Vec3::splat(grid.resolution as f32 - 1.0));
        let mut sum = [Vec4::ZERO; 3];
        for corner in 0..8 {
            let step = IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2);
            let f = p - p.floor();
            let weight = Vec3::select(step.cmpeq(IVec3::ONE), f, 1.0 - f).element_product();
            if let Some(index) = grid.index(p.floor().as_ivec3() + step) {
                for (sum, value) in sum.iter_mut().zip(stored[index]) {
                    *sum += value * weight;
                }
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
fn visible_voxels_are_as_near_the_truth() {
    let settings = RayTracingSettings {
        tests_visibility: true,
        ..Default::default()
    };
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
