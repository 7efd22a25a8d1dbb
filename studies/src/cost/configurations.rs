//! What is compiled, by name. Names are those of the studies' measurements where there are any.

use bevy::utils::default;
use bevy_ewa::{EwaKernel, EwaProbes, EwaSettings};
use bevy_voxel_gi::{
    Bounces, Receiver, Solver, VoxelAlbedo, VoxelGiSettings, VoxelGiVolume, VoxelLight, Voxelizer,
};
use bevy_wavelet_tex::{WaveletFilter, codec::rate::Rate};
use bevy_ycocg_fb::{
    FrameBufferQuality, MsaaResolve, PackedFormat, Reconstruction, YCoCgFrameBuffer,
};

use crate::{ewa::SETTINGS, wavelet_tex::tunnel::FILTERS};

/// The plugins, by the names of their studies, each with its default setting.
pub const PLUGINS: [(&str, &str); 4] = [
    ("wavelet_tex", "trilinear"),
    ("ycocg_fb", "default"),
    ("ewa", "anisotropic"),
    ("voxel_gi", "trace"),
];

/// A setting of a plugin, and the scenes in which it is compiled.
#[derive(Clone, Debug)]
pub struct Configuration {
    /// Name of the plugin, or `bevy`.
    pub plugin: &'static str,
    /// Name of the setting.
    pub setting: String,
    /// The plugin and its settings.
    pub kind: Kind,
    /// The scenes.
    pub scenes: Vec<Scene>,
}

/// A plugin and its settings.
#[derive(Clone, Debug)]
pub enum Kind {
    /// Bevy alone.
    Bevy,
    /// Bevy with an irradiance volume of its own.
    IrradianceVolume,
    /// `bevy_ewa` for all materials.
    Ewa(EwaSettings),
    /// `bevy_wavelet_tex`, colours at a rate, or a material without maps.
    Wavelet(WaveletFilter, Option<Rate>),
    /// `bevy_ycocg_fb`.
    FrameBuffer(FrameBufferQuality),
    /// `bevy_voxel_gi`.
    Gi(VoxelGiSettings, VoxelGiVolume),
}

fn configuration(
    plugin: &'static str,
    setting: impl Into<String>,
    kind: Kind,
    scenes: &[Scene],
) -> Configuration {
    Configuration {
        plugin,
        setting: setting.into(),
        kind,
        scenes: scenes.to_vec(),
    }
}

impl Configuration {
    /// Whether its pixels may fetch other texels than those of the plugin's other settings.
    pub fn changes_pixels(&self) -> bool {
        match &self.kind {
            Kind::Gi(settings, volume) => {
                let default = VoxelGiSettings::default();
                let has_cascades = volume.cascades > 1;
                *settings == default
                    || settings.receiver != default.receiver
                    || settings.specular_light
                    || has_cascades
            }
            // Nothing is resolved.
            Kind::FrameBuffer(quality) => *quality != FrameBufferQuality::Compact,
            _ => true,
        }
    }

    /// Its name among all.
    pub fn name(&self) -> String {
        format!("{}: {}", self.plugin, self.setting)
    }
}

/// All configurations; Bevy's own come first.
pub fn configurations() -> Vec<Configuration> {
    let mut all = vec![
        configuration("bevy", "default", Kind::Bevy, &Scene::ALL),
        configuration(
            "bevy",
            "irradiance_volume",
            Kind::IrradianceVolume,
            &Scene::MATERIALS,
        ),
    ];
    all.extend(wavelet_tex());
    all.extend(ycocg_fb());
    all.extend(ewa());
    all.extend(voxel_gi());
    all
}

/// A wavelet material without maps: what its own shader takes.
pub const NO_MAP: &str = "no map";

fn wavelet_tex() -> impl Iterator<Item = Configuration> {
    let filters = FILTERS.iter().map(|filter| {
        let kind = Kind::Wavelet(filter.filter, Some(Rate::Color3));
        configuration("wavelet_tex", filter.name, kind, &Scene::MATERIALS)
    });
    let rates = [Rate::Color2_25, Rate::Color3_25, Rate::Color5, Rate::Color8].map(|rate| {
        let name = format!("trilinear {}", rate.name());
        configuration(
            "wavelet_tex",
            name,
            Kind::Wavelet(default(), Some(rate)),
            &[Scene::BaseColor],
        )
    });
    let none = Kind::Wavelet(default(), None);
    let without = configuration("wavelet_tex", NO_MAP, none, &[Scene::BaseColor]);
    [without].into_iter().chain(filters).chain(rates)
}

fn ycocg_fb() -> impl Iterator<Item = Configuration> {
    let with_quality = |setting: &str, quality, scenes: &[Scene]| {
        configuration("ycocg_fb", setting, Kind::FrameBuffer(quality), scenes)
    };
    let packed = |setting: &str, packed: YCoCgFrameBuffer, scenes: &[Scene]| {
        with_quality(setting, packed.into(), scenes)
    };
    let with = |reconstruction| YCoCgFrameBuffer {
        reconstruction,
        ..default()
    };
    let weighted = YCoCgFrameBuffer {
        msaa_resolve: MsaaResolve::ToneMapWeighted,
        ..default()
    };
    let default_scenes = [
        &Scene::MATERIALS[..],
        &[Scene::Multisampled, Scene::EightBits],
    ]
    .concat();
    let base = &[Scene::BaseColor];
    [
        packed("default", default(), &default_scenes),
        packed("nearest", with(Reconstruction::Nearest), base),
        packed("bilinear", with(Reconstruction::Bilinear), base),
        packed("edge_directed", with(Reconstruction::EdgeDirected), base),
        packed(
            "guided",
            with(Reconstruction::Guided),
            &[Scene::BaseColor, Scene::EightBits],
        ),
        packed("quad", with(Reconstruction::Quad), base),
        packed(
            "float32_default",
            YCoCgFrameBuffer::with_format(PackedFormat::Float32),
            base,
        ),
        packed(
            "unorm8_default",
            YCoCgFrameBuffer::with_format(PackedFormat::Unorm8),
            &[Scene::EightBits],
        ),
        packed("weighted resolve", weighted, &[Scene::Multisampled]),
        with_quality(
            "rg11b10ufloat",
            FrameBufferQuality::Compact,
            &Scene::MATERIALS,
        ),
    ]
    .into_iter()
}

fn ewa() -> impl Iterator<Item = Configuration> {
    let ewa = |name: String, settings, scenes: &[Scene]| {
        configuration("ewa", name, Kind::Ewa(settings), scenes)
    };
    let scenes = [&[Scene::NormalMapped], &Scene::MATERIALS[..]].concat();
    let anisotropic = EwaSettings::with_method(bevy_ewa::EwaMethod::Anisotropic);
    let anisotropic = ewa("anisotropic".into(), anisotropic, &scenes);
    let computed = SETTINGS.iter().filter(|setting| !setting.needs_hardware());
    let computed =
        computed.map(move |setting| ewa(setting.name.into(), setting.settings(1), &scenes));
    let sampled = SETTINGS.iter().filter(|setting| setting.has_probes());
    let sampled = sampled.map(move |setting| {
        let name = format!("{}, 16x sampler", setting.name);
        let scenes = [Scene::BaseColor, Scene::NormalMapped];
        ewa(name, setting.settings(16), &scenes)
    });
    let kernel = EwaSettings {
        kernel: EwaKernel::Lanczos,
        ..default()
    };
    let probes = EwaSettings::with_method(bevy_ewa::EwaMethod::Approximate {
        probes: EwaProbes::ByAspect,
    });
    computed.chain(sampled).chain([
        anisotropic,
        ewa("linear, Lanczos".into(), kernel, &[Scene::BaseColor]),
        ewa(
            "approximate, probes by aspect".into(),
            probes,
            &[Scene::BaseColor],
        ),
    ])
}

fn voxel_gi() -> impl Iterator<Item = Configuration> {
    let gi_in = |volume, name: &str, settings, scenes: &[Scene]| {
        configuration("voxel_gi", name, Kind::Gi(settings, volume), scenes)
    };
    let fixed = || VoxelGiVolume::fixed(16.0);
    let gi = |name: &str, settings, scenes: &[Scene]| gi_in(fixed(), name, settings, scenes);
    let base = &[Scene::BaseColor];
    let light = |light| VoxelGiSettings { light, ..default() };
    let trace = |bounces| {
        light(VoxelLight::GlobalIllumination {
            solver: Solver::default(),
            bounces,
        })
    };
    let propagate = VoxelLight::GlobalIllumination {
        solver: Solver::Propagate { iterations: 96 },
        bounces: Bounces::default(),
    };
    let occlusion = VoxelLight::AmbientOcclusion {
        radius: 1.0,
        rays: 16,
    };
    let voxelizer = |voxelizer| VoxelGiSettings {
        voxelizer,
        ..default()
    };
    let per_pixel = VoxelGiSettings {
        receiver: Receiver::PerPixel,
        ..default()
    };
    let specular = VoxelGiSettings {
        specular_light: true,
        ..default()
    };
    let default_scenes = [&Scene::MATERIALS[..], &[Scene::TexturedLight]].concat();
    [
        gi("trace", default(), &default_scenes),
        gi("trace 4 bounces", trace(Bounces::Count(4)), base),
        gi("trace per pixel", per_pixel, &Scene::MATERIALS),
        gi("trace specular", specular.clone(), &Scene::MATERIALS),
        gi_in(default(), "trace specular cascades", specular, base),
        gi_in(default(), "trace cascades", default(), base),
        gi(
            "trace fragment_clipping",
            voxelizer(Voxelizer::FragmentClipping),
            base,
        ),
        gi(
            "trace geometry_clipping",
            voxelizer(Voxelizer::GeometryClipping),
            base,
        ),
        gi(
            "trace stochastic",
            voxelizer(Voxelizer::Stochastic { points: 256 }),
            base,
        ),
        gi(
            "trace reprojected albedo",
            VoxelGiSettings {
                albedo: VoxelAlbedo::Reprojected,
                ..default()
            },
            &[Scene::Deferred],
        ),
        gi(
            "trace stochastic reprojected albedo",
            VoxelGiSettings {
                albedo: VoxelAlbedo::Reprojected,
                ..voxelizer(Voxelizer::Stochastic { points: 16 })
            },
            &[Scene::Deferred],
        ),
        gi("propagate", light(propagate), base),
        gi("ambient_occlusion", light(occlusion), base),
    ]
    .into_iter()
}

/// What is drawn, and how. A camera is `Hdr`, without multisampling, unless it says otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scene {
    /// A texture of the base colour.
    BaseColor,
    /// Textures of the base colour and of normals.
    NormalMapped,
    /// The five maps of a glTF material.
    FiveMaps,
    /// A texture of the base colour, parts of which are cut out, with prepasses of depth, normals and motion.
    Masked,
    /// The five maps, drawn deferred.
    Deferred,
    /// The base colour with four samples a pixel.
    Multisampled,
    /// The base colour in a camera without `Hdr`.
    EightBits,
    /// The base colour, lit by a light with a texture, too.
    TexturedLight,
}

impl Scene {
    /// The scenes in which materials differ.
    pub const MATERIALS: [Self; 4] = [
        Self::BaseColor,
        Self::FiveMaps,
        Self::Masked,
        Self::Deferred,
    ];
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::BaseColor,
        Self::NormalMapped,
        Self::FiveMaps,
        Self::Masked,
        Self::Deferred,
        Self::Multisampled,
        Self::EightBits,
    ];

    /// Its name in the rows.
    pub const fn material(self) -> &'static str {
        match self {
            Self::BaseColor => "base color",
            Self::NormalMapped => "base color, normals",
            Self::FiveMaps => "five maps",
            Self::Masked => "alpha mask",
            Self::Deferred => "five maps, deferred",
            Self::Multisampled => "base color, 4 samples",
            Self::EightBits => "base color, 8 bits",
            Self::TexturedLight => "base color, light with a texture",
        }
    }

    /// Whether the material has the five maps of glTF.
    pub fn has_five_maps(self) -> bool {
        matches!(self, Self::FiveMaps | Self::Deferred)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_defaults_are_compiled_in_every_scene() {
        let all = configurations();
        for a in &all {
            let same = all.iter().filter(|b| b.name() == a.name());
            assert_eq!(same.count(), 1, "{}", a.name());
        }
        for name in PLUGINS {
            let found = all.iter().find(|c| (c.plugin, c.setting.as_str()) == name);
            let scenes = &found.expect("a default").scenes;
            assert!(
                Scene::MATERIALS.iter().all(|scene| scenes.contains(scene)),
                "{name:?}"
            );
        }
    }
}
