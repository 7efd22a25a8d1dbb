//! Reading a `.wtex` file. No input causes a panic, and no more is allocated than the file
//! contains, or than is decompressed from it, up to the sizes that its header states.

use thiserror::Error;

use super::{
    AXES_BYTES, FINGERPRINT_FLAG, FIXED_HEADER_BYTES, FLAGS_AT, GROUP_BYTES, MAGIC, PLAIN_VERSION,
    PLANES_VERSION, VERSION, ZSTD_FLAG,
    ktx2_blob::{self, INVALID_CODINGS},
    levels, plain,
    write::without_fingerprint,
};
use crate::codec::{
    axes::ColorAxes,
    image::{ColorSpace, Content, Payload, PlaneGroup, WaveletImage, WaveletPlanes},
    layout::{self, MAX_SIZE},
    packing::Packing,
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
    let truncated = |part, needed: u64| ReadError::Truncated {
        part,
        needed,
        available: bytes.len(),
    };
    let header = bytes
        .get(..FIXED_HEADER_BYTES)
        .ok_or_else(|| truncated("header", FIXED_HEADER_BYTES as u64))?;
    let u32_at = |at: usize| u32::from_le_bytes([0, 1, 2, 3].map(|i| bytes[at + i]));

    let flags = header[FLAGS_AT];
    let is_zstd = flags & ZSTD_FLAG != 0;
    // Unknown flags are a part of the version.
    let version = u16::from_le_bytes([header[8], flags & !(ZSTD_FLAG | FINGERPRINT_FLAG)]);
    match version {
        PLANES_VERSION..=VERSION => {}
        older @ 1..PLANES_VERSION => return Err(ReadError::OldVersion(older)),
        0 => {
            return Err(ReadError::Field {
                field: "version",
                value: 0,
            });
        }
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
        value => {
            return Err(ReadError::Field {
                field: "content",
                value: value.into(),
            });
        }
    };
    let color_space = match header[11] {
        0 => ColorSpace::Linear,
        1 => ColorSpace::Srgb,
        value => {
            return Err(ReadError::Field {
                field: "colour space",
                value: value.into(),
            });
        }
    };
    let size = [u32_at(12), u32_at(16)];
    if size.iter().any(|s| !(1..=MAX_SIZE).contains(s)) {
        return Err(ReadError::Size(size));
    }
    let group_count = u32_at(20);
    if version == PLAIN_VERSION && group_count == 0 {
        let plain = plain::read(bytes, content, color_space, size, is_zstd, max_size)?;
        return Ok(WaveletImage {
            content,
            color_space,
            size: layout::mip_size(size, plain.first),
            levels: plain.levels - plain.first,
            payload: Payload::Plain(plain.texture),
        });
    }
    if group_count != 1 + u32::from(content.has_chroma()) {
        return Err(ReadError::Field {
            field: "number of plane groups",
            value: group_count,
        });
    }
    let mut axes = ColorAxes::YCOCG;
    let mut groups_start = FIXED_HEADER_BYTES;
    if version == VERSION {
        groups_start += AXES_BYTES;
        let entry = bytes
            .get(FIXED_HEADER_BYTES..groups_start)
            .ok_or_else(|| truncated("header", groups_start as u64))?;
        let has_axes = |_: &ColorAxes| content.has_chroma();
        axes = read_axes(entry).filter(has_axes).ok_or(ReadError::Axes)?;
    }
    let blobs_start = groups_start + GROUP_BYTES * group_count as usize;
    if bytes.len() < blobs_start {
        return Err(truncated("header", blobs_start as u64));
    }
    let entries: Vec<Entry> = bytes[groups_start..blobs_start]
        .chunks_exact(GROUP_BYTES)
        .enumerate()
        .map(|(group, entry)| Entry::read(entry, group))
        .collect::<Result<_, _>>()?;
    let lengths = entries.iter().flat_map(|e| e.lengths);
    let end = blobs_start as u64 + lengths.map(u64::from).sum::<u64>();
    if end > bytes.len() as u64 {
        return Err(truncated("planes", end));
    }
    if end < bytes.len() as u64 {
        return Err(ReadError::TrailingBytes(bytes.len() - end as usize));
    }

    let most = layout::level_count(size);
    let first_of = |levels| levels::first_level(size, levels, max_size);
    let mut start = blobs_start;
    let mut levels = None;
    let mut groups = Vec::with_capacity(entries.len());
    for (index, entry) in entries.iter().enumerate() {
        let error = |reason| ReadError::Blob {
            group: index,
            reason,
        };
        let planes = match index {
            0 => content.luma_planes(),
            _ => 2,
        };
        let mut group = PlaneGroup {
            subsampling: entry.subsampling,
            packing: entry.packing,
            codings: Vec::new(),
            textures: Vec::new(),
        };
        for (&format, length) in entry.packing.formats().iter().zip(entry.lengths) {
            let blob = &bytes[start..start + length as usize];
            start += length as usize;
            let shape =
                ktx2_blob::Shape::of_group(format, size, entry.subsampling, entry.packing, planes)
                    .with_zstd(is_zstd);
            let contents = ktx2_blob::read(blob, shape, most, first_of).map_err(error)?;
            let valid = |coding: &PlaneCoding| coding.is_valid(entry.packing);
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
        let begin = |group| levels::begin_group(group, size, first, levels);
        groups.iter_mut().for_each(begin);
    }
    let mut groups = groups.into_iter();
    Ok(WaveletImage {
        content,
        color_space,
        size: layout::mip_size(size, first),
        levels: levels - first,
        payload: Payload::Wavelet(WaveletPlanes {
            axes,
            luma: groups.next().expect("there is at least one group"),
            chroma: groups.next(),
        }),
    })
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

/// The entry of a plane group in the header.
struct Entry {
    subsampling: u32,
    packing: Packing,
    lengths: [u32; 2],
}

impl Entry {
    fn read(bytes: &[u8], group: usize) -> Result<Self, ReadError> {
        let chroma = group > 0;
        let field = |field, value: u8| ReadError::Field {
            field,
            value: value.into(),
        };
        let subsampling = bytes[0];
        if !(if chroma { 1..=2 } else { 0..=0 }).contains(&subsampling) {
            return Err(field("subsampling", subsampling));
        }
        let fits = |packing: &Packing| match packing {
            Packing::Bc3 | Packing::Bc7 => true,
            Packing::Split | Packing::Bc4 => !chroma,
            Packing::Bc1 => chroma,
        };
        let packing = Packing::ALL.get(bytes[1] as usize).copied().filter(fits);
        let packing = packing.ok_or_else(|| field("packing", bytes[1]))?;
        if let Some(reserved) = bytes[2..4].iter().find(|b| **b != 0) {
            return Err(field("reserved byte", *reserved));
        }
        let length = |at: usize| u32::from_le_bytes([0, 1, 2, 3].map(|i| bytes[at + i]));
        let lengths = [length(4), length(8)];
        if packing.formats().len() == 1 && lengths[1] != 0 {
            return Err(ReadError::Field {
                field: "length of a second texture",
                value: lengths[1],
            });
        }
        Ok(Self {
            subsampling: subsampling.into(),
            packing,
            lengths,
        })
    }
}
