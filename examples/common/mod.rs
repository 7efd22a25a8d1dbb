//! What the examples share: a window or a picture, and a line of text. A game has its own.

use std::{path::PathBuf, time::Duration};

use bevy::{
    app::{PluginGroupBuilder, ScheduleRunnerPlugin},
    camera::RenderTarget,
    camera_controller::free_camera::FreeCameraPlugin,
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

/// Frames after the last image has arrived, of which the first ones stand still, so that pictures are the same whatever
/// time a disk takes.
const FRAMES: u32 = 90;
const STILL_FRAMES: u32 = 30;
const SIZE: UVec2 = UVec2::new(480, 270);

/// The text at the top left.
#[derive(Component)]
pub struct Caption;

/// Bevy's plugins, with those of a camera that flies (W, A, S, D, E, Q and the mouse) and of [`Caption`].
///
/// `--headless FILE` on the command line draws without a window: the example writes its picture to the file and ends.
pub fn plugins(title: &str) -> PluginGroupBuilder {
    let plugins = DefaultPlugins.set(AssetPlugin {
        file_path: concat!(env!("CARGO_MANIFEST_DIR"), "/examples/assets").into(),
        ..default()
    });
    let plugins = match headless_file() {
        None => plugins.set(WindowPlugin {
            primary_window: Some(Window {
                title: title.into(),
                ..default()
            }),
            ..default()
        }),
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
            .add(PicturePlugin(file)),
    };
    plugins.add(FreeCameraPlugin).add(CaptionPlugin)
}

/// The value of `--headless`.
fn headless_file() -> Option<PathBuf> {
    let mut arguments = std::env::args().skip_while(|argument| argument != "--headless");
    arguments.nth(1).map(PathBuf::from)
}

struct CaptionPlugin;

impl Plugin for CaptionPlugin {
    fn build(&self, app: &mut App) {
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
}

/// Draws to an image, and writes it to a file after [`FRAMES`].
struct PicturePlugin(PathBuf);

#[derive(Resource)]
struct Picture {
    file: PathBuf,
    image: Handle<Image>,
    frame: u32,
}

impl Plugin for PicturePlugin {
    fn build(&self, app: &mut App) {
        let mut image =
            Image::new_target_texture(SIZE.x, SIZE.y, TextureFormat::Rgba8UnormSrgb, None);
        image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
        let image = app.world_mut().resource_mut::<Assets<Image>>().add(image);
        app.world_mut().resource_mut::<Time<Virtual>>().pause();
        app.insert_resource(Picture {
            file: self.0.clone(),
            image,
            frame: 0,
        })
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f32(
            1.0 / 60.0,
        )))
        .add_systems(PostStartup, draw_to_image)
        .add_systems(Last, save);
    }
}

/// Cameras of the window draw to the image. The last of them shows the text, as in a window.
fn draw_to_image(
    mut commands: Commands,
    picture: Res<Picture>,
    cameras: Query<(Entity, &Camera, &RenderTarget)>,
) {
    let of_window = |target: &RenderTarget| matches!(target, RenderTarget::Window(_));
    let cameras = cameras.iter().filter(|(.., target)| of_window(target));
    let mut cameras: Vec<_> = cameras
        .map(|(entity, camera, _)| (camera.order, entity))
        .collect();
    cameras.sort_unstable_by_key(|&(order, _)| order);
    for &(_, camera) in &cameras {
        let target = RenderTarget::Image(picture.image.clone().into());
        commands.entity(camera).insert(target);
    }
    if let Some(&(_, last)) = cameras.last() {
        commands.entity(last).insert(IsDefaultUiCamera);
    }
}

fn save(
    mut commands: Commands,
    mut picture: ResMut<Picture>,
    mut images: MessageReader<AssetEvent<Image>>,
    mut time: ResMut<Time<Virtual>>,
) {
    let has_loaded = images
        .read()
        .any(|event| matches!(event, AssetEvent::LoadedWithDependencies { .. }));
    picture.frame += 1;
    if has_loaded && picture.frame < STILL_FRAMES {
        picture.frame = 0;
    }
    if picture.frame == STILL_FRAMES {
        time.unpause();
    }
    if picture.frame == FRAMES {
        commands
            .spawn(Screenshot::image(picture.image.clone()))
            .observe(save_to_disk(picture.file.clone()))
            .observe(
                |_: On<ScreenshotCaptured>, mut exit: MessageWriter<AppExit>| {
                    exit.write(AppExit::Success);
                },
            );
    }
}
