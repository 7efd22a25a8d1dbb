//! Adds direct light to the surfaces (thesis section 6.5.4).

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    prelude::*,
    render::render_resource::{
        BindGroup, BindGroupLayoutDescriptor, ComputePass, IntoBinding, PipelineCache,
        ShaderStages, TextureSampleType, binding_types::texture_2d,
    },
};

use super::{
    bindings::{
        BindGroups, COLORS, IRRADIANCE, LIGHTS, RADIANCE, TILES, WORK, group_layout, read_only,
        read_write,
    },
    kernel::{Kernel, light_defs},
};
use crate::{
    extract::{lights::ExtractedLights, volume::ExtractedVolume},
    prepare::{
        buffers::{BufferShape, VolumeBuffers},
        light_tiles::LightTiles,
        pipelines::RequiredPipelines,
        plan::FramePlan,
        scene_buffers::SceneBuffers,
        shadow_masks::ShadowMasks,
    },
};

#[derive(Resource)]
pub(crate) struct InjectPass {
    plain: Variant,
    /// With the tiles of the textures of lights.
    textured: Variant,
    uses_textures: bool,
    /// `None` if only ambient occlusion is computed.
    bind_group: Option<BindGroup>,
}

/// The kernel with one of the layouts of its bind group.
struct Variant {
    layout: BindGroupLayoutDescriptor,
    inject: Kernel,
}

impl InjectPass {
    fn variant(&self) -> &Variant {
        if self.uses_textures {
            &self.textured
        } else {
            &self.plain
        }
    }

    fn variant_mut(&mut self) -> &mut Variant {
        if self.uses_textures {
            &mut self.textured
        } else {
            &mut self.plain
        }
    }
}

pub(crate) fn init(mut commands: Commands, assets: Res<AssetServer>) {
    let entries = (
        (WORK, read_only()),
        (RADIANCE, read_write()),
        (IRRADIANCE, read_only()),
        // It is in the same buffer as the radiance, which cannot be bound both for reading and for writing.
        (COLORS, read_write()),
        (LIGHTS, read_only()),
    );
    let plain = group_layout("voxel_gi_inject", entries);
    let mut textured = plain.clone();
    let tiles = texture_2d(TextureSampleType::Uint).build(TILES, ShaderStages::COMPUTE);
    textured.entries.push(tiles);
    let shader = load_embedded_asset!(assets.as_ref(), "inject.wesl");
    let variant = |layout| Variant {
        inject: Kernel::of_light("voxel_gi_inject", "inject", &shader, &layout),
        layout,
    };
    commands.insert_resource(InjectPass {
        plain: variant(plain),
        textured: variant(textured),
        uses_textures: false,
        bind_group: None,
    });
}

pub(crate) fn queue(
    mut pass: ResMut<InjectPass>,
    volume: Res<ExtractedVolume>,
    (lights, shadow_masks): (Res<ExtractedLights>, ShadowMasks),
    cache: Res<PipelineCache>,
    mut required: ResMut<RequiredPipelines>,
) {
    let shape = volume.0.as_ref().map(BufferShape::of);
    if let Some(shape) = shape.filter(|shape| !shape.occlusion_only) {
        let mut defs = light_defs(shape);
        defs.extend(lights.defs());
        defs.extend(shadow_masks.defs(shape));
        pass.uses_textures = lights.has_textures();
        let inject = &mut pass.variant_mut().inject;
        inject.require(&defs, &cache, &mut required);
    }
}

pub(crate) fn prepare(
    mut pass: ResMut<InjectPass>,
    plan: Res<FramePlan>,
    buffers: Option<Res<VolumeBuffers>>,
    (scene, light_tiles): (Option<Res<SceneBuffers>>, Res<LightTiles>),
    groups: BindGroups,
) {
    pass.bind_group = None;
    let (Some(_), Some(buffers), Some(scene)) = (plan.work, buffers, scene) else {
        return;
    };
    let (Some(lights), false) = (scene.lights.binding(), buffers.shape.occlusion_only) else {
        return;
    };
    let mut entries = vec![
        (WORK, buffers.work.as_entire_binding()),
        (RADIANCE, buffers.radiance()),
        (IRRADIANCE, buffers.irradiance.as_entire_binding()),
        (COLORS, buffers.colors()),
        (LIGHTS, lights),
    ];
    if pass.uses_textures {
        let tiles = light_tiles.tiles.view();
        entries.extend(tiles.map(|tiles| (TILES, tiles.into_binding())));
    }
    pass.bind_group = Some(groups.create_of(&pass.variant().layout, entries));
}

impl InjectPass {
    /// Records the pass, where group 0 is set already.
    pub(super) fn record(
        &self,
        pass: &mut ComputePass<'_>,
        buffers: &VolumeBuffers,
        cache: &PipelineCache,
    ) {
        let inject = self.variant().inject.pipeline(cache);
        if let (Some(group), Some(inject)) = (&self.bind_group, inject) {
            pass.set_pipeline(inject);
            pass.set_bind_group(1, group, &[]);
            pass.dispatch_workgroups_indirect(&buffers.indirect_args, VolumeBuffers::SURFACE_ARGS);
        }
    }
}

pub(crate) fn embed(app: &mut App) {
    embedded_asset!(app, "inject.wesl");
}
