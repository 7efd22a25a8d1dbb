//! Targets, viewports and several cameras.

use bevy::{
    camera::{Hdr, Viewport},
    prelude::*,
    render::{render_resource::Extent3d, view::Msaa},
};
use bevy_frugal_lab::headless::LabTarget;
use bevy_ycocg_fb::{FrameBufferQuality, Reconstruction, YCoCgFrameBuffer};
use image::RgbImage;

use super::scene::{Studio, assert_like, lit_scene, packing};
use crate::support::{gpu, keep, psnr};

#[test]
fn pictures_of_odd_sizes_are_near_bevys() {
    let _gpu = gpu();
    // By samples, then by reconstruction. So few pixels have hardly a neighbour to take a chrominance from.
    for (width, height, least) in [
        (1, 1, [[13.0, 13.0], [23.0, 23.0]]),
        (1, 9, [[27.0, 27.0], [24.0, 35.0]]),
        (9, 1, [[26.0, 26.0], [42.0, 28.0]]),
        (2, 2, [[42.0, 42.0], [15.0, 15.0]]),
        (33, 17, [[35.0, 30.0], [30.0, 29.0]]),
        (127, 95, [[42.5, 36.5], [41.5, 35.5]]),
    ] {
        let mut studio = Studio::with_size(width, height, lit_scene);
        for (msaa, least) in [Msaa::Off, Msaa::Sample4].into_iter().zip(least) {
            let reference = studio.mode(true, msaa).plain();
            let reconstructions = [Reconstruction::Guided, Reconstruction::Quad];
            for (reconstruction, least) in reconstructions.into_iter().zip(least) {
                let settings = YCoCgFrameBuffer {
                    reconstruction,
                    ..default()
                };
                let name = format!("{width} x {height}, {msaa:?}, {reconstruction:?}");
                studio.mode(false, msaa);
                studio.check(&name, &reference, settings, least);
            }
        }
    }
}

/// A second camera in the right part of the target, from another side.
fn spawn_second(world: &mut World, viewport: Viewport) -> Entity {
    let target = world.resource::<LabTarget>().0.clone();
    world
        .spawn((
            Camera3d::default(),
            Camera {
                order: 1,
                viewport: Some(viewport),
                ..default()
            },
            target,
            Msaa::Off,
            Transform::from_xyz(2.5, 1.4, 1.0).looking_at(Vec3::new(0.0, 0.4, 0.0), Vec3::Y),
        ))
        .id()
}

fn rectangle(x: u32, y: u32, width: u32, height: u32) -> Viewport {
    Viewport {
        physical_position: UVec2::new(x, y),
        physical_size: UVec2::new(width, height),
        ..default()
    }
}

#[test]
fn viewports_at_odd_offsets_are_near_bevys_whichever_are_packed() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    studio.camera(|camera| {
        camera.entry::<Camera>().and_modify(|mut camera| {
            camera.viewport = Some(rectangle(3, 5, 60, 81));
        });
    });
    let second = spawn_second(studio.app.world_mut(), rectangle(67, 1, 61, 93));
    for msaa in [Msaa::Off, Msaa::Sample4] {
        for hdr in [true, false] {
            let mut set = |first_packed: bool, second_packed: bool, hdr: bool| -> RgbImage {
                for (camera, packed) in [(studio.camera, first_packed), (second, second_packed)] {
                    let mut camera = studio.app.world_mut().entity_mut(camera);
                    camera.insert(msaa);
                    if hdr {
                        camera.insert(Hdr);
                    } else {
                        camera.remove::<Hdr>();
                    }
                    if packed {
                        camera.insert(packing());
                    } else {
                        camera.remove::<FrameBufferQuality>();
                    }
                }
                studio.picture()
            };
            let reference = set(false, false, true);
            keep("split_plain", &reference);
            let packed = set(true, true, hdr);
            keep("split_packed", &packed);
            let both = psnr(&reference, &packed);
            println!("split {msaa:?} hdr {hdr}: {both:.2} dB");
            assert!(both >= 41.0);
            if hdr && msaa == Msaa::Off {
                // One of each kind in one target.
                for (first, second) in [(true, false), (false, true)] {
                    let mixed = psnr(&reference, &set(first, second, true));
                    println!("split, packed {first} {second}: {mixed:.2} dB");
                    assert!(mixed >= 47.5);
                }
            }
        }
    }
}

#[test]
fn a_camera_without_the_component_is_untouched_by_one_with_it() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    let reference = studio.mode(true, Msaa::Sample4).plain();
    // The other draws to a texture of its own.
    studio.spawn_to_image([64, 48], (Camera3d::default(), packing()));
    assert!(studio.picture() == reference, "the picture changed");
}

/// A second camera, and a picture frame in the scene that shows what it draws.
struct Mirror {
    studio: Studio,
    camera: Entity,
    image: Handle<Image>,
    material: Handle<StandardMaterial>,
}

impl Mirror {
    fn new() -> Self {
        let mut studio = Studio::lit();
        let before = Camera {
            order: -1,
            ..default()
        };
        let (camera, image) = studio.spawn_to_image([64, 48], (Camera3d::default(), before, Hdr));
        let world = studio.app.world_mut();
        let mesh = world.add_asset(Rectangle::new(1.6, 1.2));
        let material = world.add_asset::<StandardMaterial>(StandardMaterial {
            base_color_texture: Some(image.clone()),
            unlit: true,
            ..default()
        });
        world.spawn((
            Mesh3d(mesh),
            MeshMaterial3d(material.clone()),
            Transform::from_xyz(0.0, 0.8, 1.0),
        ));
        studio.mode(true, Msaa::Off);
        Self {
            studio,
            camera,
            image,
            material,
        }
    }

    /// What is seen when neither camera is packed, or both are.
    fn picture(&mut self, packed: bool) -> RgbImage {
        let mut camera = self.studio.app.world_mut().entity_mut(self.camera);
        if packed {
            camera.insert(packing());
            self.studio.packed(packing())
        } else {
            camera.remove::<FrameBufferQuality>();
            self.studio.plain()
        }
    }

    fn resize(&mut self, width: u32, height: u32) {
        let world = self.studio.app.world_mut();
        let mut images = world.resource_mut::<Assets<Image>>();
        let mut image = images.get_mut(&self.image).expect("the target");
        image.resize(Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        });
        drop(image);
        // Its bind group is of the former texture.
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        materials
            .get_mut(&self.material)
            .expect("the material")
            .unlit = true;
    }
}

#[test]
fn a_texture_of_a_packed_camera_that_another_shows_is_near_bevys() {
    let _gpu = gpu();
    let mut mirror = Mirror::new();
    let reference = mirror.picture(false);
    let packed = mirror.picture(true);
    assert_like("render to texture", &reference, &packed, 42.0);
}

/// A window in miniature: a target that is resized between frames, and what it shows after each.
#[test]
fn a_target_that_changes_its_size_is_near_bevys() {
    let _gpu = gpu();
    let mut mirror = Mirror::new();
    for (width, height, least) in [(40, 30, 40.5), (97, 49, 42.0), (1, 1, 29.5), (64, 48, 42.0)] {
        // Resized while packed, so that the textures of another size are there.
        mirror.resize(width, height);
        let packed = mirror.picture(true);
        let reference = mirror.picture(false);
        assert_like(&format!("{width} x {height}"), &reference, &packed, least);
        mirror.picture(true);
    }
}
