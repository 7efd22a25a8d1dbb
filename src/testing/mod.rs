//! Tests of pictures share the right to run apps, the log, and the choice of a table's rows.
//!
//! The apps of the tests have no logger, so that one of the process can listen to all. An error of the renderer that is
//! only logged, such as a bind group that was refused, leaves a picture dark and the app running. So it fails the test
//! whose app runs.

use std::{
    fmt,
    fs::OpenOptions,
    hash::{DefaultHasher, Hash, Hasher},
    io::Write,
    sync::{Condvar, Mutex, MutexGuard, Once, PoisonError},
    thread,
};

use bevy::log::{
    Level,
    tracing::{
        self, Event, Subscriber,
        field::{Field, Visit},
    },
    tracing_subscriber::{
        Layer, Registry,
        layer::{Context, SubscriberExt},
    },
};

use crate::headless::app::use_one_thread;

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
        listen();
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
        let errors = renderer_errors();
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

/// Chooses the rows of a table that a run tests: `count` of them where `TEST_SEED` is set, and all otherwise. `scripts/test`
/// sets it to another seed for each commit. The choice also depends on the name of the test. A failed test prints it.
pub fn drawn<T>(count: usize, rows: impl IntoIterator<Item = T>) -> Vec<T> {
    let rows: Vec<T> = rows.into_iter().collect();
    let Ok(seed) = std::env::var("TEST_SEED") else {
        return rows;
    };
    let drawn = draw(&seed, thread::current().name(), count, rows.len());
    println!("rows {drawn:?} of {}: TEST_SEED={seed}", rows.len());
    let rows = rows.into_iter().enumerate();
    let rows = rows.filter(|(row, _)| drawn.contains(row));
    rows.map(|(_, row)| row).collect()
}

/// The indices of `count` rows of `len`.
pub fn draw(seed: &str, test: Option<&str>, count: usize, len: usize) -> Vec<usize> {
    let mut rows: Vec<_> = (0..len).collect();
    rows.sort_by_key(|row| {
        let mut hasher = DefaultHasher::new();
        (seed, test, row).hash(&mut hasher);
        hasher.finish()
    });
    rows.truncate(count);
    rows
}

static LOG: Mutex<Log> = Mutex::new(Log {
    warnings: Vec::new(),
    errors: Vec::new(),
});

struct Log {
    warnings: Vec<String>,
    /// Those of the renderer that no test has taken yet.
    errors: Vec<String>,
}

fn log() -> MutexGuard<'static, Log> {
    LOG.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whose errors count: what the others log, such as a file that is missing, tests ask the app for.
const RENDERER: [&str; 3] = ["wgpu", "naga", "bevy_render"];

struct Listener;

impl<S: Subscriber> Layer<S> for Listener {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        let (level, target) = (*event.metadata().level(), event.metadata().target());
        if level > Level::WARN {
            return;
        }
        let mut message = Message(String::new());
        event.record(&mut message);
        let mut log = log();
        if level == Level::WARN {
            log.warnings.push(message.0);
        } else if RENDERER.iter().any(|name| target.starts_with(name)) {
            log.errors.push(format!("{target}: {}", message.0));
        }
    }
}

struct Message(String);

impl Visit for Message {
    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        if field.name() == "message" {
            self.0 = format!("{value:?}");
        }
    }
}

/// Begins to listen; more than once is once.
pub fn listen() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let all = Registry::default().with(Listener);
        tracing::subscriber::set_global_default(all).expect("no other logger");
    });
}

/// Whether there was a warning, in any app so far, with this in its text.
pub fn warned_of(text: &str) -> bool {
    log().warnings.iter().any(|warning| warning.contains(text))
}

/// The errors of the renderer since the last call, of any app.
pub fn renderer_errors() -> Vec<String> {
    std::mem::take(&mut log().errors)
}
