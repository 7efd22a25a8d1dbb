//! Encoding and decoding on the CPU: `cargo bench --profile release --bench wavelet_codec`.

use bevy_frugal_lab::content;
use bevy_wavelet_tex::codec::{
    decoder::decode,
    encoder::encode_rgb8,
    image::WaveletImage,
    rate::Rate,
    settings::{Effort, EncodeSettings, Formats},
};
use divan::{Bencher, black_box, counter::ItemsCount};

const SIZE: [u32; 2] = [768, 512];

fn main() {
    divan::main();
}

fn encoded(pixels: &[[u8; 3]], rate: Rate, effort: Effort) -> WaveletImage {
    let settings = EncodeSettings {
        rate,
        effort,
        formats: Formats::Wavelet,
        ..EncodeSettings::default()
    };
    encode_rgb8(black_box(pixels), SIZE, &settings).expect("a good image")
}

fn picture() -> Vec<[u8; 3]> {
    let picture = content::photo_like(SIZE[0], SIZE[1], 1);
    picture.pixels().map(|pixel| pixel.0).collect()
}

/// One picture of 768 x 512 with mips; pixels of its largest level a second.
#[divan::bench(sample_count = 10, args = [
    (Rate::Gray2, Effort::Fast),
    (Rate::Gray2, Effort::Default),
    (Rate::Color3, Effort::Fast),
    (Rate::Color3, Effort::Default),
    (Rate::Color3, Effort::Best),
])]
fn encoding(bencher: Bencher, (rate, effort): (Rate, Effort)) {
    let pixels = picture();
    bencher
        .counter(ItemsCount::new(pixels.len()))
        .bench(|| encoded(&pixels, rate, effort));
}

/// The reference decoder, as an adapter without BC needs it on load.
#[divan::bench(sample_count = 10, args = [Rate::Gray2, Rate::Color3])]
fn decoding(bencher: Bencher, rate: Rate) {
    let image = encoded(&picture(), rate, Effort::Fast);
    bencher
        .counter(ItemsCount::new(SIZE[0] * SIZE[1]))
        .bench(|| decode(black_box(&image), 0));
}
