//! The plugins: they register the systems and resources that the modules define.

use std::marker::PhantomData;

use bevy::{
    asset::AssetEventSystems,
    camera::visibility::VisibilitySystems,
    light::SimulationLightSystems,
    prelude::*,
    render::{
        ExtractSchedule, GpuResourceAppExt, Render, RenderApp, RenderStartup, RenderSystems,
        diagnostic::RenderDiagnosticsPlugin, mesh::allocator::MeshAllocatorSettings,
        render_resource::BufferUsages, renderer::RenderDevice,
    },
    shader::load_shader_library,
};
use bevy_frugal_hooks::{MaterialImages, ViewWireframesPlugin, shader_patch::PatchShadersExt};

use crate::{
    budget::{BudgetChoice, choose_quality},
    debug::DebugViewPlugin,
    extract::{
        changed_rows::{MovedMeshes, find_moved_meshes},
        deformed_meshes::extract_deformed_meshes,
        device_limits::{is_supported, keep_readable},
        game_sky::keep_atmosphere_map,
        lights::{ExtractedLights, extract_lights},
        material_table::{
            MaterialTable, begin_session, remove_unused, update_materials, update_unknown_materials,
        },
        meshes::{ExtractedScene, extract_scene, find_own_bounds},
        outer_levels::place_outer_levels,
        place_volume::{ActiveVolume, ExtractedVolume, extract_volume, place_volume},
        probe::place_probe,
        voxel_material::AsVoxelMaterial,
    },
    passes::{PassesPlugin, kernel::RequiredPipelines},
    prepare::{
        asset_notes::{AssetNotes, note_assets},
        buffers::VolumeBuffers,
        materials::{MaterialRecords, prepare_materials},
        mesh_batches::{MeshBatches, collect_mesh_batches},
        plan::{FramePlan, plan_frame},
        tiles::{LightTiles, Tiles, prepare_light_tiles, warn_of_missing_tiles},
        uniforms::VolumeUniforms,
    },
    receive::{
        self,
        features::{
            AwaitedReceiver, ReceiverShader, await_pipelines, extract_changes, update_features,
        },
    },
    report::{SharedReport, VoxelGiReport, receive_report},
    settings::{
        Follow, MeshVoxelMaterial, NotVoxelized, VoxelGiBudget, VoxelGiLight, VoxelGiSettings,
        VoxelGiVolume,
    },
};

/// Adds global illumination to the scene inside of each [`VoxelGiVolume`], with the resource [`VoxelGiSettings`].
///
/// An app without such a volume has no additional pass, texture or buffer.
#[derive(Clone, Copy, Debug, Default)]
pub struct VoxelGiPlugin;

impl Plugin for VoxelGiPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<ViewWireframesPlugin>() {
            app.add_plugins(ViewWireframesPlugin);
        }
        load_shader_library!(app, "shaders/albedo.wesl");
        load_shader_library!(app, "shaders/dividers.wesl");
        load_shader_library!(app, "shaders/faces.wesl");
        load_shader_library!(app, "shaders/gpu_types.wesl");
        load_shader_library!(app, "shaders/light_texture.wesl");
        load_shader_library!(app, "shaders/rays.wesl");
        load_shader_library!(app, "shaders/surface.wesl");
        load_shader_library!(app, "shaders/trace.wesl");
        load_shader_library!(app, "shaders/voxel.wesl");
        load_shader_library!(app, "receive/coverage.wesl");
        load_shader_library!(app, "receive/plane.wesl");
        load_shader_library!(app, "receive/receive.wesl");
        load_shader_library!(app, "receive/specular.wesl");
        load_shader_library!(app, "receive/visibility.wesl");
        load_shader_library!(app, "receive/volume.wesl");
        app.patch_shader(receive::receiver_patch())
            .patch_shader(receive::lighting_patch())
            .patch_shader(receive::environment_patch())
            .register_type::<VoxelGiSettings>()
            .register_type::<VoxelGiVolume>()
            .register_type::<Follow>()
            .init_resource::<VoxelGiSettings>()
            .register_type::<NotVoxelized>()
            .register_type::<MeshVoxelMaterial>()
            .register_type::<VoxelGiLight>()
            .init_resource::<ActiveVolume>()
            .register_type::<VoxelGiReport>()
            .init_resource::<VoxelGiReport>()
            .init_resource::<SharedReport>()
            .init_resource::<ReceiverShader>()
            .add_plugins((
                VoxelMaterialPlugin::<StandardMaterial>::default(),
                PassesPlugin,
                DebugViewPlugin,
            ))
            .add_systems(First, receive_report)
            .add_systems(
                Last,
                (
                    begin_session.before(UpdateMaterials),
                    (
                        find_moved_meshes.before(UpdateMaterials),
                        (update_unknown_materials, remove_unused)
                            .chain()
                            .after(UpdateMaterials),
                        find_own_bounds,
                    )
                        .run_if(there_is_a_volume),
                ),
            )
            .add_systems(
                PostUpdate,
                (
                    (place_volume, place_probe, keep_atmosphere_map)
                        .chain()
                        .after(VisibilitySystems::VisibilityPropagate)
                        .before(SimulationLightSystems::AssignLightsToClusters),
                    update_features
                        .run_if(resource_exists::<Assets<Shader>>)
                        .before(AssetEventSystems),
                )
                    .chain()
                    .after(TransformSystems::Propagate),
            );
    }

    fn finish(&self, app: &mut App) {
        let report = app.world().resource::<SharedReport>().clone();
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        let device = render_app.world().get_resource::<RenderDevice>();
        let limits = device.map(|device| device.limits());
        // The voxelisers read mesh vertices as storage buffers.
        if let Some(limits) = limits.filter(is_supported)
            && let Some(mut settings) = render_app
                .world_mut()
                .get_resource_mut::<MeshAllocatorSettings>()
        {
            settings.extra_buffer_usages |= BufferUsages::STORAGE;
            keep_readable(&mut settings, &limits);
        }
        render_app
            .insert_resource(report)
            .init_resource::<AwaitedReceiver>()
            .init_resource::<AssetNotes>()
            .init_resource::<ExtractedVolume>()
            .init_resource::<ExtractedScene>()
            .init_resource::<ExtractedLights>()
            // What is on the device is made anew with a new device.
            .init_gpu_resource::<MeshBatches>()
            .init_gpu_resource::<MaterialRecords>()
            .init_gpu_resource::<Tiles>()
            .init_gpu_resource::<LightTiles>()
            .init_gpu_resource::<RequiredPipelines>()
            .init_gpu_resource::<FramePlan>()
            .init_gpu_resource::<VolumeUniforms>()
            .add_systems(RenderStartup, forget_buffers)
            .add_systems(
                ExtractSchedule,
                (
                    extract_changes,
                    warn_of_missing_tiles,
                    extract_volume,
                    (
                        extract_scene,
                        extract_deformed_meshes,
                        place_outer_levels,
                        extract_lights,
                    )
                        .chain()
                        .run_if(a_volume_is_extracted),
                )
                    .chain(),
            )
            .add_systems(
                Render,
                (
                    note_assets.in_set(RenderSystems::ExtractCommands),
                    (
                        collect_mesh_batches,
                        prepare_materials,
                        prepare_light_tiles,
                        plan_frame,
                    )
                        .chain()
                        .in_set(RenderSystems::PrepareResources),
                    await_pipelines
                        .after(RenderSystems::PrepareBindGroups)
                        .before(RenderSystems::Render),
                ),
            );
    }
}

fn forget_buffers(mut commands: Commands) {
    commands.remove_resource::<VolumeBuffers>();
}

fn a_volume_is_extracted(volume: Res<ExtractedVolume>) -> bool {
    volume.0.is_some()
}

fn there_is_a_volume(volumes: Query<(), With<VoxelGiVolume>>) -> bool {
    !volumes.is_empty()
}

/// The systems that keep the material table in sync with each known type of material.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct UpdateMaterials;

/// Voxelises meshes with this material as it defines; see [`AsVoxelMaterial`].
pub struct VoxelMaterialPlugin<M>(PhantomData<fn() -> M>);

impl<M> Default for VoxelMaterialPlugin<M> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<M: AsVoxelMaterial> Plugin for VoxelMaterialPlugin<M> {
    fn build(&self, app: &mut App) {
        app.init_resource::<MaterialTable>()
            .init_resource::<MovedMeshes>()
            .init_resource::<MaterialImages>()
            .add_systems(
                Last,
                update_materials::<M>
                    .in_set(UpdateMaterials)
                    .run_if(there_is_a_volume),
            );
    }
}

/// Enables [`VoxelGiBudget`].
///
/// Adds Bevy's `RenderDiagnosticsPlugin`, which records the GPU timestamps, unless it has been added
/// already: an app that adds that plugin itself must add it before this one.
#[derive(Clone, Copy, Debug, Default)]
pub struct VoxelGiBudgetPlugin;

impl Plugin for VoxelGiBudgetPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<RenderDiagnosticsPlugin>() {
            app.add_plugins(RenderDiagnosticsPlugin);
        }
        app.register_type::<VoxelGiBudget>()
            .register_type::<BudgetChoice>()
            .init_resource::<BudgetChoice>()
            .add_systems(PostUpdate, choose_quality.before(place_volume));
    }
}
