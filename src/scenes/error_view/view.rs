//! Two cameras off screen and a quad over the picture area that shows their difference.
//!
//! They exist only while the view is open.

use bevy::{
    camera::{ImageRenderTarget, RenderTarget, visibility::RenderLayers},
    core_pipeline::tonemapping::DebandDither,
    prelude::*,
    render::render_resource::TextureFormat,
};

use super::material::ErrorMaterial;
use crate::{
    headless::LabTarget,
    runner::{PictureArea, SceneSettings, Side, SplitLine},
    scenes::quad_camera::{LAYER, quad_camera},
};

/// The part of the target that the open view fills; none when it is closed.
#[derive(Resource, Default)]
pub struct ErrorView(Option<URect>);

/// A camera that shows a side: that of the split (if the scene says so), or one off screen.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct Films(pub Side);

#[derive(Component)]
pub struct OfView;

/// A camera of the view that films the scene.
#[derive(Component)]
pub struct OffScreen;

/// Opens or closes the view, opens it again at another size, and sets its gain.
pub fn open_or_close(
    mut commands: Commands,
    settings: Res<SceneSettings>,
    area: Res<PictureArea>,
    target: Res<LabTarget>,
    mut view: ResMut<ErrorView>,
    mut images: ResMut<Assets<Image>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<ErrorMaterial>>,
    split: Query<(&Side, &Projection, &Transform), With<Camera>>,
    parts: Query<Entity, With<OfView>>,
) {
    let wanted = (settings.choice("view") == "error" && !area.0.is_empty()).then_some(area.0);
    let gain = settings.integer("error_gain") as f32;
    if view.0 == wanted {
        if settings.is_changed() {
            for (_, material) in materials.iter_mut() {
                material.gain = gain;
            }
        }
        return;
    }
    view.0 = wanted;
    for part in &parts {
        commands.entity(part).despawn();
    }
    let before = split.iter().find(|(side, ..)| **side == Side::Before);
    let (Some(area), Some((_, projection, pose))) = (wanted, before) else {
        return;
    };
    let size = area.size();
    let [before, after] = Side::BOTH.map(|side| {
        let format = TextureFormat::Rgba8UnormSrgb;
        let image = images.add(Image::new_target_texture(size.x, size.y, format, None));
        let order = match side {
            Side::Before => -2,
            Side::After => -1,
        };
        commands.spawn((
            OfView,
            OffScreen,
            Films(side),
            Camera3d::default(),
            Camera { order, ..default() },
            RenderTarget::Image(ImageRenderTarget::from(image.clone())),
            side.layers().with(0),
            DebandDither::Disabled,
            projection.clone(),
            *pose,
        ));
        image
    });
    commands.spawn((
        OfView,
        Mesh2d(meshes.add(Rectangle::from_length(1.0))),
        MeshMaterial2d(materials.add(ErrorMaterial {
            before,
            after,
            gain,
        })),
        RenderLayers::layer(LAYER),
    ));
    commands.spawn((OfView, quad_camera(area, &target)));
}

/// The cameras at the split see nothing while the view covers them; they still exist for the
/// reports on their memory.
pub fn hide_split(
    mut commands: Commands,
    view: Res<ErrorView>,
    mut line: ResMut<SplitLine>,
    cameras: Query<(Entity, &Side), With<Camera>>,
) {
    if !view.is_changed() {
        return;
    }
    let is_open = view.0.is_some();
    line.set_if_neq(SplitLine(!is_open));
    for (camera, side) in &cameras {
        let layers = if is_open {
            RenderLayers::none()
        } else {
            side.layers().with(0)
        };
        commands.entity(camera).insert(layers);
    }
}

/// The cameras off screen go where the "before" camera is, as that one is steered.
pub fn follow_pose(
    split: Query<(&Side, &Transform), (With<Camera>, Without<OffScreen>)>,
    mut off_screen: Query<&mut Transform, With<OffScreen>>,
) {
    let Some((_, pose)) = split.iter().find(|(side, _)| **side == Side::Before) else {
        return;
    };
    for mut transform in &mut off_screen {
        transform.set_if_neq(*pose);
    }
}
