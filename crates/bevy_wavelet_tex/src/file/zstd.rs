//! Zstandard frames, read by the crate that Bevy itself uses to read KTX2.

/// Decompresses a frame of exactly `length` bytes, or returns what is wrong with it.
///
/// The result grows as it is decompressed, so a wrong `length` allocates no more than the frame has. The
/// window, which a frame can make larger than itself, is at most `length` or 8 MiB, what every decoder has
/// to support (RFC 8878, section 3.1.1.1.2).
///
/// # Errors
/// Returns the reason, and the remedy where there is one.
#[cfg(feature = "zstd")]
pub fn decompress(frame: &[u8], length: usize) -> Result<Vec<u8>, String> {
    use ruzstd::decoding::StreamingDecoder;
    use std::io::Read;

    let fail = |error: &dyn std::fmt::Display| format!("its Zstandard data is damaged: {error}");
    let window = (length as u64).max(8 << 20);
    let mut rest = frame;
    let mut decoder = StreamingDecoder::new_with_max_window_size(&mut rest, window)
        .map_err(|error| fail(&error))?;
    let mut bytes = Vec::new();
    let most = length as u64 + 1;
    let read = (&mut decoder).take(most).read_to_end(&mut bytes);
    read.map_err(|error| fail(&error))?;
    if bytes.len() > length {
        return Err(fail(&format_args!("it has more than {length} bytes")));
    }
    if bytes.len() < length {
        return Err(fail(&format_args!(
            "it has {} bytes instead of {length}",
            bytes.len()
        )));
    }
    if !rest.is_empty() {
        return Err(fail(&format_args!("{} bytes follow it", rest.len())));
    }
    Ok(bytes)
}

/// The stand-in of a build that refuses compressed files by their headers.
#[cfg(not(feature = "zstd"))]
pub(super) fn decompress(_frame: &[u8], _length: usize) -> Result<Vec<u8>, String> {
    Err(super::ReadError::ZstdDisabled.to_string())
}

/// Makes a frame that states its length, at a `level` from 1 to 22.
#[cfg(feature = "zstd_encode")]
pub(super) fn compress(bytes: &[u8], level: i32) -> Vec<u8> {
    ::zstd::bulk::compress(bytes, level.clamp(1, 22)).expect("memory is all that it needs")
}
