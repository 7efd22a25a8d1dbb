//! A packed camera's picture is that of an ordinary one: the three formats, the two resolves, and what they take.

use bevy::{
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    prelude::*,
    render::view::Msaa,
};
use bevy_ycocg_fb::{
    CameraState, FallbackReason, FrameBufferFormat, FrameBufferQuality, MsaaResolve, PackedFormat,
    Reconstruction, YCoCgFrameBuffer,
};
use image::RgbImage;

use super::{Studio, bright_edge_scene, lit_scene, packing, spawn_mesh, srgb_image, supersampled};
use crate::support::{gpu, keep, psnr, skipped};

fn with(format: PackedFormat) -> YCoCgFrameBuffer {
    YCoCgFrameBuffer::with_format(format)
}

#[test]
fn every_reconstruction_is_near_bevys_picture_with_and_without_hdr() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    for msaa in [Msaa::Off, Msaa::Sample4] {
        let reference = studio.mode(true, msaa).plain();
        for hdr in [true, false] {
            // Each at 1 and at 4 samples a pixel, a decibel below what was measured.
            for (reconstruction, least) in [
                (Reconstruction::Nearest, [32.1, 31.1]),
                (Reconstruction::Bilinear, [30.5, 31.8]),
                (Reconstruction::EdgeDirected, [39.1, 33.9]),
                (Reconstruction::Guided, [43.9, 41.5]),
                (Reconstruction::Wide, [45.4, 42.6]),
                (Reconstruction::Quad, [36.0, 35.2]),
            ] {
                let settings = YCoCgFrameBuffer {
                    reconstruction,
                    ..default()
                };
                let name = format!("lit, {msaa:?}, hdr {hdr}, {reconstruction:?}");
                let least = least[usize::from(msaa != Msaa::Off)];
                studio.mode(hdr, msaa);
                studio.check(&name, &reference, settings, least);
            }
        }
    }
}

#[test]
fn float32_is_at_least_as_good_as_float16() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    for msaa in [Msaa::Off, Msaa::Sample4] {
        for hdr in [true, false] {
            let reference = studio.mode(true, msaa).plain();
            let float16 = psnr(
                &reference,
                &studio.mode(hdr, msaa).packed(with(PackedFormat::Float16)),
            );
            let float32 = psnr(&reference, &studio.packed(with(PackedFormat::Float32)));
            println!("{msaa:?} hdr {hdr}: {float16:.2} dB, {float32:.2} dB");
            assert!(float32 > float16 - 0.05);
        }
    }
}

#[test]
fn unorm8_is_the_picture_of_a_camera_without_hdr() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    for (msaa, least) in [(Msaa::Off, 46.0), (Msaa::Sample4, 41.5)] {
        let reference = studio.mode(false, msaa).plain();
        let name = format!("unorm8, {msaa:?}");
        studio.check(&name, &reference, with(PackedFormat::Unorm8), least);
    }
}

#[test]
fn every_sample_count_works_or_says_why_not() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    for msaa in [Msaa::Off, Msaa::Sample2, Msaa::Sample4, Msaa::Sample8] {
        for msaa_resolve in [MsaaResolve::Box, MsaaResolve::ToneMapWeighted] {
            let settings = YCoCgFrameBuffer {
                msaa_resolve,
                ..default()
            };
            let adapter_has_it = matches!(msaa, Msaa::Off | Msaa::Sample4)
                || studio.supports_samples(PackedFormat::Float16, msaa.samples());
            if adapter_has_it {
                let reference = studio.mode(true, msaa).plain();
                let name = format!("{msaa:?}, {msaa_resolve:?}");
                studio.check(&name, &reference, settings, 38.0);
            } else {
                // Bevy itself would panic in such a frame, so only the reason is asked for.
                skipped(&format!("frame buffer with {msaa:?}: not on this adapter"));
            }
        }
    }
}

#[test]
fn the_weighted_resolve_keeps_the_edge_of_a_bright_surface_smooth() {
    let _gpu = gpu();
    let truth = supersampled(bright_edge_scene, 4);
    keep("edge_truth", &truth);
    let mut studio = Studio::new(bright_edge_scene);
    let mut error = |msaa_resolve| {
        let picture = studio.mode(true, Msaa::Sample4).packed(YCoCgFrameBuffer {
            msaa_resolve,
            ..default()
        });
        keep(&format!("edge_{msaa_resolve:?}"), &picture);
        psnr(&truth, &picture)
    };
    let (plain, weighted) = (error(MsaaResolve::Box), error(MsaaResolve::ToneMapWeighted));
    println!("box {plain:.2} dB, weighted {weighted:.2} dB");
    assert!(weighted > plain + 3.0);
}

#[test]
fn memory_is_as_documented() {
    let _gpu = gpu();
    let mut studio = Studio::with_size(64, 32, lit_scene);
    let pixels = 64 * 32;
    // Bytes a pixel: Bevy's own, packed, and in three small floats.
    for (hdr, msaa, plain_bytes, packed_bytes, small_bytes) in [
        (true, Msaa::Off, 16, 20, 8),
        (true, Msaa::Sample4, 48, 36, 24),
        (false, Msaa::Off, 8, 12, 8),
        (false, Msaa::Sample4, 24, 28, 24),
    ] {
        let mut check = |quality: FrameBufferQuality, bytes: u64| {
            studio.mode(hdr, msaa).quality(quality);
            let memory = studio.report().expect("a report").memory;
            assert_eq!(memory.total(), bytes * pixels, "{hdr} {msaa:?} {quality:?}");
            studio.state()
        };
        let state = check(FrameBufferQuality::Compact, small_bytes);
        assert_eq!(state, Some(CameraState::Rg11b10Ufloat));
        check(FrameBufferQuality::Exact, plain_bytes);
        // The shader reads the samples: no texture to resolve to.
        let saved = if msaa == Msaa::Off { 0 } else { 4 };
        let weighted = YCoCgFrameBuffer {
            msaa_resolve: MsaaResolve::ToneMapWeighted,
            ..default()
        };
        let unorm8_bytes = if msaa == Msaa::Off { 10 } else { 18 };
        let mut packed = vec![
            (packing(), packed_bytes),
            (weighted.into(), packed_bytes - saved),
        ];
        if !hdr {
            packed.push((with(PackedFormat::Unorm8).into(), unorm8_bytes));
        }
        for (quality, bytes) in packed {
            let state = check(quality, bytes);
            assert!(matches!(state, Some(CameraState::Packed(_))), "{state:?}");
        }
    }
}

#[test]
fn a_format_that_needs_no_hdr_says_so() {
    let _gpu = gpu();
    let mut studio = Studio::lit();
    studio.mode(true, Msaa::Off);
    let reason = FallbackReason::Unorm8WithHdr;
    assert!(reason.to_string().contains("`Float16`"));
    studio.check_fallback(with(PackedFormat::Unorm8), reason);
}

/// A bright gradient, unlit, that fills the picture of the camera.
fn gradient_scene(app: &mut App) {
    app.add_systems(Startup, |world: &mut World| {
        let gradient = RgbImage::from_fn(128, 2, |x, _| image::Rgb([225 + (x / 12) as u8; 3]));
        let material = StandardMaterial {
            base_color_texture: Some(world.add_asset(srgb_image(gradient))),
            unlit: true,
            ..default()
        };
        let camera =
            Transform::from_xyz(0.0, 1.6, 3.2).looking_at(Vec3::new(0.0, 0.4, 0.0), Vec3::Y);
        let place = camera * Transform::from_xyz(0.0, 0.0, -1.0);
        spawn_mesh(world, Rectangle::new(1.3, 0.9), material, place);
    });
}

/// The steps of the 8-bit format are three times those of the picture at white: without dither they are bands.
#[test]
fn a_bright_gradient_in_8_bits_is_dithered_by_its_own_steps() {
    let _gpu = gpu();
    let mut studio = Studio::new(gradient_scene);
    studio.mode(false, Msaa::Off).camera(|camera| {
        camera.insert((Tonemapping::Linear, DebandDither::Disabled));
    });
    let reference = studio.plain();
    let banded = studio.packed(with(PackedFormat::Unorm8));
    studio.camera(|camera| {
        camera.insert(DebandDither::Enabled);
    });
    let dithered = studio.packed(with(PackedFormat::Unorm8));
    for (name, picture) in [
        ("plain", &reference),
        ("banded", &banded),
        ("dithered", &dithered),
    ] {
        keep(&format!("gradient_{name}"), picture);
    }
    // Root mean square of the differences of columns' means, in levels.
    let error = |picture: &RgbImage| {
        let difference = |x: u32| {
            let column = (0..picture.height()).map(|y| {
                f64::from(picture.get_pixel(x, y).0[1]) - f64::from(reference.get_pixel(x, y).0[1])
            });
            column.sum::<f64>() / f64::from(picture.height())
        };
        let squares = (0..picture.width()).map(|x| difference(x).powi(2));
        (squares.sum::<f64>() / f64::from(picture.width())).sqrt()
    };
    let (banded, dithered) = (error(&banded), error(&dithered));
    println!("{banded:.3} levels with bands, {dithered:.3} dithered");
    assert!(dithered < 0.6 * banded);
}

#[test]
fn the_dial_names_the_formats() {
    use FrameBufferQuality as Quality;
    let unorm8 = FrameBufferFormat::Packed(PackedFormat::Unorm8);
    let small_floats = FrameBufferFormat::Rg11b10Ufloat;
    for (quality, hdr, expected) in [
        (Quality::Exact, true, vec![]),
        (Quality::Compact, true, vec![small_floats]),
        (Quality::Smallest, true, vec![unorm8, small_floats]),
        (Quality::Smallest, false, vec![unorm8]),
        (
            YCoCgFrameBuffer::default().into(),
            true,
            vec![PackedFormat::Float16.into()],
        ),
    ] {
        assert_eq!(quality.formats(hdr), expected, "{quality:?}");
    }
}
