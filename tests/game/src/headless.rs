//! The game without a window, and what must be true at its end.

use std::{
    env,
    sync::atomic::{AtomicU32, Ordering},
    time::Duration,
};

use bevy::{
    app::ScheduleRunnerPlugin,
    asset::RenderAssetUsages,
    log::{
        BoxedLayer, Level, LogPlugin,
        tracing::{Event, Subscriber},
        tracing_subscriber::layer::{Context, Layer},
    },
    prelude::*,
    render::{
        gpu_readback::{Readback, ReadbackComplete},
        render_resource::{Extent3d, TextureDimension, TextureFormat, TextureUsages},
    },
    window::ExitCondition,
    winit::WinitPlugin,
};
use bevy_ewa::material::patches::REQUIRED;
use bevy_voxel_gi::VoxelGiReport;
use bevy_ycocg_fb::{CameraState, FrameBufferReports};

const SIZE: Extent3d = Extent3d {
    width: 160,
    height: 90,
    depth_or_array_layers: 1,
};

/// Where the camera draws to.
#[derive(Resource)]
pub struct Target(pub Handle<Image>);

/// The frames that are left.
#[derive(Resource)]
struct FramesLeft(u32);

/// Errors that were logged.
static ERRORS: AtomicU32 = AtomicU32::new(0);

struct CountErrors;

impl<S: Subscriber> Layer<S> for CountErrors {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        if *event.metadata().level() == Level::ERROR {
            ERRORS.fetch_add(1, Ordering::Relaxed);
        }
    }
}

fn count_errors(_: &mut App) -> Option<BoxedLayer> {
    Some(Box::new(CountErrors))
}

/// The value of `--name value`.
fn argument(name: &str) -> Option<String> {
    let mut arguments = env::args().skip_while(|argument| argument != name);
    arguments.nth(1)
}

pub fn build(app: &mut App) {
    app.add_plugins((
        DefaultPlugins
            .set(WindowPlugin {
                primary_window: None,
                exit_condition: ExitCondition::DontExit,
                ..default()
            })
            .set(LogPlugin {
                custom_layer: count_errors,
                ..default()
            })
            .set(AssetPlugin {
                file_path: concat!(env!("CARGO_MANIFEST_DIR"), "/assets").into(),
                ..default()
            })
            .disable::<WinitPlugin>(),
        ScheduleRunnerPlugin::run_loop(Duration::ZERO),
    ));
    let mut image = Image::new_fill(
        SIZE,
        TextureDimension::D2,
        &[0; 4],
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::default(),
    );
    image.texture_descriptor.usage |= TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
    let target = app.world_mut().resource_mut::<Assets<Image>>().add(image);
    let frames = argument("--frames").and_then(|frames| frames.parse().ok());
    app.insert_resource(Target(target))
        .insert_resource(FramesLeft(frames.unwrap_or(60)))
        .add_systems(Last, count_down);
}

fn count_down(mut commands: Commands, mut left: ResMut<FramesLeft>, target: Res<Target>) {
    if left.0 == 1 {
        commands
            .spawn(Readback::texture(target.0.clone()))
            .observe(finish);
    }
    left.0 = left.0.saturating_sub(1);
}

/// Looks at the picture and at what the plugins report.
fn finish(
    picture: On<ReadbackComplete>,
    mut exit: MessageWriter<AppExit>,
    cameras: Query<Entity, With<Camera3d>>,
    frame_buffers: Res<FrameBufferReports>,
    light: Res<VoxelGiReport>,
    patches: Res<bevy_frugal_hooks::ShaderPatches>,
) {
    if let Some(path) = argument("--picture") {
        let image = Image::new(
            SIZE,
            TextureDimension::D2,
            picture.data.clone(),
            TextureFormat::Rgba8UnormSrgb,
            RenderAssetUsages::default(),
        );
        let saved = image
            .try_into_dynamic()
            .map_err(|error| error.to_string())
            .and_then(|image| image.save(&path).map_err(|error| error.to_string()));
        if let Err(error) = saved {
            error!("{path}: {error}");
        }
    }
    let levels = picture.data.chunks_exact(4).map(|texel| u64::from(texel[1]));
    let mean = levels.sum::<u64>() / u64::from(SIZE.width * SIZE.height);
    let mut failures = Vec::new();
    let mut check = |holds: bool, what: &str| {
        if !holds {
            failures.push(what.to_owned());
        }
    };
    check((20..236).contains(&mean), "the picture is empty");
    check(ERRORS.load(Ordering::Relaxed) == 0, "errors were logged");
    check(light.triangles > 0 && light.receiver_patched, "no light bounces");
    check(patches.all_applied(REQUIRED), "materials are not filtered");
    for camera in &cameras {
        let state = frame_buffers.get(camera).map(|report| report.state);
        check(state == Some(CameraState::Packed), &format!("not packed: {state:?}"));
    }
    if failures.is_empty() {
        println!("the game ran: mean level {mean}");
        exit.write(AppExit::Success);
    } else {
        eprintln!("the game failed: {}", failures.join("; "));
        exit.write(AppExit::error());
    }
}
