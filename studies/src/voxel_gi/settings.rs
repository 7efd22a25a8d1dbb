//! What is measured, by name: two settings that users have by default, one thing changed at a time,
//! and the whole grid of resolution, rays and iterations.

use bevy_voxel_gi::{Bounces, Receiver, Solver, VoxelGiSettings, VoxelLight, Voxelizer};

use crate::{plan::GiPlan, run::TradeoffError, voxel_gi::town::VOLUMES};

/// Prefix of the names of the plugin's spans.
pub const SPANS: &str = "voxel_gi_";

/// A setting and its name in the records.
#[derive(Clone, Debug)]
pub struct Setting {
    /// `trace` or `propagate`, and what differs from the default.
    pub name: String,
    /// The settings; the volume is the scene's.
    pub settings: VoxelGiSettings,
}

/// Rays and iterations of the default settings.
const RAYS: u32 = 32;
const OCCLUSION_RAYS: u32 = 16;
const ITERATIONS: u32 = 96;
/// Resolution of the default settings.
const RESOLUTION: u32 = 32;
/// The finest resolution of which more than the default is measured.
const FINE: u32 = 64;

impl Setting {
    fn new(name: impl Into<String>, resolution: u32, light: VoxelLight) -> Self {
        let mut name = name.into();
        if resolution != RESOLUTION {
            name += &format!(" {resolution}^3");
        }
        Self {
            name,
            settings: VoxelGiSettings {
                resolution,
                light,
                ..VoxelGiSettings::default()
            },
        }
    }

    fn trace(rays: u32, bounces: Bounces, resolution: u32) -> Self {
        let mut name = "trace".to_string();
        if rays != RAYS {
            name += &format!(" {rays} rays");
        }
        if let Bounces::Count(count) = bounces {
            name += &format!(" {count} bounces");
        }
        let solver = Solver::Trace { rays };
        let light = VoxelLight::GlobalIllumination { solver, bounces };
        Self::new(name, resolution, light)
    }

    fn propagate(iterations: u32, resolution: u32) -> Self {
        let mut name = "propagate".to_string();
        if iterations != ITERATIONS {
            name += &format!(" {iterations} steps");
        }
        let light = VoxelLight::GlobalIllumination {
            solver: Solver::Propagate { iterations },
            bounces: Bounces::Endless,
        };
        Self::new(name, resolution, light)
    }

    /// The default solver with something else changed.
    fn variant(text: &str, resolution: u32, change: impl FnOnce(&mut VoxelGiSettings)) -> Self {
        let mut setting = Self::trace(RAYS, Bounces::Endless, resolution);
        setting.name += &format!(" {text}");
        change(&mut setting.settings);
        setting
    }

    /// Whether its picture is to be compared with path-traced light. Round-robin updates come to the same
    /// light, later.
    pub fn is_compared(&self) -> bool {
        matches!(self.settings.light, VoxelLight::GlobalIllumination { .. })
            && self.settings.update_interval == 1
    }
}

/// All settings of a plan, the default ones first.
pub fn settings(plan: &GiPlan) -> Vec<Setting> {
    let base = if plan.resolutions.contains(&RESOLUTION) {
        RESOLUTION
    } else {
        plan.resolutions[0]
    };
    let mut settings = vec![
        Setting::trace(RAYS, Bounces::Endless, base),
        Setting::propagate(ITERATIONS, base),
    ];
    for count in &plan.bounces {
        settings.push(Setting::trace(RAYS, Bounces::Count(*count), base));
    }
    for &resolution in &plan.resolutions {
        let is_finest = resolution > FINE;
        for rays in &plan.rays {
            if !is_finest || *rays == RAYS {
                settings.push(Setting::trace(*rays, Bounces::Endless, resolution));
            }
        }
        for iterations in &plan.iterations {
            // Each of the steps goes through all voxels: of finer ones few such settings are enough.
            if resolution <= RESOLUTION || !is_finest && *iterations == ITERATIONS {
                settings.push(Setting::propagate(*iterations, resolution));
            }
        }
    }
    if plan.variants {
        for samples in [1, 4] {
            let text = format!("{samples} shadow samples");
            settings.push(Setting::variant(&text, base, |settings| {
                settings.shadow_samples = samples;
            }));
        }
        settings.push(Setting::variant("round_robin 4", base, |volume| {
            volume.update_interval = 4;
        }));
        settings.push(Setting::variant("per pixel", base, |volume| {
            volume.receiver = Receiver::PerPixel;
        }));
        for (text, voxelizer) in [
            ("fragment_clipping", Voxelizer::FragmentClipping),
            ("geometry_clipping", Voxelizer::GeometryClipping),
            ("stochastic", Voxelizer::Stochastic { points: 1024 }),
        ] {
            settings.push(Setting::variant(text, base, |settings| {
                settings.voxelizer = voxelizer;
            }));
        }
        let occlusion = VoxelLight::AmbientOcclusion {
            radius: 1.0,
            rays: OCCLUSION_RAYS,
        };
        settings.push(Setting::new("ambient_occlusion", base, occlusion));
    }
    // The defaults are part of the grid.
    let mut names = Vec::new();
    settings.retain(|setting| {
        let is_new = !names.contains(&setting.name);
        names.push(setting.name.clone());
        is_new
    });
    settings
}

/// The settings that the plan names, in the order of [`settings`]; all where it names none. It may name volumes of the
/// town, too.
pub fn selected(plan: &GiPlan) -> Result<Vec<Setting>, TradeoffError> {
    let mut settings = settings(plan);
    let is_unknown = |name: &&String| {
        !settings.iter().any(|setting| setting.name == **name) && !VOLUMES.contains(&name.as_str())
    };
    if let Some(name) = plan.settings.iter().find(is_unknown) {
        return Err(TradeoffError::UnknownSetting {
            name: name.clone(),
            known: { settings.into_iter().map(|setting| setting.name) }
                .chain(VOLUMES.map(String::from))
                .collect(),
        });
    }
    let is_named = |setting: &Setting| plan.settings.contains(&setting.name);
    settings.retain(|setting| plan.settings.is_empty() || is_named(setting));
    Ok(settings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Plan;

    #[test]
    fn settings_have_names_of_their_own_and_are_in_range() {
        for quick in [false, true] {
            let settings = settings(&Plan::new(quick).gi);
            assert!(settings.len() > 3);
            for setting in &settings {
                assert_eq!(
                    setting.settings,
                    setting.settings.clamped(),
                    "{}",
                    setting.name
                );
                let same = settings.iter().filter(|other| {
                    other.name == setting.name || other.settings == setting.settings
                });
                assert_eq!(same.count(), 1, "{}", setting.name);
            }
        }
        let full = settings(&Plan::new(false).gi);
        for name in [
            "trace",
            "propagate",
            "trace 64 rays 64^3",
            "trace 128^3",
            "propagate 256 steps 16^3",
        ] {
            assert!(full.iter().any(|setting| setting.name == name), "{name}");
        }
    }

    #[test]
    fn a_name_that_no_setting_has_is_an_error() {
        let mut plan = Plan::new(true).gi;
        plan.retain_settings(&["trace 8 rays 16^3".into()]);
        let names: Vec<_> = { selected(&plan).expect("a setting").into_iter() }
            .map(|setting| setting.name)
            .collect();
        assert_eq!(names, plan.settings);
        plan.retain_settings(&["trase".into()]);
        let error = selected(&plan).expect_err("no such setting").to_string();
        assert!(
            error.contains("`trase`") && error.contains("trace 8 rays 16^3"),
            "{error}"
        );
    }
}
