//! Round trips of good files, and the errors of damaged ones.

use proptest::prelude::*;

use super::{FIXED_HEADER_BYTES, GROUP_BYTES, ReadError, read, read_at_most, write};
use crate::codec::{
    blocks::BlockFormat,
    decoder::decode,
    encoder::encode,
    image::{ColorSpace, WaveletImage},
    layout::mip_size,
    rate::Rate,
    settings::{Effort, EncodeSettings, Formats, Method},
    source::{Pixels, Source},
};

fn encoded(size: [u32; 2], pixels: &[[u8; 4]], settings: EncodeSettings) -> WaveletImage {
    let source = Source::new(size, Pixels::Rgba8(pixels));
    encode(&source, &settings, &|_, _| {}).expect("a good image")
}

fn image(size: [u32; 2], settings: EncodeSettings) -> WaveletImage {
    let pixels: Vec<[u8; 4]> = (0..size[0] * size[1])
        .map(|i| [i, i * 7, i * 31, i * 3].map(|v| (v % 251) as u8))
        .collect();
    let settings = EncodeSettings {
        color_space: ColorSpace::Linear,
        ..settings
    };
    encoded(size, &pixels, settings)
}

fn slopes_and_edges(size: [u32; 2]) -> Vec<[u8; 4]> {
    let pixel = |i: u32| {
        let [x, y] = [i % size[0], i / size[0]];
        let edge = 90 * ((x / 7 + y / 5) % 2);
        [x * 2 + edge, y * 3, x + y, 255 - x].map(|v| v.min(255) as u8)
    };
    (0..size[0] * size[1]).map(pixel).collect()
}

fn fast(rate: Rate) -> EncodeSettings {
    EncodeSettings {
        rate,
        effort: Effort::Fast,
        formats: Formats::Wavelet,
        ..EncodeSettings::default()
    }
}

fn sample() -> Vec<u8> {
    write(&image([20, 13], fast(Rate::Color3)))
}

/// A file with axes of colour that were fitted.
fn axes_sample() -> Vec<u8> {
    // Saturated edges of one hue.
    let pixel = |i: u32| {
        [
            if (i * 7919) % 13 < 6 { 250 } else { 10 },
            (i % 3) as u8,
            20,
        ]
    };
    let pixels: Vec<[u8; 3]> = (0..32 * 24).map(pixel).collect();
    let settings = EncodeSettings {
        effort: Effort::Default,
        ..fast(Rate::Color5)
    };
    let source = Source::new([32, 24], Pixels::Rgb8(&pixels));
    let image = encode(&source, &settings, &|_, _| {}).expect("a good image");
    assert!(!image.axes().are_ycocg());
    write(&image)
}

#[test]
fn axes_of_colour_come_back_and_their_faults_are_named() {
    let bytes = axes_sample();
    let image = read(&bytes).expect("a good file");
    assert_eq!(bytes[8], 4);
    assert_eq!(write(&image), bytes);
    for value in [f32::NAN, f32::INFINITY, 3.0] {
        let mut bytes = bytes.clone();
        bytes[FIXED_HEADER_BYTES..FIXED_HEADER_BYTES + 4].copy_from_slice(&value.to_le_bytes());
        assert!(matches!(read(&bytes), Err(ReadError::Axes)), "{value}");
    }
}

/// A file with a plain texture of 20 x 16 texels in BC4.
fn plain_sample() -> Vec<u8> {
    let settings = EncodeSettings {
        formats: Formats::Plain,
        ..fast(Rate::Gray4)
    };
    let image = image([20, 13], settings);
    let plain = image.plain().expect("plain");
    assert_eq!((plain.format, plain.size), (BlockFormat::Bc4, [20, 16]));
    write(&image)
}

#[test]
fn every_rate_method_and_size_comes_back() {
    for rate in Rate::ALL {
        for alpha in [false, true] {
            for method in [Method::Best, Method::Thesis] {
                for size in [[1, 1], [1, 9], [8, 8], [33, 20]] {
                    for (mips, formats) in [
                        (false, Formats::Wavelet),
                        (true, Formats::Wavelet),
                        (true, Formats::Plain),
                    ] {
                        let settings = EncodeSettings {
                            formats,
                            mips,
                            alpha,
                            method,
                            effort: Effort::Default,
                            ..fast(rate)
                        };
                        let image = image(size, settings);
                        let back = read(&write(&image)).expect("a good file");
                        assert_eq!(back, image, "{settings:?} {size:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_blob_stands_alone_as_ktx2() {
    let bytes = sample();
    let length = u32::from_le_bytes(bytes[28..32].try_into().unwrap()) as usize;
    let blob = &bytes[FIXED_HEADER_BYTES + 2 * GROUP_BYTES..][..length];
    let reader = ktx2::Reader::new(blob).expect("a KTX2 file");
    assert_eq!(
        reader.writer().map(|w| w.trim_end_matches('\0')),
        Some("bevy_wavelet_tex")
    );
    assert_eq!(reader.header().level_count, read(&bytes).unwrap().levels);
}

#[test]
fn cut_at_every_byte_it_is_an_error() {
    assert!(matches!(read(&[]), Err(ReadError::Magic)));
    for bytes in samples().into_iter().chain(compressed_samples()) {
        for length in 1..bytes.len() {
            let error = read(&bytes[..length]).expect_err("cut short");
            assert!(
                matches!(error, ReadError::Truncated { .. }),
                "{length}: {error}"
            );
        }
    }
}

/// A file with other bytes is an error that has these words.
fn assert_named(file: &[u8], faults: &[(usize, &[u8], &str)]) {
    for (at, value, words) in faults {
        let mut bytes = file.to_vec();
        bytes[*at..at + value.len()].copy_from_slice(value);
        let error = read(&bytes).expect_err("a bad file").to_string();
        assert!(error.contains(words), "{value:?} at {at}: {error}");
    }
}

#[test]
fn each_fault_of_the_header_is_named() {
    let faults: [(usize, &[u8], &str); 18] = [
        (0, b"DDS ", "not a wavelet texture"),
        (8, &[5, 0], "version 5 is newer"),
        (8, &[2, 4], "version 1026 is newer"),
        (8, &[1, 0], "version 1 was never released"),
        (8, &[0, 0], "version is 0"),
        (10, &[9], "content is 9"),
        (11, &[9], "colour space is 9"),
        (12, &u32::MAX.to_le_bytes(), "4294967295 x 13"),
        (16, &[0; 4], "20 x 0"),
        (20, &[7], "plane groups is 7"),
        (24, &[1], "subsampling is 1"),
        (25, &[4], "packing is 4"),
        (25, &[99], "packing is 99"),
        (26, &[5], "reserved byte is 5"),
        (32, &[1], "length of a second texture is 1"),
        (36, &[0], "subsampling is 0"),
        (28, &u32::MAX.to_le_bytes(), "cut short"),
        (12, &4096u32.to_le_bytes(), "bytes long instead of"),
    ];
    assert_named(&sample(), &faults);
    let mut longer = sample();
    longer.push(0);
    let error = read(&longer).expect_err("too long").to_string();
    assert!(error.contains("1 bytes follow"), "{error}");
}

#[test]
#[cfg(not(feature = "zstd"))]
fn a_compressed_file_names_the_feature_that_reads_it() {
    let mut bytes = sample();
    bytes[9] = 1;
    let error = read(&bytes).expect_err("disabled").to_string();
    assert!(error.contains("enable the feature `zstd`"), "{error}");
}

#[test]
fn each_fault_of_a_plain_texture_is_named() {
    let faults: [(usize, &[u8], &str); 10] = [
        (8, &[2, 0], "number of plane groups is 0"),
        (24, &[0], "format is 0"),
        (24, &[77], "format is 77"),
        (25, &[1], "reserved byte is 1"),
        (28, &[18], "texture width is 18"),
        (28, &[0], "texture width is 0"),
        (28, &[24], "texture width is 24"),
        (32, &[20], "texture height is 20"),
        (32, &[8], "bytes long instead of"),
        (36, &u32::MAX.to_le_bytes(), "cut short"),
    ];
    assert_named(&plain_sample(), &faults);
    let bytes = plain_sample();
    assert_eq!(bytes[8], 3);
    let blob = &bytes[FIXED_HEADER_BYTES + super::PLAIN_BYTES..];
    let header = ktx2::Reader::new(blob).expect("a KTX2 file").header();
    assert_eq!(header.format, Some(ktx2::Format::BC4_UNORM_BLOCK));
}

/// Files of all packings, each of which can be damaged in ways of its own.
fn samples() -> Vec<Vec<u8>> {
    let settings = [
        fast(Rate::Color3),
        fast(Rate::Gray3),
        fast(Rate::Color5),
        EncodeSettings {
            method: Method::Thesis,
            effort: Effort::Default,
            alpha: true,
            ..fast(Rate::Color2_25)
        },
    ];
    let planes = settings.map(|s| write(&image([20, 13], s)));
    planes
        .into_iter()
        .chain([plain_sample(), axes_sample()])
        .collect()
}

/// The same, compressed.
#[cfg(feature = "zstd_encode")]
fn compressed_samples() -> Vec<Vec<u8>> {
    let compressed = |bytes: &Vec<u8>| super::write_zstd(&read(bytes).unwrap(), 19);
    samples().iter().map(compressed).collect()
}

#[cfg(not(feature = "zstd_encode"))]
fn compressed_samples() -> Vec<Vec<u8>> {
    Vec::new()
}

fn damaged(file: &[u8], changes: Vec<(prop::sample::Index, u8)>) -> Vec<u8> {
    let mut bytes = file.to_vec();
    for (at, value) in changes {
        *at.get_mut(&mut bytes) = value;
    }
    bytes
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4096))]

    /// No change to a file makes reading it panic, and an image that is read is no larger than the
    /// file and can be decoded.
    #[test]
    fn damaged_bytes_neither_panic_nor_allocate_more_than_the_file(
        sample in 0usize..6,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
    ) {
        static SAMPLES: std::sync::LazyLock<Vec<Vec<u8>>> = std::sync::LazyLock::new(samples);
        let bytes = damaged(&SAMPLES[sample], changes);
        if let Ok(image) = read(&bytes) {
            prop_assert!(image.gpu_bytes() <= bytes.len());
            for level in 0..image.levels {
                let decoded = crate::codec::decoder::decode(&image, level);
                prop_assert!(decoded.pixels.iter().flatten().all(|v| v.is_finite()));
            }
        }
    }

    /// Nor does any to a compressed file, whose image is no larger than its header says.
    #[test]
    #[cfg(feature = "zstd_encode")]
    fn damaged_compressed_bytes_do_not_panic(
        sample in 0usize..6,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
    ) {
        static SAMPLES: std::sync::LazyLock<Vec<Vec<u8>>> =
            std::sync::LazyLock::new(compressed_samples);
        if let Ok(image) = read(&damaged(&SAMPLES[sample], changes)) {
            prop_assert_eq!(&read(&write(&image)).unwrap(), &image);
        }
    }

    #[test]
    fn random_bytes_after_the_magic_are_an_error(tail in prop::collection::vec(any::<u8>(), 0..512)) {
        let bytes = [&super::MAGIC[..], &tail].concat();
        prop_assert!(read(&bytes).is_err());
    }
}

/// Files without their largest levels decode to the levels that are left.
#[test]
fn the_levels_that_are_left_are_the_same() {
    let mut whole = 0;
    for size in [[64, 64], [93, 61], [100, 36], [37, 130], [5, 3]] {
        for rate in Rate::ALL {
            for formats in [Formats::Wavelet, Formats::Plain] {
                let settings = EncodeSettings {
                    formats,
                    alpha: true,
                    color_space: ColorSpace::Srgb,
                    ..fast(rate)
                };
                let image = encoded(size, &slopes_and_edges(size), settings);
                let file = write(&image);
                for most in [u32::MAX, 64, 32, 20, 9, 1, 0] {
                    let smaller = read_at_most(&file, Some(most)).expect("a good file");
                    let first = image.levels - smaller.levels;
                    let name = format!("{size:?} {} {formats:?}, at most {most}", rate.name());
                    assert_eq!(smaller.size, mip_size(size, first), "{name}");
                    // What is made of it is a file again.
                    assert_eq!(read(&write(&smaller)).expect("a file"), smaller, "{name}");
                    for level in 0..smaller.levels {
                        let (a, b) = (decode(&smaller, level), decode(&image, first + level));
                        assert_eq!(a.size, b.size, "{name}: {level}");
                        let errors = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
                        let worst = errors.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                        assert!(worst < 1e-5, "{name}: {level}: {worst}");
                        assert_eq!(a.alpha.is_some(), b.alpha.is_some(), "{name}");
                    }
                    let fits = smaller.size.iter().all(|side| *side <= most.max(1));
                    let is_scaled = image.plain().is_some_and(|p| p.is_scaled(size));
                    assert!(fits || is_scaled, "{name}: {:?}", smaller.size);
                    whole += u32::from(fits);
                }
            }
        }
    }
    assert!(whole > 400, "{whole}");
}

/// Files compressed with Zstandard.
#[cfg(feature = "zstd_encode")]
mod zstd {
    use ktx2::{Header, LevelIndex};

    use super::*;
    use crate::{
        codec::image::Payload,
        file::{
            AXES_BYTES, PLAIN_BYTES, VERSION, ktx2_blob, version, write_zstd,
            zstd::{compress, decompress},
        },
    };

    fn images() -> Vec<WaveletImage> {
        let read = |bytes: &Vec<u8>| read(bytes).expect("a good file");
        samples().iter().map(read).collect()
    }

    /// The offset of the first blob in bytes.
    fn blob_start(image: &WaveletImage) -> usize {
        match image.groups().count() {
            0 => FIXED_HEADER_BYTES + PLAIN_BYTES,
            groups => {
                let axes = if version(image) == VERSION {
                    AXES_BYTES
                } else {
                    0
                };
                FIXED_HEADER_BYTES + axes + groups * GROUP_BYTES
            }
        }
    }

    #[test]
    fn it_comes_back_and_each_level_is_a_frame() {
        for image in images() {
            let bytes = write_zstd(&image, 19);
            assert_eq!(read(&bytes).expect("a good file"), image);
            assert_eq!(bytes[8..10], [write(&image)[8], 1]);
            let blob = &bytes[blob_start(&image)..];
            let header = Header::from_bytes(blob.first_chunk().unwrap()).expect("a KTX2 header");
            assert_eq!(
                header.supercompression_scheme,
                Some(ktx2::SupercompressionScheme::Zstandard)
            );
            assert_eq!(header.level_count, image.levels);
            let (index, _) = blob[Header::LENGTH..].as_chunks();
            for entry in &index[..image.levels as usize] {
                let level = LevelIndex::from_bytes(entry);
                let end = (level.byte_offset + level.byte_length) as usize;
                let frame = &blob[level.byte_offset as usize..end];
                assert_eq!(frame[..4], [0x28, 0xb5, 0x2f, 0xfd]);
                let length = level.uncompressed_byte_length as usize;
                assert!(decompress(frame, length).is_ok());
            }
        }
    }

    #[test]
    fn repeated_blocks_take_less() {
        let mut image = images().swap_remove(4);
        let Payload::Plain(plain) = &mut image.payload else {
            panic!("not a plain texture")
        };
        plain.blocks.fill(7);
        let (stored, compressed) = (write(&image), write_zstd(&image, 1));
        assert!(compressed.len() < stored.len(), "{}", compressed.len());
        assert_eq!(read(&compressed).expect("a good file"), image);
    }

    /// A file whose header claims the largest size, with an index and frames that agree with it.
    #[test]
    fn a_header_that_lies_allocates_no_more_than_the_frames_hold() {
        let image = images().swap_remove(4);
        let start = blob_start(&image);
        let plain = image.plain().expect("plain");
        // The blob of an image of the largest size whose only level is the frame of a small one.
        let shape = ktx2_blob::Shape::plain(plain.format, [16384; 2], false);
        let frame = compress(&plain.blocks, 1);
        let blocks = vec![0; plain.format.level_bytes([16384; 2])];
        let blob = ktx2_blob::write(shape, 1, &[], &blocks, Some(&|_| frame.clone()));
        let mut bytes = write_zstd(&image, 1)[..start].to_vec();
        for at in [12, 16, 28, 32] {
            bytes[at..at + 4].copy_from_slice(&16384u32.to_le_bytes());
        }
        bytes[36..40].copy_from_slice(&(blob.len() as u32).to_le_bytes());
        bytes.extend(blob);
        let error = read(&bytes).expect_err("a lie").to_string();
        assert!(error.contains("bytes instead of 134217728"), "{error}");
        // The other way round, a frame is read no further than the header allows.
        let error = decompress(&compress(&[0; 1 << 20], 1), 100);
        assert!(error.expect_err("too long").contains("more than 100 bytes"));
    }

    #[test]
    fn each_fault_of_a_frame_is_named() {
        let frame = compress(&[7; 1000], 1);
        let fault = |frame: &[u8]| decompress(frame, 1000).expect_err("damaged");
        assert!(fault(&frame[..frame.len() - 1]).contains("damaged"));
        assert!(fault(&[&frame[..], &[0]].concat()).contains("1 bytes follow"));
        assert!(fault(b"no frame").contains("damaged"));
        // A window of 16 MiB: descriptor without a single segment, exponent 14.
        let window = [0x28, 0xb5, 0x2f, 0xfd, 0, 14 << 3, 1, 0, 0];
        assert!(
            fault(&window).to_lowercase().contains("window"),
            "{}",
            fault(&window)
        );

        let image = images().swap_remove(0);
        let bytes = write_zstd(&image, 1);
        let start = blob_start(&image);
        let faults: [(usize, &[u8], &str); 3] = [
            (88, &u64::MAX.to_le_bytes(), "index of mip levels"),
            (88, &[1], "bytes long instead of"),
            (44, &[0], "as `wavelet-tex` writes them"),
        ];
        assert_named(
            &bytes,
            &faults.map(|(at, value, words)| (start + at, value, words)),
        );
        let mut plain = bytes.clone();
        plain[9] = 0;
        assert!(read(&plain).is_err());
    }
}
