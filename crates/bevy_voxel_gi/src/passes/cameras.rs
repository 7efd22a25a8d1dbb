//! What runs after the prepass of each camera that has a G-buffer.
//!
//! The albedo of surfaces is reprojected from it (thesis section 6.5.2), for
//! [`VoxelAlbedo::Reprojected`](crate::VoxelAlbedo::Reprojected): the light of the next frame uses it. With
//! [`Voxelizer::Stochastic`](crate::Voxelizer::Stochastic), what the camera sees is marked, too (thesis section 6.4.3),
//! and the next frame adds it to the voxels.

use bevy::{
    asset::load_embedded_asset,
    core_pipeline::prepass::ViewPrepassTextures,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{
            BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, ComputePass,
            ShaderStages, TextureSampleType,
            binding_types::{texture_2d, texture_depth_2d, uniform_buffer},
        },
        renderer::{RenderContext, ViewQuery},
        view::{ViewUniform, ViewUniformOffset, ViewUniforms},
    },
};

use super::{
    bindings::{BindGroups, Binding::*, Group},
    kernel::{Kernel, Pipelines, record_pass, set_bind_groups},
};
use crate::{
    extract::place_volume::ExtractedVolume,
    prepare::{
        buffers::{BufferShape, VolumeBuffers},
        plan::FramePlan,
    },
    settings::VoxelAlbedo,
};

/// Pixels along an edge of a workgroup that marks what is visible.
const TILE: u32 = 8;

#[derive(Resource)]
pub(crate) struct CameraPasses {
    reproject: CameraPass,
    mark_visible: CameraPass,
    /// The layout of group 2, which `bindings.wesl` declares, too.
    g_buffer_layout: BindGroupLayoutDescriptor,
}

/// A kernel that reads the G-buffer, and its other groups.
struct CameraPass {
    groups: [Group; 2],
    kernel: Kernel,
}

pub(crate) fn init(mut commands: Commands, assets: Res<AssetServer>) {
    let assets = assets.as_ref();
    let g_buffer_layout = BindGroupLayoutDescriptor::new(
        "voxel_gi_g_buffer",
        &BindGroupLayoutEntries::sequential(
            ShaderStages::COMPUTE,
            (
                uniform_buffer::<ViewUniform>(true),
                texture_depth_2d(),
                texture_2d(TextureSampleType::Uint),
            ),
        ),
    );
    let pass = |label, entry_point, shader: Handle<Shader>, groups: [Group; 2]| {
        let layouts = [&groups[0].layout, &groups[1].layout, &g_buffer_layout];
        CameraPass {
            kernel: Kernel::new(label, entry_point, &shader, &layouts),
            groups,
        }
    };
    let reprojected = [
        Group::new(
            "voxel_gi_reproject_volume",
            &[Volume(0), Masks, PackedSurfaces, FaceSlots],
            &[ReprojectedAlbedo],
        ),
        Group::new("voxel_gi_reproject_work", &[Work, Colors], &[]),
    ];
    let marked = [
        Group::new("voxel_gi_mark_visible_volume", &[Volume(0)], &[]),
        Group::new("voxel_gi_mark_visible", &[], &[Visible]),
    ];
    let shader = load_embedded_asset!(assets, "reproject.wesl");
    let mut reproject = pass("voxel_gi_reproject", "reproject", shader, reprojected);
    reproject.kernel = reproject.kernel.with_zeroed_workgroup_memory();
    let shader = load_embedded_asset!(assets, "mark_visible.wesl");
    commands.insert_resource(CameraPasses {
        mark_visible: pass("voxel_gi_mark_visible", "mark_visible", shader, marked),
        reproject,
        g_buffer_layout,
    });
}

/// Queues the pipelines once a volume needs them; nothing waits for them.
pub(crate) fn queue(
    mut passes: ResMut<CameraPasses>,
    volume: Res<ExtractedVolume>,
    pipelines: Pipelines,
) {
    let Some(volume) = &volume.0 else {
        return;
    };
    if volume.settings.albedo == VoxelAlbedo::Reprojected {
        passes.reproject.kernel.choose(&[], &pipelines);
    }
    if BufferShape::of(volume).marks_visible {
        passes.mark_visible.kernel.choose(&[], &pipelines);
    }
}

/// Runs for the camera whose prepass has just been rendered.
pub(crate) fn read_g_buffer(
    view: ViewQuery<(&ViewUniformOffset, &ViewPrepassTextures, &ExtractedCamera)>,
    mut context: RenderContext,
    passes: Res<CameraPasses>,
    plan: Res<FramePlan>,
    views: Res<ViewUniforms>,
    groups: BindGroups,
) {
    let (offset, textures, camera) = view.into_inner();
    let (Some(_), Some(buffers)) = (plan.work, &groups.buffers) else {
        return;
    };
    if !buffers.shape.reprojects_albedo {
        return;
    }
    let (Some(depth), Some(deferred), Some(view)) = (
        textures.depth_only_view(),
        textures.deferred_view(),
        views.uniforms.binding(),
    ) else {
        return;
    };
    let g_buffer = BindGroupEntries::sequential((view, depth, deferred));
    let g_buffer = groups.create(&passes.g_buffer_layout, &g_buffer);
    let mut record = |label, pass: &CameraPass, dispatch: &dyn Fn(&mut ComputePass<'_>)| {
        let (Some(pipeline), Some(own)) = (
            pass.kernel.pipeline(&groups.cache),
            groups.bind_both(&pass.groups),
        ) else {
            return;
        };
        record_pass(&mut context, label, |compute| {
            compute.set_pipeline(pipeline);
            set_bind_groups(compute, &own);
            compute.set_bind_group(2, &g_buffer, &[offset.offset]);
            dispatch(compute);
        });
    };
    record("voxel_gi_reproject", &passes.reproject, &|compute| {
        compute.dispatch_workgroups_indirect(&buffers.indirect_args, VolumeBuffers::SURFACE_ARGS);
    });
    if buffers.shape.marks_visible
        && let Some(size) = camera.physical_viewport_size
    {
        record("voxel_gi_mark_visible", &passes.mark_visible, &|compute| {
            compute.dispatch_workgroups(size.x.div_ceil(TILE), size.y.div_ceil(TILE), 1);
        });
    }
}
