//! Pipelines: Bevy's own with other samplers, for the texture unit's anisotropic filter; those of Bevy's patched shaders,
//! which compose and validate, also where the driver here cannot run them, and are asked for as early as Bevy asks for its
//! own.

use bevy::{
    image::ImageSampler,
    prelude::*,
    render::render_resource::{PipelineDescriptor, TextureFormat},
    shader::ShaderDefVal,
};
use bevy_ewa::{
    EwaMaps, EwaMethod, EwaPlugin, EwaProbes, EwaReport, EwaSettings, MipReport,
    material::{layout::MapLayout, pipeline::EwaKey},
};
use bevy_frugal_lab::{
    headless::{HeadlessApp, HeadlessSettings},
    metrics::mse,
};

use super::{
    APPROXIMATE, Floor, all, checked, checkered, checks, colored, materials::MAPS, mips, sampler,
    texture,
};
use crate::support::{
    compose::{mesh_numbers, shader_at},
    composer, gpu, keep, psnr,
};

fn anisotropic() -> EwaSettings {
    EwaSettings::with_method(EwaMethod::Anisotropic)
}

fn size() -> HeadlessSettings {
    HeadlessSettings::with_size(96, 64)
}

/// A floor of checks whose sampler is given by hand, in an app of its own.
fn by_hand(plugin: Option<EwaPlugin>, anisotropy_clamp: u16) -> Floor {
    let floor = Floor::with_settings(size(), plugin, |images| {
        let mut image = checked(true);
        sampler(&mut image).anisotropy_clamp = anisotropy_clamp;
        colored(images.add(image))
    });
    floor.cleared()
}

/// The number of pipelines, and of those with a shader def of the filter.
fn counts(floor: &mut Floor) -> (usize, usize) {
    let is_ours = |def: &ShaderDefVal| match def {
        ShaderDefVal::Bool(name, _) | ShaderDefVal::Int(name, _) | ShaderDefVal::UInt(name, _) => {
            name.contains("EWA")
        }
    };
    let pipelines = floor.pipelines();
    let filtered = pipelines.iter().filter(|pipeline| {
        let PipelineDescriptor::RenderPipelineDescriptor(descriptor) = &pipeline.descriptor else {
            return false;
        };
        let fragment = descriptor.fragment.as_ref();
        fragment.is_some_and(|fragment| fragment.shader_defs.iter().any(is_ours))
    });
    (pipelines.len(), filtered.count())
}

#[test]
fn samplers_get_anisotropy_and_pipelines_stay_bevys_own() {
    let _gpu = gpu();
    let mut stock = by_hand(None, 1);
    let trilinear = stock.picture();
    let expected = by_hand(None, 16).picture();
    let mut floor = by_hand(all(anisotropic()), 1);
    let ours = floor.picture();
    keep("anisotropic_16", &ours);
    keep("anisotropic_1", &trilinear);
    assert!(ours == expected, "{} dB", psnr(&ours, &expected));
    assert_eq!(counts(&mut floor), (counts(&mut stock).0, 0));
    // The driver here heeds anisotropy, and it is worth something.
    let exact = floor.all(Some(EwaSettings::with_method(EwaMethod::Reference)));
    assert!(counts(&mut floor).1 > 0);
    let error = |picture| mse(picture, &exact).expect("equal sizes");
    println!(
        "MSE against exact EWA: 16x {:.1}, trilinear {:.1}",
        error(&ours),
        error(&trilinear)
    );
    assert!(error(&ours) < error(&trilinear) && psnr(&ours, &trilinear) < 30.0);
    // And back.
    assert!(floor.all(None) == trilinear);
    let four = EwaSettings {
        sampler_anisotropy: 4,
        ..anisotropic()
    };
    assert!(floor.all(Some(four)) == by_hand(None, 4).picture());
    assert!(floor.all(Some(anisotropic())) == expected);
}

#[test]
fn a_chosen_material_gets_anisotropy_without_the_others() {
    let _gpu = gpu();
    let mut floor = by_hand(Some(EwaPlugin::OPT_IN), 1);
    assert!(floor.chosen(anisotropic()) == by_hand(None, 16).picture());
    assert_eq!(counts(&mut floor).1, 0);
}

/// The graphics interfaces refuse anisotropy with nearest filters.
#[test]
fn samplers_that_are_not_linear_stay_as_they_are() {
    let _gpu = gpu();
    let nearest = |plugin| {
        let floor = Floor::with_settings(size(), plugin, |images| {
            let mut image = checked(true);
            image.sampler = ImageSampler::nearest();
            colored(images.add(image))
        });
        floor.cleared().picture()
    };
    assert!(nearest(all(anisotropic())) == nearest(None));
}

#[test]
fn maps_that_are_not_chosen_are_the_texture_units() {
    let _gpu = gpu();
    let settings = |maps, sampler_anisotropy| EwaSettings {
        maps,
        sampler_anisotropy,
        ..default()
    };
    let mut floor = by_hand(all(settings(EwaMaps::NONE, 1)), 1);
    assert!(floor.picture() == by_hand(None, 1).picture());
    assert_eq!(counts(&mut floor).1, 0);
    let raised = floor.all(Some(settings(EwaMaps::NONE, 16)));
    assert!(raised == by_hand(None, 16).picture());
    // A texture that an exact method filters keeps its sampler.
    let exact = floor.all(Some(settings(EwaMaps::default(), 1)));
    assert!(floor.all(Some(settings(EwaMaps::default(), 16))) == exact);
}

/// Probes by the texture unit need no more than the setting. Software drivers filter them otherwise, so that only
/// the sampler is checked.
#[test]
fn probes_raise_the_samplers_themselves() {
    let _gpu = gpu();
    let probes = EwaSettings {
        sampler_anisotropy: 16,
        ..EwaSettings::with_method(APPROXIMATE)
    };
    let raised = by_hand(all(probes), 1).picture();
    assert!(raised == by_hand(all(probes), 16).picture());
}

const FRAMES: u32 = 30;

/// The pipelines that a running app asks for in each frame from that on in which a mesh with a new material appears,
/// whose textures come without mip levels, and the mip levels that they have in the end.
fn new_pipelines(plugin: Option<EwaPlugin>) -> (Vec<usize>, Option<MipReport>) {
    let mut floor = Floor::with_settings(size(), plugin, checkered(true));
    let before = floor.pipelines().len();
    let world = floor.app.world_mut();
    let color = world.add_asset(checked(false));
    let normals = checks([150, 128, 240, 255], [106, 128, 240, 255]);
    let normals = texture(false, TextureFormat::Rgba8Unorm, normals);
    let material = StandardMaterial {
        normal_map_texture: Some(world.add_asset(normals)),
        ..colored(color.clone())
    };
    let material = world.add_asset::<StandardMaterial>(material);
    let cube = Mesh::from(Cuboid::from_length(0.4)).with_generated_tangents();
    let cube = world.add_asset(cube.expect("tangents"));
    world.spawn((
        Mesh3d(cube),
        MeshMaterial3d(material),
        Transform::from_xyz(0.2, 0.4, -2.0),
    ));
    let mut counts = Vec::new();
    for _ in 0..FRAMES {
        floor.app.render_frames(1).expect("a frame");
        counts.push(floor.pipelines().len() - before);
    }
    let has_report = floor.app.world().contains_resource::<EwaReport>();
    let levels = has_report.then(|| mips(floor.app.world(), &color));
    (counts, levels.flatten())
}

#[test]
fn a_new_material_asks_for_its_pipelines_in_the_frame_in_which_bevys_does() {
    let _gpu = gpu();
    let (stock, stock_levels) = new_pipelines(None);
    let (filtered, levels) = new_pipelines(Some(EwaPlugin::elliptical()));
    assert_eq!(
        [stock_levels, levels],
        [None, Some(MipReport::Generated(7))]
    );
    assert!(stock.last() > Some(&0), "the material needs new pipelines");
    // The same number in the same frames: none later.
    assert_eq!(filtered, stock);
}

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
    let sets = MAPS.map(|(map, ..)| {
        let map = map.to_uppercase();
        flag(&format!("STANDARD_MATERIAL_{map}_UV_B"))
    });
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
