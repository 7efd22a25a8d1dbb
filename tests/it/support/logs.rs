//! What was logged: the apps of the tests have no logger, so that one of the process can listen to all.
//!
//! An error that is only logged, such as a pipeline that did not compile or a bind group that was refused,
//! leaves a picture dark and the app running. So each fails the test whose app runs, unless it is
//! [expected](expect_error).

use std::{
    fmt,
    sync::{Mutex, MutexGuard, Once, PoisonError},
};

use bevy::log::{
    Level, tracing,
    tracing::{
        Event, Subscriber,
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
    expected: Vec::new(),
});

struct Log {
    warnings: Vec<String>,
    /// Those that no test has taken yet.
    errors: Vec<String>,
    /// Texts of errors that are a test's purpose.
    expected: Vec<&'static str>,
}

fn log() -> MutexGuard<'static, Log> {
    LOG.lock().unwrap_or_else(PoisonError::into_inner)
}

struct Listener;

impl<S: Subscriber> Layer<S> for Listener {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        let level = *event.metadata().level();
        if level > Level::WARN {
            return;
        }
        let mut message = Message(String::new());
        event.record(&mut message);
        let mut log = log();
        if level == Level::WARN {
            log.warnings.push(message.0);
        } else {
            let target = event.metadata().target();
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

/// Says that errors with this in their text are what a test is about.
pub fn expect_error(text: &'static str) {
    log().expected.push(text);
}

/// The errors since the last call that no test expects, of any app.
pub fn unexpected_errors() -> Vec<String> {
    let mut log = log();
    let errors = std::mem::take(&mut log.errors);
    let is_expected = |error: &String| log.expected.iter().any(|text| error.contains(text));
    errors
        .into_iter()
        .filter(|error| !is_expected(error))
        .collect()
}
