//! Detection of JPEGs that are cut short, whose missing rows the decoder fills with gray.

const START_OF_SCAN: u8 = 0xda;
const END_OF_IMAGE: [u8; 2] = [0xff, 0xd9];

/// Returns whether the end of the image follows its first scan. The segments before it are skipped,
/// because a thumbnail in one of them has an end of its own; within scans the two bytes do not occur.
pub fn is_complete(bytes: &[u8]) -> bool {
    scan(bytes).is_some_and(|scan| scan.windows(2).any(|pair| pair == END_OF_IMAGE))
}

/// The bytes from the first scan on.
fn scan(bytes: &[u8]) -> Option<&[u8]> {
    let mut rest = bytes.get(2..)?;
    loop {
        // Any number of 0xff can precede the code of a marker.
        let code = rest
            .iter()
            .position(|byte| *byte != 0xff)
            .filter(|p| *p > 0)?;
        let segment = &rest[code + 1..];
        if rest[code] == START_OF_SCAN {
            return Some(segment);
        }
        let length = u16::from_be_bytes(*segment.first_chunk()?);
        rest = segment.get(usize::from(length.max(2))..)?;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_end_inside_a_segment_is_no_end() {
        let head = [0xff, 0xd8, 0xff, 0xe1, 0, 6, 0xff, 0xd9, 1, 2];
        let scan = [0xff, 0xff, 0xda, 0, 2, 7, 0xff, 0, 8];
        let cut = [&head[..], &scan].concat();
        assert!(!is_complete(&cut));
        assert!(is_complete(&[&cut[..], &END_OF_IMAGE].concat()));
        for length in 0..cut.len() {
            assert!(!is_complete(&cut[..length]), "{length}");
        }
    }
}
