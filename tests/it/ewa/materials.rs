//! Bevy's materials: those that are filtered, in every pass, and those that are not.

use bevy::{
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass, MotionVectorPrepass, NormalPrepass},
    material::OpaqueRendererMethod,
    mesh::UvChannel,
    prelude::*,
    render::render_resource::TextureFormat,
};
use bevy_ewa::{
    EwaMaps, EwaMethod, EwaPlugin, EwaProbes, EwaSettings, material::patches::ALL as PATCHES,
};
use bevy_frugal_hooks::ShaderPatches;

use super::scene::{Floor, all, checkered, checks, texture};
use crate::support::{gpu, keep, psnr, skipped};

const REFERENCE: EwaSettings = EwaSettings {
    method: EwaMethod::Reference,
    maps: EwaMaps::ALL,
    kernel: bevy_ewa::EwaKernel::Gaussian { sigma_pixels: 0.5 },
    max_anisotropy: 32.0,
    minor_radius_texels: 1.5,
    level_of_detail: bevy_ewa::EwaLevelOfDetail::MinorRadius,
    level_blend: 0.25,
    max_fetches: 2048,
    spatial_threshold: 16.0,
    sampler_anisotropy: 1,
    periodic: true,
};

#[test]
fn materials_that_did_not_ask_are_the_same_byte_for_byte() {
    let _gpu = gpu();
    let stock = Floor::new(None, checkered(true)).picture();
    let mut floor = Floor::new(Some(EwaPlugin::OPT_IN), checkered(true));
    assert!(floor.picture() == stock);
    let patches = floor.app.world().resource::<ShaderPatches>();
    assert!(
        patches.all_applied(PATCHES),
        "{:?}",
        patches.refused(PATCHES)
    );
    let hardware = EwaSettings::with_method(EwaMethod::Hardware);
    assert!(floor.all(Some(hardware)) == stock);
    assert!(floor.all(Some(REFERENCE)) != stock);
    assert!(floor.all(None) == stock, "back to Bevy's own");
}

#[test]
fn all_materials_and_chosen_ones_are_filtered_alike() {
    let _gpu = gpu();
    let mut floor = Floor::new(Some(EwaPlugin::OPT_IN), checkered(true));
    keep("stock_with_post", &floor.picture());
    keep("filtered_with_post", &floor.all(Some(REFERENCE)));
    floor.all(None);
    floor.clear();
    let stock = floor.picture();
    keep("stock", &stock);
    for method in [
        EwaMethod::Linear,
        EwaMethod::Approximate {
            probes: EwaProbes::Five,
        },
    ] {
        let settings = EwaSettings::with_method(method);
        let mut floor = Floor::new(Some(EwaPlugin::OPT_IN), checkered(true));
        floor.clear();
        let chosen = floor.chosen(settings);
        keep("chosen", &chosen);
        let mut floor = Floor::new(all(settings), checkered(true));
        floor.clear();
        let filtered = floor.picture();
        keep("all", &filtered);
        assert!(psnr(&stock, &filtered) < 40.0, "{method:?} changed little");
        assert!(
            filtered == chosen,
            "{method:?}: {} dB",
            psnr(&filtered, &chosen)
        );
    }
}

#[test]
fn handles_and_later_edits_stay() {
    let _gpu = gpu();
    let mut floor = Floor::new(all(REFERENCE), checkered(true));
    let before = floor.picture();
    let handle = floor.material.clone();
    let mut edit = |color: Color| {
        let mut materials = floor
            .app
            .world_mut()
            .resource_mut::<Assets<StandardMaterial>>();
        materials.get_mut(&handle).expect("the material").base_color = color;
        floor.picture()
    };
    let red = edit(Color::srgb(1.0, 0.2, 0.2));
    assert!(red != before);
    assert!(edit(Color::WHITE) == before);
}

/// Puts one map on a plain material.
type Put = fn(&mut StandardMaterial, Handle<Image>, UvChannel);

/// Every map that Bevy samples, whether it is in sRGB, and the PSNR in dB of the filtered picture to Bevy's own that
/// it stays below: what its filter changes is seen. Pictures without a change have an infinite one.
const MAPS: [(&str, bool, f64, Put); 14] = [
    ("base_color", true, 52.5, |m, t, uv| {
        m.base_color_texture = Some(t);
        m.base_color_channel = uv;
    }),
    ("emissive", true, 41.0, |m, t, uv| {
        m.emissive = LinearRgba::gray(0.5);
        m.emissive_texture = Some(t);
        m.emissive_channel = uv;
    }),
    ("metallic_roughness", false, 36.5, |m, t, uv| {
        m.metallic = 1.0;
        m.perceptual_roughness = 1.0;
        m.metallic_roughness_texture = Some(t);
        m.metallic_roughness_channel = uv;
    }),
    ("normal_map", false, 20.5, |m, t, uv| {
        m.normal_map_texture = Some(t);
        m.normal_map_channel = uv;
    }),
    ("occlusion", false, 35.5, |m, t, uv| {
        m.occlusion_texture = Some(t);
        m.occlusion_channel = uv;
    }),
    ("specular", false, 30.5, |m, t, uv| {
        m.metallic = 0.0;
        m.reflectance = 1.0;
        m.specular_texture = Some(t);
        m.specular_channel = uv;
    }),
    ("specular_tint", true, 27.5, |m, t, uv| {
        m.reflectance = 1.0;
        m.specular_tint_texture = Some(t);
        m.specular_tint_channel = uv;
    }),
    ("clearcoat", false, 49.0, |m, t, uv| {
        m.clearcoat = 1.0;
        m.clearcoat_texture = Some(t);
        m.clearcoat_channel = uv;
    }),
    ("clearcoat_roughness", false, 37.5, |m, t, uv| {
        m.clearcoat = 1.0;
        m.clearcoat_perceptual_roughness = 1.0;
        m.clearcoat_roughness_texture = Some(t);
        m.clearcoat_roughness_channel = uv;
    }),
    ("clearcoat_normal", false, 33.5, |m, t, uv| {
        m.clearcoat = 1.0;
        m.clearcoat_normal_texture = Some(t);
        m.clearcoat_normal_channel = uv;
    }),
    ("specular_transmission", false, 53.0, |m, t, uv| {
        m.specular_transmission = 1.0;
        m.specular_transmission_texture = Some(t);
        m.specular_transmission_channel = uv;
    }),
    ("thickness", false, 71.5, |m, t, uv| {
        m.specular_transmission = 0.9;
        m.thickness = 3.0;
        m.attenuation_distance = 1.0;
        m.attenuation_color = Color::srgb(0.1, 0.6, 0.2);
        m.thickness_texture = Some(t);
        m.thickness_channel = uv;
    }),
    ("diffuse_transmission", false, 59.5, |m, t, uv| {
        m.diffuse_transmission = 1.0;
        m.diffuse_transmission_texture = Some(t);
        m.diffuse_transmission_channel = uv;
    }),
    ("anisotropy", false, 31.5, |m, t, uv| {
        m.metallic = 1.0;
        m.perceptual_roughness = 0.4;
        m.anisotropy_strength = 1.0;
        m.anisotropy_texture = Some(t);
        m.anisotropy_channel = uv;
    }),
];

#[test]
fn every_map_is_filtered_with_its_own_coordinates() {
    let _gpu = gpu();
    let mut floor = Floor::new(Some(EwaPlugin::OPT_IN), checkered(true));
    floor.clear();
    // Occlusion is of ambient light.
    let ambient = GlobalAmbientLight {
        brightness: 2000.0,
        ..default()
    };
    let world = floor.app.world_mut();
    world.insert_resource(ambient);
    // Transmission is of what is behind, and highlights are where the sun is opposite.
    world.insert_resource(ClearColor(Color::linear_rgb(4.0, 0.0, 0.0)));
    let mut suns = world.query_filtered::<&mut Transform, With<DirectionalLight>>();
    for mut sun in suns.iter_mut(world) {
        *sun = Transform::from_xyz(1.0, 1.2, -5.0).looking_at(Vec3::ZERO, Vec3::Y);
    }
    for (i, (name, srgb, most, put)) in MAPS.into_iter().enumerate() {
        let format = if srgb {
            TextureFormat::Rgba8UnormSrgb
        } else {
            TextureFormat::Rgba8Unorm
        };
        // Each set for half of the maps: a pipeline takes its time here.
        let uv = if i % 2 == 0 {
            UvChannel::Uv1
        } else {
            UvChannel::Uv0
        };
        floor.lay(|images| {
            // As normals and as tangents, opposite slopes.
            let checks = checks([230, 200, 230, 255], [26, 40, 60, 40]);
            let map = images.add(texture(true, format, checks));
            let mut material = StandardMaterial {
                perceptual_roughness: 0.3,
                base_color: Color::srgb(0.3, 0.3, 0.3),
                ..default()
            };
            put(&mut material, map, uv.clone());
            material
        });
        let stock = floor.all(None);
        let filtered = floor.all(Some(EwaSettings {
            maps: EwaMaps::ALL,
            ..default()
        }));
        keep(&format!("{name}_stock"), &stock);
        keep(&format!("{name}_ewa"), &filtered);
        let changed = psnr(&stock, &filtered);
        println!("{name} {uv:?}: {changed:.1} dB from Bevy's own");
        assert!(changed < most, "{name}: {changed} dB");
    }
}

#[test]
fn every_pass_filters_alike() {
    let _gpu = gpu();
    let material = |images: &mut Assets<Image>| {
        let normals = checks([200, 128, 230, 255], [56, 128, 230, 255]);
        StandardMaterial {
            normal_map_texture: Some(images.add(texture(true, TextureFormat::Rgba8Unorm, normals))),
            ..checkered(true)(images)
        }
    };
    let mut floor = Floor::new(all(REFERENCE), material);
    let is_mesa_22 = floor.app.adapter().driver.contains("Mesa 22.");
    let forward = floor.picture();
    let camera = floor.camera;
    let mut with = |change: &dyn Fn(&mut EntityWorldMut)| {
        change(&mut floor.app.world_mut().entity_mut(camera));
        floor.picture()
    };
    let depth = with(&|camera| {
        camera.insert(DepthPrepass);
    });
    assert!(forward == depth, "a prepass cuts other holes into the post");
    let normals = with(&|camera| {
        camera.insert(NormalPrepass);
    });
    let found = psnr(&forward, &normals);
    println!("normal prepass: {found:.1} dB");
    assert!(found > 40.0, "normals of the prepass: {found}");
    let motion = with(&|camera| {
        camera.insert(MotionVectorPrepass);
    });
    if is_mesa_22 {
        skipped(
            "motion-vector prepasses, which llvmpipe of Mesa 22 cannot compile with the filter",
        );
    } else {
        assert!(
            normals == motion,
            "a motion-vector prepass cuts other holes"
        );
    }
    let mut floor = Floor::new(all(REFERENCE), |images| {
        let mut material = material(images);
        material.opaque_render_method = OpaqueRendererMethod::Deferred;
        material
    });
    let camera = floor.camera;
    let mut camera = floor.app.world_mut().entity_mut(camera);
    camera.insert((DepthPrepass, DeferredPrepass));
    let deferred = floor.picture();
    keep("deferred", &deferred);
    keep("forward", &forward);
    let found = psnr(&forward, &deferred);
    println!("deferred: {found:.1} dB");
    assert!(found > 35.0, "deferred: {found}");
    let stock = floor.all(None);
    assert!(psnr(&stock, &deferred) < 40.0);
}
