//! What was logged: the apps of the tests have no logger, so that one of the process can listen to all.
//!
//! An error of the renderer that is only logged, such as a bind group that was refused, leaves a picture dark and
//! the app running. So it fails the test whose app runs.

use std::{
    fmt,
    sync::{Mutex, MutexGuard, Once, PoisonError},
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
