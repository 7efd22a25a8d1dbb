//! Coloured lines of one pixel.

use bevy::{color::Hsva, prelude::*};

use crate::scenes::ycocg_fb::scenes::{
    scene::{TestScene, View},
    shapes::{Random, add, flat, line, triangles},
};

pub(super) const SCENE: TestScene = TestScene {
    name: "thin_lines",
    description: "one-pixel lines of all hues and directions on bright and dark ground",
    view: View::Pixels,
    spawn,
};

fn spawn(world: &mut World, size: UVec2) {
    let size = size.as_vec2();
    let half = size / 2.0;
    // Left half dark, right half bright, as the filters see a line against each differently.
    for (side, shade) in [(-0.5, 0.03), (0.5, 0.6)] {
        let ground = Rectangle::new(half.x, size.y);
        let pose = Transform::from_xyz(side * half.x, 0.0, -1.0);
        add(
            world,
            ground,
            flat(LinearRgba::rgb(shade, shade, shade)),
            pose,
        );
    }
    let mut random = Random::new(11);
    let count = (size.y / 6.0) as usize;
    for i in 0..count {
        let hue = 360.0 * i as f32 / count as f32;
        let color = LinearRgba::from(Hsva::new(hue, 0.9, 0.9, 1.0));
        let level = -half.y + (i as f32 + 0.5) * size.y / count as f32;
        // Every third horizontal, every third vertical: the exact axes are the hardest.
        let (from, to) = match i % 3 {
            0 => (
                Vec2::new(-half.x, level.floor() + 0.5),
                Vec2::new(half.x, level.floor() + 0.5),
            ),
            1 => {
                // In another order than that of the hues, so that neighbours differ.
                let x = -half.x + (i * 37 % count) as f32 * size.x / count as f32;
                let x = x.floor() + 0.5;
                (Vec2::new(x, -half.y), Vec2::new(x, half.y))
            }
            _ => (
                Vec2::new(-half.x, random.between(-half.y, half.y)),
                Vec2::new(half.x, random.between(-half.y, half.y)),
            ),
        };
        let pose = Transform::from_xyz(0.0, 0.0, i as f32 / count as f32);
        add(world, triangles(&line(from, to, 1.0)), flat(color), pose);
    }
}
