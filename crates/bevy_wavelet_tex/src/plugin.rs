//! The plugin: it registers what the modules define.

use bevy::{
    app::{App, Plugin},
    asset::{AssetApp, embedded_asset},
    image::{CompressedImageFormatSupport, CompressedImageFormats},
    pbr::MaterialPlugin,
    render::render_asset::RenderAssetPlugin,
    shader::load_shader_library,
};

use crate::{
    asset::{WaveletTexture, WaveletTextureLoader},
    file::EXTENSION,
    material::{GpuWaveletTexture, WaveletAddressMode, WaveletFilter, WaveletStandardMaterial},
};

/// Adds wavelet textures to an app: the loader of `.wtex` files and [`WaveletStandardMaterial`].
///
/// An app without wavelet materials has no pass, no texture and no shader more than before.
#[derive(Clone, Copy, Debug, Default)]
pub struct WaveletTexPlugin;

impl Plugin for WaveletTexPlugin {
    fn build(&self, app: &mut App) {
        load_shader_library!(app, "material/decode.wgsl");
        load_shader_library!(app, "material/bindings.wgsl");
        embedded_asset!(app, "material/forward.wgsl");
        embedded_asset!(app, "material/prepass.wgsl");
        app.init_asset::<WaveletTexture>()
            .preregister_asset_loader::<WaveletTextureLoader>(&[EXTENSION])
            .register_type::<WaveletFilter>()
            .register_type::<WaveletAddressMode>()
            .add_plugins((
                RenderAssetPlugin::<GpuWaveletTexture>::default(),
                MaterialPlugin::<WaveletStandardMaterial>::default(),
            ));
    }

    fn finish(&self, app: &mut App) {
        // Known only after the renderer has chosen its adapter; without a renderer nothing samples.
        let formats = app.world().get_resource::<CompressedImageFormatSupport>();
        let supports_bc = formats.is_none_or(|f| f.0.contains(CompressedImageFormats::BC));
        app.register_asset_loader(WaveletTextureLoader::new(supports_bc));
    }
}
