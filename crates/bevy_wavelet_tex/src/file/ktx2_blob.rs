//! One group of planes as a KTX2 file of its own.

use ktx2::{Format, Header, Index, LevelIndex, Reader, dfd};

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

pub(super) fn write(image: &WaveletImage, group: usize) -> Vec<u8> {
    let texture = image.texture_size(group);
    let PlaneGroup { codings, blocks } = &image.groups[group];

    let (basic, type_size) =
        dfd::Basic::from_format_with(Format::BC3_UNORM_BLOCK, false, None, None, None)
            .expect("BC3 has a standard descriptor");
    let block = dfd::Block::Basic(basic).to_vec();
    let mut descriptor = (block.len() as u32 + 4).to_le_bytes().to_vec();
    descriptor.extend(block);

    let mut keys = Vec::new();
    push_key(&mut keys, "KTXwriter", b"bevy_wavelet_tex\0");
    push_key(
        &mut keys,
        CODINGS_KEY,
        &codings.iter().flat_map(coding_bytes).collect::<Vec<_>>(),
    );

    let level_bytes: Vec<usize> = (0..image.levels)
        .map(|level| codings.len() * layout::level_bytes(layout::mip_size(texture, level)))
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
        layer_count: codings.len() as u32,
        face_count: 1,
        level_count: image.levels,
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
    let mut bytes = header.as_bytes().to_vec();
    // KTX2 stores the smallest level first, but lists the largest first.
    for (level, &length) in level_bytes.iter().enumerate() {
        let smaller: usize = level_bytes[level + 1..].iter().sum();
        let index = LevelIndex {
            byte_offset: (data_offset + smaller) as u64,
            byte_length: length as u64,
            uncompressed_byte_length: length as u64,
        };
        bytes.extend(index.as_bytes());
    }
    bytes.extend(descriptor);
    bytes.extend(keys);
    bytes.resize(data_offset, 0);
    let mut end = blocks.len();
    for length in level_bytes.into_iter().rev() {
        bytes.extend(&blocks[end - length..end]);
        end -= length;
    }
    bytes
}

/// The number of levels and the planes; or what is wrong.
pub(super) fn read(
    blob: &[u8],
    texture_size: [u32; 2],
    planes: usize,
) -> Result<(u32, PlaneGroup), String> {
    let reader = Reader::new(blob).map_err(|error| error.to_string())?;
    let header = reader.header();
    let expected = (Some(Format::BC3_UNORM_BLOCK), texture_size, planes as u32);
    let found = (
        header.format,
        [header.pixel_width, header.pixel_height],
        header.layer_count,
    );
    if found != expected
        || header.face_count != 1
        || header.pixel_depth != 0
        || header.supercompression_scheme.is_some()
    {
        return Err(format!(
            "it should be {planes} layers of {} x {} texels in BC3, uncompressed",
            texture_size[0], texture_size[1]
        ));
    }
    let value = reader
        .key_value_data()
        .find_map(|(key, value)| (key == CODINGS_KEY).then_some(value))
        .ok_or_else(|| format!("it lacks the key {CODINGS_KEY}"))?;
    if value.len() != planes * CODING_BYTES {
        return Err(format!(
            "the key {CODINGS_KEY} does not describe {planes} planes"
        ));
    }
    let codings = value
        .chunks_exact(CODING_BYTES)
        .map(|bytes| {
            read_coding(bytes).ok_or_else(|| format!("the key {CODINGS_KEY} is out of range"))
        })
        .collect::<Result<Vec<_>, _>>()?;

    let mut total = 0;
    for (level, data) in reader.levels().enumerate() {
        let size = layout::mip_size(texture_size, level as u32);
        total += planes * layout::level_bytes(size);
        // Levels that overlap would make more than the file holds.
        if data.data.len() != planes * layout::level_bytes(size) || total > blob.len() {
            return Err(format!(
                "its mip level {level} is not as long as its size says"
            ));
        }
    }
    let blocks = reader
        .levels()
        .flat_map(|level| level.data)
        .copied()
        .collect();
    Ok((reader.levels().len() as u32, PlaneGroup { codings, blocks }))
}

fn push_key(keys: &mut Vec<u8>, key: &str, value: &[u8]) {
    keys.extend((key.len() as u32 + 1 + value.len() as u32).to_le_bytes());
    keys.extend(key.as_bytes());
    keys.push(0);
    keys.extend(value);
    keys.resize(keys.len().next_multiple_of(4), 0);
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
