//! The courtyard by moonlight.

use bevy::{light::GlobalAmbientLight, prelude::*};

use crate::scenes::ycocg_fb::scenes::{lit, scene::TestScene};

pub(super) const SCENE: TestScene = TestScene {
    name: "dark",
    description: "the lit scene by moonlight, a fiftieth as bright",
    spawn,
    ..lit::SCENE
};

const LIGHT: f32 = 1.0 / 50.0;

fn spawn(world: &mut World, size: UVec2) {
    (lit::SCENE.spawn)(world, size);
    let mut lights = world.query::<&mut DirectionalLight>();
    for mut light in lights.iter_mut(world) {
        light.illuminance *= LIGHT;
        light.color = Color::srgb(0.7, 0.85, 1.0);
    }
    world.resource_mut::<GlobalAmbientLight>().brightness *= LIGHT;
    world.insert_resource(ClearColor(Color::BLACK));
}
