//! How the plugins of this workspace reach into Bevy's renderer without a fork.
