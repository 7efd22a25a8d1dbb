//! A tunnel without end and a game's floor, filtered by one method on each side of the line.

use bevy::{
    asset::{AssetPath, embedded_asset, embedded_path},
    mesh::MeshVertexBufferLayoutRef,
    pbr::{Material, MaterialPipeline, MaterialPipelineKey, MaterialPlugin},
    prelude::*,
    render::render_resource::{
        AsBindGroup, RenderPipelineDescriptor, SpecializedMeshPipelineError,
    },
    shader::ShaderRef,
};
use bevy_ewa::{
    EwaKernel, EwaLevelOfDetail, EwaMaps, EwaMethod, EwaPlugin, EwaProbes, EwaSettings, EwaUniform,
};

use crate::runner::{Scene, SceneSetting, SceneSettings, Side};

mod stage;

/// The example of `bevy_ewa`.
pub struct Ewa;

impl Scene for Ewa {
    fn name(&self) -> &'static str {
        "ewa"
    }

    fn plugin(&self) -> &'static str {
        "bevy_ewa"
    }

    fn description(&self) -> &'static str {
        "Texture filtering: a tunnel or a floor, by any method before and any after"
    }

    fn settings(&self) -> Vec<SceneSetting> {
        vec![
            SceneSetting::choice("place", "what there is to see", 0, &["tunnel", "floor"]),
            SceneSetting::choice(
                "view",
                "the picture; the ellipse of every 16th pixel in its texture; red where the \
                 anisotropy exceeds spatial_threshold",
                0,
                &["picture", "ellipses", "regions"],
            ),
            SceneSetting::choice(
                "before",
                "method left of the line; hardware is the sampler as it is, anisotropic with 16x",
                HARDWARE,
                &METHODS,
            ),
            SceneSetting::choice("after", "method right of the line", LINEAR, &METHODS),
            SceneSetting::choice(
                "probes",
                "of the approximate, spatial and temporal methods",
                1,
                &["3", "5", "7", "by_aspect"],
            ),
            SceneSetting::choice(
                "kernel",
                "of the exact methods",
                2,
                &["box", "tent", "gaussian", "mitchell_netravali", "lanczos"],
            ),
            SceneSetting::float(
                "sigma",
                "standard deviation of the Gaussian",
                0.5,
                0.2..=1.5,
                "pixels",
            ),
            SceneSetting::float(
                "max_anisotropy",
                "longest ellipse, in widths",
                32.0,
                1.0..=128.0,
                "",
            ),
            SceneSetting::float(
                "minor_radius",
                "least minor radius in the chosen mip level",
                1.5,
                0.5..=4.0,
                "texels",
            ),
            SceneSetting::choice(
                "level_of_detail",
                "what the mip level is chosen by",
                0,
                &["minor_radius", "hardware"],
            ),
            SceneSetting::float(
                "level_blend",
                "part of the way to the next mip level in which both are blended",
                0.25,
                0.0..=1.0,
                "",
            ),
            SceneSetting::integer(
                "max_fetches",
                "most fetches of a lookup of the exact methods",
                2048,
                16..=4096,
                "",
            ),
            SceneSetting::float(
                "spatial_threshold",
                "anisotropy above which spatial works",
                16.0,
                2.0..=64.0,
                "",
            ),
            SceneSetting::integer(
                "sampler_anisotropy",
                "of the samplers: 1 computes probes, more leaves them to the texture unit",
                1,
                1..=16,
                "",
            ),
            SceneSetting::toggle("motion", "the texture drifts", true),
        ]
    }

    fn view(&self) -> Transform {
        Transform::from_xyz(0.0, 0.0, 0.0).looking_to(Vec3::new(0.12, -0.08, -1.0), Vec3::Y)
    }

    fn build(&self, app: &mut App) {
        embed(app);
        app.add_plugins((EwaPlugin::OPT_IN, MaterialPlugin::<ViewMaterial>::default()))
            .init_resource::<stage::Textures>()
            .add_systems(Startup, stage::spawn)
            .add_systems(
                Update,
                (
                    stage::show_place,
                    stage::configure.run_if(resource_changed::<crate::runner::SceneSettings>),
                    stage::drift,
                )
                    .chain(),
            );
    }
}

/// The methods in the panel.
pub const METHODS: [&str; 11] = [
    "reference",
    "linear",
    "bilinear",
    "approximate",
    "spatial",
    "temporal",
    "spatial_temporal",
    "stochastic",
    "software_af16",
    "anisotropic",
    "hardware",
];
/// Index of Bevy's own.
pub const HARDWARE: usize = 10;
/// Index of the default.
pub const LINEAR: usize = 1;

pub fn ewa_settings(settings: &SceneSettings, side: Side) -> EwaSettings {
    let probes = match settings.choice("probes") {
        "3" => EwaProbes::Three,
        "7" => EwaProbes::Seven,
        "by_aspect" => EwaProbes::ByAspect,
        _ => EwaProbes::Five,
    };
    let method = settings.choice(match side {
        Side::Before => "before",
        Side::After => "after",
    });
    let method = match method {
        "reference" => EwaMethod::Reference,
        "linear" => EwaMethod::Linear,
        "bilinear" => EwaMethod::Bilinear,
        "approximate" => EwaMethod::Approximate { probes },
        "spatial" => EwaMethod::Spatial { probes },
        "temporal" => EwaMethod::Temporal { probes },
        "spatial_temporal" => EwaMethod::SpatialTemporal { probes },
        "stochastic" => EwaMethod::Stochastic,
        "software_af16" => EwaMethod::SoftwareAnisotropic,
        "anisotropic" => EwaMethod::Anisotropic,
        _ => EwaMethod::Hardware,
    };
    let kernel = match settings.choice("kernel") {
        "box" => EwaKernel::Box,
        "tent" => EwaKernel::Tent,
        "mitchell_netravali" => EwaKernel::MitchellNetravali,
        "lanczos" => EwaKernel::Lanczos,
        _ => EwaKernel::Gaussian {
            sigma_pixels: settings.float("sigma"),
        },
    };
    let level_of_detail = match settings.choice("level_of_detail") {
        "hardware" => EwaLevelOfDetail::Hardware,
        _ => EwaLevelOfDetail::MinorRadius,
    };
    EwaSettings {
        method,
        maps: EwaMaps::default(),
        kernel,
        max_anisotropy: settings.float("max_anisotropy"),
        minor_radius_texels: settings.float("minor_radius"),
        level_of_detail,
        level_blend: settings.float("level_blend"),
        max_fetches: settings.integer("max_fetches"),
        spatial_threshold: settings.float("spatial_threshold"),
        sampler_anisotropy: settings.integer("sampler_anisotropy") as u16,
        periodic: true,
    }
}

#[derive(Asset, AsBindGroup, TypePath, Clone, Debug)]
pub struct ViewMaterial {
    #[uniform(0)]
    settings: EwaUniform,
    /// 0 for ellipses, 1 for regions.
    #[uniform(1)]
    view: Vec4,
    #[texture(2)]
    #[sampler(3)]
    texture: Handle<Image>,
}

impl ViewMaterial {
    pub fn new(view: &str, settings: &EwaSettings, texture: Handle<Image>) -> Self {
        let view = if view == "regions" { 1.0 } else { 0.0 };
        Self {
            settings: EwaUniform::new(settings),
            view: Vec4::splat(view),
            texture,
        }
    }
}

impl Material for ViewMaterial {
    fn fragment_shader() -> ShaderRef {
        ShaderRef::Path(AssetPath::from(embedded_path!("view.wesl")).with_source("embedded"))
    }

    fn specialize(
        _: &MaterialPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        _: &MeshVertexBufferLayoutRef,
        _: MaterialPipelineKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        descriptor.primitive.cull_mode = None;
        Ok(())
    }
}

/// Puts the shader into the binary.
pub fn embed(app: &mut App) {
    embedded_asset!(app, "view.wesl");
}
