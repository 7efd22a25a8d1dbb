//! Reading a `.wtex` file. No input causes a panic, and no more is allocated than the file
//! contains, or than is decompressed from it, up to the sizes that its header states.

use std::{cmp::Ordering, ops::Range};

use thiserror::Error;

use super::{
    AXES_BYTES, FINGERPRINT_FLAG, FIXED_HEADER_BYTES, FLAGS_AT, GROUP_BYTES, MAGIC, PLAIN_BYTES,
    PLAIN_VERSION, PLANES_VERSION, VERSION, ZSTD_FLAG,
    ktx2_blob::{self, INVALID_CODINGS, Shape},
    write::without_fingerprint,
};
use crate::codec::{
    axes::ColorAxes,
    blocks::BlockFormat,
    image::{ColorSpace, Content, Payload, PlaneGroup, WaveletImage, WaveletPlanes},
    layout::{self, MAX_SIZE, mip_size},
    packing::Packing,
    plain::PlainTexture,
    quantizer::PlaneCoding,
};

/// The reason why bytes are not a wavelet texture. A caller that knows the name of the file puts it
/// in front of the message.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file begins with the bytes of another format.
    #[error(
        "not a wavelet texture: it does not begin with the bytes of a .wtex file (was it made by \
         `wavelet-tex encode`?)"
    )]
    Magic,
    /// The file was written by a later release.
    #[error(
        "file version {0} is newer than {VERSION}, the newest this release reads: update \
         bevy_wavelet_tex or encode the texture again"
    )]
    Version(u16),
    /// The file was written before the first release.
    #[error("file version {0} was never released: encode the texture again")]
    OldVersion(u16),
    /// The file is compressed, and this build cannot decompress it.
    #[error(
        "it is compressed with Zstandard: enable the feature `zstd` of bevy_wavelet_tex, or encode the \
         texture without"
    )]
    ZstdDisabled,
    /// The file ends too early.
    #[error("the file is cut short: {needed} bytes are needed for its {part}, it has {available}")]
    Truncated {
        /// The part of the file that is incomplete.
        part: &'static str,
        /// Length in bytes that the file needs at least to contain the part.
        needed: u64,
        /// Length of the file in bytes.
        available: usize,
    },
    /// The file is longer than its header says.
    #[error("{0} bytes follow the end of the texture: the file is damaged")]
    TrailingBytes(usize),
    /// A side of the image is out of range.
    #[error("an image of {} x {} pixels: both sides must be 1 to {MAX_SIZE}", .0[0], .0[1])]
    Size([u32; 2]),
    /// A field of the header has an invalid value.
    #[error("the header's {field} is {value}, which is invalid: the file is damaged")]
    Field {
        /// Name of the field.
        field: &'static str,
        /// Value of the field.
        value: u32,
    },
    /// The axes of colour are not those of an image.
    #[error(
        "the header's axes of colour are out of range, or the image has no colour: the file is damaged"
    )]
    Axes,
    /// The KTX2 blob of a plain texture is damaged or does not match the header.
    #[error("the KTX2 data of the plain texture is damaged: {0}")]
    PlainBlob(String),
    /// A KTX2 blob is damaged or does not match the header.
    #[error("the KTX2 data of plane group {group} is damaged: {reason}")]
    Blob {
        /// Index of the plane group, from 0.
        group: usize,
        /// Description of the damage.
        reason: String,
    },
}

/// Returns whether a file begins as a wavelet texture does.
pub fn is_texture(bytes: &[u8]) -> bool {
    bytes.starts_with(&MAGIC)
}

/// Reads a file.
///
/// # Errors
/// Returns a [`ReadError`], which names what is wrong and, where there is one, the remedy.
pub fn read(bytes: &[u8]) -> Result<WaveletImage, ReadError> {
    read_at_most(bytes, None)
}

/// Reads a file without the mip levels that have more than `max_size` pixels along a side, which are not decompressed
/// either. The last level is always read. The levels of some plain textures can only begin with a larger one, whose
/// sides the result then has.
///
/// # Errors
/// Returns a [`ReadError`], which names what is wrong and, where there is one, the remedy.
pub fn read_at_most(bytes: &[u8], max_size: Option<u32>) -> Result<WaveletImage, ReadError> {
    let magic = bytes.get(..MAGIC.len()).unwrap_or(bytes);
    if magic.is_empty() || !MAGIC.starts_with(magic) {
        return Err(ReadError::Magic);
    }
    let bytes = without_fingerprint(bytes);
    let header = part(bytes, 0..FIXED_HEADER_BYTES)?;

    let flags = header[FLAGS_AT];
    let is_zstd = flags & ZSTD_FLAG != 0;
    // Unknown flags are a part of the version.
    let version = u16::from_le_bytes([header[8], flags & !(ZSTD_FLAG | FINGERPRINT_FLAG)]);
    match version {
        PLANES_VERSION..=VERSION => {}
        older @ 1..PLANES_VERSION => return Err(ReadError::OldVersion(older)),
        0 => return Err(invalid("version", 0u8)),
        newer => return Err(ReadError::Version(newer)),
    }
    if is_zstd && cfg!(not(feature = "zstd")) {
        return Err(ReadError::ZstdDisabled);
    }
    let content = match header[10] {
        0 => Content::Gray,
        1 => Content::Color,
        2 => Content::Normal,
        3 => Content::ColorAlpha,
        value => return Err(invalid("content", value)),
    };
    let color_space = match header[11] {
        0 => ColorSpace::Linear,
        1 => ColorSpace::Srgb,
        value => return Err(invalid("colour space", value)),
    };
    let size = [u32_at(header, 12), u32_at(header, 16)];
    if size.iter().any(|s| !(1..=MAX_SIZE).contains(s)) {
        return Err(ReadError::Size(size));
    }
    let group_count = u32_at(header, 20);
    if version == PLAIN_VERSION && group_count == 0 {
        return read_plain(bytes, content, color_space, size, is_zstd, max_size);
    }
    if group_count != 1 + u32::from(content.has_chroma()) {
        return Err(invalid("number of plane groups", group_count));
    }
    let mut axes = ColorAxes::YCOCG;
    let mut groups_start = FIXED_HEADER_BYTES;
    if version == VERSION {
        groups_start += AXES_BYTES;
        let entry = part(bytes, FIXED_HEADER_BYTES..groups_start)?;
        let has_axes = |_: &ColorAxes| content.has_chroma();
        axes = read_axes(entry).filter(has_axes).ok_or(ReadError::Axes)?;
    }
    let blobs_start = groups_start + GROUP_BYTES * group_count as usize;
    let entries = part(bytes, groups_start..blobs_start)?;
    let entries = entries.chunks_exact(GROUP_BYTES).enumerate();
    let entries: Vec<(PlaneGroup, [u32; 2])> = entries
        .map(|(group, entry)| read_entry(entry, group))
        .collect::<Result<_, _>>()?;
    let lengths = entries.iter().flat_map(|(_, lengths)| lengths);
    let end = blobs_start as u64 + lengths.map(|length| u64::from(*length)).sum::<u64>();
    check_end(bytes, "planes", end)?;

    let most = layout::level_count(size);
    let first_of = |levels| first_level(size, levels, max_size);
    let mut start = blobs_start;
    let mut levels = None;
    let mut groups = Vec::with_capacity(entries.len());
    for (index, (mut group, lengths)) in entries.into_iter().enumerate() {
        let error = |reason| ReadError::Blob {
            group: index,
            reason,
        };
        let planes = match index {
            0 => content.luma_planes(),
            _ => 2,
        };
        for (texture, length) in (0..group.packing.formats().len()).zip(lengths) {
            let length = length as usize;
            let blob = &bytes[start..start + length];
            start += length;
            let shape = Shape::of_group(&group, texture, size, planes).with_zstd(is_zstd);
            let contents = ktx2_blob::read(blob, shape, most, first_of).map_err(error)?;
            let valid = |coding: &PlaneCoding| coding.is_valid(group.packing);
            if !contents.codings.iter().all(valid) {
                return Err(error(INVALID_CODINGS.into()));
            }
            if levels.is_some_and(|levels| levels != contents.levels) {
                return Err(error(format!(
                    "it has {} mip levels, not as many as the one before",
                    contents.levels
                )));
            }
            levels = Some(contents.levels);
            if !group.codings.is_empty() && group.codings != contents.codings {
                return Err(error("its textures have different codings".into()));
            }
            group.codings = contents.codings;
            group.textures.push(contents.blocks);
        }
        groups.push(group);
    }
    let levels = levels.unwrap_or(1);
    let first = first_of(levels);
    if first > 0 {
        let begin = |group| begin_group(group, size, first, levels);
        groups.iter_mut().for_each(begin);
    }
    let mut groups = groups.into_iter();
    Ok(WaveletImage {
        content,
        color_space,
        size: mip_size(size, first),
        levels: levels - first,
        payload: Payload::Wavelet(WaveletPlanes {
            axes,
            luma: groups.next().expect("there is at least one group"),
            chroma: groups.next(),
        }),
    })
}

/// Reads a file that holds a plain texture.
fn read_plain(
    bytes: &[u8],
    content: Content,
    color_space: ColorSpace,
    image_size: [u32; 2],
    is_zstd: bool,
    max_size: Option<u32>,
) -> Result<WaveletImage, ReadError> {
    let start = FIXED_HEADER_BYTES + PLAIN_BYTES;
    let entry = part(bytes, FIXED_HEADER_BYTES..start)?;
    let format = BlockFormat::ALL.get(entry[0] as usize).copied();
    let format = format.filter(|format| PlainTexture::formats(content).contains(format));
    let format = format.ok_or_else(|| invalid("format", entry[0]))?;
    check_reserved(&entry[1..4])?;
    let size = [u32_at(entry, 4), u32_at(entry, 8)];
    for (axis, field) in ["texture width", "texture height"].into_iter().enumerate() {
        if !PlainTexture::is_valid_size([size[axis]; 2], [image_size[axis]; 2]) {
            return Err(invalid(field, size[axis]));
        }
    }
    let end = start as u64 + u64::from(u32_at(entry, 12));
    check_end(bytes, "plain texture", end)?;
    let mut texture = PlainTexture {
        format,
        size,
        blocks: Vec::new(),
    };
    let is_srgb = texture.is_srgb(content, color_space, image_size);
    let shape = Shape::plain(format, size, is_srgb).with_zstd(is_zstd);
    let most = PlainTexture::max_level_count(size, image_size);
    let first_of = |levels| {
        let first = first_level(image_size, levels, max_size);
        first_of_plain(&texture, image_size, first)
    };
    let contents = ktx2_blob::read(&bytes[start..], shape, most, first_of);
    let contents = contents.map_err(ReadError::PlainBlob)?;
    let levels = contents.levels;
    let first = first_of(levels);
    texture.blocks = contents.blocks;
    if first > 0 {
        begin_plain(&mut texture, image_size, first, levels);
    }
    Ok(WaveletImage {
        content,
        color_space,
        size: mip_size(image_size, first),
        levels: levels - first,
        payload: Payload::Plain(texture),
    })
}

/// A part of the header.
fn part(bytes: &[u8], range: Range<usize>) -> Result<&[u8], ReadError> {
    let needed = range.end as u64;
    bytes.get(range).ok_or(ReadError::Truncated {
        part: "header",
        needed,
        available: bytes.len(),
    })
}

/// Checks that a file ends where its last part does.
fn check_end(bytes: &[u8], part: &'static str, end: u64) -> Result<(), ReadError> {
    let available = bytes.len();
    match (available as u64).cmp(&end) {
        Ordering::Less => Err(ReadError::Truncated {
            part,
            needed: end,
            available,
        }),
        Ordering::Equal => Ok(()),
        Ordering::Greater => Err(ReadError::TrailingBytes(available - end as usize)),
    }
}

fn check_reserved(bytes: &[u8]) -> Result<(), ReadError> {
    let other = bytes.iter().find(|byte| **byte != 0);
    other.map_or(Ok(()), |byte| Err(invalid("reserved byte", *byte)))
}

fn invalid(field: &'static str, value: impl Into<u32>) -> ReadError {
    let value = value.into();
    ReadError::Field { field, value }
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([0, 1, 2, 3].map(|i| bytes[at + i]))
}

/// The axes of colour, where a decoder can use them.
fn read_axes(entry: &[u8]) -> Option<ColorAxes> {
    let (entries, _) = entry.as_chunks::<4>();
    let mut axes = ColorAxes::YCOCG;
    for (value, bytes) in axes.rgb.as_flattened_mut().iter_mut().zip(entries) {
        *value = f32::from_le_bytes(*bytes);
    }
    axes.is_valid().then_some(axes)
}

/// Reads the entry of a plane group in the header: a group without codings and blocks, and the lengths of its blobs.
fn read_entry(bytes: &[u8], group: usize) -> Result<(PlaneGroup, [u32; 2]), ReadError> {
    let is_chroma = group > 0;
    let subsampling = bytes[0];
    if !(if is_chroma { 1..=2 } else { 0..=0 }).contains(&subsampling) {
        return Err(invalid("subsampling", subsampling));
    }
    let fits = |packing: &Packing| match packing {
        Packing::Bc3 | Packing::Bc7 => true,
        Packing::Split | Packing::Bc4 => !is_chroma,
        Packing::Bc1 => is_chroma,
    };
    let packing = Packing::ALL.get(bytes[1] as usize).copied().filter(fits);
    let packing = packing.ok_or_else(|| invalid("packing", bytes[1]))?;
    check_reserved(&bytes[2..4])?;
    let lengths = [u32_at(bytes, 4), u32_at(bytes, 8)];
    if packing.formats().len() == 1 && lengths[1] != 0 {
        return Err(invalid("length of a second texture", lengths[1]));
    }
    let group = PlaneGroup {
        subsampling: subsampling.into(),
        packing,
        codings: Vec::new(),
        textures: Vec::new(),
    };
    Ok((group, lengths))
}

/// The first level whose sides are at most `max_size` pixels, or the last level.
fn first_level(size: [u32; 2], levels: u32, max_size: Option<u32>) -> u32 {
    let Some(most) = max_size else { return 0 };
    let fits = |level: &u32| mip_size(size, *level).iter().all(|side| *side <= most);
    (0..levels).find(fits).unwrap_or(levels - 1)
}

/// The level of a plain texture from which on it can do without those before, at most `first`: a texture has whole
/// blocks, and one that is smaller than its image has to keep the ratio.
fn first_of_plain(texture: &PlainTexture, image_size: [u32; 2], first: u32) -> u32 {
    if !texture.is_scaled(image_size) {
        return first;
    }
    let is_whole = |level: &u32| texture.level_size(*level).iter().all(|side| side % 4 == 0);
    (0..=first).rfind(is_whole).unwrap_or(0)
}

/// Lays out the blocks of a group, which has the levels from `first` to `levels` of an image of this size, as those
/// of an image of its own.
///
/// A level of a texture has what a GPU makes of the largest one, or what its plane needs. So where another level
/// becomes the largest, those after it can have a row or a column of blocks more or less than before, which are padding.
fn begin_group(group: &mut PlaneGroup, size: [u32; 2], first: u32, levels: u32) {
    let smaller = mip_size(size, first);
    let shape = |level| Level {
        before: group.texture_level_size(size, level),
        after: group.texture_level_size(smaller, level - first),
    };
    let shapes: Vec<Level> = (first..levels).map(shape).collect();
    let layers = group.layers();
    let formats = group.packing.formats();
    for (blocks, format) in group.textures.iter_mut().zip(formats) {
        *blocks = begun(blocks, *format, layers, &shapes);
    }
}

/// The same of a plain texture.
fn begin_plain(texture: &mut PlainTexture, size: [u32; 2], first: u32, levels: u32) {
    let largest = if texture.is_scaled(size) {
        texture.level_size(first)
    } else {
        PlainTexture::full_size(mip_size(size, first))
    };
    let shape = |level| Level {
        before: texture.level_size(level),
        after: mip_size(largest, level - first),
    };
    let shapes: Vec<Level> = (first..levels).map(shape).collect();
    texture.blocks = begun(&texture.blocks, texture.format, 1, &shapes);
    texture.size = largest;
}

/// The size of a level in texels, before and after.
struct Level {
    before: [u32; 2],
    after: [u32; 2],
}

fn begun(blocks: &[u8], format: BlockFormat, layers: usize, levels: &[Level]) -> Vec<u8> {
    let bytes = format.block_bytes();
    let mut rest = blocks;
    let mut all = Vec::with_capacity(blocks.len());
    for level in levels {
        let [before, after] =
            [level.before, level.after].map(|size| size.map(|s| s.div_ceil(4) as usize));
        for _ in 0..layers {
            let (layer, next) = rest.split_at(format.level_bytes(level.before));
            rest = next;
            let start = all.len();
            all.resize(start + format.level_bytes(level.after), 0);
            let rows = layer.chunks_exact(before[0] * bytes);
            let row_bytes = before[0].min(after[0]) * bytes;
            for (from, to) in rows.zip(all[start..].chunks_exact_mut(after[0] * bytes)) {
                to[..row_bytes].copy_from_slice(&from[..row_bytes]);
            }
        }
    }
    all
}
