//! Reading and writing of one texture, of a group of planes or a plain one, as a KTX2 file.

use std::ops::Range;

use ktx2::{Format, Header, Index, LevelIndex, SupercompressionScheme, dfd};

use super::zstd;
use crate::codec::{
    blocks::BlockFormat, haar::Transform, image::PlaneGroup, layout, packing::Packing,
    quantizer::PlaneCoding,
};

/// The shape of a blob, which follows from the rest of the file.
#[derive(Clone, Copy)]
pub(super) struct Shape {
    format: BlockFormat,
    /// Size of the largest level, in texels.
    size: [u32; 2],
    /// The image, the subsampling and the packing of a group of planes, whose levels can need more than halves.
    group: Option<([u32; 2], u32, Packing)>,
    layers: usize,
    /// Number of planes and thus of codings; one layer can hold two planes.
    planes: usize,
    /// Whether the texture unit linearises the texels.
    is_srgb: bool,
    /// Whether each level is a Zstandard frame.
    is_zstd: bool,
}

impl Shape {
    /// That of a texture of a group, which may have no codings yet, with this number of planes.
    pub(super) fn of_group(
        group: &PlaneGroup,
        texture: usize,
        image_size: [u32; 2],
        planes: usize,
    ) -> Self {
        Self {
            format: group.packing.formats()[texture],
            size: group.texture_size(image_size),
            group: Some((image_size, group.subsampling, group.packing)),
            layers: group.packing.layers(planes),
            planes,
            is_srgb: false,
            is_zstd: false,
        }
    }

    pub(super) fn with_zstd(self, is_zstd: bool) -> Self {
        Self { is_zstd, ..self }
    }

    /// Bytes of each level in main memory, from the largest.
    fn level_bytes(self, levels: u32) -> Vec<usize> {
        let size = |level| match self.group {
            Some((image_size, subsampling, packing)) => {
                layout::texture_level_size(packing, image_size, subsampling, level)
            }
            None => layout::mip_size(self.size, level),
        };
        let bytes = |level| self.format.level_bytes(size(level));
        (0..levels)
            .map(|level| self.layers * bytes(level))
            .collect()
    }

    pub(super) fn plain(format: BlockFormat, size: [u32; 2], is_srgb: bool) -> Self {
        Self {
            format,
            size,
            group: None,
            layers: 1,
            planes: 0,
            is_srgb,
            is_zstd: false,
        }
    }

    fn ktx2_format(self) -> Format {
        match self.format {
            BlockFormat::Bc1 if self.is_srgb => Format::BC1_RGB_SRGB_BLOCK,
            BlockFormat::Bc7 if self.is_srgb => Format::BC7_SRGB_BLOCK,
            BlockFormat::Bc1 => Format::BC1_RGB_UNORM_BLOCK,
            BlockFormat::Bc3 => Format::BC3_UNORM_BLOCK,
            BlockFormat::Bc4 => Format::BC4_UNORM_BLOCK,
            BlockFormat::Bc5 => Format::BC5_UNORM_BLOCK,
            BlockFormat::Bc7 => Format::BC7_UNORM_BLOCK,
        }
    }
}

/// Makes a Zstandard frame.
pub(super) type Compress<'a> = dyn Fn(&[u8]) -> Vec<u8> + 'a;

/// The contents of a blob.
pub(super) struct Contents {
    pub(super) levels: u32,
    pub(super) codings: Vec<PlaneCoding>,
    pub(super) blocks: Vec<u8>,
}

/// All bytes of a blob before the blocks, with the codings set to 0, and the range of these. They follow from the
/// sizes alone, with Zstandard from those of the compressed levels, too: `stored_bytes` are those of each level in the
/// file, from the largest.
///
/// Reading compares a blob with it instead of interpreting offsets: a blob that differs is damaged.
/// (The `ktx2` crate's own reader panics on some damaged descriptors.)
fn head_of(shape: Shape, stored_bytes: &[usize]) -> (Vec<u8>, Range<usize>) {
    let levels = stored_bytes.len() as u32;
    let planes = shape.planes;
    let format = shape.ktx2_format();
    let (basic, type_size) = dfd::Basic::from_format_with(format, false, None, None, None)
        .expect("BC formats have a standard descriptor");
    let block = dfd::Block::Basic(basic).to_vec();
    let mut descriptor = (block.len() as u32 + 4).to_le_bytes().to_vec();
    descriptor.extend(block);

    let mut keys = Vec::new();
    push_key(&mut keys, "KTXwriter", b"bevy_wavelet_tex\0");
    let value_start = match planes {
        0 => keys.len(),
        _ => push_key(&mut keys, CODINGS_KEY, &vec![0; planes * CODING_BYTES]),
    };

    let dfd_offset = Header::LENGTH + LevelIndex::LENGTH * stored_bytes.len();
    let keys_offset = dfd_offset + descriptor.len();
    let alignment = if shape.is_zstd { 1 } else { 16 };
    let data_offset = (keys_offset + keys.len()).next_multiple_of(alignment);

    let header = Header {
        format: Some(format),
        type_size,
        pixel_width: shape.size[0],
        pixel_height: shape.size[1],
        pixel_depth: 0,
        layer_count: shape.layers as u32,
        face_count: 1,
        level_count: levels,
        supercompression_scheme: shape.is_zstd.then_some(SupercompressionScheme::Zstandard),
        index: Index {
            dfd_byte_offset: dfd_offset as u32,
            dfd_byte_length: descriptor.len() as u32,
            kvd_byte_offset: keys_offset as u32,
            kvd_byte_length: keys.len() as u32,
            sgd_byte_offset: 0,
            sgd_byte_length: 0,
        },
    };
    let mut head = header.as_bytes().to_vec();
    // KTX2 stores the smallest level first, but its index begins with the largest.
    let lengths = stored_bytes.iter().zip(shape.level_bytes(levels));
    for (level, (&stored, length)) in lengths.enumerate() {
        let smaller: usize = stored_bytes[level + 1..].iter().sum();
        let index = LevelIndex {
            byte_offset: (data_offset + smaller) as u64,
            byte_length: stored as u64,
            uncompressed_byte_length: length as u64,
        };
        head.extend(index.as_bytes());
    }
    head.extend(descriptor);
    head.extend(keys);
    head.resize(data_offset, 0);
    let codings_start = keys_offset + value_start;
    (head, codings_start..codings_start + planes * CODING_BYTES)
}

/// Writes a blob. `compress` makes a Zstandard frame of a level.
pub(super) fn write(
    shape: Shape,
    levels: u32,
    codings: &[PlaneCoding],
    blocks: &[u8],
    compress: Option<&Compress>,
) -> Vec<u8> {
    let shape = shape.with_zstd(compress.is_some());
    let mut start = 0;
    let stored = shape.level_bytes(levels).into_iter().map(|length| {
        let level = &blocks[start..start + length];
        start += length;
        compress.map_or_else(|| level.to_vec(), |compress| compress(level))
    });
    let stored: Vec<Vec<u8>> = stored.collect();
    let stored_bytes: Vec<usize> = stored.iter().map(Vec::len).collect();
    let (mut bytes, codings_range) = head_of(shape, &stored_bytes);
    let codings: Vec<[u8; 4]> = codings.iter().flat_map(coding_bytes).collect();
    bytes[codings_range].copy_from_slice(codings.as_flattened());
    bytes.extend(stored.iter().rev().flatten());
    bytes
}

/// Reads a blob of at most `max_levels` levels, or returns what is wrong with it. `first` is the level from which on
/// the blocks are read, by the number of levels.
pub(super) fn read(
    blob: &[u8],
    shape: Shape,
    max_levels: u32,
    first: impl Fn(u32) -> u32,
) -> Result<Contents, String> {
    let header = blob
        .first_chunk()
        .ok_or("it is shorter than a KTX2 header")?;
    let levels = Header::from_bytes(header)
        .map_err(|error| error.to_string())?
        .level_count;
    if !(1..=max_levels).contains(&levels) {
        return Err(format!(
            "it has {levels} mip levels, its size allows 1 to {max_levels}"
        ));
    }
    let level_bytes = shape.level_bytes(levels);
    let stored_bytes = if shape.is_zstd {
        stored_bytes(blob, levels).ok_or("its index of mip levels is damaged")?
    } else {
        level_bytes.clone()
    };
    let (head, codings_range) = head_of(shape, &stored_bytes);
    let length = head.len() + stored_bytes.iter().sum::<usize>();
    if blob.len() != length {
        return Err(format!(
            "it is {} bytes long instead of {length}",
            blob.len()
        ));
    }
    let same = |range: Range<usize>| blob[range.clone()] == head[range];
    if !same(0..codings_range.start) || !same(codings_range.end..head.len()) {
        return Err(format!(
            "it should be {} layers of {} x {} texels in {:?}, as `wavelet-tex` writes them",
            shape.layers, shape.size[0], shape.size[1], shape.format
        ));
    }
    let codings = blob[codings_range]
        .chunks_exact(CODING_BYTES)
        .map(|bytes| read_coding(bytes.as_chunks().0).ok_or(INVALID_CODINGS))
        .collect::<Result<Vec<_>, _>>()?;
    let mut blocks = Vec::new();
    let mut end = blob.len();
    let first = first(levels);
    for (number, (length, stored)) in (0..).zip(level_bytes.into_iter().zip(stored_bytes)) {
        let level = &blob[end - stored..end];
        end -= stored;
        if number < first {
            continue;
        }
        if shape.is_zstd {
            blocks.extend(zstd::decompress(level, length)?);
        } else {
            blocks.extend(level);
        }
    }
    Ok(Contents {
        levels,
        codings,
        blocks,
    })
}

/// The bytes of each level in the index of a blob, none of which is more than the blob has.
fn stored_bytes(blob: &[u8], levels: u32) -> Option<Vec<usize>> {
    let end = Header::LENGTH + LevelIndex::LENGTH * levels as usize;
    let (index, _) = blob.get(Header::LENGTH..end)?.as_chunks();
    let length = |entry| LevelIndex::from_bytes(entry).byte_length;
    let lengths = index.iter().map(length);
    lengths
        .map(|length| usize::try_from(length).ok().filter(|l| *l <= blob.len()))
        .collect()
}

/// Appends a key and returns where its value begins.
fn push_key(keys: &mut Vec<u8>, key: &str, value: &[u8]) -> usize {
    keys.extend((key.len() as u32 + 1 + value.len() as u32).to_le_bytes());
    keys.extend(key.as_bytes());
    keys.push(0);
    let value_start = keys.len();
    keys.extend(value);
    keys.resize(keys.len().next_multiple_of(4), 0);
    value_start
}

/// The reason why codings are refused.
pub(super) const INVALID_CODINGS: &str = "its key wtex.codings is out of range";

/// Key of the planes' codings, which plain textures lack. For each plane the value has ten `f32`, little-endian: low_min,
/// low_max, range, gamma, the zero points of R, G and B, the predictor, the transform (0 Haar, 1
/// partially inverted Haar) and its w (0 for Haar).
const CODINGS_KEY: &str = "wtex.codings";
const CODING_FLOATS: usize = 10;
const CODING_BYTES: usize = 4 * CODING_FLOATS;

fn coding_bytes(coding: &PlaneCoding) -> [[u8; 4]; CODING_FLOATS] {
    let (kind, w) = match coding.transform {
        Transform::Haar => (0.0, 0.0),
        Transform::PartiallyInvertedHaar { w } => (1.0, w),
    };
    let [r, g, b] = coding.zero_point;
    let fields: [f32; CODING_FLOATS] = [
        coding.low_min,
        coding.low_max,
        coding.range,
        coding.gamma,
        r,
        g,
        b,
        coding.predictor,
        kind,
        w,
    ];
    fields.map(f32::to_le_bytes)
}

fn read_coding(fields: &[[u8; 4]]) -> Option<PlaneCoding> {
    let fields = fields.first_chunk::<CODING_FLOATS>()?;
    let [low_min, low_max, range, gamma, r, g, b, predictor, kind, w] =
        fields.map(f32::from_le_bytes);
    let transform = match kind {
        0.0 => Transform::Haar,
        1.0 => Transform::PartiallyInvertedHaar { w },
        _ => return None,
    };
    Some(PlaneCoding {
        low_min,
        low_max,
        range,
        gamma,
        zero_point: [r, g, b],
        predictor,
        transform,
    })
}
