//! The plugins: they register the systems and resources that the modules define.

use std::marker::PhantomData;

use bevy::{
    core_pipeline::{Core3d, Core3dSystems, schedule::camera_driver},
    light::SimulationLightSystems,
    prelude::*,
    render::{
        Extract, ExtractSchedule, Render, RenderApp, RenderStartup, RenderSystems,
        mesh::allocator::MeshAllocatorSettings,
        render_resource::{BufferUsages, SpecializedComputePipelines},
        renderer::{RenderGraph, RenderGraphSystems},
    },
    shader::load_shader_library,
};
use bevy_frugal_hooks::shader_patch::PatchShadersExt;

use crate::{
    debug::DebugViewPlugin,
    light::{
        compute_light,
        pipeline::{LightPipelines, init_pipelines},
    },
    receive,
    report::{SharedReport, VoxelGiReport, receive_report},
    reproject::{init_reproject_pipeline, prepare_reprojection, reproject},
    scene::{
        AsVoxelMaterial, MeshVoxelMaterial,
        extract::{ExtractedScene, extract_scene},
        lights::{ExtractedLights, extract_lights},
        material_table::{MaterialTable, update_materials},
        unknown_materials::update_unknown_materials,
    },
    settings::{NotVoxelized, VoxelGiVolume},
    volume::{
        gpu::VolumeUniforms,
        placement::{ActiveVolume, place_volume},
        plan::{ExtractedVolume, FramePlan, prepare_frame},
        probe::place_probe,
        scroll::{ScrollPipeline, init_scroll_pipeline, scroll},
    },
    voxelize::{
        pipeline::{VoxelizePipeline, init_pipeline},
        voxelize,
    },
};

/// Adds global illumination to the scene inside of each [`VoxelGiVolume`].
///
/// An app without such a volume has no additional pass, texture or buffer.
#[derive(Clone, Copy, Debug, Default)]
pub struct VoxelGiPlugin;

impl Plugin for VoxelGiPlugin {
    fn build(&self, app: &mut App) {
        load_shader_library!(app, "volume/volume.wesl");
        load_shader_library!(app, "voxelize/triangles.wesl");
        load_shader_library!(app, "light/faces.wesl");
        load_shader_library!(app, "light/traverse.wesl");
        load_shader_library!(app, "light/trace.wesl");
        load_shader_library!(app, "light/material.wesl");
        load_shader_library!(app, "light/rays.wesl");
        load_shader_library!(app, "light/surface.wesl");
        load_shader_library!(app, "light/albedo.wesl");
        load_shader_library!(app, "light/entry.wesl");
        load_shader_library!(app, "light/atlas.wesl");
        load_shader_library!(app, "light/harmonics.wesl");
        load_shader_library!(app, "receive/visibility.wesl");
        load_shader_library!(app, "receive/receive.wesl");
        crate::voxelize::embed(app);
        crate::light::embed(app);
        crate::reproject::embed(app);
        crate::volume::scroll::embed(app);
        app.patch_shader(receive::patch())
            .register_type::<VoxelGiVolume>()
            .register_type::<NotVoxelized>()
            .register_type::<MeshVoxelMaterial>()
            .init_resource::<ActiveVolume>()
            .init_resource::<MaterialTable>()
            .init_resource::<VoxelGiReport>()
            .init_resource::<SharedReport>()
            .add_plugins((
                VoxelMaterialPlugin::<StandardMaterial>::default(),
                DebugViewPlugin,
            ))
            .add_systems(First, receive_report)
            .add_systems(
                Last,
                update_unknown_materials
                    .after(UpdateMaterials)
                    .run_if(there_is_a_volume),
            )
            .add_systems(
                PostUpdate,
                (place_volume, place_probe)
                    .chain()
                    .after(TransformSystems::Propagate)
                    .before(SimulationLightSystems::AssignLightsToClusters),
            );
    }

    fn finish(&self, app: &mut App) {
        let report = app.world().resource::<SharedReport>().clone();
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        // The voxelisers read mesh vertices as storage buffers.
        if let Some(mut settings) = render_app
            .world_mut()
            .get_resource_mut::<MeshAllocatorSettings>()
        {
            settings.extra_buffer_usages |= BufferUsages::STORAGE;
        }
        render_app
            .insert_resource(report)
            .init_resource::<ExtractedVolume>()
            .init_resource::<ExtractedScene>()
            .init_resource::<ExtractedLights>()
            .init_resource::<FramePlan>()
            .init_resource::<VolumeUniforms>()
            .init_resource::<SpecializedComputePipelines<VoxelizePipeline>>()
            .init_resource::<SpecializedComputePipelines<LightPipelines>>()
            .init_resource::<SpecializedComputePipelines<ScrollPipeline>>()
            .add_systems(
                RenderStartup,
                (
                    init_pipeline,
                    init_pipelines,
                    init_scroll_pipeline,
                    init_reproject_pipeline,
                ),
            )
            .add_systems(
                ExtractSchedule,
                (
                    extract_volume,
                    extract_scene.run_if(there_is_or_was_a_volume),
                    extract_lights.run_if(there_is_or_was_a_volume),
                )
                    .chain(),
            )
            .add_systems(
                Render,
                (
                    prepare_reprojection.in_set(RenderSystems::PrepareResources),
                    prepare_frame.in_set(RenderSystems::PrepareBindGroups),
                ),
            )
            .add_systems(
                Core3d,
                reproject
                    .after(Core3dSystems::Prepass)
                    .before(Core3dSystems::MainPass),
            )
            .add_systems(
                RenderGraph,
                (scroll, voxelize, compute_light)
                    .chain()
                    .in_set(RenderGraphSystems::Render)
                    .before(camera_driver),
            );
    }
}

fn extract_volume(mut volume: ResMut<ExtractedVolume>, active: Extract<Res<ActiveVolume>>) {
    volume.0.clone_from(&active.volume);
}

fn there_is_or_was_a_volume(volume: Res<ExtractedVolume>) -> bool {
    volume.0.is_some()
}

fn there_is_a_volume(volumes: Query<(), With<VoxelGiVolume>>) -> bool {
    !volumes.is_empty()
}

/// The systems that assign each known type of material its entries in the surface table.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct UpdateMaterials;

/// Voxelises meshes with this material with its own surface; see [`AsVoxelMaterial`].
pub struct VoxelMaterialPlugin<M>(PhantomData<fn() -> M>);

impl<M> Default for VoxelMaterialPlugin<M> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<M: AsVoxelMaterial> Plugin for VoxelMaterialPlugin<M> {
    fn build(&self, app: &mut App) {
        app.init_resource::<MaterialTable>().add_systems(
            Last,
            update_materials::<M>
                .in_set(UpdateMaterials)
                .run_if(there_is_a_volume),
        );
    }
}
