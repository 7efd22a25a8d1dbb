//! Runs the game without a window and decides whether it does what it should.

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
use bevy_ewa::material::patches::ALL as PATCHES;
use bevy_frugal_hooks::ShaderPatches;
use bevy_voxel_gi::VoxelGiReport;
use bevy_ycocg_fb::{CameraState, FrameBufferReport};

/// Rows of whole 256 bytes: the copy that is read back has no padding.
const SIZE: Extent3d = Extent3d {
    width: 192,
    height: 108,
    depth_or_array_layers: 1,
};

/// The image that the camera draws to.
#[derive(Resource)]
pub struct Target(pub Handle<Image>);

/// Frames between two looks at the picture: assets load and pipelines compile meanwhile.
const INTERVAL: u32 = 20;

/// Counts frames up to the number after which the game has failed.
#[derive(Resource)]
struct Frames {
    drawn: u32,
    most: u32,
}

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
                file_path: concat!(env!("CARGO_MANIFEST_DIR"), "/../..").into(),
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
        .insert_resource(Frames {
            drawn: 0,
            most: frames.unwrap_or(400),
        })
        .add_systems(Last, look);
}

fn look(mut commands: Commands, mut frames: ResMut<Frames>, target: Res<Target>) {
    frames.drawn += 1;
    if frames.drawn.is_multiple_of(INTERVAL) {
        commands
            .spawn(Readback::texture(target.0.clone()))
            .observe(judge);
    }
}

/// Ends the game if all is there, or if it should have been by now.
fn judge(
    picture: On<ReadbackComplete>,
    mut commands: Commands,
    mut exit: MessageWriter<AppExit>,
    frames: Res<Frames>,
    cameras: Query<&FrameBufferReport, With<Camera3d>>,
    light: Res<VoxelGiReport>,
    patches: Res<ShaderPatches>,
) {
    commands.entity(picture.entity).despawn();
    let mut missing = missing_in(&picture.data);
    let mut expect = |holds: bool, what: &str| {
        if !holds {
            missing.push(what.to_owned());
        }
    };
    expect(
        light.triangles > 0 && light.receiver_patched,
        "no light bounces",
    );
    expect(patches.all_applied(PATCHES), "materials are not filtered");
    for FrameBufferReport { state, .. } in &cameras {
        let is_packed = matches!(state, CameraState::Packed(_));
        expect(is_packed, &format!("the camera is not packed: {state:?}"));
    }
    let errors = ERRORS.load(Ordering::Relaxed);
    if errors > 0 || frames.drawn >= frames.most {
        missing.push(format!("{errors} errors were logged"));
    } else if !missing.is_empty() {
        return;
    }
    save(&picture.data);
    if missing.is_empty() {
        println!("the game runs: all is there after {} frames", frames.drawn);
        exit.write(AppExit::Success);
    } else {
        eprintln!("after {} frames: {}", frames.drawn, missing.join("; "));
        exit.write(AppExit::error());
    }
}

/// Names what the picture should show and does not.
fn missing_in(picture: &[u8]) -> Vec<String> {
    let level = |x: usize, y: usize, channel: usize| {
        let texel = y * SIZE.width as usize + x;
        f32::from(picture[4 * texel + channel])
    };
    let [red, blue] = [0, 2].map(|channel| level(80, 55, channel));
    let [sky, shadow, floor] = [(10, 10), (128, 66), (30, 80)].map(|(x, y)| level(x, y, 1));
    let expected = [
        (red > 1.5 * blue, "the crate of the glTF file"),
        (floor > 1.5 * sky, "the floor with its wavelet texture"),
        (3.0 * shadow < 2.0 * floor, "the shadow of the crate"),
        (shadow > 10.0, "light in the shadow"),
    ];
    let missing = expected.into_iter().filter(|(holds, _)| !holds);
    missing
        .map(|(_, what)| format!("not in the picture: {what}"))
        .collect()
}

/// Saves the picture in the file that `--picture` names.
fn save(picture: &[u8]) {
    let Some(path) = argument("--picture") else {
        return;
    };
    let image = Image::new(
        SIZE,
        TextureDimension::D2,
        picture.to_vec(),
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::default(),
    );
    let saved = image
        .try_into_dynamic()
        .map_err(|error| error.to_string())
        .and_then(|image| image.save(&path).map_err(|error| error.to_string()));
    if let Err(error) = saved {
        eprintln!("{path}: {error}");
    }
}
