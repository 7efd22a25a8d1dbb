//! Apps that tests hand on to each other: most of a small test's time is an app's start and its pipelines.

use std::{
    cell::RefCell,
    ops::{Deref, DerefMut},
    rc::{Rc, Weak},
    sync::{Mutex, PoisonError},
    thread,
};

use bevy::prelude::*;
use bevy_frugal_lab::headless::HeadlessApp;

use super::{Gpu, gpu};

thread_local! {
    /// The right to run apps that those of this thread's test hold.
    static HELD: RefCell<Weak<Gpu>> = RefCell::default();
}

/// Apps of one configuration.
pub struct Pool {
    idle: Mutex<Vec<Idle>>,
    build: fn() -> HeadlessApp,
    /// Puts into an app without a scene what every test begins with.
    begin: fn(&mut World),
}

struct Idle(HeadlessApp);

// SAFETY: an `App` is not `Send` for its runner, which a headless app never calls, and for data that is bound to
// a thread, of which it has none: without a window and an event loop, nothing of Bevy inserts any. The lock of
// the pool hands an app from one thread to the next.
unsafe impl Send for Idle {}

impl Pool {
    /// Makes a pool of apps that `build` builds and whose tests start with what `begin` spawns.
    pub const fn new(build: fn() -> HeadlessApp, begin: fn(&mut World)) -> Self {
        Self {
            idle: Mutex::new(Vec::new()),
            build,
            begin,
        }
    }

    /// An app as if it was new, but for its pipelines. A test holds its [`gpu`](super::gpu) longer.
    pub fn app(&'static self) -> Borrowed {
        let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        let former = idle.pop();
        drop(idle);
        let mut app = former.map_or_else(self.build, |idle| idle.0);
        (self.begin)(app.world_mut());
        Borrowed {
            app: Some(app),
            pool: Some(self),
            _gpu: None,
        }
    }
}

/// An app of a pool. It goes back there when it is dropped, without the entities of its scene, unless the test
/// failed.
pub struct Borrowed {
    app: Option<HeadlessApp>,
    pool: Option<&'static Pool>,
    /// Dropped after the app.
    _gpu: Option<Rc<Gpu>>,
}

impl Borrowed {
    /// An app with the right to run it, which all such apps of a thread share.
    pub fn with_gpu(app: impl FnOnce() -> Self) -> Self {
        let gpu = HELD.with_borrow_mut(|held| {
            held.upgrade().unwrap_or_else(|| {
                let gpu = Rc::new(gpu());
                *held = Rc::downgrade(&gpu);
                gpu
            })
        });
        let mut app = app();
        app._gpu = Some(gpu);
        app
    }
}

/// For a test that needs an app of its own where others share theirs.
impl From<HeadlessApp> for Borrowed {
    fn from(app: HeadlessApp) -> Self {
        Self {
            app: Some(app),
            pool: None,
            _gpu: None,
        }
    }
}

impl Deref for Borrowed {
    type Target = HeadlessApp;

    fn deref(&self) -> &HeadlessApp {
        self.app.as_ref().expect("taken only when dropped")
    }
}

impl DerefMut for Borrowed {
    fn deref_mut(&mut self) -> &mut HeadlessApp {
        self.app.as_mut().expect("taken only when dropped")
    }
}

impl Drop for Borrowed {
    fn drop(&mut self) {
        let (Some(mut app), Some(pool), false) = (self.app.take(), self.pool, thread::panicking())
        else {
            return;
        };
        let world = app.world_mut();
        let mut scene = world.query_filtered::<Entity, (With<Transform>, Without<ChildOf>)>();
        for entity in scene.iter(world).collect::<Vec<_>>() {
            world.despawn(entity);
        }
        // The renderer forgets them, and reports with a delay.
        if app.render_frames(3).is_ok() {
            let mut idle = pool.idle.lock().unwrap_or_else(PoisonError::into_inner);
            idle.push(Idle(app));
        }
    }
}
