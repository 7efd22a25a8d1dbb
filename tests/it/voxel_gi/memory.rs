//! Memory that volumes allocate.

use bevy_frugal_lab::headless::HeadlessApp;
use bevy_voxel_gi::{Bounces, Solver, VoxelGiReport, VoxelGiVolume, VoxelLight};

use super::{
    scene::{app, floor, under_sky},
    support::settle,
};
use crate::support::gpu;

/// Bytes a voxel of a volume that traces rays: 8 of occupancy, 24 of surfaces, 48 of radiance, 96 of irradiance,
/// 28 of lists and 48 of texture.
pub const WITH_LIGHT: u64 = 8 + 24 + 48 + 96 + 28 + 48;

/// A volume of 16^3 voxels, or as many cascades of it as are in the report, takes these bytes a voxel, the
/// texture's last slice, and little else.
pub fn assert_memory(app: &HeadlessApp, bytes_per_voxel: u64) {
    let memory = app.world().resource::<VoxelGiReport>().memory;
    let expected = 4096 * bytes_per_voxel + 16 * 32 * 8;
    println!("{memory} bytes, expected {expected}");
    assert!(memory.abs_diff(expected) < 1024, "{memory} for {expected}");
}

#[test]
fn each_solver_has_the_memory_that_it_needs() {
    let _gpu = gpu();
    let mut app = app();
    floor(app.world_mut());
    let light = |solver| VoxelLight::GlobalIllumination {
        solver,
        bounces: Bounces::Endless,
    };
    let occlusion = VoxelLight::AmbientOcclusion {
        radius: 0.5,
        rays: 8,
    };
    for (light, cascades, bytes) in [
        // Two times the light on its way: 64 bytes.
        (
            light(Solver::Propagate { iterations: 8 }),
            1,
            WITH_LIGHT + 128,
        ),
        (light(Solver::Trace { rays: 8 }), 2, 2 * WITH_LIGHT),
        // No surfaces, no radiance, no irradiance but in the texture.
        (occlusion, 1, 8 + 28 + 48),
    ] {
        let volume = VoxelGiVolume {
            light,
            cascades,
            ..under_sky(1.0)
        };
        let volume = app.world_mut().spawn(volume).id();
        settle(&mut app);
        assert_memory(&app, bytes);
        app.world_mut().despawn(volume);
        app.render_frames(3).expect("frames");
    }
}
