//! Normal maps that are given or generated, and their encoding in each format.

use bevy_wavelet_tex::codec::{
    angle::unit,
    blocks::{BlockFormat, BlockQuality, decode_blocks, encode_bc1, encode_bc4},
    decoder::{decode, normal_from_xy},
    encoder::{EncodeError, encode},
    image::ColorSpace,
    rate::Rate,
    settings::{EncodeSettings, Formats, Method},
    source::{Pixels, Source},
};
use image::{Rgb, Rgb32FImage, imageops};

/// Side of the generated maps, in pixels.
const SIDE: u32 = 256;

/// Unit normals, row by row from the top.
#[derive(Clone)]
pub struct NormalMap {
    pub size: [u32; 2],
    pub normals: Vec<[f64; 3]>,
}

/// The format that a map is encoded in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Format {
    /// X, Y and Z as a colour in BC1, normalised when sampled: 4 bpp.
    Bc1,
    /// X and Y in BC5, Z reconstructed: 8 bpp.
    Bc5,
    /// BC5 with both sides smaller by the square root of 2, interpolated bilinearly: 4 bpp.
    SmallBc5,
    /// X and Y as wavelet planes, Z reconstructed: 4 bpp.
    Wavelet(Method),
}

impl Format {
    pub const ALL: [Self; 6] = [
        Self::Bc1,
        Self::SmallBc5,
        Self::Wavelet(Method::Thesis),
        Self::Wavelet(Method::OneFetch),
        Self::Wavelet(Method::Best),
        Self::Bc5,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Bc1 => "BC1",
            Self::Bc5 => "BC5",
            Self::SmallBc5 => "BC5 of a lower resolution",
            Self::Wavelet(Method::Best) => "normal4",
            Self::Wavelet(Method::OneFetch) => "normal4, one fetch",
            Self::Wavelet(Method::Thesis) => "normal4, thesis",
        }
    }
}

impl NormalMap {
    /// Converts the pixels of a picture.
    pub fn given(picture: &Rgb32FImage) -> Self {
        let normal = |p: &Rgb<f32>| unit(p.0.map(|v| 2.0 * f64::from(v) - 1.0));
        Self {
            size: picture.dimensions().into(),
            normals: picture.pixels().map(normal).collect(),
        }
    }

    /// Generates long waves whose normals change by less than a degree from pixel to pixel.
    pub fn smooth() -> Self {
        Self::of_slopes(|x, y| {
            let (u, v) = (x * 0.031, y * 0.027);
            [
                0.35 * (u + 0.4 * v.sin()).cos(),
                0.35 * (v + 0.4 * u.cos()).sin(),
            ]
        })
    }

    /// Generates waves of all lengths down to three pixels.
    pub fn rough() -> Self {
        Self::of_slopes(|x, y| {
            let wave = |i: i32| {
                let (frequency, angle) = (0.1 * 1.45f64.powi(i), 2.4 * f64::from(i));
                let phase = frequency * (x * angle.cos() + y * angle.sin()) + 1.7 * f64::from(i);
                [angle.cos(), angle.sin()].map(|direction| 0.15 * direction * phase.cos())
            };
            (0..9)
                .map(wave)
                .fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]])
        })
    }

    fn of_slopes(slopes: impl Fn(f64, f64) -> [f64; 2]) -> Self {
        let normal = |i: u32| {
            let [x, y] = slopes(f64::from(i % SIDE), f64::from(i / SIDE));
            unit([-x, -y, 1.0])
        };
        Self {
            size: [SIDE; 2],
            normals: (0..SIDE * SIDE).map(normal).collect(),
        }
    }

    /// Encodes and decodes the map in a format. Returns the decoded map and the bytes of its blocks.
    pub fn through(&self, format: Format) -> Result<(Self, usize), EncodeError> {
        match format {
            Format::Bc1 => {
                let texels: Vec<_> = self.normals.iter().map(|n| bytes(*n)).collect();
                let blocks = encode_bc1(&texels, self.size, BlockQuality::High);
                let decoded = decode_blocks(BlockFormat::Bc1, &blocks, self.size);
                let normal =
                    |[x, y, z, _]: &[f32; 4]| unit([x, y, z].map(|v| 2.0 * f64::from(*v) - 1.0));
                let normals = decoded.iter().map(normal).collect();
                Ok((self.with(normals), blocks.len()))
            }
            Format::Bc5 => {
                let (xy, bytes) = through_bc5(self.size, |x, y| self.at(x, y));
                let normals = xy.into_iter().map(from_xy).collect();
                Ok((self.with(normals), bytes))
            }
            Format::SmallBc5 => {
                let small = self
                    .size
                    .map(|s| (f64::from(s) / 2f64.sqrt()).round().max(1.0) as u32);
                let smaller = self.resized(small);
                let (xy, bytes) = through_bc5(small, |x, y| smaller.at(x, y));
                let back = Self {
                    size: small,
                    // The texture unit filters X and Y; then Z is reconstructed.
                    normals: xy
                        .iter()
                        .map(|[x, y]| [f64::from(*x), f64::from(*y), 0.0])
                        .collect(),
                };
                let back = back.interpolated_to(self.size);
                let normals = back
                    .into_iter()
                    .map(|[x, y, _]| from_xy([x as f32, y as f32]));
                Ok((self.with(normals.collect()), bytes))
            }
            Format::Wavelet(method) => {
                let words: Vec<[u16; 4]> = self.normals.iter().map(|n| words(*n)).collect();
                let settings = EncodeSettings {
                    rate: Rate::Normal4,
                    color_space: ColorSpace::Linear,
                    mips: false,
                    method,
                    formats: Formats::Wavelet,
                    ..EncodeSettings::default()
                };
                let source = Source::new(self.size, Pixels::Rgba16(&words));
                let image = encode(&source, &settings, &|_, _| {})?;
                let decoded = decode(&image, 0).pixels.into_iter();
                let normals = decoded.map(|n| unit(n.map(f64::from))).collect();
                Ok((self.with(normals), image.gpu_bytes()))
            }
        }
    }

    fn with(&self, normals: Vec<[f64; 3]>) -> Self {
        Self {
            size: self.size,
            normals,
        }
    }

    fn at(&self, x: u32, y: u32) -> [f64; 3] {
        let x = x.min(self.size[0] - 1);
        let y = y.min(self.size[1] - 1);
        self.normals[(y * self.size[0] + x) as usize]
    }

    /// Downsamples the map by Lanczos, as `baselines` downsamples pictures.
    fn resized(&self, [width, height]: [u32; 2]) -> Self {
        let image = Rgb32FImage::from_fn(self.size[0], self.size[1], |x, y| {
            // The values are mapped to 0 to 1 because the library clamps to that.
            Rgb(self.at(x, y).map(|v| (0.5 + 0.5 * v) as f32))
        });
        let filter = imageops::FilterType::Lanczos3;
        let small = imageops::resize(&image, width, height, filter);
        Self {
            size: [width, height],
            normals: small
                .pixels()
                .map(|p| unit(p.0.map(|v| 2.0 * f64::from(v) - 1.0)))
                .collect(),
        }
    }

    /// Resamples the map to another size, bilinearly between the centres of the pixels.
    pub fn interpolated_to(&self, size: [u32; 2]) -> Vec<[f64; 3]> {
        let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y]));
        pixels
            .map(|pixel| {
                let [x, y] = [0, 1].map(|i: usize| {
                    let scale = f64::from(self.size[i]) / f64::from(size[i]);
                    ((f64::from(pixel[i]) + 0.5) * scale - 0.5).max(0.0)
                });
                let (left, above) = (x.floor(), y.floor());
                let mut sum = [0.0; 3];
                for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let weight = |t: f64, d: u32| if d == 0 { 1.0 - t } else { t };
                    let weight = weight(x - left, dx) * weight(y - above, dy);
                    let normal = self.at(left as u32 + dx, above as u32 + dy);
                    sum = std::array::from_fn(|c| sum[c] + weight * normal[c]);
                }
                sum
            })
            .collect()
    }
}

/// Encodes and decodes X and Y in BC5, which is two BC4 blocks.
fn through_bc5(size: [u32; 2], normal: impl Fn(u32, u32) -> [f64; 3]) -> (Vec<[f32; 2]>, usize) {
    let mut length = 0;
    let [x, y] = [0, 1].map(|c: usize| {
        let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
        let values: Vec<f32> = pixels
            .map(|(x, y)| (0.5 + 0.5 * normal(x, y)[c]) as f32)
            .collect();
        let blocks = encode_bc4(&values, size, BlockQuality::High);
        length += blocks.len();
        decode_blocks(BlockFormat::Bc4, &blocks, size)
    });
    let signed = |texel: &[f32; 4]| 2.0 * texel[0] - 1.0;
    (
        x.iter()
            .zip(&y)
            .map(|(x, y)| [signed(x), signed(y)])
            .collect(),
        length,
    )
}

fn from_xy(xy: [f32; 2]) -> [f64; 3] {
    unit(normal_from_xy(xy).map(f64::from))
}

fn bytes(normal: [f64; 3]) -> [u8; 4] {
    let [x, y, z] = normal.map(|v| (127.5 + 127.5 * v).round() as u8);
    [x, y, z, 255]
}

fn words(normal: [f64; 3]) -> [u16; 4] {
    let [x, y, z] = normal.map(|v| (32767.5 + 32767.5 * v).round() as u16);
    [x, y, z, u16::MAX]
}
