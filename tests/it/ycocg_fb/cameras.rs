//! Targets, viewports and several cameras, also of one picture, as a view model over a world does.

use bevy::{
    camera::{ClearColorConfig, Hdr, MsaaWriteback, Viewport, visibility::RenderLayers},
    image::ToExtents,
    prelude::*,
    render::view::Msaa,
};
use bevy_ycocg_fb::{CameraState, FrameBufferQuality as Quality, Reconstruction, YCoCgFrameBuffer};
use image::RgbImage;

use super::{Studio, assert_like, lit_scene, packing, spawn_mesh};
use crate::support::{drawn, gpu, keep, psnr};

#[test]
fn pictures_of_odd_sizes_are_near_bevys() {
    let _gpu = gpu();
    // By samples, then by reconstruction. So few pixels have hardly a neighbour to take a chrominance from.
    let rows = [
        (1, 1, [[13.0, 13.0], [23.0, 23.0]]),
        (1, 9, [[27.0, 27.0], [24.0, 35.0]]),
        (9, 1, [[26.0, 26.0], [42.0, 28.0]]),
        (2, 2, [[42.0, 42.0], [15.0, 15.0]]),
        (33, 17, [[35.0, 30.0], [30.0, 29.0]]),
        (127, 95, [[42.5, 36.5], [41.5, 35.5]]),
    ];
    for (width, height, least) in drawn(2, rows) {
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
    // In the right part of the target, from another side.
    let camera = Camera {
        viewport: Some(rectangle(67, 1, 61, 93)),
        ..default()
    };
    let place = Transform::from_xyz(2.5, 1.4, 1.0).looking_at(Vec3::new(0.0, 0.4, 0.0), Vec3::Y);
    let second = studio.spawn_beside(camera, (Camera3d::default(), Msaa::Off, place));
    for msaa in [Msaa::Off, Msaa::Sample4] {
        for hdr in [true, false] {
            let mut set = |first_packed: bool, second_packed: bool, hdr: bool| -> RgbImage {
                for (camera, packed) in [(studio.camera, first_packed), (second, second_packed)] {
                    studio.set_quality(camera, packed.then(packing));
                    let mut camera = studio.app.world_mut().entity_mut(camera);
                    camera.insert(msaa);
                    if hdr {
                        camera.insert(Hdr);
                    } else {
                        camera.remove::<Hdr>();
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
        let quality = packed.then(packing);
        self.studio.set_quality(self.camera, quality);
        match quality {
            Some(quality) => self.studio.packed(quality),
            None => self.studio.plain(),
        }
    }

    fn resize(&mut self, width: u32, height: u32) {
        let world = self.studio.app.world_mut();
        let mut images = world.resource_mut::<Assets<Image>>();
        let mut image = images.get_mut(&self.image).expect("the target");
        image.resize(UVec2::new(width, height).to_extents());
        drop(image);
        // Its bind group is of the former texture.
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        let mut material = materials.get_mut(&self.material).expect("the material");
        material.unlit = true;
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

/// What is on top of the world.
#[derive(Clone, Debug)]
struct Above {
    is_3d: bool,
    hdr: bool,
    msaa: Msaa,
    clear_color: ClearColorConfig,
    writeback: MsaaWriteback,
    viewport: Option<Viewport>,
}

impl Above {
    /// The camera of a view model, with Bevy's defaults.
    fn view_model(msaa: Msaa) -> Self {
        Self {
            is_3d: true,
            hdr: true,
            msaa,
            clear_color: ClearColorConfig::Default,
            writeback: MsaaWriteback::Auto,
            viewport: None,
        }
    }

    fn spawn(&self, studio: &mut Studio) -> Entity {
        let camera = Camera {
            clear_color: self.clear_color,
            msaa_writeback: self.writeback,
            viewport: self.viewport.clone(),
            ..default()
        };
        let above = studio.spawn_beside(camera, (self.msaa, RenderLayers::layer(1)));
        let mut above = studio.app.world_mut().entity_mut(above);
        if self.is_3d {
            above.insert(Camera3d::default());
        } else {
            above.insert(Camera2d);
        }
        if self.hdr {
            above.insert(Hdr);
        }
        above.id()
    }

    /// Whether Bevy draws both cameras into the same textures, and what of the world is seen is defined.
    fn is_defined(&self, world: Msaa) -> bool {
        let shares = self.hdr && self.msaa == world;
        let keeps = matches!(self.clear_color, ClearColorConfig::None)
            || (self.writeback == MsaaWriteback::Always && self.msaa == Msaa::Sample4);
        shares || !keeps
    }
}

/// A green cube close to the cameras, on the layer of the view model.
fn spawn_arm(studio: &mut Studio) {
    let world = studio.app.world_mut();
    let green = StandardMaterial::from(Color::srgb(0.1, 0.9, 0.1));
    let place = Transform::from_xyz(0.6, 0.3, -2.0);
    let arm = spawn_mesh(world, Cuboid::from_length(0.6), green, place);
    world.entity_mut(arm).insert(RenderLayers::layer(1));
    world.spawn((
        DirectionalLight::default(),
        RenderLayers::layer(1),
        Transform::from_xyz(1.0, 2.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

#[test]
fn a_compact_world_with_a_view_model_on_top() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    spawn_arm(&mut studio);
    for msaa in [Msaa::Off, Msaa::Sample4] {
        let clear_color = match msaa {
            // Without samples Bevy does not go on by itself.
            Msaa::Off => ClearColorConfig::None,
            _ => ClearColorConfig::Default,
        };
        let above = Above {
            clear_color,
            ..Above::view_model(msaa)
        };
        let world_alone = studio.mode(true, msaa).plain();
        let arm = above.spawn(&mut studio);
        let reference = studio.plain();
        assert!(psnr(&world_alone, &reference) < 30.0, "no arm");
        for of_the_arm in [None, Some(Quality::Compact)] {
            studio.set_quality(arm, of_the_arm);
            let name = format!("view model, {msaa:?}, {of_the_arm:?}");
            studio.check(&name, &reference, Quality::Compact, 45.0);
        }
        assert_eq!(studio.state_of(arm), Some(CameraState::Rg11b10Ufloat));
        studio.app.world_mut().despawn(arm);
    }
}

#[test]
fn a_packed_world_with_a_view_model_on_top() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    spawn_arm(&mut studio);
    let arm = Above::view_model(Msaa::Sample4).spawn(&mut studio);
    let reference = studio.mode(true, Msaa::Sample4).plain();
    for of_the_arm in [None, Some(packing())] {
        studio.set_quality(arm, of_the_arm);
        let picture = studio.quality(packing());
        assert!(picture == reference, "the picture changed");
        let state = studio.state();
        assert!(matches!(state, Some(CameraState::Fallback(_))), "{state:?}");
    }
    let state = studio.state_of(arm);
    assert!(matches!(state, Some(CameraState::Fallback(_))), "{state:?}");
}

/// Whatever the cameras are, they show what Bevy shows.
#[test]
fn every_stack_shows_what_bevy_shows() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    spawn_arm(&mut studio);
    let samples = [Msaa::Off, Msaa::Sample4];
    let half = Viewport {
        physical_position: UVec2::new(63, 0),
        physical_size: UVec2::new(65, 96),
        ..default()
    };
    let mut stacks = Vec::new();
    for of_the_world in samples {
        for bits in 0..64_u32 {
            let has = |bit: u32| bits >> bit & 1 == 1;
            let above = Above {
                is_3d: has(0),
                hdr: has(1),
                msaa: samples[usize::from(has(2))],
                clear_color: [ClearColorConfig::Default, ClearColorConfig::None]
                    [usize::from(has(3))],
                writeback: [MsaaWriteback::Auto, MsaaWriteback::Always][usize::from(has(4))],
                viewport: has(5).then(|| half.clone()),
            };
            // In two dimensions there is only a layer without content: half of them is enough.
            if !above.is_defined(of_the_world) || (!above.is_3d && above.viewport.is_some()) {
                continue;
            }
            stacks.push((of_the_world, above));
        }
    }
    println!("{} stacks", stacks.len());
    for (of_the_world, above) in drawn(5, stacks) {
        check_stack(&mut studio, of_the_world, &above);
    }
}

fn check_stack(studio: &mut Studio, of_the_world: Msaa, above: &Above) {
    let second = above.spawn(studio);
    let reference = studio.mode(true, of_the_world).plain();
    for (first, of_the_second) in [
        (Quality::Compact, None),
        (Quality::Compact, Some(Quality::Compact)),
        (packing(), None),
        (packing(), Some(packing())),
        (Quality::Exact, Some(Quality::Compact)),
        (Quality::Compact, Some(packing())),
    ] {
        studio.set_quality(second, of_the_second.filter(|_| above.is_3d));
        let picture: RgbImage = studio.quality(first);
        let psnr_db = psnr(&reference, &picture);
        let states = [studio.state(), studio.state_of(second)];
        assert!(
            psnr_db > 33.0,
            "{of_the_world:?} {first:?} below {of_the_second:?} {above:?}: {psnr_db:.2} dB, {states:?}"
        );
    }
    studio.app.world_mut().despawn(second);
}
