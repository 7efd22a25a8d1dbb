//! The studies at their smallest, what the pages say of them, and the command line.

use std::path::Path;

use bevy_frugal_lab::ROOT;
use clap::Parser;
use indicatif::ProgressBar;

use crate::{
    page,
    plan::Plan,
    run::{Options, STUDIES, Study},
    wavelet_tex::WaveletTex,
};

mod arcade;
mod cost;
mod ewa;
mod figures;
mod town;
mod voxel_gi;
mod wavelet_tex;
mod ycocg_fb;

fn tiny_plan() -> Plan {
    Plan {
        photo: [24, 16],
        tile: [16; 2],
        kodak: Vec::new(),
        repetitions: 1,
        picture: None,
        ..Plan::new(true)
    }
}

#[test]
fn a_tiny_report_has_every_row_with_finite_figures() {
    let plan = tiny_plan();
    let report = WaveletTex::measure(&plan, &ProgressBar::hidden()).expect("a report");
    let rows = &report.rows.images;
    // Three images in colour and in gray, and a normal map: the original, BC1, three efforts of
    // the first rate, and the others.
    assert_eq!(rows.len(), 3 * (1 + 1 + 3 + 4) + 3 * (1 + 3 + 1) + (1 + 3));
    for (setting, count) in [
        ("rgba8", 3),
        ("r8", 3),
        ("rg8", 1),
        ("bc1", 3),
        ("gray2 fast", 3),
        ("color3 default", 3),
    ] {
        let found = rows.iter().filter(|row| row.setting == setting).count();
        assert_eq!(found, count, "{setting}");
    }
    let photo = |setting| {
        rows.iter()
            .find(|row| row.scene == "photo" && row.setting == setting)
    };
    // 24 x 16 pixels: luma is 12 x 8 coefficients of 16 bytes a block, chroma 12 x 8 or 6 x 4
    // pixels of 8 bytes a block.
    let bytes = |setting| photo(setting).and_then(|row| row.bytes);
    assert_eq!(bytes("rgba8"), Some(24 * 16 * 4));
    assert_eq!(bytes("color3 default"), Some(3 * 2 * 16 + 3 * 2 * 8));
    assert_eq!(bytes("color2.25 best"), Some(3 * 2 * 16 + 2 * 8));
    // Four gathers of the low band of luma, its details, and chroma.
    let fetches = photo("color3 default").map(|row| row.fetches);
    assert_eq!(fetches, Some(4.0 + 1.0 + 1.0));

    let json = serde_json::to_value(&report).expect("serialises");
    let records = json["images"].as_array().expect("an array");
    for record in records.iter().filter(|r| r["reference"] != "itself") {
        for name in ["scene", "setting", "reference"] {
            let text = record[name].as_str();
            assert!(
                text.is_some_and(|text| !text.is_empty()),
                "{name}: {record}"
            );
        }
        let figures = [
            "mse",
            "psnr_db",
            "flip",
            "max_error",
            "cpu_ms",
            "bytes",
            "fetches",
        ];
        for name in figures {
            let figure = record[name].as_f64();
            assert!(figure.is_some_and(f64::is_finite), "{name}: {record}");
        }
    }
    // The chart has the baselines, too.
    let summary = WaveletTex::summary(&report.rows);
    let names: Vec<_> = { summary.choices.iter() }
        .map(|choice| choice.name.as_str())
        .collect();
    assert_eq!(
        names,
        [
            "bc1",
            "color2.25",
            "color3",
            "color3.25",
            "color4",
            "color5"
        ]
    );
}

/// What the pages advise is what was measured.
#[test]
fn the_pages_advise_what_the_measurements_say() {
    for study in &STUDIES {
        let text = std::fs::read_to_string(page::plugin_page(study.name)).expect("a page");
        let folder = Path::new(ROOT).join("docs/measurements/llvmpipe");
        let summary = (study.summary)(&folder).expect("its measurements");
        let advice = page::advice(&summary);
        let renewed = page::renewed(&text, study.name, &advice);
        assert!(
            renewed.as_ref() == Some(&text),
            "the table of {} is another one: `tradeoff all --from docs/measurements/llvmpipe \
             --out docs/measurements/llvmpipe --advise` renews it",
            study.name
        );
    }
}

#[test]
fn an_unknown_plugin_is_refused_with_the_known_ones() {
    let error = Options::try_parse_from(["tradeoff", "nanite"]).expect_err("unknown");
    assert_eq!(error.exit_code(), 2);
    let text = error.to_string();
    assert!(
        text.contains("wavelet_tex") && text.contains("all"),
        "{text}"
    );
    let all = Options::try_parse_from(["tradeoff", "all", "--quick"]).expect("known");
    assert_eq!(all.studies().count(), STUDIES.len());
}
