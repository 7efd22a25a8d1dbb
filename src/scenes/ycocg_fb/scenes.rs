//! The scenes that the frame buffer is measured on.
//!
//! | scene | what it is hard for |
//! | --- | --- |
//! | `lit` | nothing in particular: textures, lights and shadows as in a game |
//! | `equal_luminance_edges` | filters that look for edges in luminance: there are none |
//! | `thin_lines` | filters that need a neighbour of the same surface |
//! | `foliage` | all filters: detail as fine as a pixel, in luminance and chrominance |
//! | `hdr_edge` | filters that compare absolute values: 10,000 beside 0 |
//! | `dark` | filters that compare absolute values, and formats: 0.01 on average |

use bevy::{
    camera::{Exposure, Hdr, ScalingMode},
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    ecs::entity::EntityHashSet,
    light::GlobalAmbientLight,
    prelude::*,
};

pub use self::shapes::add;
use crate::headless::LabTarget;

mod flat;
mod lit;
mod shapes;

pub const SCENES: [TestScene; 6] = [
    lit::LIT,
    flat::EQUAL_LUMINANCE_EDGES,
    flat::THIN_LINES,
    lit::FOLIAGE,
    flat::HDR_EDGE,
    lit::DARK,
];

/// A scene, without its camera.
#[derive(Clone, Copy, Debug)]
pub struct TestScene {
    /// Its name in the records.
    pub name: &'static str,
    pub description: &'static str,
    view: View,
    spawn: fn(&mut World, UVec2),
}

/// Where the camera stands.
#[derive(Clone, Copy, Debug)]
enum View {
    /// At a point, looking at another.
    Perspective { eye: Vec3, target: Vec3 },
    /// One unit is one pixel, the origin in the middle.
    Pixels,
}

impl TestScene {
    /// Spawns the scene and a camera with `Hdr` and no multisampling, which draws to the app's
    /// [`LabTarget`] of `size` pixels.
    pub fn spawn(&self, world: &mut World, size: UVec2, tonemapping: Tonemapping) -> Entity {
        (self.spawn)(world, size);
        let (projection, pose) = self.camera(size);
        let target = world.resource::<LabTarget>().0.clone();
        world
            .spawn((
                Camera3d::default(),
                target,
                Hdr,
                Msaa::Off,
                tonemapping,
                DebandDither::Disabled,
                Exposure::default(),
                projection,
                pose,
            ))
            .id()
    }

    /// Spawns the scene without a camera; gives what it consists of. The colour that cameras clear
    /// to and the ambient light are those of the scene, or Bevy's.
    pub fn spawn_content(&self, world: &mut World, size: UVec2) -> Vec<Entity> {
        type Content = Or<(With<Mesh3d>, With<DirectionalLight>)>;
        let mut query = world.query_filtered::<Entity, Content>();
        let others: EntityHashSet = query.iter(world).collect();
        world.insert_resource(ClearColor::default());
        world.insert_resource(GlobalAmbientLight::default());
        (self.spawn)(world, size);
        let content = query.iter(world);
        content.filter(|entity| !others.contains(entity)).collect()
    }

    /// Projection and pose of a camera that draws pictures of `size` pixels.
    pub fn camera(&self, size: UVec2) -> (Projection, Transform) {
        match self.view {
            View::Perspective { eye, target } => (
                Projection::from(PerspectiveProjection::default()),
                Transform::from_translation(eye).looking_at(target, Vec3::Y),
            ),
            View::Pixels => (
                Projection::from(OrthographicProjection {
                    scaling_mode: ScalingMode::Fixed {
                        width: size.x as f32,
                        height: size.y as f32,
                    },
                    ..OrthographicProjection::default_3d()
                }),
                Transform::from_xyz(0.0, 0.0, 10.0),
            ),
        }
    }

    /// Whether a unit is a pixel, so that the content depends on the size of the picture.
    pub fn is_in_pixels(&self) -> bool {
        matches!(self.view, View::Pixels)
    }
}
