//! Packing in the shaders of materials, without a change of the materials: calls in Bevy's shaders that pack under a
//! shader def, and this shader def in the pipelines of packed cameras. [`detect`] finds the shaders that pack.
//!
//! The calls do nothing without the shader def. The shader of temporal anti-aliasing rounds what it writes to a target
//! of three small floats in the same way as materials do, with dither.

pub mod detect;

use bevy::{
    mesh::BaseMeshPipelineKey,
    pbr::MeshPipelineKey,
    prelude::*,
    render::{
        RenderApp,
        render_resource::{RenderPipelineDescriptor, TextureFormat},
    },
    shader::ShaderDefVal,
};
use bevy_frugal_hooks::{
    Insertion, MaterialHookPlugin, ShaderPatch, SpecializedMaterial, shader_patch::PatchShadersExt,
};

use crate::{
    report::FrameBufferReport,
    settings::{FrameBufferFormat, PackedFormat},
};
use detect::PackingShaders;

/// Patches Bevy's shaders and specializes the pipelines of materials for packed cameras.
pub(crate) struct MaterialPackingPlugin;

impl Plugin for MaterialPackingPlugin {
    fn build(&self, app: &mut App) {
        for patch in patches() {
            app.patch_shader(patch);
        }
        let shaders = PackingShaders::default();
        app.insert_resource(shaders.clone())
            .add_systems(
                Last,
                detect::find_packing_shaders.run_if(any_with_component::<FrameBufferReport>),
            )
            .add_plugins(MaterialHookPlugin(pack_for_packed_targets));
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            render_app.insert_resource(shaders);
        }
    }
}

/// Name of the patch of `main_pass_post_lighting_processing`, in which every lit or unlit
/// `StandardMaterial` and every other material with Bevy's lighting ends.
const MATERIALS: &str = "bevy_ycocg_fb/materials";

/// The patches that must be applied before any camera packs. The shaders of the other patches need not
/// be part of an app; where one of those patches is missing, its shader is detected as not packing.
pub(crate) const REQUIRED: &[&str] = &[MATERIALS];

/// Returns all patches, which insert a call into each of Bevy's shaders that write colour to the main pass.
fn patches() -> Vec<ShaderPatch> {
    let fade = "vec4(in.color.xyz, in.color.w * alpha)";
    let mut joints = wrapped(
        "bevy_ycocg_fb/gizmo_joints",
        "bevy_gizmos_render::line_joints",
        &[("fn fragment(", "in.color", "in.position")],
    );
    let position = "    @builtin(position) position: vec4<f32>,";
    let position = Insertion::after("struct FragmentInput {", position);
    joints.insertions.insert(0, position);
    vec![
        ShaderPatch {
            insertions: vec![
                Insertion::before(
                    "    return output_color;\n}",
                    "    output_color = pack_fragment(output_color, pbr_input.frag_coord);",
                )
                .in_function("fn main_pass_post_lighting_processing("),
            ],
            ..wrapped(MATERIALS, "bevy_pbr::render::pbr_functions", &[])
        },
        // Materials without a fragment shader of their own.
        wrapped(
            "bevy_ycocg_fb/unshaded",
            "bevy_pbr::render::mesh",
            &[
                ("fn fragment(", "mesh.color", "mesh.position"),
                (
                    "fn fragment(",
                    "vec4<f32>(1.0, 0.0, 1.0, 1.0)",
                    "mesh.position",
                ),
            ],
        ),
        wrapped(
            "bevy_ycocg_fb/skybox",
            "bevy_core_pipeline::skybox::skybox",
            &[(
                "fn skybox_fragment(",
                "vec4(out.rgb * uniforms.brightness, out.a)",
                "in.position",
            )],
        ),
        wrapped(
            "bevy_ycocg_fb/taa",
            "bevy_anti_alias::taa::taa",
            &[(
                "fn taa(",
                "vec4(current_color, original_color.a)",
                "vec4(uv * texture_size, 0.0, 1.0)",
            )],
        ),
        wrapped(
            "bevy_ycocg_fb/gizmo_lines",
            "bevy_gizmos_render::lines",
            &[
                ("fn fragment_solid(", "in.color", "in.position"),
                ("fn fragment_dotted(", fade, "in.position"),
                ("fn fragment_dashed(", fade, "in.position"),
            ],
        ),
        joints,
    ]
}

/// A patch that wraps expressions in calls that pack them: functions, the expression that each has once, and the position
/// of the fragment in it.
fn wrapped(
    name: &'static str,
    shader: &'static str,
    colors: &[(&'static str, &'static str, &str)],
) -> ShaderPatch {
    let insertions = colors.iter().flat_map(|(function, color, frag_coord)| {
        [
            Insertion::before(color, "pack_fragment(").in_function(function),
            Insertion::after(color, format!(", {frag_coord})")).in_function(function),
        ]
    });
    ShaderPatch {
        imports: vec!["bevy_ycocg_fb::shaders::pack::pack_fragment"],
        insertions: insertions.collect(),
        ..ShaderPatch::new(name, shader)
    }
}

/// Shader def under which shaders write or read packed colours.
pub(crate) const PACK: &str = "YCOCG_FB_PACK";
const FLOAT32: &str = "YCOCG_FB_FLOAT32";
const UNORM8: &str = "YCOCG_FB_UNORM8";
/// Shader def under which shaders round colours, with dither, to those of `Rg11b10Ufloat`.
pub(crate) const RG11B10UFLOAT: &str = "YCOCG_FB_RG11B10UFLOAT";
/// Shader def of materials whose alpha selects samples, and the number of samples per pixel.
const COVERAGE: &str = "YCOCG_FB_COVERAGE";
const SAMPLES: &str = "YCOCG_FB_SAMPLES";
/// Shader defs of Bevy's dither, by steps of a display, and of that by steps of the packed format.
const BEVYS_DITHER: &str = "DEBAND_DITHER";
const DITHER: &str = "YCOCG_FB_DITHER";

/// Flag of views with a format of this crate in Bevy's `MeshPipelineKey`, a bit that Bevy does not use.
pub(crate) const PACKED_KEY: u64 = 1 << 57;
const _: () = assert!(
    (MeshPipelineKey::all().bits() | BaseMeshPipelineKey::all().bits()) & PACKED_KEY == 0,
    "Bevy has taken the bit: choose another"
);

impl FrameBufferFormat {
    /// Returns the format of the texture that is drawn to.
    pub fn texture_format(self) -> TextureFormat {
        match self {
            Self::Packed(format) => format.texture_format(),
            Self::Rg11b10Ufloat => TextureFormat::Rg11b10Ufloat,
        }
    }
}

impl PackedFormat {
    /// All packed formats.
    pub const ALL: [Self; 3] = [Self::Float16, Self::Float32, Self::Unorm8];

    /// Returns the format of the packed texture.
    pub fn texture_format(self) -> TextureFormat {
        match self {
            Self::Float16 => TextureFormat::Rg16Float,
            Self::Float32 => TextureFormat::Rg32Float,
            Self::Unorm8 => TextureFormat::Rg8Unorm,
        }
    }

    /// Returns the shader defs of all shaders that write or read the packed texture.
    pub(crate) fn shader_defs(self) -> Vec<ShaderDefVal> {
        let format = match self {
            Self::Float16 => None,
            Self::Float32 => Some(FLOAT32),
            Self::Unorm8 => Some(UNORM8),
        };
        let names = [PACK].into_iter().chain(format);
        names.map(ShaderDefVal::from).collect()
    }
}

/// The material hook, by which a material's pipeline for a camera with another format writes that format's
/// colours.
fn pack_for_packed_targets(
    material: SpecializedMaterial,
    descriptor: &mut RenderPipelineDescriptor,
) {
    if material.mesh_key.bits() & PACKED_KEY == 0 {
        return;
    }
    let target_format = material.mesh_key.target_format();
    if target_format == FrameBufferFormat::Rg11b10Ufloat.texture_format()
        && let Some(fragment) = &mut descriptor.fragment
    {
        fragment.shader_defs.push(RG11B10UFLOAT.into());
    }
    for format in PackedFormat::ALL {
        if format.texture_format() == target_format {
            pack(descriptor, format);
        }
    }
}

/// Sets the target format and the shader defs of a pipeline for packed colours. Its shader must support
/// them.
pub(crate) fn pack(descriptor: &mut RenderPipelineDescriptor, format: PackedFormat) {
    let Some(fragment) = &mut descriptor.fragment else {
        return;
    };
    let Some(Some(target)) = fragment.targets.first_mut() else {
        return;
    };
    target.format = format.texture_format();
    if format != PackedFormat::Unorm8 {
        // Packed colours are scene-linear; tone mapping follows the reconstruction.
        fragment.shader_defs.retain(|def| !is_tone_mapping(def));
    } else if let Some(dither) = fragment
        .shader_defs
        .iter_mut()
        .find(|def| matches!(def, ShaderDefVal::Bool(name, true) if name == BEVYS_DITHER))
    {
        *dither = DITHER.into();
    }
    fragment.shader_defs.extend(format.shader_defs());
    let multisample = &descriptor.multisample;
    if multisample.alpha_to_coverage_enabled && multisample.count > 1 {
        let samples = ShaderDefVal::UInt(SAMPLES.into(), multisample.count);
        fragment.shader_defs.extend([COVERAGE.into(), samples]);
    }
}

/// Whether a pipeline has the shader def and the target of this format. Its shader may still not pack.
pub(crate) fn packs(descriptor: &RenderPipelineDescriptor, format: PackedFormat) -> bool {
    let has_def = descriptor
        .fragment
        .as_ref()
        .is_none_or(|fragment| fragment.shader_defs.contains(&PACK.into()));
    has_def && has_format(descriptor, format.into())
}

/// Whether the target of a pipeline has the format, whatever it writes.
pub(crate) fn has_format(descriptor: &RenderPipelineDescriptor, format: FrameBufferFormat) -> bool {
    let fragment = descriptor.fragment.as_ref();
    let target = fragment.and_then(|fragment| fragment.targets.first()?.as_ref());
    target.is_some_and(|target| target.format == format.texture_format())
}

fn is_tone_mapping(def: &ShaderDefVal) -> bool {
    matches!(def, ShaderDefVal::Bool(name, _)
        if name == "TONEMAP_IN_SHADER" || name == BEVYS_DITHER || name.starts_with("TONEMAP_METHOD_"))
}
