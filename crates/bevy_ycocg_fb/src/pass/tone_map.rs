//! Tone mapping in the resolve, where no later pass of Bevy does it.

use bevy::{
    core_pipeline::tonemapping::{DebandDither, Tonemapping, TonemappingPipelineKeyFlags},
    prelude::*,
    render::view::ExtractedView,
    shader::ShaderDefVal,
};

/// The part of the pipeline key that selects the tone mapping.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct ToneMap {
    method: Tonemapping,
    dither: DebandDither,
    flags: TonemappingPipelineKeyFlags,
}

impl ToneMap {
    /// Returns the tone mapping of a view, as Bevy's own pass would do it.
    pub(super) fn of(
        view: &ExtractedView,
        method: Tonemapping,
        dither: Option<&DebandDither>,
    ) -> Self {
        let grading = &view.color_grading;
        let mut flags = TonemappingPipelineKeyFlags::empty();
        flags.set(
            TonemappingPipelineKeyFlags::HUE_ROTATE,
            grading.global.hue != 0.0,
        );
        flags.set(
            TonemappingPipelineKeyFlags::WHITE_BALANCE,
            grading.global.temperature != 0.0 || grading.global.tint != 0.0,
        );
        flags.set(
            TonemappingPipelineKeyFlags::SECTIONAL_COLOR_GRADING,
            grading.all_sections().any(|section| *section != default()),
        );
        Self {
            method,
            dither: dither.copied().unwrap_or_default(),
            flags,
        }
    }

    /// Returns the shader defs of Bevy's own tone mapping pass.
    pub(super) fn shader_defs(self) -> Vec<ShaderDefVal> {
        let mut defs: Vec<ShaderDefVal> = vec![
            "YCOCG_FB_TONE_MAP".into(),
            ShaderDefVal::UInt("TONEMAPPING_LUT_TEXTURE_BINDING_INDEX".into(), 2),
            ShaderDefVal::UInt("TONEMAPPING_LUT_SAMPLER_BINDING_INDEX".into(), 3),
        ];
        let flags = [
            (TonemappingPipelineKeyFlags::HUE_ROTATE, "HUE_ROTATE"),
            (TonemappingPipelineKeyFlags::WHITE_BALANCE, "WHITE_BALANCE"),
            (
                TonemappingPipelineKeyFlags::SECTIONAL_COLOR_GRADING,
                "SECTIONAL_COLOR_GRADING",
            ),
        ];
        defs.extend(
            flags
                .into_iter()
                .filter(|(flag, _)| self.flags.contains(*flag))
                .map(|(_, def)| def.into()),
        );
        if self.dither == DebandDither::Enabled {
            defs.push("DEBAND_DITHER".into());
        }
        defs.push(
            match self.method {
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
            }
            .into(),
        );
        defs
    }
}
