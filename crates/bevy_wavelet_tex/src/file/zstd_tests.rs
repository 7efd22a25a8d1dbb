//! Files compressed with Zstandard.

use ktx2::{Header, LevelIndex};

use super::{
    AXES_BYTES, FIXED_HEADER_BYTES, GROUP_BYTES, PLAIN_BYTES, VERSION, read, tests, version, write,
    write_zstd,
};
use crate::codec::image::{Payload, WaveletImage};

fn images() -> Vec<WaveletImage> {
    let read = |bytes: &Vec<u8>| read(bytes).expect("a good file");
    tests::samples().iter().map(read).collect()
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
            assert!(super::zstd::decompress(frame, length).is_ok());
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
    let shape = super::ktx2_blob::Shape::plain(plain.format, [16384; 2], false);
    let frame = super::zstd::compress(&plain.blocks, 1);
    let blocks = vec![0; plain.format.level_bytes([16384; 2])];
    let blob = super::ktx2_blob::write(shape, 1, &[], &blocks, Some(&|_| frame.clone()));
    let mut bytes = write_zstd(&image, 1)[..start].to_vec();
    for at in [12, 16, 28, 32] {
        bytes[at..at + 4].copy_from_slice(&16384u32.to_le_bytes());
    }
    bytes[36..40].copy_from_slice(&(blob.len() as u32).to_le_bytes());
    bytes.extend(blob);
    let error = read(&bytes).expect_err("a lie").to_string();
    assert!(error.contains("bytes instead of 134217728"), "{error}");
    // The other way round, a frame is read no further than the header allows.
    let error = super::zstd::decompress(&super::zstd::compress(&[0; 1 << 20], 1), 100);
    assert!(error.expect_err("too long").contains("more than 100 bytes"));
}

#[test]
fn each_fault_of_a_frame_is_named() {
    let frame = super::zstd::compress(&[7; 1000], 1);
    let fault = |frame: &[u8]| super::zstd::decompress(frame, 1000).expect_err("damaged");
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
    let with = |at: usize, value: &[u8]| {
        let mut bytes = bytes.clone();
        let at = blob_start(&image) + at;
        bytes[at..at + value.len()].copy_from_slice(value);
        read(&bytes).expect_err("damaged").to_string()
    };
    assert!(with(88, &u64::MAX.to_le_bytes()).contains("index of mip levels"));
    assert!(with(88, &[1]).contains("bytes long instead of"));
    assert!(with(44, &[0]).contains("as `wavelet-tex` writes them"));
    let mut plain = bytes.clone();
    plain[9] = 0;
    assert!(read(&plain).is_err());
}
