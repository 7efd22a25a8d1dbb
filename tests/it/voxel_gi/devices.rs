//! Devices that can do less, and devices that are lost.

use bevy::{
    prelude::*,
    render::{
        RenderApp,
        error_handler::{RenderErrorHandler, RenderErrorPolicy},
        render_resource::{
            BindingType, BufferBindingType, CachedPipelineState, PipelineCache, PipelineDescriptor,
        },
        renderer::RenderDevice,
        settings::WgpuSettings,
    },
};
use bevy_frugal_lab::headless::{HeadlessApp, HeadlessSettings, LabTarget};
use bevy_voxel_gi::{VoxelAlbedo, VoxelLight};

use super::fixture::*;
use crate::support::{gpu_alone, renderer_errors, warned_of};

/// As many as every WebGPU device binds in a stage.
const STORAGE_BUFFERS: u32 = 8;

#[test]
fn devices_that_bind_eight_storage_buffers_have_all_but_reprojected_albedo() {
    let limits = {
        let app = app_with(|_| ());
        app.world().resource::<RenderDevice>().limits()
    };
    let constrained = wgpu::Limits {
        max_storage_buffers_per_shader_stage: STORAGE_BUFFERS,
        ..limits
    };
    let mut app = app_of(
        |settings| settings.constrained_limits = Some(constrained),
        |_| (),
    );
    floor(app.world_mut());
    app.world_mut().spawn(under_sky(1.0));
    for albedo in [VoxelAlbedo::Material, VoxelAlbedo::Reprojected] {
        settings(app.world_mut()).albedo = albedo;
        let found = at(&settled(&mut app), 0.0, 0.0).x;
        assert!((found - 1.0).abs() < 0.02, "{found}");
    }
    assert!(warned_of(
        "`VoxelAlbedo::Reprojected` takes 9 storage buffers"
    ));
    // The device refuses layouts of more; these are all that there are.
    let render_world = app.app_mut().sub_app(RenderApp).world();
    let cache = render_world.resource::<PipelineCache>();
    let mut counts = Vec::new();
    for pipeline in cache.pipelines() {
        assert!(!matches!(pipeline.state, CachedPipelineState::Err(_)));
        let PipelineDescriptor::ComputePipelineDescriptor(descriptor) = &pipeline.descriptor else {
            continue;
        };
        let label = descriptor.label.as_deref().unwrap_or_default();
        if !label.starts_with("voxel_gi_") {
            continue;
        }
        let entries = descriptor.layout.iter().flat_map(|group| &group.entries);
        let storage = entries.filter_map(|entry| match entry.ty {
            BindingType::Buffer { ty, .. } => Some(ty != BufferBindingType::Uniform),
            _ => None,
        });
        let count = storage.filter(|is_storage| *is_storage).count() as u32;
        println!("{label}: {count}");
        counts.push(count);
    }
    assert!(counts.len() > 8, "{counts:?}");
    assert!(counts.iter().all(|count| *count <= STORAGE_BUFFERS));
}

/// The loss of a device has been handled.
#[derive(Resource)]
struct IsHandled;

fn recover(app: &mut App) {
    app.insert_resource(RenderErrorHandler(|_, world, _| {
        world.insert_resource(IsHandled);
        RenderErrorPolicy::Recover(WgpuSettings::default().into())
    }));
}

/// Loses the device, and renders until there is another one. The loss is known before the next frame: Bevy itself
/// ends where a frame finds it out, as buffers with contents cannot be made then.
fn lose_device(app: &mut HeadlessApp) {
    let device = app.world().resource::<RenderDevice>();
    device.wgpu_device().destroy();
    let _ = device.poll(wgpu::PollType::Poll);
    app.app_mut().update();
    let handled = app.world_mut().remove_resource::<IsHandled>();
    assert!(handled.is_some(), "Bevy noticed the loss");
    // It takes the new device, and then starts with it.
    (0..3).for_each(|_| app.app_mut().update());
    // That the device is lost is an error, and so is what was done with it.
    renderer_errors();
}

/// Bevy alone: what the plugin is measured by.
#[test]
fn bevy_recovers_from_a_lost_device() {
    let _gpu = gpu_alone();
    let mut app = HeadlessApp::new(HeadlessSettings::with_size(16, 16), recover).expect("adapter");
    let world = app.world_mut();
    let target = world.resource::<LabTarget>().0.clone();
    world.spawn((
        Camera3d::default(),
        target,
        Transform::from_xyz(0.0, 0.0, 5.0),
    ));
    block(world, Vec3::ZERO, Vec3::ONE);
    ready(&mut app);
    lose_device(&mut app);
    frames(&mut app, 5);
}

#[test]
fn after_a_lost_device_the_light_is_as_before() {
    let _gpu = gpu_alone();
    for light in [VoxelLight::default(), occlusion(1.0, 16)] {
        let mut app = unguarded_app(|_| (), recover);
        let world = app.world_mut();
        floor(world);
        let block = usual_block(world);
        settings(world).light = light;
        world.spawn(under_sky(1.0));
        ready(&mut app);
        settle(&mut app);
        let (before, shown) = (light_texture_bytes(&mut app), picture(&mut app));
        // It is lost while the scene is voxelised.
        pose(app.world_mut(), block).translation.x = -1.0;
        frames(&mut app, 2);
        pose(app.world_mut(), block).translation.x = 1.0;
        lose_device(&mut app);
        frames(&mut app, 3);
        settle(&mut app);
        assert!(light_texture_bytes(&mut app) == before, "{light:?}");
        assert!(picture(&mut app) == shown, "{light:?}");
    }
}
