//! Bevy's materials: those that are filtered, in every pass, and those that are not. Maps of one size and UV set, which
//! share a loop, look like maps with loops of their own.

use bevy::{
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass, MotionVectorPrepass, NormalPrepass},
    material::OpaqueRendererMethod,
    mesh::UvChannel,
    prelude::*,
    reflect::structs::Struct,
    render::render_resource::TextureFormat,
};
use bevy_ewa::{EwaMaps, EwaMethod, EwaPlugin, EwaSettings, material::patches::ALL as PATCHES};
use bevy_frugal_hooks::ShaderPatches;
use image::RgbImage;

use super::{APPROXIMATE, Floor, all, checkered, checks, texture};
use crate::support::{drawn, gpu, keep, psnr, skipped};

/// The exact filter of all maps.
fn reference() -> EwaSettings {
    EwaSettings {
        maps: EwaMaps::ALL,
        ..EwaSettings::with_method(EwaMethod::Reference)
    }
}

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
    assert!(floor.all(Some(reference())) != stock);
    assert!(floor.all(None) == stock, "back to Bevy's own");
}

#[test]
fn all_materials_and_chosen_ones_are_filtered_alike() {
    let _gpu = gpu();
    let mut floor = Floor::new(Some(EwaPlugin::OPT_IN), checkered(true));
    keep("stock_with_post", &floor.picture());
    keep("filtered_with_post", &floor.all(Some(reference())));
    floor.all(None);
    let mut floor = floor.cleared();
    let stock = floor.picture();
    keep("stock", &stock);
    for method in [EwaMethod::Linear, APPROXIMATE] {
        let settings = EwaSettings::with_method(method);
        let floor = Floor::new(Some(EwaPlugin::OPT_IN), checkered(true));
        let chosen = floor.cleared().chosen(settings);
        keep("chosen", &chosen);
        let floor = Floor::new(all(settings), checkered(true));
        let filtered = floor.cleared().picture();
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
    let mut floor = Floor::new(all(reference()), checkered(true));
    let before = floor.picture();
    let handle = floor.material.clone();
    let mut edit = |color: Color| {
        let world = floor.app.world_mut();
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        materials.get_mut(&handle).expect("the material").base_color = color;
        floor.picture()
    };
    let red = edit(Color::srgb(1.0, 0.2, 0.2));
    assert!(red != before);
    assert!(edit(Color::WHITE) == before);
}

/// Every map that Bevy samples, whether it is in sRGB, the PSNR in dB of the filtered picture to Bevy's own that it stays
/// below, and what it needs of its material: what its filter changes is seen. Pictures without a change have an infinite
/// one.
pub const MAPS: [(&str, bool, f64, fn(&mut StandardMaterial)); 14] = [
    ("base_color", true, 52.5, |_| {}),
    ("emissive", true, 41.0, |m| {
        m.emissive = LinearRgba::gray(0.5);
    }),
    ("metallic_roughness", false, 36.5, |m| {
        m.metallic = 1.0;
        m.perceptual_roughness = 1.0;
    }),
    ("normal_map", false, 20.5, |_| {}),
    ("occlusion", false, 35.5, |_| {}),
    ("specular", false, 30.5, |m| {
        m.metallic = 0.0;
        m.reflectance = 1.0;
    }),
    ("specular_tint", true, 27.5, |m| m.reflectance = 1.0),
    ("clearcoat", false, 49.0, |m| m.clearcoat = 1.0),
    ("clearcoat_roughness", false, 37.5, |m| {
        m.clearcoat = 1.0;
        m.clearcoat_perceptual_roughness = 1.0;
    }),
    ("clearcoat_normal", false, 33.5, |m| m.clearcoat = 1.0),
    ("specular_transmission", false, 53.0, |m| {
        m.specular_transmission = 1.0;
    }),
    ("thickness", false, 71.5, |m| {
        m.specular_transmission = 0.9;
        m.thickness = 3.0;
        m.attenuation_distance = 1.0;
        m.attenuation_color = Color::srgb(0.1, 0.6, 0.2);
    }),
    ("diffuse_transmission", false, 59.5, |m| {
        m.diffuse_transmission = 1.0;
    }),
    ("anisotropy", false, 31.5, |m| {
        m.metallic = 1.0;
        m.perceptual_roughness = 0.4;
        m.anisotropy_strength = 1.0;
    }),
];

/// Puts a map on a material.
fn put(material: &mut StandardMaterial, map: &str, texture: Handle<Image>, uv: UvChannel) {
    let field = material.field_mut(&format!("{map}_texture"));
    let field = field.and_then(|field| field.try_downcast_mut());
    *field.expect("a texture") = Some(texture);
    let field = material.field_mut(&format!("{map}_channel"));
    let field = field.and_then(|field| field.try_downcast_mut());
    *field.expect("a channel") = uv;
}

#[test]
fn every_map_is_filtered_with_its_own_coordinates() {
    let _gpu = gpu();
    let mut floor = Floor::new(Some(EwaPlugin::OPT_IN), checkered(true)).cleared();
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
    for (i, (name, srgb, most, prepare)) in drawn(5, MAPS.into_iter().enumerate()) {
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
            prepare(&mut material);
            put(&mut material, name, map, uv.clone());
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
    let mut floor = Floor::new(all(reference()), material);
    let is_mesa_22 = floor.app.adapter().driver.contains("Mesa 22.");
    let forward = floor.picture();
    fn with(floor: &mut Floor, prepass: impl Component) -> RgbImage {
        let camera = floor.camera;
        floor.app.world_mut().entity_mut(camera).insert(prepass);
        floor.picture()
    }
    let depth = with(&mut floor, DepthPrepass);
    assert!(forward == depth, "a prepass cuts other holes into the post");
    let normals = with(&mut floor, NormalPrepass);
    let found = psnr(&forward, &normals);
    println!("normal prepass: {found:.1} dB");
    assert!(found > 40.0, "normals of the prepass: {found}");
    let motion = with(&mut floor, MotionVectorPrepass);
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
    let mut floor = Floor::new(all(reference()), |images| {
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

/// A texture without its coarsest mip levels, so that it differs in shape but hardly in the picture.
fn without_levels(mut image: Image, count: u32) -> Image {
    image.texture_descriptor.mip_level_count -= count;
    // Levels of 1 x 1 texel, of 2 x 2 and so on, of four bytes each.
    let bytes: usize = (0..count).map(|level| 4 << (2 * level)).sum();
    let data = image.data.as_mut().expect("data");
    data.truncate(data.len() - bytes);
    image
}

/// A lit floor with a base colour, emission and normals, whose textures lack so many levels.
fn mapped(images: &mut Assets<Image>, lacking: [u32; 3]) -> StandardMaterial {
    let [color, emissive, normals] = [
        (
            TextureFormat::Rgba8UnormSrgb,
            [200, 190, 170, 255],
            [20, 30, 60, 255],
        ),
        (
            TextureFormat::Rgba8UnormSrgb,
            [0, 0, 0, 255],
            [40, 90, 20, 255],
        ),
        (
            TextureFormat::Rgba8Unorm,
            [150, 128, 240, 255],
            [106, 128, 240, 255],
        ),
    ]
    .map(|(format, a, b)| texture(true, format, checks(a, b)));
    let mut add = |image, index: usize| Some(images.add(without_levels(image, lacking[index])));
    StandardMaterial {
        base_color_texture: add(color, 0),
        emissive_texture: add(emissive, 1),
        normal_map_texture: add(normals, 2),
        emissive: LinearRgba::gray(0.4),
        base_color: Color::srgb(0.4, 0.4, 0.4),
        perceptual_roughness: 0.8,
        ..default()
    }
}

#[test]
fn shared_maps_look_like_maps_with_loops_of_their_own() {
    let _gpu = gpu();
    for method in drawn(1, [EwaMethod::Linear, APPROXIMATE]) {
        let settings = EwaSettings::with_method(method);
        let mut floor = Floor::new(all(settings), |images| mapped(images, [0; 3])).cleared();
        let shared = floor.picture();
        let mut with = |change: &dyn Fn(&mut Assets<Image>) -> StandardMaterial| {
            floor.lay(|images| change(images));
            floor.picture()
        };
        let own = with(&|images| mapped(images, [0, 1, 2]));
        let partly = with(&|images| mapped(images, [0, 1, 0]));
        // Parallax mapping of no depth changes no coordinates, but the maps are filtered after it.
        let after_parallax = with(&|images| {
            let depth = texture(true, TextureFormat::Rgba8Unorm, |_, _| [0, 0, 0, 255]);
            StandardMaterial {
                depth_map: Some(images.add(depth)),
                parallax_depth_scale: 0.0,
                ..mapped(images, [0; 3])
            }
        });
        let stock = floor.all(None);
        keep("shared", &shared);
        keep("own", &own);
        let difference = psnr(&shared, &stock);
        for (name, found) in [
            ("own", own),
            ("partly", partly),
            ("parallax", after_parallax),
        ] {
            let found = psnr(&shared, &found);
            println!("{method:?}, {name}: {found:.1} dB; Bevy's own {difference:.1} dB");
            assert!(
                found > difference + 5.0 && difference < 40.0,
                "{method:?}, {name}: {found} dB"
            );
        }
    }
}
