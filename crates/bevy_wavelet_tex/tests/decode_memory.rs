//! Decoding takes no more memory than the loader's budget counts with.
#![cfg(feature = "encode")]

use std::{
    alloc::{GlobalAlloc, Layout, System},
    sync::atomic::{AtomicUsize, Ordering},
};

use bevy_wavelet_tex::codec::{
    decoder::decode,
    encoder::encode,
    rate::Rate,
    settings::{Effort, EncodeSettings, Formats},
    source::{Pixels, Source},
};

/// Counts the bytes that are allocated, and the most so far.
struct Counting;

static NOW: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

// SAFETY: all calls are passed on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let now = NOW.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        MOST.fetch_max(now, Ordering::Relaxed);
        // SAFETY: the caller's.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        NOW.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller's.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// `asset::DECODE_BYTES_PER_PIXEL`, which is there with the feature `bevy` alone.
const BYTES_PER_PIXEL: f64 = 40.0;

#[test]
fn a_pixel_takes_no_more_bytes_than_the_budget_has() {
    #[cfg(feature = "bevy")]
    assert_eq!(
        BYTES_PER_PIXEL,
        bevy_wavelet_tex::asset::DECODE_BYTES_PER_PIXEL as f64
    );
    const SIDE: u32 = 256;
    let pixels: Vec<[u8; 4]> = (0..SIDE * SIDE)
        .map(|i| [i, i / SIDE, i / 7, i / 300].map(|v| v as u8))
        .collect();
    let source = Source::new([SIDE; 2], Pixels::Rgba8(&pixels));
    for rate in Rate::ALL {
        for formats in [Formats::Wavelet, Formats::Plain] {
            let settings = EncodeSettings {
                rate,
                formats,
                alpha: true,
                effort: Effort::Fast,
                ..EncodeSettings::default()
            };
            let image = encode(&source, &settings, &|_, _| {}).expect("an image");
            let before = NOW.load(Ordering::Relaxed);
            MOST.store(before, Ordering::Relaxed);
            // As the loader does: the texture grows level by level.
            let levels = (0..image.levels)
                .flat_map(|level| decode(&image, level).to_rgba8(image.content))
                .flatten();
            let texture: Vec<u8> = levels.collect();
            let most = MOST.load(Ordering::Relaxed) - before;
            let bytes = most as f64 / f64::from(SIDE * SIDE);
            println!("{} {formats:?}: {bytes:.1} bytes a pixel", rate.name());
            assert!(texture.len() > pixels.len() * 4);
            assert!(
                bytes <= BYTES_PER_PIXEL,
                "{} {formats:?}: {bytes}",
                rate.name()
            );
        }
    }
}
