//! Good files come back, bad ones are named.

use proptest::prelude::*;

use super::{FIXED_HEADER_BYTES, ReadError, read, write};
use crate::codec::{
    encoder::{EncodeSettings, encode},
    image::{ColorSpace, Content, WaveletImage},
    search::Effort,
};

fn image(size: [u32; 2], content: Content, mips: bool) -> WaveletImage {
    let pixels: Vec<[u8; 3]> = (0..size[0] * size[1])
        .map(|i| [i, i * 7, i * 31].map(|v| (v % 251) as u8))
        .collect();
    let settings = EncodeSettings {
        content,
        mips,
        color_space: ColorSpace::Linear,
        effort: Effort::Fast,
    };
    encode(&pixels, size, &settings, &|_, _| {}).expect("a good image")
}

fn sample() -> Vec<u8> {
    write(&image([20, 13], Content::Color, true))
}

#[test]
fn every_content_and_size_comes_back() {
    for content in [Content::Gray, Content::Color, Content::Normal] {
        for size in [[1, 1], [1, 9], [8, 8], [33, 20]] {
            for mips in [false, true] {
                let image = image(size, content, mips);
                let back = read(&write(&image)).expect("a good file");
                assert_eq!(back, image, "{content:?} {size:?}");
            }
        }
    }
}

#[test]
fn a_blob_stands_alone_as_ktx2() {
    let bytes = sample();
    let length = u32::from_le_bytes(bytes[24..28].try_into().unwrap()) as usize;
    let blob = &bytes[FIXED_HEADER_BYTES + 8..][..length];
    let reader = ktx2::Reader::new(blob).expect("a KTX2 file");
    assert_eq!(
        reader.writer().map(|w| w.trim_end_matches('\0')),
        Some("bevy_wavelet_tex")
    );
    assert_eq!(reader.header().level_count, read(&bytes).unwrap().levels);
}

#[test]
fn cut_at_every_byte_it_is_an_error() {
    let bytes = sample();
    assert!(matches!(read(&[]), Err(ReadError::Magic)));
    for length in 1..bytes.len() {
        let error = read(&bytes[..length]).expect_err("cut short");
        assert!(
            matches!(error, ReadError::Truncated { .. }),
            "{length}: {error}"
        );
    }
}

#[test]
fn each_fault_of_the_header_is_named() {
    let with = |at: usize, value: &[u8]| {
        let mut bytes = sample();
        bytes[at..at + value.len()].copy_from_slice(value);
        read(&bytes).expect_err("a bad file").to_string()
    };
    assert!(with(0, b"DDS ").contains("not a wavelet texture"));
    assert!(with(8, &[2, 0]).contains("version 2 is newer"));
    assert!(with(8, &[0, 0]).contains("version is 0"));
    assert!(with(10, &[9]).contains("content is 9"));
    assert!(with(11, &[9]).contains("colour space is 9"));
    assert!(with(12, &u32::MAX.to_le_bytes()).contains("4294967295 x 13"));
    assert!(with(16, &[0; 4]).contains("20 x 0"));
    assert!(with(20, &[7]).contains("plane groups is 7"));
    assert!(with(24, &u32::MAX.to_le_bytes()).contains("cut short"));
    assert!(with(12, &4096u32.to_le_bytes()).contains("bytes long instead of"));
    let mut longer = sample();
    longer.push(0);
    assert!(
        read(&longer)
            .expect_err("too long")
            .to_string()
            .contains("1 bytes follow")
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4096))]

    /// Whatever is changed, reading does not panic, and what it returns is no larger than the file
    /// and can be decoded.
    #[test]
    fn damaged_bytes_neither_panic_nor_allocate_more_than_the_file(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
    ) {
        let mut bytes = sample();
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Ok(image) = read(&bytes) {
            prop_assert!(image.gpu_bytes() <= bytes.len());
            for level in 0..image.levels {
                let decoded = crate::codec::decoder::decode(&image, level);
                prop_assert!(decoded.pixels.iter().flatten().all(|v| v.is_finite()));
            }
        }
    }

    #[test]
    fn random_bytes_after_the_magic_are_an_error(tail in prop::collection::vec(any::<u8>(), 0..512)) {
        let bytes = [&super::MAGIC[..], &tail].concat();
        prop_assert!(read(&bytes).is_err());
    }
}
