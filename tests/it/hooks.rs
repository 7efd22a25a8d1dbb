//! A shader of Bevy that is not as the patches expect is left alone: one error names it, and the
//! picture is Bevy's own.

use bevy::{
    image::{ImageSampler, ToExtents},
    prelude::*,
    render::render_resource::{TextureDimension, TextureFormat},
    shader::{Shader, ShaderImport},
};
use bevy_ewa::{EwaMethod, EwaPlugin, EwaSettings, EwaStandardMaterial};
use bevy_frugal_hooks::ShaderPatches;
use bevy_frugal_lab::headless::HeadlessApp;
use bevy_frugal_lab::metrics::mse;
use bevy_voxel_gi::{VoxelGiPlugin, VoxelGiSettings, VoxelGiVolume};
use bevy_ycocg_fb::{
    CameraState, FallbackReason, FrameBufferQuality, FrameBufferReport, YCoCgFrameBuffer,
    YCoCgFrameBufferPlugin,
};
use image::RgbImage;

use crate::support::{drawn, gpu, headless, spawn_camera_and_light};

/// A change of one of Bevy's shaders, as a patch release might bring it, without any effect.
#[derive(Resource, Clone, Copy)]
struct Change {
    module: &'static str,
    from: &'static str,
    to: &'static str,
}

/// Before the shaders are patched.
fn change_shader(change: Res<Change>, mut shaders: ResMut<Assets<Shader>>) {
    let is_meant = |shader: &Shader| {
        shader.import_path == ShaderImport::Custom(change.module.into())
            && shader.source.as_str().contains(change.from)
    };
    let found = shaders.iter().find(|(_, shader)| is_meant(shader));
    let Some((id, shader)) = found.map(|(id, shader)| (id, shader.clone())) else {
        return;
    };
    let source = shader.source.as_str().replace(change.from, change.to);
    shaders
        .insert(id, Shader::from_wesl(source, shader.path))
        .expect("the shader exists");
}

/// A cube as Bevy draws it.
fn scene(app: &mut App) {
    cube(app, (), None, AlphaMode::Opaque);
}

/// A cube with a striped texture, in a material of the filter's own with settings.
fn cube(
    app: &mut App,
    camera: impl Bundle + Clone,
    settings: Option<EwaSettings>,
    alpha_mode: AlphaMode,
) {
    let system = move |world: &mut World| {
        let eye = Vec3::new(1.0, 1.5, 3.0);
        spawn_camera_and_light(world, eye, camera.clone());
        let stripe = [[255, 200, 40, 255], [10, 20, 90, 255]].concat();
        let mut image = Image::new(
            UVec2::splat(64).to_extents(),
            TextureDimension::D2,
            stripe.repeat(64 * 32),
            TextureFormat::Rgba8UnormSrgb,
            default(),
        );
        image.sampler = ImageSampler::linear();
        let base = StandardMaterial {
            base_color_texture: Some(world.add_asset(image)),
            alpha_mode,
            ..default()
        };
        let floor = Mesh3d(world.add_asset(Cuboid::new(4.0, 0.5, 4.0)));
        let white = world.add_asset::<StandardMaterial>(Color::WHITE);
        let place = Transform::from_xyz(0.0, -0.8, 0.0);
        world.spawn((floor, MeshMaterial3d(white), place));
        let cube = Mesh3d(world.add_asset(Cuboid::default()));
        if let Some(settings) = settings {
            let extension = settings.into();
            let material = EwaStandardMaterial { base, extension };
            let material = world.add_asset::<EwaStandardMaterial>(material);
            world.spawn((cube, MeshMaterial3d(material)));
        } else {
            let material = world.add_asset::<StandardMaterial>(base);
            world.spawn((cube, MeshMaterial3d(material)));
        }
    };
    app.add_systems(Startup, system);
}

fn picture(build: impl FnOnce(&mut App)) -> (HeadlessApp, RgbImage) {
    let mut app = headless(96, 96, build);
    app.run_until_ready(300).expect("pipelines");
    // Chains of mips would be done by then.
    app.render_frames(30).expect("frames");
    let picture = app.capture_rgb8().expect("a picture");
    (app, picture)
}

fn changed_picture(change: Change, build: impl FnOnce(&mut App)) -> (HeadlessApp, RgbImage) {
    picture(|app| {
        app.insert_resource(change)
            .add_systems(Update, change_shader);
        build(app);
    })
}

fn is_like(
    expected: impl FnOnce(&mut App),
    change: Change,
    names: &[&str],
    plugin: impl FnOnce(&mut App),
) -> HeadlessApp {
    let _gpu = gpu();
    let (_, expected) = picture(expected);
    let (app, found) = changed_picture(change, plugin);
    let patches = app.world().resource::<ShaderPatches>();
    let (name, error) = patches.refused(names).expect("a refused patch");
    assert!(names.contains(&name), "{name}: {error}");
    assert!(found == expected);
    app
}

const FRAGMENT_CHANGED: Change = Change {
    module: "bevy_pbr::render::pbr_fragment",
    from: "thickness *= textureSampleBias(",
    to: "thickness = thickness * textureSampleBias(",
};

/// One sampling more than the patch knows.
const ALPHA_CHANGED: Change = Change {
    module: "bevy_pbr::render::pbr_prepass_functions",
    from: "    prepass_alpha_discard(flags, alpha_cutoff, output_color);\n}",
    to: "    prepass_alpha_discard(flags, alpha_cutoff, output_color);\n\
         // A textureSampleBias( of another map.\n}",
};

/// The cube with this method and a base colour of this alpha mode.
fn filtered(method: EwaMethod, chosen: bool, alpha_mode: AlphaMode) -> impl FnOnce(&mut App) {
    let settings = EwaSettings::with_method(method);
    move |app| {
        let all_materials = (!chosen).then_some(settings);
        app.add_plugins(EwaPlugin { all_materials });
        cube(app, (), chosen.then_some(settings), alpha_mode);
    }
}

#[test]
fn without_its_anchors_ewa_leaves_materials_to_the_texture_unit() {
    for chosen in drawn(1, [false, true]) {
        is_like(
            filtered(EwaMethod::Hardware, chosen, AlphaMode::Opaque),
            FRAGMENT_CHANGED,
            &["bevy_ewa/fragment"],
            filtered(EwaMethod::Linear, chosen, AlphaMode::Opaque),
        );
    }
}

#[test]
fn without_the_patch_of_shadows_only_alpha_masks_are_left_to_the_texture_unit() {
    let rows = [
        (AlphaMode::Mask(0.5), EwaMethod::Hardware),
        (AlphaMode::Opaque, EwaMethod::Linear),
    ];
    for (alpha_mode, expected) in drawn(1, rows) {
        is_like(
            filtered(expected, false, alpha_mode),
            ALPHA_CHANGED,
            &["bevy_ewa/alpha"],
            filtered(EwaMethod::Linear, false, alpha_mode),
        );
    }
}

#[test]
fn without_its_anchor_the_frame_buffer_is_bevys() {
    let change = Change {
        module: "bevy_pbr::render::pbr_functions",
        from: "    return output_color;\n}",
        to: "    return output_color; // changed\n}",
    };
    let names = &["bevy_ycocg_fb/materials"];
    let mut app = is_like(scene, change, names, |app| {
        app.add_plugins(YCoCgFrameBufferPlugin);
        let quality = FrameBufferQuality::from(YCoCgFrameBuffer::default());
        cube(app, quality, None, AlphaMode::Opaque);
    });
    let world = app.world_mut();
    let mut cameras = world.query::<&FrameBufferReport>();
    let state = &cameras.single(world).expect("one camera").state;
    let CameraState::Fallback(FallbackReason::PatchRefused(text)) = state else {
        panic!("{state:?}");
    };
    assert!(text.contains("bevy_ycocg_fb/materials"), "{text}");
}

#[test]
fn without_its_anchor_a_volume_is_read_as_bevys_own() {
    let _gpu = gpu();
    let change = Change {
        module: "bevy_pbr::light_probe::irradiance_volume",
        from: "let atlas_resolution = vec3<f32>(",
        to: "let atlas_resolution: vec3<f32> = vec3<f32>(",
    };
    let volume = |app: &mut App| {
        app.add_plugins(VoxelGiPlugin)
            .insert_resource(VoxelGiSettings {
                resolution: 16,
                ..default()
            })
            .add_systems(Startup, |mut commands: Commands| {
                commands.spawn((VoxelGiVolume::default(), Transform::default()));
            });
        scene(app);
    };
    let (_, without) = picture(scene);
    let (_, patched) = picture(volume);
    let (app, refused) = changed_picture(change, volume);
    let patches = app.world().resource::<ShaderPatches>();
    assert!(patches.refused(&["bevy_voxel_gi/receive"]).is_some());
    let error = |a: &RgbImage, b: &RgbImage| mse(a, b).expect("one size");
    let (refused, without) = (error(&refused, &patched), error(&without, &patched));
    println!("{refused} {without}");
    assert!(refused < 0.1 * without);
}
