//! Path-traced pictures, and how close another comes to them.

use std::{
    error::Error,
    fmt, fs,
    path::{Path, PathBuf},
};

use bevy::math::{DVec3, Vec3};

/// A file that is not what it should be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TruthError {
    /// Which.
    pub path: PathBuf,
    /// Why.
    pub error: String,
}

impl fmt::Display for TruthError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.path.display(), self.error)
    }
}

impl Error for TruthError {}

/// Reads an H x W x 3 array of little-endian 32-bit floats in NumPy's format, version 1.
///
/// # Errors
/// What is wrong with the file.
pub fn read_npy(path: &Path) -> Result<Vec<Vec3>, TruthError> {
    let wrong = |error: &str| TruthError {
        path: path.to_owned(),
        error: error.to_owned(),
    };
    let bytes = fs::read(path).map_err(|error| wrong(&error.to_string()))?;
    parse_npy(&bytes).map_err(wrong)
}

fn parse_npy(bytes: &[u8]) -> Result<Vec<Vec3>, &'static str> {
    let (header, data) = bytes
        .strip_prefix(b"\x93NUMPY\x01\x00")
        .and_then(|rest| rest.split_first_chunk::<2>())
        .and_then(|(length, rest)| rest.split_at_checked(u16::from_le_bytes(*length).into()))
        .ok_or("not a NumPy file of version 1")?;
    let header = String::from_utf8_lossy(header);
    if !header.contains("'<f4'") || !header.contains("'fortran_order': False") {
        return Err("not little-endian 32-bit floats in C order");
    }
    let floats: Vec<f32> = data
        .chunks_exact(4)
        .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect();
    Ok(floats.chunks_exact(3).map(Vec3::from_slice).collect())
}

/// Edge in pixels of the blocks whose means are compared: single pixels of a path-traced picture are noisy.
const BLOCK: usize = 4;

/// Indices of the pixels of each whole block, row after row.
fn blocks(width: u32, pixels: usize) -> impl Iterator<Item = [usize; BLOCK * BLOCK]> {
    let width = width as usize;
    let (columns, rows) = (width / BLOCK, pixels / width.max(1) / BLOCK);
    (0..rows * columns).map(move |block| {
        let corner = block / columns * BLOCK * width + block % columns * BLOCK;
        std::array::from_fn(|i| corner + i / BLOCK * width + i % BLOCK)
    })
}

fn mean(picture: &[Vec3], block: &[usize]) -> Vec3 {
    let sum: DVec3 = block.iter().map(|&i| picture[i].as_dvec3()).sum();
    (sum / block.len() as f64).as_vec3()
}

/// Means of 4 x 4 pixels; zero where one of the 16 sees no surface, and so is zero.
pub fn block_means(picture: &[Vec3], width: u32) -> Vec<Vec3> {
    blocks(width, picture.len())
        .map(|block| {
            if block.iter().any(|&i| picture[i] == Vec3::ZERO) {
                Vec3::ZERO
            } else {
                mean(picture, &block)
            }
        })
        .collect()
}

/// How close a picture comes to the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Agreement {
    /// Mean absolute difference over mean truth.
    pub relative_error: f64,
    /// Mean difference over mean truth.
    pub bias: f64,
}

/// Compares the picture with the block means of the truth, where those are not zero.
///
/// # Panics
/// If the picture has another number of blocks than the truth.
pub fn agreement(picture: &[Vec3], width: u32, truth: &[Vec3]) -> Agreement {
    let blocks: Vec<_> = blocks(width, picture.len()).collect();
    assert_eq!(blocks.len(), truth.len(), "pictures of two sizes");
    let (mut difference, mut absolute, mut reference) = (0.0, 0.0, 0.0);
    for (block, truth) in blocks.iter().zip(truth) {
        if *truth == Vec3::ZERO {
            continue;
        }
        let change = (mean(picture, block) - truth).as_dvec3();
        difference += change.element_sum();
        absolute += change.abs().element_sum();
        reference += truth.as_dvec3().element_sum();
    }
    Agreement {
        relative_error: absolute / reference,
        bias: difference / reference,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn arrays_come_back_and_damaged_ones_never_panic(
            floats in prop::collection::vec(any::<f32>(), 0..30),
            damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..4),
            cut in any::<prop::sample::Index>(),
        ) {
            let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 1, 3), }\n";
            let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
            bytes.extend((header.len() as u16).to_le_bytes());
            bytes.extend(header.bytes());
            bytes.extend(floats.iter().flat_map(|f| f.to_le_bytes()));
            let back = parse_npy(&bytes).expect("a good file");
            let back: Vec<u32> = back.iter().flat_map(|v| v.to_array()).map(f32::to_bits).collect();
            let wanted: Vec<u32> = floats.iter().map(|f| f.to_bits()).collect();
            prop_assert_eq!(&back, &wanted[..floats.len() / 3 * 3]);
            for (at, value) in damage {
                let at = at.index(bytes.len());
                bytes[at] = value;
            }
            let _ = parse_npy(&bytes[..cut.index(bytes.len() + 1)]);
        }
    }

    #[test]
    fn a_tenth_too_bright() {
        let truth: Vec<Vec3> = (0..64).map(|i| Vec3::splat(1.0 + i as f32)).collect();
        let picture: Vec<Vec3> = truth.iter().map(|t| t * 1.1).collect();
        let found = agreement(&picture, 8, &block_means(&truth, 8));
        assert!((found.relative_error - 0.1).abs() < 1e-6);
        assert!((found.bias - 0.1).abs() < 1e-6);
    }

    #[test]
    fn blocks_that_see_nothing_do_not_count() {
        let mut truth = vec![Vec3::ONE; 32];
        let mut picture = truth.clone();
        truth[0] = Vec3::ZERO;
        picture[1] = Vec3::splat(100.0);
        let truth = block_means(&truth, 8);
        assert_eq!(agreement(&picture, 8, &truth), Agreement::default());
    }
}
