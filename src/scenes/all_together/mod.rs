//! All four plugins in one game: a hall with wavelet textures, EWA on its floor, light that bounces,
//! drawn into a packed frame buffer. Before is Bevy alone; each plugin of after has a switch.
//!
//! | file | contents |
//! | --- | --- |
//! | `hall` | the hall in numbers |
//! | `textures` | its textures, as they are and encoded |
//! | `stage` | its meshes and the sun |
//! | `materials` | the materials that the switches select |
//! | `switches` | what they make of the volume and the cameras |
//! | `figures` | what each plugin reports |

mod figures;
mod hall;
mod materials;
mod stage;
mod switches;
mod textures;

use bevy::{
    camera::{Exposure, Hdr},
    core_pipeline::tonemapping::DebandDither,
    prelude::*,
};
use bevy_ewa::{EwaPlugin, EwaStandardMaterial};
use bevy_voxel_gi::{VoxelGiPlugin, VoxelMaterialPlugin};
use bevy_wavelet_tex::{WaveletStandardMaterial, WaveletTexPlugin};
use bevy_ycocg_fb::YCoCgFrameBufferPlugin;

use crate::{
    headless::AwaitedWork,
    runner::{Scene, SceneSetting, Side},
};

pub struct AllTogether;

/// The switches, one a plugin, in the order of the panel.
pub const SWITCHES: [&str; 4] = ["wavelet_tex", "ycocg_fb", "ewa", "voxel_gi"];

impl Scene for AllTogether {
    fn name(&self) -> &'static str {
        "all_together"
    }

    fn plugin(&self) -> &'static str {
        "bevy_frugal"
    }

    fn description(&self) -> &'static str {
        "A hall: Bevy alone before; compressed textures, a packed frame buffer, elliptical filtering \
         of the floor and bouncing light after, each with a switch"
    }

    fn settings(&self) -> Vec<SceneSetting> {
        let [wavelet_tex, ycocg_fb, ewa, voxel_gi] = SWITCHES;
        vec![
            SceneSetting::toggle(
                wavelet_tex,
                "walls, crates, pictures and plants from wavelet textures",
                true,
            ),
            SceneSetting::toggle(ycocg_fb, "a frame buffer of two channels", true),
            SceneSetting::toggle(ewa, "the floor filtered by ellipses", true),
            SceneSetting::toggle(
                voxel_gi,
                "light that bounces, instead of an ambient light that is the same everywhere",
                true,
            ),
            SceneSetting::choice(
                "color_rate",
                "bits per pixel of the wavelet textures' colours",
                1,
                &["color2.25", "color3", "color3.25", "color5"],
            ),
            SceneSetting::choice(
                "ewa_method",
                "of the floor",
                0,
                &["linear", "reference", "bilinear", "approximate"],
            ),
            SceneSetting::choice(
                "resolution",
                "voxels along an edge of the volume",
                1,
                &["16", "32", "64"],
            ),
            SceneSetting::choice(
                "tone_mapping",
                "of both cameras; none, and dark, for comparisons of light",
                0,
                &["tony_mc_mapface", "none"],
            ),
            SceneSetting::toggle("sun_motion", "the sun wanders", true),
        ]
    }

    fn view(&self) -> Transform {
        hall::view()
    }

    fn build(&self, app: &mut App) {
        app.world_mut()
            .resource_mut::<AwaitedWork>()
            .0
            .insert(figures::LIGHT);
        app.add_plugins((
            WaveletTexPlugin,
            YCoCgFrameBufferPlugin,
            EwaPlugin::OPT_IN,
            VoxelGiPlugin,
            // What bounces off the floor is known, whichever of its materials it has.
            VoxelMaterialPlugin::<EwaStandardMaterial>::default(),
            VoxelMaterialPlugin::<WaveletStandardMaterial>::default(),
        ))
        .insert_resource(GlobalAmbientLight::NONE)
        .insert_resource(ClearColor(hall::background()))
        .init_resource::<textures::Textures>()
        .init_resource::<materials::PlainMaterials>()
        .init_resource::<figures::TextureBytes>()
        .add_systems(Startup, stage::spawn)
        .add_systems(
            Update,
            (
                (
                    materials::before,
                    materials::after,
                    switches::place_volume,
                    switches::configure_cameras,
                )
                    .chain()
                    .run_if(resource_changed::<crate::runner::SceneSettings>),
                stage::move_sun,
                figures::show,
            )
                .chain(),
        );
    }

    fn configure_camera(&self, camera: &mut EntityCommands, _: Side) {
        camera.insert((Hdr, DebandDither::Disabled, Exposure { ev100: hall::EV100 }));
    }
}
