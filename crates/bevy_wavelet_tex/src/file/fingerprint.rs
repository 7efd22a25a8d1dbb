//! The fingerprint of what a file was made of.

use super::{FINGERPRINT_FLAG, FLAGS_AT, MAGIC};

const BYTES: usize = size_of::<u64>();

/// Adds a fingerprint to the bytes of a file, or replaces the one that is there.
pub fn with_fingerprint(mut bytes: Vec<u8>, value: u64) -> Vec<u8> {
    bytes.truncate(without(&bytes).len());
    bytes[FLAGS_AT] |= FINGERPRINT_FLAG;
    bytes.extend(value.to_le_bytes());
    bytes
}

/// The fingerprint of a file that has one.
pub fn fingerprint(bytes: &[u8]) -> Option<u64> {
    let end = without(bytes).len();
    bytes[end..]
        .first_chunk()
        .map(|value| u64::from_le_bytes(*value))
}

/// The file without its fingerprint.
pub(super) fn without(bytes: &[u8]) -> &[u8] {
    let has_one = bytes.starts_with(&MAGIC)
        && bytes
            .get(FLAGS_AT)
            .is_some_and(|flags| flags & FINGERPRINT_FLAG != 0)
        && bytes.len() >= MAGIC.len() + BYTES;
    let end = if has_one {
        bytes.len() - BYTES
    } else {
        bytes.len()
    };
    &bytes[..end]
}
