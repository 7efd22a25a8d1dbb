//! Objects that follow the mouse over the floor.

use bevy::{prelude::*, window::PrimaryWindow};

use crate::{
    runner::{PictureArea, Side, Split},
    scenes::voxel_gi::room,
};

/// Distance from the split line in logical pixels at which the mouse is the line's.
const LINE: f32 = 10.0;

/// An object that can be dragged.
#[derive(Component)]
pub struct Draggable {
    /// Half its edge, or its radius, in metres.
    pub half: f32,
}

/// What is being dragged.
#[derive(Clone, Copy)]
pub struct Grip {
    object: Entity,
    /// From where it was grabbed to its centre.
    offset: Vec3,
}

/// Follows the mouse while its left button is down.
pub fn drag(
    buttons: Option<Res<ButtonInput<MouseButton>>>,
    windows: Query<&Window, With<PrimaryWindow>>,
    cameras: Query<(&Camera, &GlobalTransform), With<Side>>,
    (area, split): (Res<PictureArea>, Res<Split>),
    mut grip: Local<Option<Grip>>,
    mut objects: Query<(Entity, &Draggable, &mut Transform)>,
) {
    let (Some(buttons), Ok(window)) = (buttons, windows.single()) else {
        return;
    };
    if !buttons.pressed(MouseButton::Left) {
        *grip = None;
        return;
    }
    let Some(cursor) = window.cursor_position() else {
        return;
    };
    let camera = cameras.iter().find(|(camera, _)| {
        let view = camera.logical_viewport_rect();
        camera.is_active && view.is_some_and(|view| view.contains(cursor))
    });
    let Some((camera, pose)) = camera else {
        return;
    };
    let Ok(ray) = camera.viewport_to_world(pose, cursor) else {
        return;
    };
    if buttons.just_pressed(MouseButton::Left) {
        let line = area.0.min.x + area.split_width(*split);
        if (cursor.x - line as f32 / window.scale_factor()).abs() > LINE {
            let at = |pose: &Transform| pose.translation;
            let hits = objects.iter().filter_map(|(object, body, pose)| {
                let distance = sphere_hit(ray, at(pose), body.half)?;
                let grabbed = over_floor(ray, at(pose).y)?;
                let offset = at(pose) - grabbed;
                Some((distance, Grip { object, offset }))
            });
            *grip = hits
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .map(|(_, grip)| grip);
        }
    }
    let Some(Grip { object, offset }) = *grip else {
        return;
    };
    let Ok((_, body, mut pose)) = objects.get_mut(object) else {
        *grip = None;
        return;
    };
    if let Some(at) = over_floor(ray, pose.translation.y) {
        let wanted = kept_inside(at + offset, body.half);
        if wanted.distance(pose.translation) > 1e-4 {
            pose.translation = wanted;
        }
    }
}

/// Distance to a sphere in front of the ray's origin.
fn sphere_hit(ray: Ray3d, center: Vec3, radius: f32) -> Option<f32> {
    let along = (center - ray.origin).dot(*ray.direction);
    let aside = (center - ray.origin).length_squared() - along * along;
    (along > 0.0 && aside <= radius * radius).then_some(along)
}

/// Where the ray comes down to a height.
fn over_floor(ray: Ray3d, height: f32) -> Option<Vec3> {
    let down = -ray.direction.y;
    let distance = (ray.origin.y - height) / down;
    (down > 1e-3 && distance > 0.0).then(|| ray.origin + distance * ray.direction)
}

/// At most at the walls.
fn kept_inside(at: Vec3, half: f32) -> Vec3 {
    let [low, high] = room::INSIDE;
    let free = at.clamp(low + half, high - half);
    Vec3::new(free.x, at.y, free.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(direction: [f32; 3]) -> Ray3d {
        Ray3d {
            origin: Vec3::new(0.0, 2.0, 2.0),
            direction: Dir3::new(direction.into()).expect("a direction"),
        }
    }

    #[test]
    fn a_ray_meets_what_is_before_it() {
        let ray = ray([0.0, -1.0, -1.0]);
        assert!(sphere_hit(ray, Vec3::new(0.1, 0.2, 0.0), 0.3).is_some());
        assert!(sphere_hit(ray, Vec3::new(1.0, 0.2, 0.0), 0.3).is_none());
        assert!(sphere_hit(ray, Vec3::new(0.0, 3.8, 4.0), 0.3).is_none());
        let floor = over_floor(ray, 0.5).expect("below");
        assert!(
            (floor - Vec3::new(0.0, 0.5, 0.5)).length() < 1e-5,
            "{floor}"
        );
    }

    #[test]
    fn no_height_is_met_on_the_way_up() {
        assert!(over_floor(ray([0.0, 1.0, -1.0]), 0.5).is_none());
        assert!(over_floor(ray([0.0, 0.0, -1.0]), 0.5).is_none());
        assert!(over_floor(ray([0.0, -1.0, 0.0]), 2.5).is_none());
    }

    #[test]
    fn walls_stop_objects() {
        let at = kept_inside(Vec3::new(9.0, 0.25, -9.0), 0.25);
        assert_eq!(at, Vec3::new(2.75, 0.25, -2.25));
        let at = Vec3::new(0.5, 0.25, 0.5);
        assert_eq!(kept_inside(at, 0.25), at);
    }
}
