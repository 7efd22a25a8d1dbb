//! What the receiver's shader contains: pixels do not pay for what no volume uses.
//!
//! The features are constants of a shader module that is written anew when they change, so Bevy compiles all
//! shaders again that read irradiance volumes. They are known in the first frame of a volume, in general before
//! any material is compiled.

use bevy::{light::IrradianceVolume, prelude::*, shader::Shader};

use crate::extract::{place_volume::ActiveVolume, probe::VoxelGiProbe};

/// The features of the receiver in an app.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ReceiverFeatures {
    /// Whether there was a `VoxelGiVolume`. It stays, so that one that is switched on and off compiles once.
    voxel_gi: bool,
    /// Whether there was an irradiance volume of another origin. It stays too.
    other_volumes: bool,
    /// Whether the texture has the placement of its levels; see
    /// [`is_plain`](crate::extract::texture::is_plain).
    levels: bool,
    /// Whether pixels test the visibility of the voxels around them.
    visibility: bool,
}

impl ReceiverFeatures {
    fn shader(self) -> Shader {
        let Self {
            voxel_gi,
            other_volumes,
            levels,
            visibility,
        } = self;
        let source = format!(
            "const VOXEL_GI: bool = {voxel_gi};\n\
             const OTHER_VOLUMES: bool = {other_volumes};\n\
             const LEVELS: bool = {levels};\n\
             const VISIBILITY: bool = {visibility};\n"
        );
        Shader::from_wesl(source, "embedded://bevy_voxel_gi/receive/features.wesl")
    }
}

/// The module with the features, as it is now.
#[derive(Resource, Default)]
pub(crate) struct ReceiverShader(Option<(ReceiverFeatures, Handle<Shader>)>);

/// Writes the module where there is none, and anew where the volumes of the app need other features.
pub(crate) fn update_features(
    active: Res<ActiveVolume>,
    others: Query<(), (With<IrradianceVolume>, Without<VoxelGiProbe>)>,
    mut receiver: ResMut<ReceiverShader>,
    mut shaders: ResMut<Assets<Shader>>,
) {
    let mut features = receiver
        .0
        .as_ref()
        .map_or(ReceiverFeatures::default(), |(features, _)| *features);
    features.other_volumes |= !others.is_empty();
    if let Some(volume) = &active.volume {
        features.voxel_gi = true;
        features.levels = !volume.is_plain();
        features.visibility = volume.is_per_pixel();
    }
    let module = match &receiver.0 {
        Some((former, _)) if *former == features => return,
        // The same asset: Bevy warns of another one with the same path.
        Some((_, module)) => match shaders.insert(module, features.shader()) {
            Ok(()) => module.clone(),
            Err(error) => {
                error_once!("voxel GI: the receiver keeps its former features: {error}");
                return;
            }
        },
        None => shaders.add(features.shader()),
    };
    receiver.0 = Some((features, module));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        extract::placement::{PlacedLevel, PlacedVolume},
        settings::{Receiver, VoxelGiVolume},
    };

    fn placed(receiver: Receiver, levels: usize) -> PlacedVolume {
        let settings = VoxelGiVolume {
            receiver,
            ..default()
        };
        let level = PlacedLevel {
            owner: Entity::PLACEHOLDER,
            center: Vec3::ZERO,
            size: 1.0,
            sky: default(),
            intensity: 1.0,
        };
        PlacedVolume {
            own_settings: settings.clone(),
            settings,
            levels: vec![level; levels],
            texture: default(),
            patched: true,
            exposure: 1.0,
            layers: default(),
            viewpoints: Vec::new(),
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
        check(Some((Receiver::Interpolated, 2)), &["VOXEL_GI", "LEVELS"]);
        let all = ["VOXEL_GI", "LEVELS", "VISIBILITY"];
        check(Some((Receiver::PerPixel, 1)), &all);
        check(Some((Receiver::Interpolated, 1)), &["VOXEL_GI"]);
        check(None, &["VOXEL_GI"]);
        app.world_mut().spawn(IrradianceVolume::default());
        assert_eq!(features_with(&mut app, None), ["VOXEL_GI", "OTHER_VOLUMES"]);
    }
}
