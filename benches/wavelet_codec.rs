//! Encoding and decoding on the CPU: `cargo bench --profile release --bench wavelet_codec`.

use bevy_frugal_lab::content;
use bevy_wavelet_tex::codec::{
    decoder::decode,
    encoder::{EncodeSettings, encode},
    image::{Content, WaveletImage},
    search::Effort,
};
use divan::{Bencher, black_box, counter::ItemsCount};

const SIZE: [u32; 2] = [768, 512];

fn main() {
    divan::main();
}

fn encoded(pixels: &[[u8; 3]], content: Content, effort: Effort) -> WaveletImage {
    let settings = EncodeSettings {
        content,
        effort,
        ..EncodeSettings::default()
    };
    encode(black_box(pixels), SIZE, &settings, &|_, _| {}).expect("a good image")
}

fn picture() -> Vec<[u8; 3]> {
    let picture = content::photo_like(SIZE[0], SIZE[1], 1);
    picture.pixels().map(|pixel| pixel.0).collect()
}

/// One picture of 768 x 512 with mips; pixels of its largest level a second.
#[divan::bench(sample_count = 10, args = [
    (Content::Gray, Effort::Fast),
    (Content::Gray, Effort::Default),
    (Content::Color, Effort::Fast),
    (Content::Color, Effort::Default),
    (Content::Color, Effort::Best),
])]
fn encoding(bencher: Bencher, (content, effort): (Content, Effort)) {
    let pixels = picture();
    bencher
        .counter(ItemsCount::new(pixels.len()))
        .bench(|| encoded(&pixels, content, effort));
}

/// The reference decoder, as an adapter without BC needs it on load.
#[divan::bench(sample_count = 10, args = [Content::Gray, Content::Color])]
fn decoding(bencher: Bencher, content: Content) {
    let image = encoded(&picture(), content, Effort::Fast);
    bencher
        .counter(ItemsCount::new(SIZE[0] * SIZE[1]))
        .bench(|| decode(black_box(&image), 0));
}
