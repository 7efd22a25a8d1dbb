//! A small game: a glTF model on a floor, a sun with shadows, and all four plugins, added in another
//! order than in the lab. Headless: it draws some frames, and fails if anything logged an error, a plugin
//! did not do what it is for, or the picture is empty.

#[cfg(feature = "default")]
mod headless;
#[cfg(feature = "default")]
mod scene;

use bevy::prelude::*;
use bevy_ewa::EwaPlugin;
use bevy_voxel_gi::VoxelGiPlugin;
use bevy_wavelet_tex::WaveletTexPlugin;
use bevy_ycocg_fb::YCoCgFrameBufferPlugin;

fn plugins(app: &mut App) {
    app.add_plugins((
        YCoCgFrameBufferPlugin,
        VoxelGiPlugin,
        WaveletTexPlugin,
        EwaPlugin::elliptical(),
    ));
}

#[cfg(feature = "default")]
fn main() -> AppExit {
    let mut app = App::new();
    headless::build(&mut app);
    plugins(&mut app);
    app.add_systems(Startup, scene::spawn).run()
}

/// With the fewest features it is enough that all compile together.
#[cfg(not(feature = "default"))]
fn main() {
    plugins(&mut App::new());
}
