//! One group of planes as a KTX2 file of its own.

use std::ops::Range;

use ktx2::{Format, Header, Index, LevelIndex, dfd};

use crate::codec::{
    haar::Transform,
    image::{PlaneGroup, WaveletImage},
    layout,
    quantizer::PlaneCoding,
};

/// Key of the planes' codings: for each plane six `f32`, little-endian: mean_min, mean_max, range,
/// gamma, the transform (0 Haar, 1 partially inverted Haar) and its w (0 for Haar).
const CODINGS_KEY: &str = "wtex.codings";
const CODING_BYTES: usize = 24;

/// Everything of a blob but its codings and blocks, which follows from the sizes alone.
///
/// Reading compares with it instead of interpreting offsets: what is not exactly as written is
/// damaged. (The `ktx2` crate's own reader panics on some damaged descriptors.)
struct Frame {
    /// All bytes before the blocks, the codings 0.
    head: Vec<u8>,
    /// Where in `head` the codings are.
    codings: Range<usize>,
    /// Bytes of each level, largest first.
    level_bytes: Vec<usize>,
}

impl Frame {
    fn new(texture: [u32; 2], planes: usize, levels: u32) -> Self {
        let (basic, type_size) =
            dfd::Basic::from_format_with(Format::BC3_UNORM_BLOCK, false, None, None, None)
                .expect("BC3 has a standard descriptor");
        let block = dfd::Block::Basic(basic).to_vec();
        let mut descriptor = (block.len() as u32 + 4).to_le_bytes().to_vec();
        descriptor.extend(block);

        let mut keys = Vec::new();
        push_key(&mut keys, "KTXwriter", b"bevy_wavelet_tex\0");
        let value_start = push_key(&mut keys, CODINGS_KEY, &vec![0; planes * CODING_BYTES]);

        let level_bytes: Vec<usize> = (0..levels)
            .map(|level| planes * layout::level_bytes(layout::mip_size(texture, level)))
            .collect();
        let dfd_offset = Header::LENGTH + LevelIndex::LENGTH * level_bytes.len();
        let keys_offset = dfd_offset + descriptor.len();
        let data_offset = (keys_offset + keys.len()).next_multiple_of(16);

        let header = Header {
            format: Some(Format::BC3_UNORM_BLOCK),
            type_size,
            pixel_width: texture[0],
            pixel_height: texture[1],
            pixel_depth: 0,
            layer_count: planes as u32,
            face_count: 1,
            level_count: levels,
            supercompression_scheme: None,
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
        // KTX2 stores the smallest level first, but lists the largest first.
        for (level, &length) in level_bytes.iter().enumerate() {
            let smaller: usize = level_bytes[level + 1..].iter().sum();
            let index = LevelIndex {
                byte_offset: (data_offset + smaller) as u64,
                byte_length: length as u64,
                uncompressed_byte_length: length as u64,
            };
            head.extend(index.as_bytes());
        }
        head.extend(descriptor);
        head.extend(keys);
        head.resize(data_offset, 0);
        let codings_start = keys_offset + value_start;
        let codings = codings_start..codings_start + planes * CODING_BYTES;
        Self {
            head,
            codings,
            level_bytes,
        }
    }
}

pub(super) fn write(image: &WaveletImage, group: usize) -> Vec<u8> {
    let PlaneGroup { codings, blocks } = &image.groups[group];
    let Frame {
        head: mut bytes,
        codings: codings_range,
        level_bytes,
    } = Frame::new(image.texture_size(group), codings.len(), image.levels);
    let codings: Vec<u8> = codings.iter().flat_map(coding_bytes).collect();
    bytes[codings_range].copy_from_slice(&codings);
    let mut end = blocks.len();
    for length in level_bytes.into_iter().rev() {
        bytes.extend(&blocks[end - length..end]);
        end -= length;
    }
    bytes
}

/// The number of levels (at most `max_levels`) and the planes; or what is wrong.
pub(super) fn read(
    blob: &[u8],
    texture_size: [u32; 2],
    planes: usize,
    max_levels: u32,
) -> Result<(u32, PlaneGroup), String> {
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
    let Frame {
        head,
        codings: codings_range,
        level_bytes,
    } = Frame::new(texture_size, planes, levels);
    let data: usize = level_bytes.iter().sum();
    if blob.len() != head.len() + data {
        return Err(format!(
            "it is {} bytes long instead of {}",
            blob.len(),
            head.len() + data
        ));
    }
    let same = |range: Range<usize>| blob[range.clone()] == head[range];
    if !same(0..codings_range.start) || !same(codings_range.end..head.len()) {
        return Err(format!(
            "it should be {planes} layers of {} x {} texels in BC3, as `wavelet-tex` writes them",
            texture_size[0], texture_size[1]
        ));
    }
    let codings = blob[codings_range]
        .chunks_exact(CODING_BYTES)
        .map(|bytes| {
            read_coding(bytes).ok_or_else(|| format!("its key {CODINGS_KEY} is out of range"))
        })
        .collect::<Result<Vec<_>, _>>()?;
    let mut blocks = Vec::with_capacity(data);
    let mut end = blob.len();
    for length in level_bytes {
        blocks.extend(&blob[end - length..end]);
        end -= length;
    }
    Ok((levels, PlaneGroup { codings, blocks }))
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

fn coding_bytes(coding: &PlaneCoding) -> [u8; CODING_BYTES] {
    let (kind, w) = match coding.transform {
        Transform::Haar => (0.0, 0.0),
        Transform::PartiallyInvertedHaar { w } => (1.0, w),
    };
    let fields = [
        coding.mean_min,
        coding.mean_max,
        coding.range,
        coding.gamma,
        kind,
        w,
    ];
    let mut bytes = [0; CODING_BYTES];
    bytes
        .as_chunks_mut::<4>()
        .0
        .iter_mut()
        .zip(fields)
        .for_each(|(b, f)| *b = f.to_le_bytes());
    bytes
}

fn read_coding(bytes: &[u8]) -> Option<PlaneCoding> {
    let (fields, []) = bytes.as_chunks::<4>() else {
        return None;
    };
    let fields: Vec<f32> = fields.iter().map(|b| f32::from_le_bytes(*b)).collect();
    let &[mean_min, mean_max, range, gamma, kind, w] = fields.as_slice() else {
        return None;
    };
    let transform = match kind {
        0.0 => Transform::Haar,
        1.0 => Transform::PartiallyInvertedHaar { w },
        _ => return None,
    };
    let coding = PlaneCoding {
        mean_min,
        mean_max,
        range,
        gamma,
        transform,
    };
    coding.is_valid().then_some(coding)
}
