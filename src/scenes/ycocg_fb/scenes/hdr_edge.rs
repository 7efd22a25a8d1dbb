//! Lights of a luminance of 10,000 beside black.

use bevy::prelude::*;

use crate::scenes::ycocg_fb::scenes::{
    scene::{TestScene, View},
    shapes::{Random, add, flat, line, triangles},
};

pub(super) const SCENE: TestScene = TestScene {
    name: "hdr_edge",
    description: "tubes of light of up to 10,000 in warm and cold colours before black and dusk",
    view: View::Pixels,
    spawn,
};

/// Colours of the lights, the largest channel 1.
const COLORS: [[f32; 3]; 5] = [
    [1.0, 0.45, 0.12],
    [0.35, 0.6, 1.0],
    [1.0, 0.08, 0.05],
    [1.0, 0.95, 0.8],
    [0.1, 1.0, 0.35],
];

fn spawn(world: &mut World, size: UVec2) {
    world.insert_resource(ClearColor(Color::BLACK));
    let size = size.as_vec2();
    // The lower half is dusk: a dim wall that is not grey.
    let wall = flat(LinearRgba::rgb(0.04, 0.06, 0.11));
    let pose = Transform::from_xyz(0.0, -size.y / 4.0, -1.0);
    add(world, Rectangle::new(size.x, size.y / 2.0), wall, pose);
    let mut random = Random::new(23);
    for i in 0..10 {
        let [r, g, b] = COLORS[i % COLORS.len()];
        // From what a display can just show to what blinds.
        let intensity = [1e4, 3.0, 30.0][i % 3];
        let color = LinearRgba::rgb(r * intensity, g * intensity, b * intensity);
        let center = Vec2::new(
            ((i as f32 + 0.5) / 10.0 - 0.5) * size.x,
            random.between(-0.2, 0.2) * size.y,
        );
        let half = Vec2::from_angle(random.between(0.6, 2.5)) * random.between(0.1, 0.25) * size.y;
        let tube = line(center - half, center + half, random.between(1.0, 9.0));
        let pose = Transform::from_xyz(0.0, 0.0, i as f32 / 10.0);
        add(world, triangles(&tube), flat(color), pose);
    }
}
