//! What was logged: the apps of the tests have no logger, so that one of the process can listen to all.

use std::{
    fmt,
    sync::{Mutex, Once, PoisonError},
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

static WARNINGS: Mutex<Vec<String>> = Mutex::new(Vec::new());

struct Warnings;

impl<S: Subscriber> Layer<S> for Warnings {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        if *event.metadata().level() == Level::WARN {
            event.record(&mut Message);
        }
    }
}

struct Message;

impl Visit for Message {
    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        if field.name() == "message" {
            let mut warnings = WARNINGS.lock().unwrap_or_else(PoisonError::into_inner);
            warnings.push(format!("{value:?}"));
        }
    }
}

/// Begins to listen; more than once is once.
pub fn listen() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let all = Registry::default().with(Warnings);
        tracing::subscriber::set_global_default(all).expect("no other logger");
    });
}

/// Whether there was a warning, in any app so far, with this in its text.
pub fn warned_of(text: &str) -> bool {
    let warnings = WARNINGS.lock().unwrap_or_else(PoisonError::into_inner);
    warnings.iter().any(|warning| warning.contains(text))
}
