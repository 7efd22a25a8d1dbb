//! What a scene waits for.

use std::collections::BTreeSet;

use bevy::{asset::UntypedHandle, ecs::resource::Resource};

/// The assets that a scene needs before its picture is meaningful.
#[derive(Resource, Clone, Debug, Default)]
pub struct AwaitedAssets(pub Vec<UntypedHandle>);

/// What a scene is still computing before its picture is meaningful, by name; the scene adds and
/// removes it.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct AwaitedWork(pub BTreeSet<&'static str>);
