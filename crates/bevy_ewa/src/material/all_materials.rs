//! Filtering of all `StandardMaterial`s of an app, without a change of the assets.

use std::{
    any::TypeId,
    sync::{PoisonError, RwLock},
};

use bevy::{
    asset::AssetEventSystems,
    pbr::StandardMaterial,
    prelude::*,
    render::{
        Extract, ExtractSchedule, RenderApp, render_resource::RenderPipelineDescriptor,
        renderer::RenderAdapterInfo,
    },
};
use bevy_frugal_hooks::{MaterialHookPlugin, MaterialTags, ShaderPatches, SpecializedMaterial};

use super::{
    clamped_textures,
    extension::EwaStandardMaterial,
    llvmpipe,
    patches::is_refused,
    pipeline::{self, EwaKey},
};
use crate::settings::EwaSettings;

/// Settings of the filter for all `StandardMaterial`s of the app; `None` leaves them to Bevy.
///
/// A change takes effect in the next frame and builds new pipelines; the assets stay unchanged.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Resource, Debug, PartialEq)]
pub struct AllMaterials(pub Option<EwaSettings>);

impl Default for AllMaterials {
    fn default() -> Self {
        Self(Some(EwaSettings::default()))
    }
}

/// Tags the materials and specializes their pipelines.
pub(super) struct AllMaterialsPlugin;

impl Plugin for AllMaterialsPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<AllMaterials>()
            .init_resource::<AllMaterials>()
            .add_plugins(MaterialHookPlugin(apply_filter))
            .add_systems(PostUpdate, reprepare_materials.before(AssetEventSystems));
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            render_app.add_systems(ExtractSchedule, tag_materials);
        }
    }

    fn finish(&self, app: &mut App) {
        if let Some(info) = app.world().get_resource::<RenderAdapterInfo>() {
            llvmpipe::detect(info);
        }
    }
}

/// The keys, of which a tag is an index. It grows with the number of distinct settings, not of materials.
static KEYS: RwLock<Vec<EwaKey>> = RwLock::new(Vec::new());

const TAG: &str = "bevy_ewa";

fn index_of(key: EwaKey) -> u64 {
    let mut keys = KEYS.write().unwrap_or_else(PoisonError::into_inner);
    let index = keys.iter().position(|known| *known == key);
    index.unwrap_or_else(|| {
        keys.push(key);
        keys.len() - 1
    }) as u64
}

/// Tag of `EwaStandardMaterial`s while one of Bevy's shaders could not be patched.
const REFUSED_TAG: &str = "bevy_ewa/refused";

/// Has the materials prepared again when the settings change or a shader could not be patched, because
/// the key of a pipeline is made when its material is prepared.
fn reprepare_materials(
    settings: Res<AllMaterials>,
    patches: Option<Res<ShaderPatches>>,
    mut last: Local<Option<(AllMaterials, bool)>>,
    mut standard: ResMut<Assets<StandardMaterial>>,
    mut extended: ResMut<Assets<EwaStandardMaterial>>,
) {
    let refused = is_refused(patches);
    let Some(last) = last.replace((*settings, refused)) else {
        return;
    };
    // A mutable reference marks the asset as modified.
    if last != (*settings, refused) {
        standard.iter_mut().for_each(drop);
    }
    if last.1 != refused {
        extended.iter_mut().for_each(drop);
    }
}

fn tag_materials(
    settings: Extract<Res<AllMaterials>>,
    patches: Extract<Option<Res<ShaderPatches>>>,
    mut tags: ResMut<MaterialTags>,
) {
    let refused = is_refused(patches.as_ref().map(Res::clone));
    let settings = settings.0.filter(|_| !refused);
    let tag = settings.map(|settings| index_of(EwaKey::new(&settings, llvmpipe::is_llvmpipe())));
    tags.set_for_type(TypeId::of::<StandardMaterial>(), TAG, tag);
    let tag = refused.then_some(1);
    tags.set_for_type(TypeId::of::<EwaStandardMaterial>(), REFUSED_TAG, tag);
}

/// The material hook. `EwaStandardMaterial`s set their own key; here they get only the address modes and
/// the refusal.
fn apply_filter(material: SpecializedMaterial, descriptor: &mut RenderPipelineDescriptor) {
    if let Some(index) = material.tag(TAG) {
        let keys = KEYS.read().unwrap_or_else(PoisonError::into_inner);
        if let Some(key) = keys.get(index as usize) {
            key.apply(material.mesh_key, descriptor);
        }
    }
    clamped_textures::disable_periodic(material, descriptor);
    if material.tag(REFUSED_TAG).is_some() {
        pipeline::disable(descriptor);
    }
}
