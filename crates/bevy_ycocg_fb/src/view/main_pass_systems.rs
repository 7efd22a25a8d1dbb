//! The systems of other plugins in Bevy's main pass, which packed cameras skip.

use bevy::{
    core_pipeline::{
        Core3d, Core3dSystems,
        core_3d::{main_opaque_pass_3d, main_transparent_pass_3d},
        oit::resolve::node::oit_resolve,
    },
    ecs::schedule::{InternedSystemSet, Schedules, SystemSet},
    pbr::{deferred::deferred_lighting, main_transmissive_pass_3d, screen_space_reflections},
    prelude::*,
};

/// This plugin's systems in the main pass.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct OwnMainPass;

/// The first system of another plugin in the main pass.
#[derive(Resource, Debug, Default)]
pub(super) struct MainPassSystems {
    foreign: Option<String>,
    /// The number of systems that were inspected.
    inspected: usize,
}

impl MainPassSystems {
    pub(super) fn foreign(&self) -> Option<&str> {
        self.foreign.as_deref()
    }
}

/// The systems that are replaced, or that do not draw for a packed camera, as sets.
fn known() -> [InternedSystemSet; 7] {
    [
        main_opaque_pass_3d.into_system_set().intern(),
        main_transmissive_pass_3d.into_system_set().intern(),
        main_transparent_pass_3d.into_system_set().intern(),
        // Cameras that use these fall back.
        oit_resolve.into_system_set().intern(),
        deferred_lighting.into_system_set().intern(),
        screen_space_reflections.into_system_set().intern(),
        OwnMainPass.intern(),
    ]
}

/// Inspects the schedule after it was built, and whenever systems were added.
pub(super) fn find_main_pass_systems(
    schedules: Res<Schedules>,
    mut found: ResMut<MainPassSystems>,
) {
    let Some(schedule) = schedules.get(Core3d) else {
        return;
    };
    let count = schedule.systems_len();
    if count == found.inspected {
        return;
    }
    let keys_of = |set| schedule.graph().systems_in_set(set);
    let (Ok(main_pass), Ok(systems)) = (
        keys_of(Core3dSystems::MainPass.intern()),
        schedule.systems(),
    ) else {
        return;
    };
    found.inspected = count;
    let known: Vec<_> = known()
        .into_iter()
        .filter_map(|set| keys_of(set).ok())
        .collect();
    let mut foreign = systems
        .filter(|(key, _)| main_pass.contains(key) && !known.iter().any(|keys| keys.contains(key)))
        .map(|(_, system)| system.name().to_string())
        .map(|name| match name.contains("::") {
            true => format!("`{name}`"),
            false => "a system (Bevy's feature `debug` shows its name)".into(),
        });
    found.foreign = foreign.next();
}
