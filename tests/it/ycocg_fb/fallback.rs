//! What cannot be packed or drawn in three small floats: the picture is Bevy's own and the reason is given.

use std::sync::atomic::{AtomicBool, Ordering};

use bevy::{
    camera::{ClearColorConfig, CompositingSpace, Hdr, MainPassResolutionOverride},
    core_pipeline::{
        oit::OrderIndependentTransparencySettings,
        prepass::{DeferredPrepass, DepthPrepass},
    },
    ecs::system::EntityCommands,
    light::atmosphere::{Atmosphere, ScatteringMedium},
    math::UVec4,
    pbr::{
        AtmosphereSettings, ScreenSpaceReflections,
        wireframe::{Wireframe, WireframePlugin},
    },
    prelude::*,
    render::{
        ExtractSchedule, Render, RenderApp, RenderSystems,
        render_resource::TextureFormat,
        sync_world::TemporaryRenderEntity,
        view::{ColorGrading, ExtractedView, Msaa, RetainedViewEntity},
    },
};
use bevy_ycocg_fb::{
    CameraState, FallbackReason as Reason, FrameBufferQuality, PackedFormat, YCoCgFrameBuffer,
};

use super::{Studio, clear_to, lit_scene, packing, with, without};
use crate::support::{gpu, skipped};
type Change = fn(&mut EntityCommands);

fn without_clear() -> Camera {
    Camera {
        clear_color: ClearColorConfig::None,
        ..default()
    }
}

#[test]
fn each_obstacle_is_named_and_without_it_the_camera_packs() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    studio.mode(true, Msaa::Off);
    let unorm8 = YCoCgFrameBuffer::with_format(PackedFormat::Unorm8).into();
    let cases: [(FrameBufferQuality, Reason, Change, Change); 4] = [
        (
            packing(),
            Reason::DeferredPrepass,
            with::<(DepthPrepass, DeferredPrepass)>,
            without::<(DepthPrepass, DeferredPrepass)>,
        ),
        (
            packing(),
            Reason::NoClear,
            |camera| clear_to(camera, ClearColorConfig::None),
            |camera| clear_to(camera, ClearColorConfig::Default),
        ),
        (
            packing(),
            Reason::TransparentBackground,
            |camera| clear_to(camera, Color::NONE.into()),
            |camera| clear_to(camera, ClearColorConfig::Default),
        ),
        (unorm8, Reason::Unorm8WithHdr, |_| {}, |_| {}),
    ];
    for (quality, reason, configure, undress) in cases {
        studio.camera(configure).check_fallback(quality, reason);
        // The obstacle gone, it packs.
        studio.camera(undress).packed(packing());
    }
}

#[test]
fn a_compositing_space_is_linear_for_3d_cameras() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    studio.mode(true, Msaa::Off);
    let linear = studio.packed(packing());
    studio.camera(|camera| {
        camera.insert(CompositingSpace::Oklab);
    });
    assert!(studio.packed(packing()) == linear);
}

#[test]
fn a_camera_that_sees_wireframes_is_bevys_own() {
    let _gpu = gpu();
    let mut studio = Studio::new(|app| {
        app.add_plugins(WireframePlugin::default());
        lit_scene(app);
    });
    studio.mode(true, Msaa::Off);
    let world = studio.app.world_mut();
    let mesh = world
        .query_filtered::<Entity, With<Mesh3d>>()
        .iter(world)
        .next()
        .expect("a mesh");
    world.entity_mut(mesh).insert(Wireframe);
    studio.check_fallback(packing(), Reason::Wireframes);
    studio
        .app
        .world_mut()
        .entity_mut(mesh)
        .remove::<Wireframe>();
    studio.packed(packing());
}

/// Checks a component of Bevy that uses the main pass; prepasses that it requires go with it.
fn check_component<C: Component + Default>(studio: &mut Studio, reason: Reason) {
    studio.mode(true, Msaa::Off).camera(with::<C>);
    studio.check_fallback(packing(), reason);
    studio
        .camera(without::<(C, DepthPrepass, DeferredPrepass)>)
        .packed(packing());
}

#[test]
fn a_camera_with_screen_space_reflections_is_bevys_own() {
    let _gpu = gpu();
    check_component::<ScreenSpaceReflections>(&mut Studio::lit(), Reason::ScreenSpaceReflections);
}

#[test]
fn a_camera_with_order_independent_transparency_is_bevys_own() {
    let _gpu = gpu();
    let reason = Reason::OrderIndependentTransparency;
    check_component::<OrderIndependentTransparencySettings>(&mut Studio::lit(), reason);
}

/// In both formats.
#[test]
fn a_camera_with_an_atmosphere_is_bevys_own_in_both_formats() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    if studio.app.adapter().driver.contains("Mesa 22.") {
        skipped("frame buffer and Bevy's atmosphere: this software driver ends the process");
        return;
    }
    let world = studio.app.world_mut();
    let medium = world.add_asset(ScatteringMedium::default());
    world.spawn(Atmosphere::earth(medium));
    studio.mode(true, Msaa::Off).camera(|camera| {
        camera.insert(AtmosphereSettings::default());
    });
    studio.check_fallback(FrameBufferQuality::Compact, Reason::Atmosphere);
    check_component::<AtmosphereSettings>(&mut studio, Reason::Atmosphere);
}

#[test]
fn a_camera_with_a_smaller_main_pass_is_bevys_own() {
    static SMALLER: AtomicBool = AtomicBool::new(false);
    let _gpu = gpu();
    let mut studio = Studio::new(|app| {
        let override_resolution =
            |mut commands: Commands, views: Query<Entity, With<ExtractedView>>| {
                for view in &views {
                    let mut view = commands.entity(view);
                    if SMALLER.load(Ordering::Relaxed) {
                        view.insert(MainPassResolutionOverride(UVec2::new(64, 48)));
                    } else {
                        view.remove::<MainPassResolutionOverride>();
                    }
                }
            };
        app.sub_app_mut(RenderApp)
            .add_systems(ExtractSchedule, override_resolution);
        lit_scene(app);
    });
    studio.mode(true, Msaa::Off);
    SMALLER.store(true, Ordering::Relaxed);
    studio.check_fallback(packing(), Reason::ResolutionOverride);
    SMALLER.store(false, Ordering::Relaxed);
    studio.packed(packing());
}

#[test]
fn a_camera_whose_picture_another_continues_is_bevys_own() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    studio.mode(true, Msaa::Sample4);
    let from_aside = Transform::from_xyz(2.5, 1.4, 1.0).looking_at(Vec3::ZERO, Vec3::Y);
    let second = (Camera3d::default(), Hdr, Msaa::Sample4, from_aside);
    let second = studio.spawn_beside(without_clear(), second);
    studio.check_fallback(packing(), Reason::ContinuedByMultisampled);
    studio.app.world_mut().despawn(second);
    studio.packed(packing());
}

#[test]
fn a_camera_of_two_dimensions_stays_bevys_own() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    let (flat, _) = studio.spawn_to_image([16, 16], (Camera2d, packing()));
    studio.picture();
    let state = studio.state_of(flat);
    assert_eq!(state, Some(CameraState::Fallback(Reason::Not3d)));
}

#[test]
fn what_cannot_be_drawn_so_is_named() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    studio.mode(true, Msaa::Off).camera(|camera| {
        clear_to(camera, Color::NONE.into());
    });
    studio.check_fallback(FrameBufferQuality::Compact, Reason::TransparentBackground);
    studio.camera(|camera| {
        clear_to(camera, ClearColorConfig::Default);
    });

    let second = (
        Camera3d::default(),
        Hdr,
        Msaa::Off,
        FrameBufferQuality::Exact,
    );
    let second = studio.spawn_beside(without_clear(), second);
    let why = "It has `Exact`.".into();
    let reason = Reason::ContinuedInAnotherFormat(why);
    studio.check_fallback(FrameBufferQuality::Compact, reason);
    studio.app.world_mut().despawn(second);
    studio.rg11b10ufloat();
}

/// As `bevy_egui` does, whose pipelines take their format from `Hdr` alone.
#[test]
fn a_plugin_that_draws_over_the_picture_keeps_bevys_format() {
    let _gpu = gpu();
    let mut studio = Studio::new(|app| {
        app.sub_app_mut(RenderApp).add_systems(
            Render,
            (|mut commands: Commands, cameras: Query<&ExtractedView>| {
                for view in &cameras {
                    let id = view.retained_view_entity;
                    if id.subview_index == 0 && id.auxiliary_entity.is_none() {
                        let over = ExtractedView {
                            retained_view_entity: RetainedViewEntity::new(id.main_entity, None, 77),
                            clip_from_view: Mat4::IDENTITY,
                            world_from_view: GlobalTransform::IDENTITY,
                            clip_from_world: None,
                            target_format: TextureFormat::Rgba16Float,
                            viewport: UVec4::new(0, 0, 1, 1),
                            color_grading: ColorGrading::default(),
                            invert_culling: false,
                        };
                        commands.spawn((over, TemporaryRenderEntity::default()));
                    }
                }
            })
            .in_set(RenderSystems::ExtractCommands),
        );
        lit_scene(app);
    });
    studio.mode(true, Msaa::Off);
    studio.quality(FrameBufferQuality::Compact);
    assert_eq!(
        studio.state(),
        Some(CameraState::Fallback(Reason::DrawnOver))
    );
}
