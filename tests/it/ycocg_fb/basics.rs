//! A packed camera's picture is that of an ordinary one.

use bevy::render::view::Msaa;
use bevy_ycocg_fb::{Reconstruction, YCoCgFrameBuffer};

use super::scene::{Studio, keep, psnr};
use crate::support::gpu;

#[test]
fn a_lit_scene_with_and_without_hdr() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    for msaa in [Msaa::Off, Msaa::Sample4] {
        let reference = studio.mode(true, msaa).plain();
        keep(&format!("lit_{msaa:?}"), &reference);
        for hdr in [true, false] {
            // Each at 1 and at 4 samples a pixel, a decibel below what was measured.
            for (reconstruction, wanted) in [
                (Reconstruction::Nearest, [32.1, 31.1]),
                (Reconstruction::Bilinear, [30.5, 31.8]),
                (Reconstruction::EdgeDirected, [39.1, 33.9]),
                (Reconstruction::Guided, [43.9, 41.5]),
                (Reconstruction::Wide, [45.4, 42.6]),
                (Reconstruction::Quad, [36.0, 35.2]),
            ] {
                let packed = studio.mode(hdr, msaa).packed(YCoCgFrameBuffer {
                    reconstruction,
                    ..Default::default()
                });
                let psnr = psnr(&reference, &packed);
                assert!(psnr > wanted[usize::from(msaa != Msaa::Off)]);
                println!("{msaa:?} hdr {hdr} {reconstruction:?}: {psnr:.2} dB");
                keep(&format!("lit_{msaa:?}_{hdr}_{reconstruction:?}"), &packed);
            }
        }
    }
}
