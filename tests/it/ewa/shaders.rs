//! Bevy's patched shaders compose and validate, also those that the driver here cannot run.

use bevy::shader::ShaderDefVal;
use bevy_ewa::{
    EwaMethod, EwaPlugin, EwaProbes, EwaSettings,
    material::{layout::MapLayout, pipeline::EwaKey},
};
use bevy_frugal_lab::headless::{HeadlessApp, HeadlessSettings};

use crate::support::{
    compose::{mesh_numbers, shader_at},
    composer, gpu,
};

fn flag(name: &str) -> ShaderDefVal {
    ShaderDefVal::from(name.to_owned())
}

/// A mesh with everything and a material with every map, its UV sets from `maps_uv_b`.
fn material(uv_b: bool) -> Vec<ShaderDefVal> {
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
    let mut defs = mesh_numbers();
    defs.extend(flags.map(flag));
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
    let mut composer = composer(&mut app);
    let settings = [
        EwaMethod::Linear,
        EwaMethod::SpatialTemporal {
            probes: EwaProbes::Five,
        },
    ];
    // The five maps that can share a loop do, or all maps have loops of their own.
    let layouts = [
        MapLayout::of_masks(0b11111, 0x3fe0),
        MapLayout::of_masks(0b00110, 0).with_parallax(true),
        MapLayout::of_masks(0, 0x3fff),
    ];
    let mut count = 0;
    for (file, prepass) in [
        ("render/pbr.wesl", None),
        ("render/pbr.wesl", Some("DEFERRED_PREPASS")),
        ("render/pbr_prepass.wesl", Some("NORMAL_PREPASS")),
    ] {
        for bindless in [false, true] {
            for uv_b in [false, true] {
                for (method, layout) in settings
                    .into_iter()
                    .flat_map(|method| layouts.map(|l| (method, l)))
                {
                    let key = EwaKey::new(&EwaSettings::with_method(method), false);
                    let mut defs = material(uv_b);
                    defs.extend(key.expect("a method in shaders").shader_defs(layout));
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
                    let name = format!(
                        "{file} {prepass:?} bindless {bindless} uv_b {uv_b} {method:?} {layout:?}"
                    );
                    let valid = composer.compose(shader_at(app.world(), file), &defs);
                    assert!(valid.is_ok(), "{name}: {}", valid.unwrap_err());
                    count += 1;
                }
            }
        }
    }
    assert_eq!(count, 72);
}
