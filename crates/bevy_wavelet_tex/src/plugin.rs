//! The plugin: it registers what the modules define.

use bevy::{
    app::{App, Plugin, PostUpdate, Update},
    asset::{AssetApp, AssetEventSystems, embedded_asset},
    ecs::schedule::IntoScheduleConfigs,
    image::{CompressedImageFormatSupport, CompressedImageFormats},
    pbr::MaterialPlugin,
    render::{RenderApp, render_asset::RenderAssetPlugin},
    shader::load_shader_library,
};

#[cfg(feature = "encode")]
use crate::asset::{WaveletProcessor, WaveletSaver};
use crate::{
    asset::{WaveletTexture, WaveletTextureLoader},
    file::EXTENSION,
    gltf::{self, WaveletGltf},
    material::{
        GpuWaveletTexture, WaveletAddressMode, WaveletFilter, WaveletSamplers,
        WaveletStandardMaterial, reload::rebind_materials,
    },
};

/// Adds wavelet textures to an app: the loader of `.wtex` files and [`WaveletStandardMaterial`].
///
/// An app without wavelet materials has no pass, no texture and no shader more than before.
#[derive(Clone, Copy, Debug, Default)]
pub struct WaveletTexPlugin;

impl Plugin for WaveletTexPlugin {
    fn build(&self, app: &mut App) {
        load_shader_library!(app, "material/types.wesl");
        load_shader_library!(app, "material/decode.wesl");
        load_shader_library!(app, "material/sampling.wesl");
        load_shader_library!(app, "material/anisotropic.wesl");
        load_shader_library!(app, "material/bindings.wesl");
        embedded_asset!(app, "material/forward.wesl");
        embedded_asset!(app, "material/prepass.wesl");
        app.init_asset::<WaveletTexture>()
            .preregister_asset_loader::<WaveletTextureLoader>(&[EXTENSION])
            .register_type::<WaveletFilter>()
            .register_type::<WaveletAddressMode>()
            .register_type::<WaveletGltf>()
            .add_systems(
                Update,
                (gltf::find_meshes, gltf::exchange_materials).chain(),
            )
            .add_systems(PostUpdate, rebind_materials.before(AssetEventSystems))
            .add_plugins((
                RenderAssetPlugin::<GpuWaveletTexture>::default(),
                MaterialPlugin::<WaveletStandardMaterial>::default(),
            ));
        // By name only, from `.meta` files: no extension is taken over.
        #[cfg(feature = "encode")]
        app.register_asset_processor::<WaveletProcessor>(WaveletSaver.into());
    }

    fn finish(&self, app: &mut App) {
        // Known only after the renderer has chosen its adapter; without a renderer nothing samples.
        let formats = app.world().get_resource::<CompressedImageFormatSupport>();
        let supports_bc = formats.is_none_or(|f| f.0.contains(CompressedImageFormats::BC));
        app.register_asset_loader(WaveletTextureLoader::new(supports_bc));
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            render_app.init_resource::<WaveletSamplers>();
        }
    }
}
