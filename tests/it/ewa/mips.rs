//! Mip chains of textures that come without.

use bevy::prelude::*;
use bevy_ewa::{EwaMethod, EwaPlugin, EwaSettings};

use super::scene::{Floor, checkered, psnr};
use crate::support::gpu;

fn levels(floor: &Floor) -> u32 {
    let world = floor.app.world();
    let materials = world.resource::<Assets<StandardMaterial>>();
    let material = materials.get(&floor.material).expect("the material");
    let texture = material.base_color_texture.as_ref().expect("a texture");
    let image = world.resource::<Assets<Image>>().get(texture);
    image.expect("the image").texture_descriptor.mip_level_count
}

#[test]
fn a_texture_without_mips_gets_those_it_should_have() {
    let _gpu = gpu();
    let settings = EwaSettings::with_method(EwaMethod::Linear);
    let plugin = EwaPlugin {
        all_materials: Some(settings),
    };
    let with = Floor::new(Some(plugin), checkered(true)).picture();
    let mut floor = Floor::new(Some(plugin), checkered(false));
    for _ in 0..100 {
        if levels(&floor) > 1 {
            break;
        }
        floor.app.render_frames(1).expect("a frame");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    assert_eq!(levels(&floor), 7);
    let made = floor.picture();
    assert!(made == with, "{} dB", psnr(&made, &with));
}

#[test]
fn a_texture_of_materials_that_did_not_ask_gets_none() {
    let _gpu = gpu();
    let mut floor = Floor::new(Some(EwaPlugin::OPT_IN), checkered(false));
    floor.app.render_frames(20).expect("frames");
    assert_eq!(levels(&floor), 1);
    let stock = Floor::new(None, checkered(false)).picture();
    assert!(floor.picture() == stock);
}
