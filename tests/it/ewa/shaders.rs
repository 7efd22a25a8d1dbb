//! Bevy's patched shaders compose and validate, also those that the driver here cannot run.

use bevy::{
    prelude::*,
    shader::{Shader, ShaderCache, ShaderCacheSource, ShaderDefVal},
};
use bevy_ewa::{EwaMethod, EwaPlugin, EwaProbes, EwaSettings, material::pipeline::EwaKey};
use bevy_frugal_lab::headless::{HeadlessApp, HeadlessSettings};

use crate::support::gpu;

fn flag(name: &str) -> ShaderDefVal {
    ShaderDefVal::from(name)
}

fn number(name: &str, value: u32) -> ShaderDefVal {
    ShaderDefVal::UInt(name.into(), value)
}

/// A mesh with everything and a material with every map, its UV sets from `maps_uv_b`.
fn material(uv_b: bool) -> Vec<ShaderDefVal> {
    let numbers = [
        ("MATERIAL_BIND_GROUP", 3),
        ("MAX_CASCADES_PER_LIGHT", 4),
        ("MAX_DIRECTIONAL_LIGHTS", 10),
        ("AVAILABLE_STORAGE_BUFFER_BINDINGS", 8),
        ("PER_OBJECT_BUFFER_BATCH_SIZE", 64),
        ("TONEMAPPING_LUT_TEXTURE_BINDING_INDEX", 27),
        ("TONEMAPPING_LUT_SAMPLER_BINDING_INDEX", 28),
    ];
    let flags = [
        "VERTEX_UVS",
        "VERTEX_UVS_A",
        "VERTEX_UVS_B",
        "VERTEX_POSITIONS",
        "VERTEX_NORMALS",
        "VERTEX_TANGENTS",
        "VERTEX_OUTPUT_INSTANCE_INDEX",
        "STANDARD_MATERIAL_NORMAL_MAP",
        "STANDARD_MATERIAL_CLEARCOAT",
        "STANDARD_MATERIAL_CLEARCOAT_NORMAL_MAP",
        "STANDARD_MATERIAL_ANISOTROPY",
        "PBR_ANISOTROPY_TEXTURE_SUPPORTED",
        "PBR_TRANSMISSION_TEXTURES_SUPPORTED",
        "PBR_MULTI_LAYER_MATERIAL_TEXTURES_SUPPORTED",
        "PBR_SPECULAR_TEXTURES_SUPPORTED",
        "SHADOW_FILTER_METHOD_GAUSSIAN",
        "TONEMAP_METHOD_NONE",
    ];
    let sets = [
        "BASE_COLOR",
        "SPECULAR",
        "SPECULAR_TINT",
        "EMISSIVE",
        "METALLIC_ROUGHNESS",
        "CLEARCOAT",
        "CLEARCOAT_ROUGHNESS",
        "SPECULAR_TRANSMISSION",
        "THICKNESS",
        "DIFFUSE_TRANSMISSION",
        "OCCLUSION",
        "NORMAL_MAP",
        "CLEARCOAT_NORMAL",
        "ANISOTROPY",
    ];
    let sets = sets.map(|map| flag(&format!("STANDARD_MATERIAL_{map}_UV_B")));
    let numbers = numbers.map(|(name, value)| number(name, value));
    let mut defs: Vec<_> = numbers.into_iter().chain(flags.map(flag)).collect();
    if uv_b {
        defs.extend(sets);
    }
    defs
}

#[test]
fn bevys_shaders_validate_with_and_without_bindless_in_every_pass() {
    let _gpu = gpu();
    let mut app = HeadlessApp::new(HeadlessSettings::with_size(16, 16), |app| {
        app.add_plugins(EwaPlugin::default());
    })
    .expect("an app");
    app.render_frames(3).expect("frames");
    let shaders = app.world().resource::<Assets<Shader>>();
    let mut cache = ShaderCache::<naga::Module, ()>::new(
        (),
        wgpu::Features::all(),
        wgpu::DownlevelFlags::all(),
        |_, source, _| match source {
            ShaderCacheSource::Naga(module) => Ok(module),
            _ => unreachable!("all are WGSL"),
        },
    );
    for (id, shader) in shaders.iter() {
        cache.set_shader(id, shader.clone());
    }
    let find = |end: &str| {
        let found = shaders
            .iter()
            .find(|(_, shader)| shader.path.ends_with(end));
        found.expect("Bevy's shader").0
    };
    let settings = [
        EwaMethod::Linear,
        EwaMethod::SpatialTemporal {
            probes: EwaProbes::Five,
        },
    ];
    let mut count = 0;
    for (file, prepass) in [
        ("render/pbr.wgsl", None),
        ("render/pbr.wgsl", Some("DEFERRED_PREPASS")),
        ("render/pbr_prepass.wgsl", Some("NORMAL_PREPASS")),
    ] {
        for bindless in [false, true] {
            for uv_b in [false, true] {
                for method in settings {
                    let key = EwaKey::new(&EwaSettings::with_method(method), false);
                    let mut defs = material(uv_b);
                    defs.extend(key.shader_defs());
                    if bindless {
                        defs.push(flag("BINDLESS"));
                    }
                    if let Some(kind) = prepass {
                        defs.extend([
                            flag("PREPASS_PIPELINE"),
                            flag("PREPASS_FRAGMENT"),
                            flag("NORMAL_PREPASS_OR_DEFERRED_PREPASS"),
                            flag("MOTION_VECTOR_PREPASS_OR_DEFERRED_PREPASS"),
                            flag("MAY_DISCARD"),
                            flag(kind),
                        ]);
                    }
                    let name =
                        format!("{file} {prepass:?} bindless {bindless} uv_b {uv_b} {method:?}");
                    let module = cache.get(0, find(file), &defs);
                    let module = module.unwrap_or_else(|error| panic!("{name}: {error:?}"));
                    let mut validator = naga::valid::Validator::new(
                        naga::valid::ValidationFlags::all(),
                        naga::valid::Capabilities::all(),
                    );
                    let valid = validator.validate(&module);
                    assert!(valid.is_ok(), "{name}: {valid:?}");
                    count += 1;
                }
            }
        }
    }
    assert_eq!(count, 24);
}
