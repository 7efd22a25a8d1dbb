//! `.wtex` files: whatever the bytes, reading ends without a panic and allocates no more than they
//! justify; what was read comes back from its own file, and every level of it decodes.
#![no_main]

use bevy_wavelet_tex::{
    codec::decoder::decode,
    file::{read, write},
};
use libfuzzer_sys::fuzz_target;

/// Pixels up to which a texture is decoded: more only costs time.
const MOST_PIXELS: u64 = 4096;

fuzz_target!(|bytes: &[u8]| {
    let Ok(image) = read(bytes) else { return };
    let again = read(&write(&image)).expect("its own file");
    assert!(again == image, "a file does not come back as it was");
    if u64::from(image.size[0]) * u64::from(image.size[1]) <= MOST_PIXELS {
        for level in 0..image.levels {
            let decoded = decode(&image, level);
            assert!(decoded.pixels.iter().flatten().all(|value| value.is_finite()));
        }
    }
});
