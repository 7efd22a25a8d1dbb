//! What tests of pictures share: the right to run apps, and what they log.

use std::{
    fs::OpenOptions,
    io::Write,
    sync::{Condvar, Mutex, PoisonError},
    thread,
};

use crate::headless::app::use_one_thread;

pub mod logs;

static QUEUE: Mutex<Queue> = Mutex::new(Queue {
    running: 0,
    asked: 0,
    served: 0,
});
static MOVED: Condvar = Condvar::new();

/// Apps that run, and tests that wait in the order in which they asked: one that wants to be alone would wait until
/// the end otherwise.
struct Queue {
    running: usize,
    asked: usize,
    served: usize,
}

/// A right to run apps, until it is dropped.
pub struct Gpu {
    apps: usize,
}

impl Gpu {
    fn wait_for(apps: usize) -> Self {
        logs::listen();
        let most = most_apps();
        let mut queue = QUEUE.lock().unwrap_or_else(PoisonError::into_inner);
        let ticket = queue.asked;
        queue.asked += 1;
        let queue = MOVED.wait_while(queue, |queue| {
            queue.served != ticket || queue.running + apps > most
        });
        let mut queue = queue.unwrap_or_else(PoisonError::into_inner);
        queue.served += 1;
        queue.running += apps;
        // A test that is alone has Bevy's threads for itself, as a game has.
        use_one_thread(apps < most);
        MOVED.notify_all();
        Self { apps }
    }
}

impl Drop for Gpu {
    fn drop(&mut self) {
        let mut queue = QUEUE.lock().unwrap_or_else(PoisonError::into_inner);
        queue.running -= self.apps;
        MOVED.notify_all();
        drop(queue);
        let errors = logs::renderer_errors();
        if !thread::panicking() {
            assert!(
                errors.is_empty(),
                "logged, perhaps by an app beside this test's: {errors:#?}"
            );
        }
    }
}

/// Waits until an app may run.
pub fn gpu() -> Gpu {
    Gpu::wait_for(1)
}

/// Waits until no other app runs, for what is measured of the whole process.
pub fn gpu_alone() -> Gpu {
    Gpu::wait_for(most_apps())
}

/// Apps that run at the same time, at most: a software driver compiles an app's pipelines one after the
/// other, and while one app waits for that another can draw.
fn most_apps() -> usize {
    thread::available_parallelism().map_or(1, |cores| cores.get().min(2) + 1)
}

/// Says that a part of a test is left out, and why. `scripts/test` names a file in `SKIPPED_TESTS` and prints
/// at its end what was appended.
pub fn skipped(what: &str) {
    println!("skipped: {what}");
    let Some(path) = std::env::var_os("SKIPPED_TESTS") else {
        return;
    };
    let file = OpenOptions::new().create(true).append(true).open(&path);
    file.and_then(|mut file| writeln!(file, "{what}"))
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
}
