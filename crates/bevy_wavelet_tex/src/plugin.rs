//! The plugin, which registers the assets, materials and shaders of the other modules.

use bevy::{
    app::{App, Plugin, PostUpdate, Update},
    asset::{AssetApp, AssetEventSystems, embedded_asset},
    ecs::schedule::IntoScheduleConfigs,
    image::{CompressedImageFormatSupport, CompressedImageFormats},
    pbr::MaterialPlugin,
    render::{RenderApp, render_asset::RenderAssetPlugin, renderer::RenderDevice},
    shader::load_shader_library,
};
use bevy_frugal_hooks::MaterialImages;

#[cfg(feature = "encode")]
use crate::asset::{WaveletProcessor, WaveletSaver};
use crate::{
    asset::{BlockLack, WaveletTexture, WaveletTextureLoader},
    file::EXTENSION,
    gltf::{self, Exchanges, WaveletGltf},
    material::{
        Decals, GpuWaveletTexture, WaveletExtension, WaveletSamplers, WaveletStandardMaterial,
        find_decals, missing_textures, rebind_materials, write_forms,
    },
    settings::{WaveletAddressMode, WaveletFilter},
};

/// Adds wavelet textures to an app: the loader of `.wtex` files and [`WaveletStandardMaterial`].
///
/// It adds no pass, no texture and no shader to an app that has no wavelet materials.
#[derive(Clone, Copy, Debug, Default)]
pub struct WaveletTexPlugin;

impl Plugin for WaveletTexPlugin {
    fn build(&self, app: &mut App) {
        load_shader_library!(app, "material/types.wesl");
        load_shader_library!(app, "material/low_band.wesl");
        load_shader_library!(app, "material/decode.wesl");
        load_shader_library!(app, "material/sampling.wesl");
        load_shader_library!(app, "material/stochastic.wesl");
        load_shader_library!(app, "material/bindings.wesl");
        embedded_asset!(app, "material/forward.wesl");
        embedded_asset!(app, "material/prepass.wesl");
        app.init_asset::<WaveletTexture>()
            .init_resource::<Decals>()
            .init_resource::<Exchanges>()
            .preregister_asset_loader::<WaveletTextureLoader>(&[EXTENSION])
            .register_type::<WaveletFilter>()
            .register_type::<WaveletAddressMode>()
            .register_type::<WaveletGltf>()
            .register_type::<WaveletExtension>()
            .register_asset_reflect::<WaveletTexture>()
            .register_asset_reflect::<WaveletStandardMaterial>()
            .add_systems(
                Update,
                (
                    gltf::find_meshes,
                    gltf::forget_materials,
                    gltf::exchange_materials,
                )
                    .chain(),
            )
            .add_systems(
                PostUpdate,
                (
                    (find_decals, rebind_materials).before(AssetEventSystems),
                    write_forms.after(AssetEventSystems),
                ),
            )
            .add_plugins((
                RenderAssetPlugin::<GpuWaveletTexture>::default(),
                MaterialPlugin::<WaveletStandardMaterial>::default(),
            ));
        // The processor runs only where a `.meta` file names it; it is the default of no file
        // extension.
        #[cfg(feature = "encode")]
        app.register_asset_processor::<WaveletProcessor>(WaveletSaver.into());
    }

    fn finish(&self, app: &mut App) {
        // The formats are known only after the renderer has chosen its adapter. Without a renderer
        // nothing samples the textures, so blocks are kept.
        let formats = app.world().get_resource::<CompressedImageFormatSupport>();
        let supports_bc = formats.is_none_or(|f| f.0.contains(CompressedImageFormats::BC));
        let device = app.world().get_resource::<RenderDevice>();
        let max_size = device.map_or(u32::MAX, |d| d.limits().max_texture_dimension_2d);
        let lack = if supports_bc {
            let missing = device.and_then(missing_textures);
            missing.map(|[limit, needed]| BlockLack::Textures { limit, needed })
        } else {
            Some(BlockLack::Bc)
        };
        let is_read = app.world().contains_resource::<MaterialImages>();
        app.register_asset_loader(WaveletTextureLoader::new(lack, max_size).with_previews(is_read));
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            render_app.init_resource::<WaveletSamplers>();
        }
    }
}
