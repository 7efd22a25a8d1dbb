//! What the examples share: a window or a picture, and a line of text. A game has its own.

use std::{path::PathBuf, time::Duration};

use bevy::{
    app::{PluginGroupBuilder, ScheduleRunnerPlugin},
    camera::RenderTarget,
    camera_controller::free_camera::FreeCameraPlugin,
    image::{ImageAddressMode, ImageSamplerDescriptor},
    prelude::*,
    render::{
        RenderPlugin,
        render_resource::{TextureFormat, TextureUsages},
        view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk},
    },
    time::TimeUpdateStrategy,
    window::ExitCondition,
    winit::WinitPlugin,
};

/// Frames after all is there. The first ones stand still, so that pictures are the same whatever time a disk takes.
const FRAMES: u32 = 90;
const STILL_FRAMES: u32 = 30;

/// The text at the top left.
#[derive(Component)]
pub struct Caption;

/// Bevy's plugins, with those of a camera that flies (W, A, S, D, E, Q and the mouse) and of [`Caption`].
///
/// `--headless FILE` on the command line draws without a window: the example writes its picture to the file and ends.
pub fn plugins() -> PluginGroupBuilder {
    // Textures repeat, as those of glTF files do.
    let mut default_sampler = ImageSamplerDescriptor::linear();
    default_sampler.set_address_mode(ImageAddressMode::Repeat);
    let plugins = DefaultPlugins
        .set(AssetPlugin {
            file_path: concat!(env!("CARGO_MANIFEST_DIR"), "/examples/assets").into(),
            ..default()
        })
        .set(ImagePlugin { default_sampler });
    let file = std::env::args().skip_while(|it| it != "--headless").nth(1);
    let plugins = match file {
        None => plugins,
        Some(file) => plugins
            .set(WindowPlugin {
                primary_window: None,
                exit_condition: ExitCondition::DontExit,
                ..default()
            })
            .set(RenderPlugin {
                synchronous_pipeline_compilation: true,
                ..default()
            })
            .disable::<WinitPlugin>()
            .add(ScheduleRunnerPlugin::run_loop(Duration::ZERO))
            .add(move |app: &mut App| draw_picture(app, file.clone().into())),
    };
    plugins.add(FreeCameraPlugin).add(add_caption)
}

fn add_caption(app: &mut App) {
    app.add_systems(Startup, |mut commands: Commands| {
        commands.spawn((
            Caption,
            Text::default(),
            TextFont::from_font_size(15.0),
            TextShadow::default(),
            Node {
                position_type: PositionType::Absolute,
                top: px(10),
                left: px(12),
                ..default()
            },
        ));
    });
}

#[derive(Resource)]
struct Picture {
    file: PathBuf,
    image: Handle<Image>,
}

/// Draws to an image, and writes it to the file after [`FRAMES`].
fn draw_picture(app: &mut App, file: PathBuf) {
    let mut image = Image::new_target_texture(480, 270, TextureFormat::Rgba8UnormSrgb, None);
    image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
    let image = app.world_mut().resource_mut::<Assets<Image>>().add(image);
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    let step = Duration::from_secs_f32(1.0 / 60.0);
    app.insert_resource(Picture { file, image })
        .insert_resource(TimeUpdateStrategy::ManualDuration(step))
        .add_systems(PostStartup, draw_to_image)
        .add_systems(Last, save);
}

/// Cameras of the window draw to the image. The last of them shows the text, as in a window.
fn draw_to_image(
    mut commands: Commands,
    picture: Res<Picture>,
    cameras: Query<(Entity, &Camera, &RenderTarget)>,
) {
    let in_order = cameras
        .iter()
        .sort_by_key::<&Camera, _>(|camera| camera.order);
    let mut last = None;
    for (camera, _, target) in in_order {
        if let RenderTarget::Window(_) = target {
            let image = RenderTarget::Image(picture.image.clone().into());
            commands.entity(camera).insert(image);
            last = Some(camera);
        }
    }
    if let Some(last) = last {
        commands.entity(last).insert(IsDefaultUiCamera);
    }
}

fn save(
    mut commands: Commands,
    mut frame: Local<u32>,
    picture: Res<Picture>,
    mut images: MessageReader<AssetEvent<Image>>,
    caption: Single<&Text, With<Caption>>,
    mut time: ResMut<Time<Virtual>>,
) {
    let has_loaded = images
        .read()
        .any(|event| matches!(event, AssetEvent::LoadedWithDependencies { .. }));
    *frame += 1;
    // Without a caption, an example waits for more than images.
    if (has_loaded || caption.is_empty()) && *frame < STILL_FRAMES {
        *frame = 0;
    }
    if *frame == STILL_FRAMES {
        time.unpause();
    }
    if *frame == FRAMES {
        let end = |_: On<ScreenshotCaptured>, mut exit: MessageWriter<AppExit>| {
            exit.write(AppExit::Success);
        };
        commands
            .spawn(Screenshot::image(picture.image.clone()))
            .observe(save_to_disk(picture.file.clone()))
            .observe(end);
    }
}
