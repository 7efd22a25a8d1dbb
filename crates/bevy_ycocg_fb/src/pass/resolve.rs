//! The pipeline of `resolve.wesl`, which reconstructs colours from packed texels.

use bevy::{
    asset::load_embedded_asset,
    core_pipeline::{
        FullscreenShader,
        tonemapping::{
            DebandDither, Tonemapping, TonemappingLuts, get_lut_bind_group_layout_entries,
            get_lut_bindings,
        },
    },
    pbr::Transmissive3d,
    prelude::*,
    render::{
        render_asset::RenderAssets,
        render_phase::ViewSortedRenderPhases,
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries,
            CachedRenderPipelineId, ColorTargetState, ColorWrites, FragmentState, PipelineCache,
            RenderPipelineDescriptor, ShaderStages, SpecializedRenderPipeline,
            SpecializedRenderPipelines, TextureFormat, TextureSampleType,
            binding_types::{texture_2d, texture_2d_multisampled, uniform_buffer},
        },
        renderer::RenderDevice,
        texture::{FallbackImage, GpuImage},
        view::{ExtractedView, ViewUniform, ViewUniforms},
    },
};

use super::tone_map::ToneMap;
use crate::{
    settings::{MsaaResolve, PackedFormat, Reconstruction},
    view::{
        eligibility::PackedView,
        textures::{PackedTextures, TRANSMISSION_FORMAT},
    },
};

#[derive(Resource)]
pub(crate) struct ResolvePipeline {
    single: BindGroupLayoutDescriptor,
    multisampled: BindGroupLayoutDescriptor,
    fullscreen: FullscreenShader,
    shader: Handle<Shader>,
}

impl ResolvePipeline {
    fn layout(&self, samples: u32) -> &BindGroupLayoutDescriptor {
        if samples > 1 {
            &self.multisampled
        } else {
            &self.single
        }
    }
}

pub(super) fn init_pipeline(
    mut commands: Commands,
    fullscreen: Res<FullscreenShader>,
    asset_server: Res<AssetServer>,
) {
    let sample_type = TextureSampleType::Float { filterable: false };
    let layout = |label: &'static str, texture| {
        let [lut, lut_sampler] = get_lut_bind_group_layout_entries();
        let view = uniform_buffer::<ViewUniform>(true);
        BindGroupLayoutDescriptor::new(
            label,
            &BindGroupLayoutEntries::sequential(
                ShaderStages::FRAGMENT,
                (texture, view, lut, lut_sampler),
            ),
        )
    };
    commands.insert_resource(ResolvePipeline {
        single: layout("packed_ycocg_resolve", texture_2d(sample_type)),
        multisampled: layout(
            "packed_ycocg_resolve_multisampled",
            texture_2d_multisampled(sample_type),
        ),
        fullscreen: fullscreen.clone(),
        shader: load_embedded_asset!(asset_server.as_ref(), "resolve.wesl"),
    });
}

/// Pipeline key of the resolve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct ResolveKey {
    format: PackedFormat,
    reconstruction: Reconstruction,
    /// Samples per pixel of the texture that it reads.
    samples: u32,
    msaa_resolve: MsaaResolve,
    output: TextureFormat,
    tone_map: Option<ToneMap>,
}

impl SpecializedRenderPipeline for ResolvePipeline {
    type Key = ResolveKey;

    fn specialize(&self, key: Self::Key) -> RenderPipelineDescriptor {
        let mut shader_defs = key.format.shader_defs();
        shader_defs.push(
            match key.reconstruction {
                Reconstruction::Nearest => "YCOCG_FB_NEAREST",
                Reconstruction::Bilinear => "YCOCG_FB_BILINEAR",
                Reconstruction::EdgeDirected => "YCOCG_FB_EDGE_DIRECTED",
                Reconstruction::Guided => "YCOCG_FB_GUIDED",
                Reconstruction::Wide => "YCOCG_FB_WIDE",
                Reconstruction::Quad => "YCOCG_FB_QUAD",
            }
            .into(),
        );
        let mut constants = Vec::new();
        if key.samples > 1 {
            shader_defs.push("YCOCG_FB_MULTISAMPLED".into());
            constants.push(("SAMPLES".into(), f64::from(key.samples)));
            if key.msaa_resolve == MsaaResolve::ToneMapWeighted {
                shader_defs.push("YCOCG_FB_TONE_MAP_WEIGHTED".into());
            }
        }
        if let Some(tone_map) = key.tone_map {
            shader_defs.extend(tone_map.shader_defs());
        }
        RenderPipelineDescriptor {
            label: Some("packed_ycocg_resolve".into()),
            layout: vec![self.layout(key.samples).clone()],
            vertex: self.fullscreen.to_vertex_state(),
            fragment: Some(FragmentState {
                shader: self.shader.clone(),
                shader_defs,
                constants,
                entry_point: Some("resolve".into()),
                targets: vec![Some(ColorTargetState {
                    format: key.output,
                    blend: None,
                    write_mask: ColorWrites::ALL,
                })],
            }),
            ..default()
        }
    }
}

/// The pipelines of a view's resolve.
#[derive(Component)]
pub(crate) struct PackedResolve {
    /// Resolve into the view's main texture.
    pub to_view: CachedRenderPipelineId,
    /// Resolve into the background of transmissive objects, if there are any, without tone mapping.
    pub to_transmission: Option<CachedRenderPipelineId>,
    samples: u32,
}

/// The bind group of a view's resolve.
#[derive(Component)]
pub(crate) struct ResolveBindGroup(pub BindGroup);

pub(super) fn prepare_pipelines(
    mut commands: Commands,
    views: Query<(
        Entity,
        &PackedView,
        &ExtractedView,
        Option<&Tonemapping>,
        Option<&DebandDither>,
    )>,
    former: Query<Entity, (With<PackedResolve>, Without<PackedView>)>,
    transmissive_phases: Res<ViewSortedRenderPhases<Transmissive3d>>,
    pipeline: Res<ResolvePipeline>,
    mut pipelines: ResMut<SpecializedRenderPipelines<ResolvePipeline>>,
    cache: Res<PipelineCache>,
) {
    for entity in &former {
        commands
            .entity(entity)
            .remove::<(PackedResolve, ResolveBindGroup)>();
    }
    for (entity, packed, view, tonemapping, dither) in &views {
        let samples = if packed.hardware_resolve {
            1
        } else {
            packed.samples
        };
        let to_view = ResolveKey {
            format: packed.settings.format,
            reconstruction: packed.settings.reconstruction,
            samples,
            msaa_resolve: packed.settings.msaa_resolve,
            output: view.target_format,
            tone_map: tonemapping
                .filter(|method| packed.tone_map && method.is_enabled())
                .map(|&method| ToneMap::of(view, method, dither)),
        };
        let to_transmission = ResolveKey {
            output: TRANSMISSION_FORMAT,
            tone_map: None,
            ..to_view
        };
        let transmissive = transmissive_phases
            .get(&view.retained_view_entity)
            .is_some_and(|phase| !phase.items.is_empty());
        commands.entity(entity).insert(PackedResolve {
            to_view: pipelines.specialize(&cache, &pipeline, to_view),
            to_transmission: transmissive
                .then(|| pipelines.specialize(&cache, &pipeline, to_transmission)),
            samples,
        });
    }
}

pub(super) fn prepare_bind_groups(
    mut commands: Commands,
    views: Query<(
        Entity,
        &PackedResolve,
        &PackedTextures,
        Option<&Tonemapping>,
    )>,
    pipeline: Res<ResolvePipeline>,
    cache: Res<PipelineCache>,
    view_uniforms: Res<ViewUniforms>,
    images: Res<RenderAssets<GpuImage>>,
    luts: Res<TonemappingLuts>,
    fallback_image: Res<FallbackImage>,
    device: Res<RenderDevice>,
) {
    let Some(view_binding) = view_uniforms.uniforms.binding() else {
        return;
    };
    for (entity, resolve, textures, tonemapping) in &views {
        let Some(source) = textures.resolve_source() else {
            continue;
        };
        let method = tonemapping.copied().unwrap_or(Tonemapping::None);
        let (lut, lut_sampler) = get_lut_bindings(&images, &luts, &method, &fallback_image);
        let bind_group = device.create_bind_group(
            "packed_ycocg_resolve",
            &cache.get_bind_group_layout(pipeline.layout(resolve.samples)),
            &BindGroupEntries::sequential((
                &source.default_view,
                view_binding.clone(),
                lut,
                lut_sampler,
            )),
        );
        commands.entity(entity).insert(ResolveBindGroup(bind_group));
    }
}
