//! Filtering of all `StandardMaterial`s of an app, without a change of the assets.

use bevy::prelude::*;

use crate::settings::{EwaMethod, EwaSettings};

/// Settings of the filter for all `StandardMaterial`s of the app, and for the materials of an
/// [`EwaMaterialPlugin`](crate::EwaMaterialPlugin); `None` leaves them to Bevy.
///
/// A change takes effect in the next frame and builds new pipelines; the assets stay unchanged.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Resource, Debug, PartialEq)]
pub struct AllMaterials(pub Option<EwaSettings>);

impl Default for AllMaterials {
    fn default() -> Self {
        Self(Some(EwaSettings::with_method(EwaMethod::Anisotropic)))
    }
}
