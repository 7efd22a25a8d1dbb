//! The studies at their smallest, what the pages say of them, and the command line.

use std::path::Path;

use bevy_frugal_lab::{
    ROOT, content,
    lookups::scenes::SCENES as LOOKUP_SCENES,
    metrics::max_error,
    scenes::ycocg_fb::scenes::{SCENES, TestScene},
    testing::{drawn, gpu, skipped},
};
use clap::Parser;
use indicatif::ProgressBar;

use crate::{
    ewa::{Ewa, SETTINGS},
    page,
    plan::Plan,
    record::PictureRow,
    run::{Options, STUDIES, Study},
    wavelet_tex::{
        WaveletTex,
        tunnel::{self, TunnelRow},
    },
    ycocg_fb::{
        Frame,
        display::{ToneMap, display_frames, hdr_frame},
        scene_rows, settings,
    },
};

mod cost;
mod figures;
mod voxel_gi;

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

#[test]
fn a_filter_is_compared_with_the_hardware() {
    let _gpu = gpu();
    let plan = Plan {
        rounds: 1,
        tunnel_frames: 4,
        ..Plan::new(true)
    };
    let tile = content::bricks(64, 64, 7).color;
    let filters = tunnel::FILTERS;
    let filters = filters
        .into_iter()
        .filter(|filter| filter.name == "bilinear");
    let filters: Vec<_> = filters.collect();
    let (adapter, rows) =
        tunnel::rows(&tile, &filters, [96, 64], &plan, &ProgressBar::hidden()).expect("rows");
    assert!(!adapter.name.is_empty());
    if rows.is_empty() {
        skipped(
            "wavelet textures against hardware filters: the adapter lacks BC or binds too few textures",
        );
        return;
    }
    assert!(rows.iter().all(|row| row.times.cpu_ms.is_some()));
    let row = |setting: &str| -> &TunnelRow {
        let found = rows.iter().find(|row| row.setting == setting);
        found.unwrap_or_else(|| panic!("no {setting} in {rows:?}"))
    };
    assert_eq!(rows.len(), 1 + 3 + 1);
    // All levels of 64 x 64 texels, the last three of which take a block each.
    let texels = |least: u64| (0..7).map(|l| (64u64 >> l).max(least).pow(2)).sum::<u64>();
    assert_eq!(row("rgba8 bilinear").bytes, 4 * texels(1));
    assert_eq!(row("bc7 bilinear").bytes, texels(4));
    assert_eq!(row("bc1 bilinear").bytes, texels(4) / 2);
    let ours = row("color3 bilinear");
    // The levels lie side by side in whole blocks, which counts for more than the bits where a texture is so small.
    assert!(ours.bytes > 0 && 4 * ours.bytes < 3 * texels(4));
    // Four gathers of the low band, then details and chroma of four pixels.
    assert_eq!(ours.fetches, 4.0 + 4.0 + 4.0);
    // Four texels a gather at 1 byte, one of details at 1 byte, four of interpolated chroma at half a byte.
    assert_eq!(ours.fetched_bytes, 16.0 + 4.0 + 8.0);
    let psnr = |row: &TunnelRow| row.error.expect("an error").psnr_db;
    assert!(psnr(ours).is_some_and(|psnr| psnr > 20.0), "{ours:?}");
    assert!(psnr(row("bc7 bilinear")) > psnr(ours));
    let times = &ours.relative_time;
    assert!(times.values().all(|time| time.is_finite()), "{times:?}");
    assert_eq!(row("no texture").bytes, 0);
}

const SCENE_NAMES: [&str; 7] = [
    "tunnel",
    "checker_1deg",
    "checker_5deg",
    "checker_5deg_45",
    "text",
    "srgb_stripes",
    "floor",
];
const SETTING_NAMES: [&str; 11] = [
    "reference",
    "linear",
    "bilinear",
    "approximate",
    "spatial",
    "temporal",
    "spatial_temporal",
    "stochastic",
    "software_af16",
    "hardware_af16",
    "trilinear",
];

#[test]
#[ignore = "long: the whole study"]
fn every_scene_has_every_setting_against_both_references() {
    let _gpu = gpu();
    assert_eq!(LOOKUP_SCENES.map(|scene| scene.name), SCENE_NAMES);
    assert_eq!(SETTINGS.map(|setting| setting.name), SETTING_NAMES);
    let mut plan = Plan::new(true);
    plan.picture = Some([150, 100]);
    plan.rounds = 1;
    plan.frames = 2;
    let report = Ewa::measure(&plan, &ProgressBar::hidden()).expect("a report");
    let software = report.adapter.name.contains("llvmpipe");
    let rows = &report.rows;
    let find = |scene: &str, setting: &str, reference: &str| {
        let mut rows = rows.pictures.iter();
        rows.find(|row| row.scene == scene && row.setting == setting && row.reference == reference)
    };
    let row = |scene: &str, setting: &str, reference: &str| {
        find(scene, setting, reference)
            .unwrap_or_else(|| panic!("no row {scene}, {setting}, {reference}"))
    };
    for setting in SETTING_NAMES {
        if software && setting == "hardware_af16" {
            assert!(find("tunnel", setting, "truth").is_none(), "not hardware");
            continue;
        }
        for scene in SCENE_NAMES {
            for reference in ["truth", "ewa"] {
                let row = row(scene, setting, reference);
                let error = row.error;
                let figures = [error.mse, error.flip, error.max_error, row.fetches];
                let finite = |f: f64| f >= 0.0 && f.is_finite();
                assert!(figures.into_iter().all(finite), "{row:?}");
                assert!(error.psnr_db.is_none_or(|psnr| psnr > 10.0), "{row:?}");
            }
        }
        let mut times = rows.times.iter().filter(|row| row.scene == "tunnel");
        let time = times.find(|row| row.setting == setting).expect("a time");
        assert!(time.times.cpu_ms.is_some_and(|ms| ms > 0.0), "{time:?}");
    }
    let figure = |scene: &str, setting: &str| {
        let row = row(scene, setting, "ewa");
        (row.error.mse, row.fetches)
    };
    // The thesis's errors against EWA (table 5.1), on every scene.
    for scene in SCENE_NAMES {
        let [reference, linear, bilinear] =
            ["reference", "linear", "bilinear"].map(|setting| figure(scene, setting));
        assert!(reference.0 < 0.1 && linear.0 < 0.1, "{scene}: {linear:?}");
        assert!(bilinear.0 < 6.4, "{scene}: {bilinear:?}");
        assert!(linear.1 < 0.65 * reference.1, "{scene}: {linear:?} fetches");
        assert!(figure(scene, "approximate").0 < 30.0, "{scene}");
        for setting in ["spatial", "temporal", "spatial_temporal"] {
            let found = figure(scene, setting);
            println!("{scene} {setting}: {found:?}");
            assert!(found.0 < 55.0, "{scene} {setting}: {found:?}");
        }
    }
    // What a higher threshold saves costs accuracy.
    let curve = |threshold: u32| {
        let setting = format!("spatial, threshold {threshold}");
        figure("checker_5deg", &setting)
    };
    let [low, middle, high] = [4, 8, 16].map(curve);
    for lower in [low, middle] {
        assert!(lower.1 > high.1 && lower.0 < high.0, "{lower:?} {high:?}");
    }
    // Split over two frames, the picture of a still camera changes; with TAA it settles.
    let flicker_in = |scene: &str, setting: &str, camera: &str| {
        let mut rows = rows.flicker.iter().filter(|row| row.scene == scene);
        let row = rows.find(|row| row.setting == setting && row.camera == camera);
        row.unwrap_or_else(|| panic!("no row {scene}, {setting}, {camera}"))
            .mse
    };
    let flicker = |setting, camera| flicker_in("tunnel", setting, camera);
    let rasterised = |setting, camera| flicker_in("rasterised floor", setting, camera);
    assert_eq!(flicker("linear", "still"), 0.0);
    assert!(flicker("temporal", "still") > 4.0 * flicker("temporal", "still, TAA"));
    assert_eq!(rasterised("approximate", "still"), 0.0);
    let [without, with] = ["still", "still, Bevy's TAA"].map(|kind| rasterised("temporal", kind));
    println!("temporal, still: {without:.2}, with Bevy's TAA {with:.2}");
    assert!(without > 2.0 * with, "{without} {with}");
    // The methods differ under it, too: it does not switch them off.
    assert!(rasterised("trilinear", "moving, Bevy's TAA") > 0.5);
}

const SIZE: [u32; 2] = [160, 120];

fn scene(name: &str) -> &'static TestScene {
    let found = SCENES.iter().find(|scene| scene.name == name);
    found.expect("a scene of this name")
}

fn frame(name: &str) -> Frame {
    let image = hdr_frame(scene(name), SIZE).expect("a frame");
    Frame::from(&image)
}

fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.25 * r + 0.5 * g + 0.25 * b
}

/// Share of the pixels that differ from the one to the right by more than a tenth in a channel.
fn edges(frame: &Frame) -> f32 {
    let differs = |pair: &&[[f32; 3]]| {
        let [a, b] = [pair[0], pair[1]];
        (0..3).any(|c| (a[c] - b[c]).abs() > 0.1 * a[c].max(b[c]) + 1e-6)
    };
    frame.pixels.windows(2).filter(differs).count() as f32 / frame.pixels.len() as f32
}

#[test]
fn the_scenes_are_what_they_are_called() {
    let _gpu = gpu();
    let flat = frame("equal_luminance_edges");
    // Up to the rounding of the 16-bit target.
    let level = |p: &[f32; 3]| (luminance(*p) - 0.2).abs();
    assert!(flat.pixels.iter().map(level).fold(0.0, f32::max) < 2e-4);
    assert!(edges(&flat) > 0.01, "{}", edges(&flat));

    let hdr = frame("hdr_edge");
    let channels = || hdr.pixels.iter().flatten().copied();
    let largest = channels().fold(0.0, f32::max);
    assert!((9990.0..=10_010.0).contains(&largest), "{largest}");
    let black = hdr.pixels.iter().filter(|p| **p == [0.0; 3]).count();
    assert!(black > hdr.pixels.len() / 4, "{black} black pixels");

    let dark = frame("dark");
    let mean = dark.pixels.iter().map(|p| luminance(*p)).sum::<f32>() / dark.pixels.len() as f32;
    assert!((0.001..0.02).contains(&mean), "{mean}");

    let lit = frame("lit");
    let bright = lit.pixels.iter().filter(|p| luminance(**p) > 0.05).count();
    assert!(bright > lit.pixels.len() / 2, "{bright} lit pixels");

    // A line in nearly every row and column, and leaves everywhere.
    assert!(edges(&frame("thin_lines")) > 0.1);
    assert!(edges(&frame("foliage")) > 0.5);
}

#[test]
fn tone_mapping_on_the_cpu_is_that_of_the_camera() {
    let _gpu = gpu();
    let tone_map = ToneMap::capture().expect("a table");
    for name in ["lit", "hdr_edge"] {
        let (camera, _) = display_frames(scene(name), SIZE, &[]).expect("a picture");
        let ours = tone_map.display(&frame(name)).to_rgb8();
        let error = max_error(&camera, &ours).expect("one size");
        assert!(error <= 1, "{name}: {error} steps");
    }
}

#[test]
fn every_scene_is_measured_with_every_setting() {
    let _gpu = gpu();
    let tone_map = ToneMap::capture().expect("a table");
    let settings = settings();
    for scene in drawn(1, &SCENES) {
        let rows = scene_rows(scene, SIZE, &settings, &tone_map).expect("rows");
        assert_eq!(rows.len(), 1 + settings.len());
        let mse = |setting: &str| mse(&rows, setting);
        assert_eq!(mse("rgba16float"), 0.0);
        // The goal on every scene: better than the thesis's filter, and that in 8 bits too.
        assert!(
            mse("default") < 0.75 * mse("edge_directed"),
            "{}",
            scene.name
        );
        assert!(
            mse("guided") < 0.75 * mse("edge_directed"),
            "{}",
            scene.name
        );
        assert!(mse("edge_directed") <= mse("bilinear"), "{}", scene.name);
        // Half the memory of the reference.
        let bytes = |setting: &str| find(&rows, setting).bytes;
        assert_eq!(bytes("default"), Some(160 * 120 * 4));
        assert_eq!(bytes("rgba16float"), Some(160 * 120 * 8));
    }
}

fn find<'a>(rows: &'a [PictureRow], setting: &str) -> &'a PictureRow {
    let found = rows.iter().find(|row| row.setting == setting);
    found.unwrap_or_else(|| panic!("no row {setting}"))
}

fn mse(rows: &[PictureRow], setting: &str) -> f64 {
    find(rows, setting).error.mse
}
