//! Bevy's irradiance volume with the indirect light that the lab's path tracer finds.

use bevy::{
    light::{IrradianceVolume, LightProbe},
    math::UVec3,
    prelude::*,
    render::render_resource::TextureDimension,
};
use bevy_frugal_lab::{
    boxes::{BoxScene, trace_receivers},
    path_tracer::{Receiver, TraceSettings},
};

use crate::bake::{Baked, fill, texture};

/// Voxels along an edge of the volume, as many as the default of `bevy_voxel_gi` has.
const RESOLUTION: u32 = 32;
/// Paths from each voxel in each of its six directions.
const SAMPLES: u32 = 1024;

/// Bakes the volume around all boxes and spawns it.
pub fn bake(world: &mut World, scene: &BoxScene) -> Baked {
    let r = RESOLUTION;
    let (baked, image) = Baked::bake(|| {
        let size = UVec3::new(r, 2 * r, 3 * r);
        texture(TextureDimension::D3, size, &texels(scene))
    });
    let voxels = world.resource_mut::<Assets<Image>>().add(image);
    let (center, extent) = scene.volume(r);
    world.spawn((
        LightProbe::new(),
        IrradianceVolume {
            voxels,
            intensity: 1.0,
            ..default()
        },
        Transform::from_translation(center).with_scale(Vec3::splat(extent)),
    ));
    baked
}

/// Switches the volume on or off.
pub fn switch(world: &mut World, on: bool) {
    let mut volumes = world.query::<&mut IrradianceVolume>();
    for mut volume in volumes.iter_mut(world) {
        volume.intensity = if on { 1.0 } else { 0.0 };
    }
}

/// Irradiance over pi of each side, as Bevy multiplies an irradiance volume with the albedo alone, in Bevy's layout:
/// the axes of the normal are three parts of Z, the positive side of each is the lower half of Y.
fn texels(scene: &BoxScene) -> Vec<Vec3> {
    let count = RESOLUTION.pow(3);
    let (center, extent) = scene.volume(RESOLUTION);
    let settings = TraceSettings {
        samples: SAMPLES,
        ..default()
    };
    let mut texels = vec![Vec3::ZERO; 6 * count as usize];
    for side in 0..6 {
        let axis = side as usize / 2;
        let is_negative = side % 2 == 1;
        let normal = if is_negative { -1.0 } else { 1.0 } * Vec3::AXES[axis];
        let light = trace_receivers(scene, &settings, count, |index, _| {
            let at = (voxel(index).as_vec3() + 0.5) / RESOLUTION as f32 - 0.5;
            Some(Receiver {
                position: center + extent * at,
                normal,
            })
        });
        let half = if is_negative { RESOLUTION } else { 0 };
        for (index, light) in (0..count).zip(outwards(&light, normal)) {
            let at = voxel(index) + UVec3::new(0, half, axis as u32 * RESOLUTION);
            let texel = at.x + RESOLUTION * (at.y + 2 * RESOLUTION * at.z);
            texels[texel as usize] = light.unwrap_or_default();
        }
    }
    texels
}

fn voxel(index: u32) -> UVec3 {
    UVec3::new(index, index / RESOLUTION, index / RESOLUTION.pow(2)) % RESOLUTION
}

/// A voxel in a box gets the light of the next one outside in the direction of the side, where the surfaces in it have
/// theirs from, or of those around it where there is none.
fn outwards(light: &[Option<Vec3>], normal: Vec3) -> Vec<Option<Vec3>> {
    let next = |index: u32| {
        let steps =
            (0..RESOLUTION as i32).map(|step| voxel(index).as_ivec3() + step * normal.as_ivec3());
        let inside = steps.map_while(|at| {
            let at = at.as_uvec3();
            at.cmplt(UVec3::splat(RESOLUTION)).all().then_some(at)
        });
        inside
            .filter_map(|at| light[(at.x + RESOLUTION * (at.y + RESOLUTION * at.z)) as usize])
            .next()
    };
    let mut filled: Vec<_> = (0..RESOLUTION.pow(3)).map(next).collect();
    fill(&mut filled, UVec3::splat(RESOLUTION));
    filled
}
