//! What a scene waits for.

use std::collections::BTreeSet;

use bevy::{asset::UntypedHandle, ecs::resource::Resource};

/// The assets that a scene needs before its picture is meaningful.
#[derive(Resource, Clone, Debug, Default)]
pub struct AwaitedAssets(pub Vec<UntypedHandle>);

/// What a scene is still computing before its picture is meaningful, by name; the scene adds and
/// removes it. None of it may depend on what the cameras draw; see [`Unwatched`].
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct AwaitedWork(pub BTreeSet<&'static str>);

/// Present while a headless app waits until its scene is ready. Cameras may draw one pixel then as long as there
/// is [`AwaitedWork`]: on a software driver a frame's time is that of its pixels.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct Unwatched;
