//! The two cameras and the line between them.
//!
//! Both cameras have the same pose and projection; each renders its part of the picture area, as
//! a sub-view of the whole, so that the picture continues across the line.

use bevy::{
    camera::{
        CameraOutputMode, SubCameraView, Viewport,
        visibility::{RenderLayers, VisibilitySystems},
    },
    light::SimulationLightSystems,
    prelude::*,
    render::render_resource::BlendState,
    transform::TransformSystems,
};

use crate::{
    headless::{AwaitedWork, LabTarget, Unwatched},
    runner::{Scene, Side},
};

/// Where the line between before and after is.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct Split {
    /// Part of the picture's width that shows "before": 0 (none) to 1 (all). Default 0.5.
    pub position: f32,
}

impl Default for Split {
    fn default() -> Self {
        Self { position: 0.5 }
    }
}

/// Whether the line is drawn and can be dragged, for scenes that show something else at times.
/// Default: it is.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct SplitLine(pub bool);

impl Default for SplitLine {
    fn default() -> Self {
        Self(true)
    }
}

/// The part of the render target that the picture fills, in physical pixels.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PictureArea(pub URect);

impl PictureArea {
    /// Width in pixels of the "before" part.
    pub fn split_width(&self, split: Split) -> u32 {
        let width = self.0.width();
        ((width as f32 * split.position.clamp(0.0, 1.0)).round() as u32).min(width)
    }
}

/// Adds the two cameras of `scene` to `app` and keeps them at the split line.
pub fn add_cameras(app: &mut App, scene: &'static dyn Scene) {
    let spawn = move |mut commands: Commands, target: Res<LabTarget>| {
        for side in Side::BOTH {
            let layer = side.layer();
            let mut camera = commands.spawn((
                side,
                Camera3d::default(),
                Camera {
                    order: layer as isize,
                    ..default()
                },
                target.0.clone(),
                RenderLayers::from_layers(&[0, layer]),
                scene.view(),
            ));
            scene.configure_camera(&mut camera, side);
        }
    };
    app.init_resource::<Split>()
        .init_resource::<SplitLine>()
        .init_resource::<PictureArea>()
        .add_systems(Startup, spawn)
        .add_systems(
            PostUpdate,
            (follow_pose, place_cameras)
                .before(TransformSystems::Propagate)
                .before(bevy::camera::CameraUpdateSystems),
        )
        .add_systems(
            PostUpdate,
            cull_by_whole_picture
                .after(bevy::camera::CameraUpdateSystems)
                .before(VisibilitySystems::UpdateFrusta)
                .before(SimulationLightSystems::UpdateDirectionalLightCascades),
        );
}

/// Bevy gives a projection the aspect of its viewport and culls by that, though a sub-view may look
/// past it: objects aside of the middle would vanish, and shadows too.
fn cull_by_whole_picture(
    area: Res<PictureArea>,
    mut cameras: Query<&mut Projection, (With<Side>, With<Camera>)>,
) {
    let size = area.0.size().as_vec2();
    if size.min_element() < 1.0 {
        return;
    }
    let aspect = size.x / size.y;
    for mut projection in &mut cameras {
        if let Projection::Perspective(view) = &*projection
            && view.aspect_ratio != aspect
            && let Projection::Perspective(view) = &mut *projection
        {
            view.aspect_ratio = aspect;
        }
    }
}

/// The "after" camera goes where the "before" camera is, as that one is steered.
fn follow_pose(mut cameras: Query<(&Side, &mut Transform), With<Camera>>) {
    let pose = cameras
        .iter()
        .find(|(side, _)| **side == Side::Before)
        .map(|(_, transform)| *transform);
    for (side, mut transform) in &mut cameras {
        if let (Side::After, Some(pose)) = (side, pose) {
            transform.set_if_neq(pose);
        }
    }
}

/// Gives each camera its part of the area, or switches it off when it has none. Where nobody watches while the
/// scene computes what its picture needs, the part is one pixel.
fn place_cameras(
    split: Res<Split>,
    area: Res<PictureArea>,
    work: Res<AwaitedWork>,
    unwatched: Option<Res<Unwatched>>,
    mut cameras: Query<(&Side, &mut Camera)>,
) {
    let one_pixel = unwatched.is_some() && !work.0.is_empty();
    let full_size = area.0.size();
    let split_width = area.split_width(*split);
    for (side, mut camera) in &mut cameras {
        let (offset, width) = match side {
            Side::Before => (0, split_width),
            Side::After => (split_width, full_size.x - split_width),
        };
        let active = width > 0 && full_size.y > 0;
        if camera.is_active != active {
            camera.is_active = active;
        }
        if !active {
            continue;
        }
        let size = if one_pixel {
            UVec2::ONE
        } else {
            UVec2::new(width, full_size.y)
        };
        camera.viewport = Some(Viewport {
            physical_position: area.0.min + UVec2::new(offset, 0),
            physical_size: size,
            ..default()
        });
        camera.sub_camera_view = Some(SubCameraView {
            full_size,
            offset: Vec2::new(offset as f32, 0.0),
            size,
        });
        // The second camera must keep what the first has put on the target.
        camera.output_mode = CameraOutputMode::Write {
            blend_state: Some(BlendState::REPLACE),
            clear_color: if offset == 0 {
                ClearColorConfig::Default
            } else {
                ClearColorConfig::None
            },
        };
    }
}
