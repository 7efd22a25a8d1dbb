//! Several cameras that draw one picture, as a view model over a world does.

use bevy::{
    camera::{ClearColorConfig, Hdr, MsaaWriteback, Viewport, visibility::RenderLayers},
    prelude::*,
    render::view::Msaa,
};
use bevy_frugal_lab::headless::LabTarget;
use bevy_ycocg_fb::{CameraState, FrameBufferQuality as Quality, FrameBufferReport};
use image::RgbImage;

use super::scene::{Studio, packing};
use crate::support::{gpu, psnr};

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
        let world = studio.app.world_mut();
        let target = world.resource::<LabTarget>().0.clone();
        let camera = Camera {
            order: 1,
            clear_color: self.clear_color,
            msaa_writeback: self.writeback,
            viewport: self.viewport.clone(),
            ..default()
        };
        let mut above = world.spawn((camera, target, self.msaa, RenderLayers::layer(1)));
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
    let mesh = world.add_asset(Cuboid::from_length(0.6));
    let material = world.add_asset::<StandardMaterial>(Color::srgb(0.1, 0.9, 0.1));
    let arm = (
        Mesh3d(mesh),
        MeshMaterial3d(material),
        RenderLayers::layer(1),
    );
    world.spawn((arm, Transform::from_xyz(0.6, 0.3, -2.0)));
    world.spawn((
        DirectionalLight::default(),
        RenderLayers::layer(1),
        Transform::from_xyz(1.0, 2.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

fn set_quality(studio: &mut Studio, camera: Entity, quality: Option<Quality>) {
    let mut camera = studio.app.world_mut().entity_mut(camera);
    match quality {
        Some(quality) => camera.insert(quality),
        None => camera.remove::<Quality>(),
    };
}

fn state(studio: &Studio, camera: Entity) -> Option<CameraState> {
    let report = studio.app.world().get::<FrameBufferReport>(camera);
    report.map(|report| report.state.clone())
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
            set_quality(&mut studio, arm, of_the_arm);
            let name = format!("view model, {msaa:?}, {of_the_arm:?}");
            studio.check(&name, &reference, Quality::Compact, 45.0);
        }
        assert_eq!(state(&studio, arm), Some(CameraState::Rg11b10Ufloat));
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
        set_quality(&mut studio, arm, of_the_arm);
        let picture = studio.quality(packing());
        assert!(picture == reference, "the picture changed");
        let of_the_world = studio.state();
        assert!(
            matches!(of_the_world, Some(CameraState::Fallback(_))),
            "{of_the_world:?}"
        );
    }
    let of_the_arm = state(&studio, arm);
    assert!(
        matches!(of_the_arm, Some(CameraState::Fallback(_))),
        "{of_the_arm:?}"
    );
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
    let mut stacks = 0;
    for of_the_world in samples {
        for bits in 0..64_u32 {
            let has = |bit: u32| bits >> bit & 1 == 1;
            let above = Above {
                is_3d: has(0),
                hdr: has(1),
                msaa: samples[usize::from(has(2))],
                clear_color: if has(3) {
                    ClearColorConfig::None
                } else {
                    ClearColorConfig::Default
                },
                writeback: if has(4) {
                    MsaaWriteback::Always
                } else {
                    MsaaWriteback::Auto
                },
                viewport: has(5).then(|| half.clone()),
            };
            // In two dimensions there is only a layer without content: half of them is enough.
            if !above.is_defined(of_the_world) || (!above.is_3d && above.viewport.is_some()) {
                continue;
            }
            stacks += 1;
            check(&mut studio, of_the_world, &above);
        }
    }
    println!("{stacks} stacks");
}

fn check(studio: &mut Studio, of_the_world: Msaa, above: &Above) {
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
        set_quality(studio, second, of_the_second.filter(|_| above.is_3d));
        let picture: RgbImage = studio.quality(first);
        let psnr_db = psnr(&reference, &picture);
        let states = [studio.state(), state(studio, second)];
        assert!(
            psnr_db > 33.0,
            "{of_the_world:?} {first:?} below {of_the_second:?} {above:?}: {psnr_db:.2} dB, {states:?}"
        );
    }
    studio.app.world_mut().despawn(second);
}
