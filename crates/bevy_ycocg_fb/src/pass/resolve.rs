//! The pipeline of `resolve.wesl`, which reconstructs colours from packed texels, and tone-maps them where no later
//! pass of Bevy does.

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
            BindGroup, BindGroupEntries, BindGroupEntry, BindGroupLayoutDescriptor,
            BindGroupLayoutEntries, CachedRenderPipelineId, FragmentState, IntoBinding,
            PipelineCache, RenderPipelineDescriptor, ShaderStages, SpecializedRenderPipeline,
            SpecializedRenderPipelines, TextureFormat, TextureSampleType,
            binding_types::{texture_2d, texture_2d_multisampled, uniform_buffer},
        },
        renderer::{RenderAdapterInfo, RenderDevice},
        settings::Backends,
        texture::{FallbackImage, GpuImage},
        view::{ExtractedView, ViewUniform, ViewUniforms},
    },
    shader::ShaderDefVal,
};

use crate::{
    settings::{MsaaResolve, PackedFormat, Reconstruction},
    view::formatted::{PackedTextures, PackedView, TRANSMISSION_FORMAT, has_transmissive_items},
};

/// The textures that the resolve shader reads, with the number of samples of the multisampled one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum ResolveSource {
    Resolved,
    Samples(u32),
    Both(u32),
}

impl ResolveSource {
    fn of(packed: &PackedView) -> Self {
        if packed.has_linear_light() {
            Self::Both(packed.samples)
        } else if packed.samples > 1 && !packed.hardware_resolve {
            Self::Samples(packed.samples)
        } else {
            Self::Resolved
        }
    }
}

#[derive(Resource)]
pub(crate) struct ResolvePipeline {
    single: BindGroupLayoutDescriptor,
    multisampled: BindGroupLayoutDescriptor,
    linear_light: BindGroupLayoutDescriptor,
    fullscreen: FullscreenShader,
    shader: Handle<Shader>,
    /// Whether fine derivatives are the differences of all rows and columns of a quad. GLSL ES has derivatives of
    /// unspecified precision only.
    has_fine_derivatives: bool,
}

impl ResolvePipeline {
    fn layout(&self, source: ResolveSource) -> &BindGroupLayoutDescriptor {
        match source {
            ResolveSource::Resolved => &self.single,
            ResolveSource::Samples(_) => &self.multisampled,
            ResolveSource::Both(_) => &self.linear_light,
        }
    }
}

pub(super) fn init_pipeline(
    mut commands: Commands,
    fullscreen: Res<FullscreenShader>,
    asset_server: Res<AssetServer>,
    adapter: Res<RenderAdapterInfo>,
) {
    let sample_type = TextureSampleType::Float { filterable: false };
    let samples = texture_2d_multisampled(sample_type);
    let [lut, lut_sampler] = get_lut_bind_group_layout_entries();
    let view = uniform_buffer::<ViewUniform>(true);
    let layout = |label: &'static str, texture| {
        let entries = BindGroupLayoutEntries::sequential(
            ShaderStages::FRAGMENT,
            (texture, view, lut, lut_sampler),
        );
        BindGroupLayoutDescriptor::new(label, &entries)
    };
    let linear_light = BindGroupLayoutEntries::sequential(
        ShaderStages::FRAGMENT,
        (texture_2d(sample_type), view, lut, lut_sampler, samples),
    );
    commands.insert_resource(ResolvePipeline {
        single: layout("packed_ycocg_resolve", texture_2d(sample_type)),
        multisampled: layout("packed_ycocg_resolve_multisampled", samples),
        linear_light: BindGroupLayoutDescriptor::new(
            "packed_ycocg_resolve_linear_light",
            &linear_light,
        ),
        fullscreen: fullscreen.clone(),
        shader: load_embedded_asset!(asset_server.as_ref(), "resolve.wesl"),
        // Derivatives in the shading languages of these may be coarse, whatever is asked for.
        has_fine_derivatives: !(Backends::GL | Backends::METAL).contains(adapter.backend.into()),
    });
}

/// Returns the shader defs of the tone mapping of a view, as Bevy's own pass would do it.
fn tone_map_defs(
    view: &ExtractedView,
    method: Tonemapping,
    dither: Option<&DebandDither>,
) -> Vec<&'static str> {
    let grading = &view.color_grading;
    let method = match method {
        Tonemapping::None | Tonemapping::Linear => "TONEMAP_METHOD_LINEAR",
        Tonemapping::Reinhard => "TONEMAP_METHOD_REINHARD",
        Tonemapping::ReinhardLuminance => "TONEMAP_METHOD_REINHARD_LUMINANCE",
        Tonemapping::AcesFitted => "TONEMAP_METHOD_ACES_FITTED",
        Tonemapping::AgX => "TONEMAP_METHOD_AGX",
        Tonemapping::SomewhatBoringDisplayTransform => {
            "TONEMAP_METHOD_SOMEWHAT_BORING_DISPLAY_TRANSFORM"
        }
        Tonemapping::TonyMcMapface => "TONEMAP_METHOD_TONY_MC_MAPFACE",
        Tonemapping::BlenderFilmic => "TONEMAP_METHOD_BLENDER_FILMIC",
        Tonemapping::KhronosPbrNeutral => "TONEMAP_METHOD_PBR_NEUTRAL",
    };
    let has_white_balance = grading.global.temperature != 0.0 || grading.global.tint != 0.0;
    let has_sections = grading.all_sections().any(|section| *section != default());
    let has_dither = dither.copied().unwrap_or_default() == DebandDither::Enabled;
    let defs = [
        (true, "YCOCG_FB_TONE_MAP"),
        (grading.global.hue != 0.0, "HUE_ROTATE"),
        (has_white_balance, "WHITE_BALANCE"),
        (has_sections, "SECTIONAL_COLOR_GRADING"),
        (has_dither, "DEBAND_DITHER"),
        (true, method),
    ];
    let defs = defs.into_iter().filter(|(is_set, _)| *is_set);
    defs.map(|(_, def)| def).collect()
}

/// Pipeline key of the resolve.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct ResolveKey {
    format: PackedFormat,
    reconstruction: Reconstruction,
    source: ResolveSource,
    msaa_resolve: MsaaResolve,
    output: TextureFormat,
    /// Shader defs of the tone mapping; none where a later pass of Bevy maps the tones.
    tone_map: Vec<&'static str>,
    /// Whether the viewport is one pixel wide or high.
    is_line: bool,
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
        if key.is_line || key.reconstruction == Reconstruction::Quad {
            shader_defs.push("YCOCG_FB_MISSING_NEIGHBORS".into());
        }
        if !self.has_fine_derivatives {
            shader_defs.push("YCOCG_FB_NO_FINE_DERIVATIVES".into());
        }
        let mut constants = Vec::new();
        if let ResolveSource::Samples(samples) | ResolveSource::Both(samples) = key.source {
            constants.push(("SAMPLES".into(), f64::from(samples)));
        }
        match key.source {
            ResolveSource::Resolved => {}
            ResolveSource::Samples(_) => {
                shader_defs.push("YCOCG_FB_MULTISAMPLED".into());
                if key.msaa_resolve == MsaaResolve::ToneMapWeighted {
                    shader_defs.push("YCOCG_FB_TONE_MAP_WEIGHTED".into());
                }
            }
            ResolveSource::Both(_) => shader_defs.push("YCOCG_FB_LINEAR_LIGHT".into()),
        }
        if !key.tone_map.is_empty() {
            shader_defs.extend([
                ShaderDefVal::UInt("TONEMAPPING_LUT_TEXTURE_BINDING_INDEX".into(), 2),
                ShaderDefVal::UInt("TONEMAPPING_LUT_SAMPLER_BINDING_INDEX".into(), 3),
            ]);
            shader_defs.extend(key.tone_map.into_iter().map(ShaderDefVal::from));
        }
        RenderPipelineDescriptor {
            label: Some("packed_ycocg_resolve".into()),
            layout: vec![self.layout(key.source).clone()],
            vertex: self.fullscreen.to_vertex_state(),
            fragment: Some(FragmentState {
                shader: self.shader.clone(),
                shader_defs,
                constants,
                entry_point: Some("resolve".into()),
                targets: vec![Some(key.output.into())],
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
    source: ResolveSource,
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
    transmissive_phases: Res<ViewSortedRenderPhases<Transmissive3d>>,
    pipeline: Res<ResolvePipeline>,
    mut pipelines: ResMut<SpecializedRenderPipelines<ResolvePipeline>>,
    cache: Res<PipelineCache>,
) {
    for (entity, packed, view, tonemapping, dither) in &views {
        let source = ResolveSource::of(packed);
        let to_view = ResolveKey {
            format: packed.format,
            reconstruction: packed.settings.reconstruction,
            source,
            msaa_resolve: packed.settings.msaa_resolve,
            output: view.target_format,
            tone_map: tonemapping
                .filter(|method| packed.tone_map && method.is_enabled())
                .map_or_else(Vec::new, |&method| tone_map_defs(view, method, dither)),
            is_line: view.viewport.zw().min_element() == 1,
        };
        let to_transmission = ResolveKey {
            output: TRANSMISSION_FORMAT,
            tone_map: Vec::new(),
            ..to_view.clone()
        };
        let transmissive = has_transmissive_items(&transmissive_phases, view);
        commands.entity(entity).insert(PackedResolve {
            to_view: pipelines.specialize(&cache, &pipeline, to_view),
            to_transmission: transmissive
                .then(|| pipelines.specialize(&cache, &pipeline, to_transmission)),
            source,
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
        let Some(texture) = textures.resolve_source() else {
            continue;
        };
        let method = tonemapping.copied().unwrap_or(Tonemapping::None);
        let (lut, lut_sampler) = get_lut_bindings(&images, &luts, &method, &fallback_image);
        let layout = cache.get_bind_group_layout(pipeline.layout(resolve.source));
        let entries = (
            &texture.default_view,
            view_binding.clone(),
            lut,
            lut_sampler,
        );
        let mut entries = BindGroupEntries::sequential(entries).to_vec();
        if matches!(resolve.source, ResolveSource::Both(_)) {
            let samples = textures.multisampled.as_ref();
            entries.extend(samples.map(|samples| BindGroupEntry {
                binding: 4,
                resource: samples.default_view.into_binding(),
            }));
        }
        let bind_group = device.create_bind_group("packed_ycocg_resolve", &layout, &entries);
        commands.entity(entity).insert(ResolveBindGroup(bind_group));
    }
}
