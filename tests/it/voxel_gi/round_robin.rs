//! Round-robin updates of the volume.

use bevy::prelude::*;

use super::{
    scene::{app, block, floor, settings, under_sky},
    support::{read_texels, settle},
};
use crate::support::gpu;

/// Less is the weight of voxels without surfaces.
const SURFACE: f32 = 0.003;

#[test]
fn round_robin_updates_converge_to_the_same_light() {
    let _gpu = gpu();
    let [whole, round_robin] = [1, 8].map(|update_interval| {
        let mut app = app();
        floor(app.world_mut());
        block(app.world_mut(), Vec3::new(1.0, 0.5, 0.1), Vec3::splat(1.1));
        settings(app.world_mut()).update_interval = update_interval;
        app.world_mut().spawn(under_sky(1.0));
        app.run_until_ready(200).expect("not ready");
        settle(&mut app);
        read_texels(&mut app)
    });
    // Of surfaces and of empty voxels: how much the light differs, and how much there is.
    let mut kinds = [[0.0; 2]; 2];
    for (a, b) in whole.iter().flatten().zip(round_robin.iter().flatten()) {
        assert_eq!(a.w == 0.0, b.w == 0.0, "{a} {b}");
        let [difference, sum] = &mut kinds[usize::from(a.w < SURFACE)];
        if a.w > 0.0 && b.w > 0.0 {
            *difference += (a.x / a.w - b.x / b.w).abs();
            *sum += a.x / a.w;
        }
    }
    let [surfaces, empty] = kinds.map(|[difference, sum]| difference / sum);
    println!("surfaces {surfaces}, empty {empty}");
    assert!(surfaces < 0.002 && empty < 0.005, "{surfaces} {empty}");
}

/// In the next frame, wherever it was.
#[test]
fn light_of_removed_meshes_is_cleared() {
    let _gpu = gpu();
    let mut app = app();
    let gone = block(app.world_mut(), Vec3::new(0.1, 0.1, 0.1), Vec3::splat(1.1));
    app.world_mut().spawn(under_sky(1.0));
    app.run_until_ready(200).expect("not ready");
    settle(&mut app);
    let surfaces = |texels: &[[Vec4; 6]]| {
        let faces = texels.iter().flatten();
        faces.filter(|texel| texel.w > SURFACE).count()
    };
    // It moves, so that its last light is not the first after a pause, when everything is updated.
    for step in 0..12 {
        let at = Vec3::new(0.1 + 0.5 * (step as f32).sin(), 0.1, 0.1);
        app.world_mut()
            .entity_mut(gone)
            .insert(Transform::from_translation(at));
        app.render_frames(1).expect("a frame");
    }
    assert!(surfaces(&read_texels(&mut app)) > 100);
    app.world_mut().despawn(gone);
    app.render_frames(2).expect("a frame");
    assert_eq!(surfaces(&read_texels(&mut app)), 0);
}
