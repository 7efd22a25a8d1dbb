//! The study of `bevy_wavelet_tex`.
//!
//! Of every image, each effort of the encoder gives a row: the reference decoder against the
//! original in 8 bits, `cpu_ms` the time to encode. `bytes` are those of the largest level, without
//! mips, and `fetches` those of one nearest sample there. Rows `r8`, `rg8` and `rgba8` are the
//! original itself. The rows of the [`tunnel`] have times of frames.
//!
//! Normal maps are compared as X, Y and Z mapped to 0 to 255, so their FLIP is that of the map seen
//! as a picture.
//!
//! | module | contents |
//! | --- | --- |
//! | `inputs` | the images, and what each is encoded as |
//! | `encoded` | the rows of encoded images |
//! | [`tunnel`] | frame times and pictures of the filters |
//! | `published` | figures of the thesis |
//! | [`mod@summary`] | what a user chooses between |

mod encoded;
mod inputs;
mod published;
pub mod summary;
pub mod tunnel;

use bevy_wavelet_tex::codec::image::Content;
use indicatif::ProgressBar;

use self::inputs::{DEFAULT_EFFORT, Input, SEED, inputs};
use super::{
    plan::Plan,
    study::{Study, TradeoffError},
};
use crate::record::{Measurement, Report};
use bevy_frugal_lab::content;

pub const STUDY: Study = Study {
    name: "wavelet_tex",
    measure,
    summary: summary::summary,
    tables: |_| String::new(),
};

fn measure(plan: &Plan, progress: &ProgressBar) -> Result<Report, TradeoffError> {
    progress.set_message("images");
    let photo = content::photo_like(plan.photo[0], plan.photo[1], SEED);
    let inputs = inputs(plan, &photo, progress)?;
    let rendered = plan.picture.map_or(0, |_| plan.rounds as usize);
    let rows: usize = inputs
        .iter()
        .map(|i| i.rates.len() + i.efforts.len() - 1)
        .sum();
    progress.set_length((rows + rendered) as u64);

    let mut report = Report::default();
    for input in &inputs {
        report
            .measurements
            .extend(image_rows(input, plan, progress)?);
    }
    if let Some(picture) = plan.picture {
        let tile = content::bricks(plan.tile[0], plan.tile[1], SEED).color;
        let (adapter, rows) = tunnel::rows(&tile, &tunnel::FILTERS, picture, plan, progress)?;
        report.adapter = adapter;
        report.measurements.extend(rows);
    }
    Ok(report)
}

/// The rows of an image: the image itself, every rate, and BC1 of colour.
fn image_rows(
    input: &Input,
    plan: &Plan,
    progress: &ProgressBar,
) -> Result<Vec<Measurement>, TradeoffError> {
    let mut rows = vec![Measurement {
        scene: input.scene.clone(),
        ..encoded::original(&input.image, input.content)
    }];
    if input.content == Content::Color {
        rows.push(encoded::bc1_row(input)?);
    }
    for (i, &rate) in input.rates.iter().enumerate() {
        let efforts = if i == 0 {
            input.efforts
        } else {
            DEFAULT_EFFORT
        };
        for &(effort, name) in efforts {
            progress.set_message(format!("{}, {} {name}", input.scene, rate.name()));
            rows.push(encoded::encoded_row(
                input,
                rate,
                effort,
                name,
                plan.repetitions,
            )?);
            progress.inc(1);
        }
    }
    Ok(rows)
}
