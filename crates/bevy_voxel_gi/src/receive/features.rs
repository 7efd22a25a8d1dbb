//! What the receiver's shader contains: pixels do not pay for what no volume uses.
//!
//! The features are constants of a shader module that is written anew when they change, so Bevy compiles all
//! shaders again that read irradiance volumes. They are known in the first frame of a volume, in general before
//! any material is compiled. Where they change later, [`await_pipelines`] has the frame wait for these shaders: else all
//! that is lit would vanish until they are compiled.

use bevy::{
    light::IrradianceVolume,
    platform::collections::HashSet,
    prelude::*,
    render::{
        Extract,
        render_resource::{CachedPipelineState, PipelineCache},
    },
    shader::Shader,
};

use crate::extract::{place_volume::ActiveVolume, probe::VoxelGiProbe};

/// The features of the receiver in an app.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ReceiverFeatures {
    /// Whether there was a `VoxelGiVolume`. It stays, so that one that is switched on and off compiles once.
    voxel_gi: bool,
    /// Whether there was an irradiance volume of another origin. It stays too.
    other_volumes: bool,
    /// Whether there were cascades. It stays too.
    cascades: bool,
    /// Whether pixels read the placement of the levels. It stays, so that second volumes that come and go compile once.
    levels: bool,
    /// Whether pixels test the visibility of the voxels around them.
    visibility: bool,
    /// Whether rough surfaces have specular light of the volume.
    specular: bool,
    /// Whether lightmapped meshes receive the light of irradiance volumes.
    lightmapped: bool,
}

impl ReceiverFeatures {
    fn shader(self) -> Shader {
        let Self {
            voxel_gi,
            other_volumes,
            cascades,
            levels,
            visibility,
            specular,
            lightmapped,
        } = self;
        let source = format!(
            "const VOXEL_GI: bool = {voxel_gi};\n\
             const OTHER_VOLUMES: bool = {other_volumes};\n\
             const CASCADES: bool = {cascades};\n\
             const LEVELS: bool = {levels};\n\
             const VISIBILITY: bool = {visibility};\n\
             const SPECULAR: bool = {specular};\n\
             const LIGHTMAPPED: bool = {lightmapped};\n"
        );
        Shader::from_wesl(source, "embedded://bevy_voxel_gi/receive/features.wesl")
    }
}

/// The module with the features, as it is now.
#[derive(Resource, Default)]
pub(crate) struct ReceiverShader {
    module: Option<(ReceiverFeatures, Handle<Shader>)>,
    /// How often it was written anew.
    changes: u32,
}

/// Writes the module where there is none, and anew where the volumes of the app need other features.
pub(crate) fn update_features(
    active: Res<ActiveVolume>,
    others: Query<(), (With<IrradianceVolume>, Without<VoxelGiProbe>)>,
    mut receiver: ResMut<ReceiverShader>,
    mut shaders: ResMut<Assets<Shader>>,
) {
    let mut features = receiver
        .module
        .as_ref()
        .map_or(ReceiverFeatures::default(), |(features, _)| *features);
    features.other_volumes |= !others.is_empty();
    if let Some(volume) = &active.volume {
        features.voxel_gi = true;
        features.cascades = volume.has_had_cascades;
        features.levels = volume.has_had_levels;
        features.visibility = volume.is_per_pixel();
        features.specular = volume.is_specular();
        features.lightmapped = volume.settings.affects_lightmapped_meshes;
    }
    let module = match &receiver.module {
        Some((former, _)) if *former == features => return,
        // The same asset: Bevy warns of another one with the same path.
        Some((_, module)) => match shaders.insert(module, features.shader()) {
            Ok(()) => {
                let module = module.clone();
                receiver.changes += 1;
                module
            }
            Err(error) => {
                error_once!("voxel GI: the receiver keeps its former features: {error}");
                return;
            }
        },
        None => shaders.add(features.shader()),
    };
    receiver.module = Some((features, module));
}

/// Whether the frame waits for pipelines.
#[derive(Resource, Default)]
pub(crate) struct AwaitedReceiver {
    changes: u32,
    is_new: bool,
}

/// Notices that the features have changed.
pub(crate) fn extract_changes(
    mut awaited: ResMut<AwaitedReceiver>,
    receiver: Extract<Res<ReceiverShader>>,
) {
    awaited.is_new = awaited.changes != receiver.changes;
    awaited.changes = receiver.changes;
}

/// Has the frame wait until the pipelines are compiled, where the features have changed in it. Where threads cannot
/// wait, Bevy compiles them at once anyway.
pub(crate) fn await_pipelines(awaited: Res<AwaitedReceiver>, mut cache: ResMut<PipelineCache>) {
    if !awaited.is_new || cfg!(target_arch = "wasm32") {
        return;
    }
    // Bevy tries those again whose shaders are not loaded yet.
    let mut failed = HashSet::new();
    loop {
        cache.process_queue();
        let mut is_ready = true;
        for (id, pipeline) in cache.pipelines().enumerate() {
            match pipeline.state {
                CachedPipelineState::Err(_) => {
                    failed.insert(id);
                }
                CachedPipelineState::Ok(_) => {}
                _ => is_ready &= failed.contains(&id),
            }
        }
        if is_ready {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        extract::placement::{PlacedLevel, PlacedVolume},
        settings::{Receiver, VoxelGiSettings},
    };

    fn placed(receiver: Receiver, levels: usize) -> PlacedVolume {
        let settings = VoxelGiSettings {
            receiver,
            ..default()
        };
        PlacedVolume {
            own_settings: settings.clone(),
            settings,
            has_had_cascades: levels > 1,
            has_had_levels: receiver == Receiver::PerPixel,
            ..PlacedVolume::of(vec![PlacedLevel::of(Vec3::ZERO, 1.0); levels])
        }
    }

    /// The constants that are true in the module.
    fn features_with(app: &mut App, volume: Option<PlacedVolume>) -> Vec<String> {
        app.world_mut().resource_mut::<ActiveVolume>().volume = volume;
        app.update();
        let shaders = app.world().resource::<Assets<Shader>>();
        assert_eq!(shaders.len(), 1);
        let source = shaders.iter().map(|(_, shader)| shader.source.as_str());
        let lines = source.flat_map(str::lines);
        lines
            .filter_map(|line| line.strip_prefix("const ")?.strip_suffix(": bool = true;"))
            .map(String::from)
            .collect()
    }

    #[test]
    fn the_shader_has_what_the_volumes_of_the_app_use() {
        let mut app = App::new();
        app.init_resource::<Assets<Shader>>()
            .init_resource::<ActiveVolume>()
            .init_resource::<ReceiverShader>()
            .add_systems(Update, update_features);
        let mut check = |volume: Option<(Receiver, usize)>, expected: &[&str]| {
            let volume = volume.map(|(receiver, levels)| placed(receiver, levels));
            assert_eq!(features_with(&mut app, volume), expected);
        };
        check(None, &[]);
        check(Some((Receiver::Interpolated, 1)), &["VOXEL_GI"]);
        check(Some((Receiver::Interpolated, 2)), &["VOXEL_GI", "CASCADES"]);
        let all = ["VOXEL_GI", "LEVELS", "VISIBILITY"];
        check(Some((Receiver::PerPixel, 1)), &all);
        check(Some((Receiver::Interpolated, 1)), &["VOXEL_GI"]);
        check(None, &["VOXEL_GI"]);
        let mut specular = placed(Receiver::Interpolated, 1);
        specular.settings.specular_light = true;
        let all = ["VOXEL_GI", "SPECULAR"];
        assert_eq!(features_with(&mut app, Some(specular)), all);
        let plain = placed(Receiver::Interpolated, 1);
        assert_eq!(features_with(&mut app, Some(plain)), ["VOXEL_GI"]);
        app.world_mut().spawn(IrradianceVolume::default());
        assert_eq!(features_with(&mut app, None), ["VOXEL_GI", "OTHER_VOLUMES"]);
    }
}
