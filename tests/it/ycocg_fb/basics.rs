//! A packed camera's picture is that of an ordinary one.

use bevy::render::view::Msaa;
use bevy_ycocg_fb::{Reconstruction, YCoCgFrameBuffer};

use super::scene::{Studio, keep, lit_scene, psnr};
use crate::support::gpu;

#[test]
fn a_lit_scene_with_and_without_hdr() {
    let _gpu = gpu();
    let mut studio = Studio::new(lit_scene);
    for msaa in [Msaa::Off, Msaa::Sample4] {
        let reference = studio.mode(true, msaa).plain();
        keep(&format!("lit_{msaa:?}"), &reference);
        for hdr in [true, false] {
            for reconstruction in [
                Reconstruction::Nearest,
                Reconstruction::Bilinear,
                Reconstruction::EdgeDirected,
                Reconstruction::Guided,
                Reconstruction::Wide,
                Reconstruction::Quad,
            ] {
                let packed = studio.mode(hdr, msaa).packed(YCoCgFrameBuffer {
                    reconstruction,
                    ..Default::default()
                });
                let psnr = psnr(&reference, &packed);
                println!("{msaa:?} hdr {hdr} {reconstruction:?}: {psnr:.2} dB");
                keep(&format!("lit_{msaa:?}_{hdr}_{reconstruction:?}"), &packed);
            }
        }
    }
}
