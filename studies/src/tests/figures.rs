//! Figures on the pages are those of the committed measurements: each row is made anew from them, and must be
//! on its page word for word.

use bevy_frugal_lab::ROOT;
use std::path::Path;

use crate::{
    cost, demo,
    markdown::renewed,
    record::{Measurement, Report},
    voxel_gi::arcade_table,
};
use bevy_frugal_lab::lookups::scenes::SCENES;

/// The measurements of a plugin.
struct Data(Vec<Measurement>);

impl Data {
    fn read(plugin: &str) -> Self {
        let folder = Path::new(ROOT).join("docs/measurements/llvmpipe");
        let report = Report::read(folder.join(plugin).with_extension("json"));
        Self(report.expect("committed measurements").measurements)
    }

    /// The row of a setting in a scene; `reference` is what it begins with.
    fn row(&self, scene: &str, setting: &str, reference: &str) -> &Measurement {
        let mut rows = self.0.iter().filter(|row| {
            row.scene == scene && row.setting == setting && row.reference.starts_with(reference)
        });
        rows.next()
            .unwrap_or_else(|| panic!("nothing of {setting} in {scene} against {reference}"))
    }
}

/// Fails with all rows that the page lacks, as it should have them.
fn assert_rows(page: &str, rows: impl IntoIterator<Item = (String, Vec<String>)>) {
    let missing: Vec<_> = rows
        .into_iter()
        .map(|(name, cells)| format!("| {name} | {} |", cells.join(" | ")))
        .filter(|row| !page.lines().any(|line| line == row))
        .collect();
    assert!(
        missing.is_empty(),
        "not on the page:\n{}",
        missing.join("\n")
    );
}

#[test]
fn quality_of_the_frame_buffer() {
    let data = Data::read("ycocg_fb");
    let rows = [
        ("lit", "lit"),
        ("edges of equal luminance", "equal_luminance_edges"),
        ("thin lines", "thin_lines"),
        ("foliage", "foliage"),
        ("emissive 10,000 beside black", "hdr_edge"),
        ("dark", "dark"),
    ];
    assert_rows(
        include_str!("../../../crates/bevy_ycocg_fb/README.md"),
        rows.map(|(name, scene)| {
            let cell = |setting: &str| {
                let row = data.row(scene, setting, "rgba16float");
                row.psnr_db
                    .map_or("equal".into(), |psnr| format!("{psnr:.1}"))
            };
            let settings = [
                "nearest",
                "bilinear",
                "edge_directed",
                "quad",
                "guided",
                "default",
                "rgb565",
                "rg11b10ufloat",
            ];
            (name.into(), settings.map(cell).to_vec())
        }),
    );
}

#[test]
fn quality_of_wavelet_textures() {
    let data = Data::read("wavelet_tex");
    let rates = ["color2.25", "color3", "color3.25", "color5"];
    let cells = rates.map(|rate| {
        let images = (1..=24).map(|i| {
            let setting = format!("{rate} default");
            let row = data.row(&format!("kodim{i:02}"), &setting, "original");
            row.psnr_db.expect("a PSNR")
        });
        format!("{:.2}", images.sum::<f64>() / 24.0)
    });
    assert_rows(
        include_str!("../../../crates/bevy_wavelet_tex/README.md"),
        [("the 24 Kodak images".into(), cells.to_vec())],
    );
}

#[test]
fn price_of_sampling_wavelet_textures() {
    let data = Data::read("wavelet_tex");
    let filters = [
        "nearest",
        "nearest mip linear",
        "stochastic",
        "bilinear",
        "trilinear",
        "anisotropic",
    ];
    assert_rows(
        include_str!("../../../crates/bevy_wavelet_tex/README.md"),
        filters.map(|filter| {
            let row = data.row("tunnel", &format!("color3 {filter}"), "rgba8");
            let number = |value: Option<f64>| value.expect("a number").to_string();
            let time = |of: &str| format!("{:.1}", row.relative_time[of]);
            let cells = vec![
                number(row.fetches),
                number(row.fetched_bytes),
                time("bc7 frame"),
                time("bc7 sampling"),
                time("bc1 frame"),
            ];
            (filter.into(), cells)
        }),
    );
}

/// An error with as many digits as it deserves.
fn error(value: f64) -> String {
    let decimals = usize::from(value < 10.0);
    format!("{value:.decimals$}")
}

fn error_and_fetches(row: &Measurement) -> String {
    let fetches = row.fetches.expect("fetches");
    format!("{}, {fetches:.0}", error(row.mse.expect("an error")))
}

#[test]
fn prices_of_the_plugins() {
    let folder = Path::new(ROOT).join("docs/measurements/radv");
    let rows = cost::record::read(&folder).expect("committed cost");
    let page = include_str!("../../../README.md");
    for (plugin, setting) in cost::configurations::PLUGINS {
        let row = rows.iter().find(|row| {
            row.plugin == plugin
                && row.setting == setting
                && row.gpu == "navi31"
                && row.material == "base color"
                && row.pass == "forward"
        });
        let row = row.unwrap_or_else(|| panic!("no row of {plugin}"));
        let baseline = row.baseline_instructions.expect("Bevy's own");
        let price = row.instructions as f64 / baseline as f64;
        let link = format!("crates/bevy_{plugin}/README");
        let line = page.lines().find(|line| line.contains(&link));
        let line = line.unwrap_or_else(|| panic!("{plugin} is not on the page"));
        assert!(
            line.ends_with(&format!("| {price:.2} |")),
            "{price:.2}: {line}"
        );
    }
}

#[test]
fn error_of_elliptical_filtering() {
    let data = Data::read("ewa");
    let methods = [
        ("`Reference`", "reference"),
        ("`Linear` (default)", "linear"),
        ("`Bilinear`", "bilinear"),
        ("`Approximate`, 5 probes", "approximate"),
        ("`Temporal`, mean of two frames", "temporal"),
        ("`Spatial`", "spatial"),
        ("`SpatialTemporal`, mean of two", "spatial_temporal"),
        ("`Stochastic`, mean of 16 frames", "stochastic"),
        ("`SoftwareAnisotropic`", "software_af16"),
        ("Bevy's own, trilinear", "trilinear"),
    ];
    assert_rows(
        include_str!("../../../crates/bevy_ewa/README.md"),
        methods.map(|(name, setting)| {
            let cell = |scene| error_and_fetches(data.row(scene, setting, "truth"));
            (name.into(), SCENES.map(|scene| cell(scene.name)).to_vec())
        }),
    );
}

#[test]
fn price_of_the_spatial_threshold() {
    let data = Data::read("ewa");
    let scenes = ["tunnel", "checker_5deg", "checker_5deg_45", "floor"];
    assert_rows(
        include_str!("../../../crates/bevy_ewa/README.md"),
        [2, 4, 8, 12, 16, 24, 32].map(|threshold| {
            let setting = format!("spatial, threshold {threshold}");
            let cell = |scene| {
                let sampler = data.row(scene, &format!("{setting}, 16x sampler"), "ewa");
                let fetches = sampler.fetches.expect("fetches");
                let computed = error_and_fetches(data.row(scene, &setting, "ewa"));
                format!("{computed} / {fetches:.1}")
            };
            let name = match threshold {
                16 => "16 (default)".into(),
                _ => threshold.to_string(),
            };
            (name, scenes.map(cell).to_vec())
        }),
    );
}

#[test]
fn flicker_of_elliptical_filtering() {
    let data = Data::read("ewa");
    let methods = [
        ("`Reference`", "reference"),
        ("`Approximate`", "approximate"),
        ("`Temporal`", "temporal"),
        ("`SpatialTemporal`", "spatial_temporal"),
        ("`Stochastic`", "stochastic"),
        ("Bevy's own, trilinear", "trilinear"),
    ];
    let kinds = ["still", "moving", "still, Bevy's TAA", "moving, Bevy's TAA"];
    assert_rows(
        include_str!("../../../crates/bevy_ewa/README.md"),
        methods.map(|(name, setting)| {
            let cell = |kind| {
                let reference = format!("flicker, {kind}");
                let rows = data.0.iter().filter(|row| row.scene == "rasterised floor");
                let row = { rows }.find(|row| row.setting == setting && row.reference == reference);
                error(row.expect("a row").mse.expect("an error"))
            };
            (name.into(), kinds.map(cell).to_vec())
        }),
    );
}

const GI_SCENES: [&str; 3] = ["cornell_point", "colonnade", "sunlit_room"];

#[test]
fn error_of_global_illumination() {
    let data = Data::read("voxel_gi");
    let scenes = [
        ("Cornell box, point light", "15%"),
        ("colonnade, sun and sky", "20%"),
        ("room lit through a window", "25%"),
    ];
    let rows = scenes.into_iter().zip(GI_SCENES);
    assert_rows(
        include_str!("../../../crates/bevy_voxel_gi/README.md"),
        rows.map(|((name, goal), scene)| {
            let cell = |setting| {
                let row = data.row(scene, setting, "path traced");
                let percent = |value: Option<f64>| 100.0 * value.expect("a number");
                let (error, bias) = (percent(row.relative_error), percent(row.bias));
                format!("{error:.1}% / {bias:+.1}%")
            };
            (
                name.into(),
                vec![
                    cell("trace"),
                    cell("trace per pixel"),
                    cell("propagate"),
                    goal.into(),
                ],
            )
        }),
    );
}

#[test]
fn error_of_global_illumination_in_the_arcade() {
    let data = Data::read("arcade");
    let tables = arcade_table::tables(&Report {
        measurements: data.0,
        ..Report::default()
    });
    let page = include_str!("../../../crates/bevy_voxel_gi/README.md");
    assert!(
        !tables.is_empty() && page.contains(&tables),
        "not on the page:\n{tables}"
    );
}

#[test]
fn price_of_global_illumination() {
    let data = Data::read("voxel_gi");
    let settings = [
        ("64³, trace, 32 rays", "trace 64^3"),
        ("64³, trace, 8 rays", "trace 8 rays 64^3"),
        ("32³, trace, 64 rays", "trace 64 rays"),
        ("32³, trace, 32 rays (default)", "trace"),
        ("32³, trace, 16 rays", "trace 16 rays"),
        ("32³, trace, 8 rays", "trace 8 rays"),
        ("32³, trace, a quarter in each frame", "trace round_robin 4"),
        ("32³, trace, four bounces a frame", "trace 4 bounces"),
        ("32³, geometry clipping", "trace geometry_clipping"),
        ("32³, stochastic points", "trace stochastic"),
        ("32³, propagate, 96 steps", "propagate"),
        ("16³, trace, 32 rays", "trace 16^3"),
        ("16³, trace, 8 rays", "trace 8 rays 16^3"),
        ("16³, propagate, 32 steps", "propagate 32 steps 16^3"),
    ];
    assert_rows(
        include_str!("../../../crates/bevy_voxel_gi/README.md"),
        settings.map(|(name, setting)| {
            let cell = |scene| {
                let row = data.row(scene, setting, "path traced");
                let ms: f64 = row.stage_ms.values().sum();
                let error = row
                    .relative_error
                    .map_or("the same".into(), |error| format!("{:.1}%", 100.0 * error));
                format!("{error} in {ms:.0} ms")
            };
            (name.into(), GI_SCENES.map(cell).to_vec())
        }),
    );
}

#[test]
fn global_illumination_side_by_side() {
    let data = Data::read("solari");
    let still = [
        "no GI",
        "constant ambient light",
        "constant ambient light, what it adds",
        "ambient light and SSAO",
        "ambient light and SSAO, what it adds",
        "lightmaps",
        "lightmaps, what it adds",
        "irradiance volume",
        "irradiance volume, what it adds",
        "bevy_voxel_gi, what it adds",
        "bevy_solari, mean of frames 193 to 256",
        "bevy_solari ReSTIR, mean of frames 193 to 256",
    ];
    let in_frames = ["bevy_voxel_gi", "bevy_solari", "bevy_solari ReSTIR"];
    let frames = in_frames
        .iter()
        .flat_map(|name| [1, 8, 64].map(|frame| format!("{name}, frame {frame}")));
    let settings: Vec<_> = still.map(String::from).into_iter().chain(frames).collect();
    let percent = |value: Option<f64>| 100.0 * value.expect("a number");
    assert_rows(
        include_str!("../../../docs/choosing-gi.md"),
        settings.into_iter().map(|setting| {
            let cell = |scene| {
                let row = data.row(scene, &setting, "path traced");
                let (error, bias) = (percent(row.relative_error), percent(row.bias));
                let flicker = row.flicker.filter(|_| setting.ends_with("64"));
                let flicker =
                    flicker.map_or(String::new(), |f| format!(", flicker {:.1}%", 100.0 * f));
                format!("{error:.1}% / {bias:+.1}%{flicker}")
            };
            let cells = GI_SCENES.map(cell).to_vec();
            (setting, cells)
        }),
    );
    let bakes = ["lightmaps, bake", "irradiance volume, bake"];
    assert_rows(
        include_str!("../../../docs/choosing-gi.md"),
        bakes.map(|setting| {
            let cell = |scene| {
                let row = data.row(scene, setting, "");
                let bytes = row.bytes.expect("bytes") as f64;
                let ms = row.cpu_ms.expect("a time");
                format!("{:.1} MiB in {:.0} s", bytes / 1024.0 / 1024.0, ms / 1e3)
            };
            (setting.into(), GI_SCENES.map(cell).to_vec())
        }),
    );
}

#[test]
fn times_of_the_demos() {
    let root = Path::new(ROOT);
    let file = root.join("docs/measurements/llvmpipe").join(demo::FILE);
    let report = Report::read(file).expect("committed figures");
    for (page, name, table) in demo::pages(&report) {
        let text = std::fs::read_to_string(&page).expect("a page");
        let renewed = renewed(&text, &name, &table);
        assert!(
            renewed.as_deref() == Some(text.as_str()),
            "{} should have, as {name},\n{table}",
            page.display()
        );
    }
}

#[test]
fn compiled_cost_fetches_traffic_and_time_of_the_cpu() {
    let root = Path::new(ROOT);
    let folder = root.join(cost::record::FOLDER);
    let rows = cost::record::read(&folder).expect("committed figures");
    for (page, tables) in cost::tables::pages(&rows, &folder).expect("committed figures") {
        let text = std::fs::read_to_string(root.join(&page)).expect("a page");
        for (name, table) in tables {
            let renewed = renewed(&text, &name, &table);
            assert!(
                renewed.as_deref() == Some(text.as_str()),
                "{page} should have, as {name},\n{table}"
            );
        }
    }
}
