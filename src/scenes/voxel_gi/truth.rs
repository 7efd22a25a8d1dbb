//! The path-traced picture of the Cornell box, at the right, and how far the live one is from it.
//!
//! The comparison has cameras of its own, off screen and where the traced picture was taken from:
//! the light that bounces is what one with the volume's light sees more than one without.

use bevy::{
    camera::{Exposure, Hdr, ImageRenderTarget, RenderTarget, visibility::RenderLayers},
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    math::Affine2,
    prelude::*,
    render::{
        gpu_readback::{Readback, ReadbackComplete},
        render_resource::{TextureFormat, TextureUsages},
    },
    tasks::{AsyncComputeTaskPool, Task, futures::check_ready},
};
use bevy_voxel_gi::{VoxelGiReport, VoxelGiState};

use crate::{
    boxes::{Agreement, agreement, block_means, trace},
    content,
    headless::LabTarget,
    path_tracer::{TraceSettings, TracedPicture},
    runner::{PictureArea, SceneSettings, Side},
    scenes::{
        QUAD_LAYER, quad_camera,
        voxel_gi::stage::{self, EV100, EV100_OF_ONE, FOV, Part, SIZE, Stage},
    },
};

/// The traced picture, as far as it is.
#[derive(Resource, Default)]
pub struct Truth {
    /// Paths from each pixel of the picture.
    samples: u32,
    task: Option<Task<TracedPicture>>,
    picture: Option<TracedPicture>,
    shown: Option<Handle<Image>>,
    /// The live pictures before and after, as they come in.
    live: [Option<Vec<Vec3>>; 2],
    found: Option<Agreement>,
    /// The box is on stage.
    is_open: bool,
}

impl Truth {
    /// Something is still to come.
    pub fn is_waiting(&self) -> bool {
        self.is_open && self.found.is_none()
    }

    /// What there is to say.
    pub fn note(&self) -> Option<String> {
        if !self.is_open {
            return None;
        }
        Some(match (&self.picture, self.found) {
            (None, _) => "the picture is being traced".into(),
            (_, None) => "compared once the light has settled".into(),
            (_, Some(found)) => format!(
                "{:.1}% error and {:+.1}% bias of the light that bounces",
                100.0 * found.relative_error,
                100.0 * found.bias
            ),
        })
    }
}

/// Starts to trace when the box comes on stage or the number of paths changes, and takes what was traced.
pub fn receive(
    stage: Res<Stage>,
    settings: Res<SceneSettings>,
    mut truth: ResMut<Truth>,
    mut images: ResMut<Assets<Image>>,
) {
    if truth.is_open != stage.has_truth() {
        truth.is_open = stage.has_truth();
        (truth.live, truth.found) = ([None, None], None);
    }
    let samples = settings.integer("paths");
    if truth.samples != samples {
        truth.samples = samples;
        (truth.task, truth.picture, truth.found) = (None, None, None);
    }
    if !truth.is_open || truth.picture.is_some() {
        return;
    }
    let task = truth.task.get_or_insert_with(|| {
        AsyncComputeTaskPool::get().spawn(async move {
            let settings = TraceSettings {
                samples,
                ..default()
            };
            trace(&stage::scene(), &settings)
        })
    });
    if let Some(picture) = check_ready(task) {
        truth.task = None;
        let image = image(&picture.total);
        let shown = truth.shown.as_ref().map(Handle::id);
        if shown.is_none_or(|shown| images.insert(shown, image.clone()).is_err()) {
            truth.shown = Some(images.add(image));
        }
        truth.picture = Some(picture);
    }
}

/// A picture as a display shows it, exposed as the live one and not tone-mapped either.
fn image(radiance: &[Vec3]) -> Image {
    let exposure = Exposure { ev100: EV100 }.exposure();
    let texels = radiance.iter().flat_map(|radiance| {
        let color = Srgba::from(LinearRgba::from_vec3(exposure * *radiance));
        let [r, g, b] = [color.red, color.green, color.blue].map(|c| (c * 255.0).round() as u8);
        [r, g, b, 255]
    });
    content::texture(
        SIZE.into(),
        TextureFormat::Rgba8UnormSrgb,
        1,
        texels.collect(),
    )
}

/// The camera of the quad, and the area for which it was placed.
#[derive(Component)]
pub struct PictureView(URect);

/// Shows the box's part of the traced picture in the right half of the area.
pub fn place_picture(
    mut commands: Commands,
    truth: Res<Truth>,
    area: Res<PictureArea>,
    target: Res<LabTarget>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<ColorMaterial>>,
    views: Query<(Entity, &PictureView)>,
    quads: Query<(), With<Quad>>,
) {
    let shown = truth.shown.as_ref().filter(|_| truth.is_open);
    let Some(shown) = shown.filter(|_| !area.0.is_empty()) else {
        for (view, _) in &views {
            commands.entity(view).despawn();
        }
        return;
    };
    if quads.is_empty() {
        let mut left_half = ColorMaterial::from(shown.clone());
        left_half.uv_transform = Affine2::from_scale(Vec2::new(0.5, 1.0));
        commands.spawn((
            Quad,
            Mesh2d(meshes.add(Rectangle::from_length(1.0))),
            MeshMaterial2d(materials.add(left_half)),
            RenderLayers::layer(QUAD_LAYER),
        ));
    }
    if views.iter().any(|(_, view)| view.0 == area.0) {
        return;
    }
    for (view, _) in &views {
        commands.entity(view).despawn();
    }
    let half = UVec2::new(area.0.width() / 2, area.0.height());
    let scale = (half.as_vec2() / Vec2::new(0.5 * SIZE.x as f32, SIZE.y as f32)).min_element();
    let size = (scale * Vec2::new(0.5 * SIZE.x as f32, SIZE.y as f32))
        .as_uvec2()
        .max(UVec2::ONE);
    let corner = area.0.min + UVec2::new(area.0.width() - half.x, 0) + (half - size) / 2;
    let shown = URect::from_corners(corner, corner + size);
    commands.spawn((PictureView(area.0), quad_camera(shown, &target)));
}

/// What shows the traced picture.
#[derive(Component)]
pub struct Quad;

/// A camera of the comparison, and where it draws to.
#[derive(Component)]
pub struct Compared {
    side: usize,
    image: Handle<Image>,
}

/// Takes the live pictures each time that the light has settled, and compares them.
pub fn compare(
    mut commands: Commands,
    mut truth: ResMut<Truth>,
    report: Res<VoxelGiReport>,
    mut images: ResMut<Assets<Image>>,
    cameras: Query<(Entity, &Compared, Has<Readback>)>,
) {
    if !truth.is_open {
        return;
    }
    if cameras.is_empty() {
        spawn_cameras(&mut commands, &mut images);
        return;
    }
    if report.state != VoxelGiState::Settled {
        if truth.found.is_some() || truth.live.iter().any(Option::is_some) {
            (truth.live, truth.found) = ([None, None], None);
        }
        return;
    }
    if truth.found.is_some() || truth.picture.is_none() {
        return;
    }
    for (entity, camera, is_reading) in &cameras {
        if truth.live[camera.side].is_none() && !is_reading {
            let readback = Readback::texture(camera.image.clone());
            commands.entity(entity).insert(readback);
        }
    }
    if let (Some(picture), [Some(before), Some(after)]) = (&truth.picture, &truth.live) {
        let bounced: Vec<Vec3> = after.iter().zip(before).map(|(a, b)| a - b).collect();
        let found = agreement(
            &bounced,
            picture.width,
            &block_means(&picture.indirect, picture.width),
        );
        truth.found = Some(found);
    }
}

fn spawn_cameras(commands: &mut Commands, images: &mut Assets<Image>) {
    let scene = stage::scene();
    for (index, side) in Side::BOTH.into_iter().enumerate() {
        let mut image = Image::new_target_texture(SIZE.x, SIZE.y, TextureFormat::Rgba32Float, None);
        image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
        let image = images.add(image);
        let mut camera = commands.spawn((
            Part,
            Compared {
                side: index,
                image: image.clone(),
            },
            Camera3d::default(),
            Camera {
                order: -2 + index as isize,
                ..default()
            },
            RenderTarget::Image(ImageRenderTarget::from(image)),
            side.layers().with(0),
            Hdr,
            Msaa::Off,
            Tonemapping::None,
            DebandDither::Disabled,
            Exposure {
                ev100: EV100_OF_ONE,
            },
            Projection::Perspective(PerspectiveProjection {
                fov: FOV.to_radians(),
                ..default()
            }),
            Transform::from_translation(scene.camera.eye)
                .looking_at(scene.camera.target, scene.camera.up),
        ));
        camera.observe(take);
    }
}

/// Keeps the pixels of a live picture.
fn take(
    event: On<ReadbackComplete>,
    mut commands: Commands,
    mut truth: ResMut<Truth>,
    cameras: Query<&Compared>,
) {
    let Ok(camera) = cameras.get(event.entity) else {
        return;
    };
    commands.entity(event.entity).remove::<Readback>();
    let texels: Vec<Vec4> = event.to_shader_type();
    let pixels = texels.into_iter().map(Vec4::truncate);
    truth.live[camera.side] = Some(pixels.collect());
}
