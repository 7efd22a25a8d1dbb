//! `wavelet-tex encode`.

use std::time::{Duration, Instant};

use bevy_wavelet_tex::{
    codec::{
        encoder::{EncodeSettings, encode},
        image::{ColorSpace, Content},
    },
    file,
};
use indicatif::{ProgressBar, ProgressStyle};

use crate::{args::EncodeArgs, compare::Difference, error::Error, files, picture::Picture};

/// Encodes a PNG; one line about the result.
pub fn run(args: &EncodeArgs) -> Result<String, Error> {
    args.check()?;
    let output = match &args.output {
        Some(output) => output.clone(),
        None => args.input.with_extension(file::EXTENSION),
    };
    files::check_output(&args.input, &output, file::EXTENSION)?;
    let source = Picture::read_png(&args.input)?;

    let content = args.content(source.is_gray());
    let linear = args.linear || content == Content::Normal;
    let settings = EncodeSettings {
        content,
        color_space: if linear {
            ColorSpace::Linear
        } else {
            ColorSpace::Srgb
        },
        mips: !args.no_mips,
        effort: args.effort(),
    };
    // Hidden by indicatif where standard error is no terminal.
    let bar = ProgressBar::no_length().with_style(
        ProgressStyle::with_template("{spinner} {bar:40} {pos} of {len} mip levels of planes")
            .expect("a good template"),
    );
    bar.enable_steady_tick(Duration::from_millis(100));
    let start = Instant::now();
    let texture = encode(&source.pixels, source.size, &settings, &|_, parts| {
        bar.set_length(parts as u64);
        bar.inc(1);
    });
    let seconds = start.elapsed().as_secs_f64();
    bar.finish_and_clear();
    let texture = texture.map_err(|e| Error::file(&args.input, e))?;

    let bytes = file::write(&texture);
    files::write(&output, &bytes)?;
    let difference = Difference::between(&source, &Picture::from_texture(&texture, 0), false);
    let [width, height] = texture.size;
    Ok(format!(
        "{}: {width} x {height} pixels, {:.2} bpp, {} bytes, {}, {seconds:.2} s",
        output.display(),
        texture.bits_per_pixel(),
        bytes.len(),
        difference.quality(),
    ))
}
