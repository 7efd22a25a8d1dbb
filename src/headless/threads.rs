//! On which threads the systems of an app run.

use std::sync::atomic::{AtomicBool, Ordering};

use bevy::{
    app::App,
    ecs::schedule::{Schedules, SingleThreadedExecutor},
};

static ONE_THREAD: AtomicBool = AtomicBool::new(false);

/// Whether apps that are built from now on run their systems one after the other, each app on the thread that updates
/// it. Bevy's own way, and the default, is one pool of threads for the whole process: where several apps share it, a
/// frame of one waits for systems of the others.
pub fn use_one_thread(one: bool) {
    ONE_THREAD.store(one, Ordering::Relaxed);
}

/// Prepares the schedules of a built app.
pub(super) fn apply(app: &mut App) {
    if !ONE_THREAD.load(Ordering::Relaxed) {
        return;
    }
    for sub_app in app.sub_apps_mut().iter_mut() {
        let Some(mut schedules) = sub_app.world_mut().get_resource_mut::<Schedules>() else {
            continue;
        };
        for (_, schedule) in schedules.iter_mut() {
            schedule.set_executor(SingleThreadedExecutor::new());
        }
    }
}
