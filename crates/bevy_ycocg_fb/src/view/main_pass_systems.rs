//! The systems of other plugins in Bevy's main pass, which packed cameras skip.

use bevy::{
    core_pipeline::{Core3d, Core3dSystems},
    ecs::schedule::{Schedules, SystemSet},
    prelude::*,
};

/// The crates whose systems in the main pass are replaced or do not draw, and the parts of them that do.
const KNOWN: [&str; 4] = [
    "bevy_core_pipeline::",
    "bevy_pbr::",
    "bevy_post_process::",
    "bevy_ycocg_fb::",
];
const DRAWING: &str = "bevy_pbr::meshlet::";

/// The first system of another plugin in the main pass. Its name is known in apps with Bevy's feature `debug`, which
/// is one of its default features.
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
    let set = schedule
        .graph()
        .systems_in_set(Core3dSystems::MainPass.intern());
    let (Ok(keys), Ok(systems)) = (set, schedule.systems()) else {
        return;
    };
    found.inspected = count;
    let mut names = systems
        .filter(|(key, _)| keys.contains(key))
        .map(|(_, system)| system.name().to_string());
    found.foreign = names.find(|name| {
        name.contains("::")
            && (name.starts_with(DRAWING) || !KNOWN.iter().any(|known| name.starts_with(known)))
    });
}
