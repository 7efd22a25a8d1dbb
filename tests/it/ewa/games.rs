//! What games do with textures: mirrors, painted and streamed pictures, pixel art, atlases, materials of their own.

use bevy::{
    asset::RenderAssetUsages,
    camera::RenderTarget,
    image::{ImageFilterMode, ToExtents},
    math::Affine2,
    pbr::{ExtendedMaterial, MaterialExtension},
    prelude::*,
    render::render_resource::{AsBindGroup, TextureFormat},
    shader::ShaderRef,
};
use bevy_ewa::{
    AllMaterials, EwaImage, EwaMaterialPlugin, EwaMethod, EwaOverrides, EwaPlugin, EwaSettings,
    MipReport, mips::NoMips,
};
use image::RgbImage;

use super::{Floor, all, checks, mips, sampler, texture, unlit};
use crate::support::{Folder, drawn, gpu, keep, psnr};

const RED: [u8; 4] = [240, 30, 20, 255];
const BLUE: [u8; 4] = [20, 40, 250, 255];

/// Checks of a colour and black.
fn picture(color: [u8; 4]) -> Image {
    let texels = checks(color, [10, 10, 10, 255]);
    texture(false, TextureFormat::Rgba8UnormSrgb, texels)
}

fn plugins() -> [EwaPlugin; 2] {
    [EwaPlugin::default(), EwaPlugin::elliptical()]
}

/// A floor that shows an image, and the image.
fn floor_of(plugin: Option<EwaPlugin>, image: Image) -> (Floor, Handle<Image>) {
    let mut handle = Handle::default();
    let floor = Floor::new(plugin, |images| {
        handle = images.add(image);
        unlit(handle.clone())
    });
    (floor.cleared(), handle)
}

fn edit(floor: &mut Floor, image: &Handle<Image>, edit: impl FnOnce(&mut Image)) {
    let mut images = floor.app.world_mut().resource_mut::<Assets<Image>>();
    edit(&mut images.get_mut(image).expect("the image"));
}

fn assert_levels(floor: &Floor, image: &Handle<Image>, levels: u32) {
    let report = mips(floor.app.world(), image);
    assert_eq!(report, Some(MipReport::Generated(levels)));
}

/// The picture of a floor that shows an image from the beginning.
fn fresh(plugin: EwaPlugin, image: Image) -> RgbImage {
    floor_of(Some(plugin), image).0.picture()
}

#[test]
fn a_painted_texture_is_new_at_any_distance_and_stays_the_games() {
    let _gpu = gpu();
    for plugin in plugins() {
        let (mut floor, image) = floor_of(Some(plugin), picture(RED));
        floor.picture();
        let blue = picture(BLUE).data.expect("data");
        edit(&mut floor, &image, |image| {
            // As games do with a video's frame: the data are as long as ever.
            let data = image.data.as_mut().expect("data");
            data.copy_from_slice(&blue);
        });
        let painted = floor.picture();
        keep("painted", &painted);
        assert!(painted == fresh(plugin, picture(BLUE)));
        let images = floor.app.world().resource::<Assets<Image>>();
        let descriptor = &images.get(&image).expect("the image").texture_descriptor;
        assert_eq!(
            descriptor.mip_level_count, 1,
            "the game's image is unchanged"
        );
    }
}

#[test]
fn a_texture_that_is_edited_in_every_frame_is_new_in_every_frame() {
    let _gpu = gpu();
    let plugin = EwaPlugin::elliptical();
    let (mut floor, image) = floor_of(Some(plugin), picture(RED));
    floor.picture();
    for green in [0, 80, 160, 240] {
        let color = [20, green, 30, 255];
        let data = picture(color).data;
        edit(&mut floor, &image, |image| image.data = data);
        floor.app.render_frames(1).expect("a frame");
        let seen = floor.app.capture_rgb8().expect("a picture");
        assert!(seen == fresh(plugin, picture(color)), "green {green}");
    }
}

#[test]
fn a_resized_texture_has_the_levels_of_its_size() {
    let _gpu = gpu();
    for plugin in plugins() {
        let (mut floor, image) = floor_of(Some(plugin), picture(RED));
        floor.picture();
        let size = UVec2::new(128, 32).to_extents();
        let color = [30, 200, 90, 255].repeat(128 * 32);
        let resize = |image: &mut Image| {
            image.resize(size);
            image.data = Some(color.clone());
        };
        edit(&mut floor, &image, resize);
        let seen = floor.picture();
        assert_levels(&floor, &image, 8);
        let mut expected = picture(RED);
        resize(&mut expected);
        assert!(seen == fresh(plugin, expected));
    }
}

#[test]
fn images_that_are_only_on_the_gpu_and_those_loaded_long_before_their_material_get_levels() {
    let _gpu = gpu();
    let plugin = EwaPlugin::elliptical();
    let expected = fresh(plugin, picture(RED));
    let mut gpu_only = picture(RED);
    gpu_only.asset_usage = RenderAssetUsages::RENDER_WORLD;
    let (mut floor, image) = floor_of(Some(plugin), gpu_only.clone());
    assert!(floor.picture() == expected);
    assert_levels(&floor, &image, 7);

    for image in drawn(1, [gpu_only, picture(RED)]) {
        let (mut floor, _) = floor_of(Some(plugin), picture(BLUE));
        let image = { floor.app.world_mut().resource_mut::<Assets<Image>>() }.add(image);
        floor.app.render_frames(310).expect("frames");
        floor.lay(|_| unlit(image.clone()));
        let seen = floor.picture();
        assert!(seen == expected, "{} dB", psnr(&seen, &expected));
        let is_editable = {
            let images = floor.app.world().resource::<Assets<Image>>();
            images.get(&image).is_some_and(|image| image.data.is_some())
        };
        if is_editable {
            let blue = picture(BLUE).data;
            edit(&mut floor, &image, |image| image.data = blue);
            assert!(floor.picture() == fresh(plugin, picture(BLUE)));
        }
    }
}

#[test]
fn all_materials_can_be_filtered_long_after_they_are_there() {
    let _gpu = gpu();
    let plugin = EwaPlugin::elliptical();
    let (mut floor, _) = floor_of(Some(EwaPlugin::OPT_IN), picture(RED));
    floor.app.render_frames(310).expect("frames");
    let seen = floor.all(plugin.all_materials);
    assert!(seen == fresh(plugin, picture(RED)));
}

/// A camera above the floor that shows a strip of red and blue, whose picture the floor shows.
fn mirror(plugin: EwaPlugin, after_draws: bool) -> (RgbImage, Option<MipReport>) {
    let format = TextureFormat::Rgba8UnormSrgb;
    let mut target = Image::new_target_texture(64, 64, format, None);
    target.sampler = picture(RED).sampler;
    let (mut floor, target) = floor_of(Some(plugin), target);
    let world = floor.app.world_mut();
    if after_draws {
        let choice = EwaImage {
            after_draws,
            ..default()
        };
        world
            .resource_mut::<EwaOverrides>()
            .set_image(&target, choice);
    }
    let mut images = world.resource_mut::<Assets<Image>>();
    let shown = images.add(picture(RED));
    let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
    let shown = materials.add(unlit(shown));
    let quad = world.add_asset(Rectangle::new(2.0, 2.0));
    world.spawn((
        Mesh3d(quad),
        MeshMaterial3d(shown),
        Transform::from_xyz(0.0, 500.0, -1.0),
    ));
    world.spawn((
        Camera3d::default(),
        Camera {
            order: -1,
            ..default()
        },
        Msaa::Off,
        bevy::core_pipeline::tonemapping::Tonemapping::None,
        RenderTarget::Image(target.clone().into()),
        Projection::from(OrthographicProjection {
            scaling_mode: bevy::camera::ScalingMode::Fixed {
                width: 2.0,
                height: 2.0,
            },
            ..OrthographicProjection::default_3d()
        }),
        Transform::from_xyz(0.0, 500.0, 0.0),
    ));
    let seen = floor.picture();
    (seen, mips(floor.app.world(), &target))
}

#[test]
fn a_mirror_is_shown_and_has_levels_where_the_game_asks() {
    let _gpu = gpu();
    for plugin in plugins() {
        let (seen, report) = mirror(plugin, false);
        assert_eq!(report, Some(MipReport::Without(NoMips::WrittenOnGpu)));
        let has_red = |pixel: &image::Rgb<u8>| pixel[0] > 150 && pixel[2] < 60;
        assert!(seen.pixels().filter(|pixel| has_red(pixel)).count() > 200);
        let (leveled, report) = mirror(plugin, true);
        assert_eq!(report, Some(MipReport::Generated(7)));
        keep("mirror", &seen);
        keep("mirror_levels", &leveled);
        // With levels it is nearly the picture that was drawn to the target, on the floor.
        let expected = fresh(plugin, picture(RED));
        let (without, with) = (psnr(&seen, &expected), psnr(&leveled, &expected));
        println!("{without} dB without levels, {with} dB with them");
        assert!(with > 40.0 && with > without + 10.0);
    }
}

#[test]
fn pixel_art_and_what_the_game_excludes_is_bevys_own() {
    let _gpu = gpu();
    let mut art = picture(RED);
    sampler(&mut art).mag_filter = ImageFilterMode::Nearest;
    sampler(&mut art).min_filter = ImageFilterMode::Nearest;
    for plugin in plugins() {
        let stock = floor_of(None, art.clone()).0.picture();
        assert!(fresh(plugin, art.clone()) == stock);

        let stock = floor_of(None, picture(RED)).0.picture();
        let (mut floor, image) = floor_of(Some(plugin), picture(RED));
        let filtered = floor.picture();
        assert!(filtered != stock);
        let overrides = |floor: &mut Floor, change: &dyn Fn(&mut EwaOverrides)| {
            change(&mut floor.app.world_mut().resource_mut::<EwaOverrides>());
            floor.picture()
        };
        let excluded = |o: &mut EwaOverrides| o.set_image(&image, EwaImage::EXCLUDED);
        assert!(overrides(&mut floor, &excluded) == stock, "excluded image");
        assert!(overrides(&mut floor, &|o| o.clear_image(&image)) == filtered);
        let material = floor.material.clone();
        let left = |o: &mut EwaOverrides| o.set_material(&material, None);
        assert!(overrides(&mut floor, &left) == stock, "excluded material");
        assert!(overrides(&mut floor, &|o| o.clear_material(&material)) == filtered);
        // One material alone.
        floor.all(None);
        let chosen = |o: &mut EwaOverrides| o.set_material(&material, plugin.all_materials);
        assert!(overrides(&mut floor, &chosen) == filtered, "one material");
    }
}

/// Models with a colour for each face have one texture coordinate on all of it. With [`EwaPlugin::default`] the software
/// driver, and no GPU, draws black there.
#[test]
fn faces_of_one_colour_have_it() {
    let _gpu = gpu();
    let faces = |plugin| {
        let floor = Floor::new(plugin, |images| StandardMaterial {
            uv_transform: Affine2::from_scale_angle_translation(Vec2::ZERO, 0.0, Vec2::splat(0.3)),
            ..unlit(images.add(picture(RED)))
        });
        floor.cleared().picture()
    };
    let expected = faces(None);
    let without_anisotropy = all(EwaSettings::with_method(EwaMethod::Hardware));
    for plugin in [without_anisotropy, Some(EwaPlugin::elliptical())] {
        let found = faces(plugin);
        assert!(psnr(&found, &expected) > 45.0, "{plugin:?}");
    }
}

#[derive(Asset, AsBindGroup, Reflect, Clone, Default)]
struct Detail {
    #[texture(100)]
    #[sampler(101)]
    texture: Option<Handle<Image>>,
}

impl MaterialExtension for Detail {}

#[derive(Asset, AsBindGroup, Reflect, Clone)]
struct Plain {
    #[texture(0)]
    #[sampler(1)]
    texture: Handle<Image>,
}

impl Material for Plain {
    fn fragment_shader() -> ShaderRef {
        "plain.wesl".into()
    }
}

const PLAIN: &str = "
import bevy_pbr::render::forward_io::VertexOutput;
@group(constants::MATERIAL_BIND_GROUP) @binding(0) var texture: texture_2d<f32>;
@group(constants::MATERIAL_BIND_GROUP) @binding(1) var texture_sampler: sampler;
@fragment
fn fragment(in: VertexOutput) -> @location(0) vec4<f32> {
    return textureSample(texture, texture_sampler, in.uv);
}
";

#[test]
fn materials_of_the_games_own_are_filtered_by_one_line() {
    let _gpu = gpu();
    let folder = Folder::new("plain").with("plain.wesl", PLAIN.as_bytes());
    type Extended = ExtendedMaterial<StandardMaterial, Detail>;
    let floor = Floor::with_plugins(folder.settings(96, 64), |app| {
        app.add_plugins((
            EwaPlugin::default(),
            MaterialPlugin::<Extended>::default(),
            MaterialPlugin::<Plain>::default(),
            EwaMaterialPlugin::<Extended>::default(),
            EwaMaterialPlugin::<Plain>::default(),
        ));
    });
    let mut floor = floor.cleared();
    let elliptical = EwaPlugin::elliptical().all_materials;
    let world = floor.app.world_mut();
    let mut images = world.resource_mut::<Assets<Image>>();
    let [base, detail, plain] = [(); 3].map(|()| images.add(picture(RED)));
    let extended = world.add_asset::<Extended>(Extended {
        base: unlit(base.clone()),
        extension: Detail {
            texture: Some(detail.clone()),
        },
    });
    world
        .entity_mut(floor.floor)
        .remove::<MeshMaterial3d<StandardMaterial>>()
        .insert(MeshMaterial3d(extended));
    let seen = floor.all(elliptical);
    assert!(seen == fresh(EwaPlugin::elliptical(), picture(RED)));
    for image in [&base, &detail] {
        assert_levels(&floor, image, 7);
    }

    let world = floor.app.world_mut();
    let material = world.add_asset::<Plain>(Plain {
        texture: plain.clone(),
    });
    world
        .entity_mut(floor.floor)
        .remove::<MeshMaterial3d<Extended>>()
        .insert(MeshMaterial3d(material));
    world.insert_resource(AllMaterials::default());
    let seen = floor.picture();
    keep("plain", &seen);
    let expected = fresh(EwaPlugin::default(), picture(RED));
    assert!(psnr(&seen, &expected) > 45.0, "{}", psnr(&seen, &expected));
    assert_levels(&floor, &plain, 7);
}
