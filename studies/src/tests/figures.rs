//! Figures on the pages are those of the committed measurements: each row is made anew from them, and must be
//! on its page word for word.

use std::{
    fmt::Display,
    path::{Path, PathBuf},
};

use bevy_frugal_lab::{ROOT, lookups::scenes::SCENES};

use crate::{
    cost, demo,
    ewa::Ewa,
    page::renewed,
    record::{PictureRow, Report},
    run::{Study, read},
    voxel_gi::{self, LightRow, VoxelGi, arcade, town},
    wavelet_tex::{WaveletTex, tunnel::TunnelRow},
    ycocg_fb::YCoCgFb,
};

fn folder() -> PathBuf {
    Path::new(ROOT).join("docs/measurements/llvmpipe")
}

/// The measurements of a plugin.
fn rows<S: Study>() -> S::Rows {
    read::<S>(&folder()).expect("committed measurements").rows
}

/// The row of a setting in a scene; `reference` is what it begins with.
fn picture<'a>(
    rows: &'a [PictureRow],
    scene: &str,
    setting: &str,
    reference: &str,
) -> &'a PictureRow {
    let mut rows = rows.iter().filter(|row| {
        row.scene == scene && row.setting == setting && row.reference.starts_with(reference)
    });
    rows.next()
        .unwrap_or_else(|| panic!("nothing of {setting} in {scene} against {reference}"))
}

/// The row of a setting in a scene.
fn light<'a>(rows: &'a [LightRow], scene: &str, setting: &str) -> &'a LightRow {
    let mut rows = rows.iter();
    rows.find(|row| row.scene == scene && row.setting == setting)
        .unwrap_or_else(|| panic!("nothing of {setting} in {scene}"))
}

/// Fails with all rows that a page of `docs` lacks, as it should have them: a name, and a cell for each column.
fn assert_rows<R, C>(
    page: &str,
    rows: impl IntoIterator<Item = (impl Display, R)>,
    columns: &[C],
    cell: impl Fn(&R, &C) -> String,
) {
    let page = Path::new(ROOT).join("docs").join(page);
    let page = std::fs::read_to_string(page).expect("a page");
    let missing: Vec<_> = rows
        .into_iter()
        .map(|(name, row)| {
            let cells: Vec<_> = columns.iter().map(|column| cell(&row, column)).collect();
            format!("| {name} | {} |", cells.join(" | "))
        })
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
    let pictures = rows::<YCoCgFb>().pictures;
    let scenes = [
        ("lit", "lit"),
        ("edges of equal luminance", "equal_luminance_edges"),
        ("thin lines", "thin_lines"),
        ("foliage", "foliage"),
        ("emissive 10,000 beside black", "hdr_edge"),
        ("dark", "dark"),
    ];
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
    assert_rows("ycocg_fb.md", scenes, &settings, |scene, setting| {
        let row = picture(&pictures, scene, setting, "rgba16float");
        let psnr = row.error.psnr_db;
        psnr.map_or("equal".into(), |psnr| format!("{psnr:.1}"))
    });
}

#[test]
fn quality_of_wavelet_textures() {
    let pictures = rows::<WaveletTex>().images;
    let rates = ["color2.25", "color3", "color3.25", "color5"];
    let row = [("the 24 Kodak images", ())];
    assert_rows("wavelet_tex.md", row, &rates, |(), rate| {
        let images = (1..=24).map(|i| {
            let setting = format!("{rate} default");
            let row = picture(&pictures, &format!("kodim{i:02}"), &setting, "original");
            row.error.psnr_db.expect("a PSNR")
        });
        format!("{:.2}", images.sum::<f64>() / 24.0)
    });
}

#[test]
fn price_of_sampling_wavelet_textures() {
    let tunnel = rows::<WaveletTex>().tunnel;
    let filters = [
        "nearest",
        "nearest mip linear",
        "stochastic",
        "bilinear",
        "trilinear",
        "anisotropic",
    ];
    let filters = filters.map(|filter| (filter, format!("color3 {filter}")));
    let figures: [fn(&TunnelRow) -> f64; 2] = [|row| row.fetches, |row| row.fetched_bytes];
    assert_rows("wavelet_tex.md", filters, &figures, |setting, figure| {
        let row = tunnel.iter().find(|row| row.setting == *setting);
        figure(row.expect("a row")).to_string()
    });
}

/// An error with as many digits as it deserves.
fn error(value: f64) -> String {
    let decimals = usize::from(value < 10.0);
    format!("{value:.decimals$}")
}

fn error_and_fetches(row: &PictureRow) -> String {
    format!("{}, {:.0}", error(row.error.mse), row.fetches)
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
    let pictures = rows::<Ewa>().pictures;
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
    assert_rows("ewa.md", methods, &SCENES, |setting, scene| {
        error_and_fetches(picture(&pictures, scene.name, setting, "truth"))
    });
}

#[test]
fn price_of_the_spatial_threshold() {
    let pictures = rows::<Ewa>().pictures;
    let scenes = ["tunnel", "checker_5deg", "checker_5deg_45", "floor"];
    let thresholds = [2, 4, 8, 12, 16, 24, 32].map(|threshold| {
        let note = if threshold == 16 { " (default)" } else { "" };
        let setting = format!("spatial, threshold {threshold}");
        (format!("{threshold}{note}"), setting)
    });
    assert_rows("ewa.md", thresholds, &scenes, |setting, scene| {
        let sampler = format!("{setting}, 16x sampler");
        let sampler = picture(&pictures, scene, &sampler, "ewa").fetches;
        let computed = error_and_fetches(picture(&pictures, scene, setting, "ewa"));
        format!("{computed} / {sampler:.1}")
    });
}

#[test]
fn flicker_of_elliptical_filtering() {
    let flicker = rows::<Ewa>().flicker;
    let methods = [
        ("`Reference`", "reference"),
        ("`Approximate`", "approximate"),
        ("`Temporal`", "temporal"),
        ("`SpatialTemporal`", "spatial_temporal"),
        ("`Stochastic`", "stochastic"),
        ("Bevy's own, trilinear", "trilinear"),
    ];
    let kinds = ["still", "moving", "still, Bevy's TAA", "moving, Bevy's TAA"];
    assert_rows("ewa.md", methods, &kinds, |setting, kind| {
        let mut rows = flicker.iter().filter(|row| row.scene == "rasterised floor");
        let row = rows.find(|row| row.setting == *setting && row.camera == *kind);
        error(row.expect("a row").mse)
    });
}

const GI_SCENES: [&str; 3] = ["cornell_point", "colonnade", "sunlit_room"];

fn error_and_bias(row: &LightRow) -> String {
    let percent = |value: Option<f64>| 100.0 * value.expect("a number");
    let (error, bias) = (percent(row.relative_error), percent(row.bias));
    format!("{error:.1}% / {bias:+.1}%")
}

#[test]
fn error_of_global_illumination() {
    let boxes = rows::<VoxelGi>().boxes;
    let names = [
        ("Cornell box, point light", "15%"),
        ("colonnade, sun and sky", "20%"),
        ("room lit through a window", "25%"),
    ];
    let scenes = names.into_iter().zip(GI_SCENES);
    let scenes = scenes.map(|((name, goal), scene)| (name, (scene, goal)));
    let columns = ["trace", "trace per pixel", "propagate", "goal"];
    assert_rows(
        "voxel_gi.md",
        scenes,
        &columns,
        |(scene, goal), column| match *column {
            "goal" => goal.to_string(),
            setting => error_and_bias(light(&boxes, scene, setting)),
        },
    );
}

#[test]
fn error_of_global_illumination_in_scenes_of_meshes() {
    let rows = |name| {
        let report = Report::<voxel_gi::Rows>::read(folder().join(name));
        report.expect("committed measurements").rows
    };
    let page = include_str!("../../../docs/voxel_gi.md");
    for tables in [
        arcade::tables(&rows("arcade.json").arcade),
        town::tables(&rows("town.json").town),
    ] {
        assert!(
            !tables.is_empty() && page.contains(&tables),
            "not on the page:\n{tables}"
        );
    }
}

#[test]
fn price_of_global_illumination() {
    let boxes = rows::<VoxelGi>().boxes;
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
    assert_rows("voxel_gi.md", settings, &GI_SCENES, |setting, scene| {
        let row = light(&boxes, scene, setting);
        let ms: f64 = row.times.stage_ms.values().sum();
        let error = row
            .relative_error
            .map_or("the same".into(), |error| format!("{:.1}%", 100.0 * error));
        format!("{error} in {ms:.0} ms")
    });
}

#[test]
fn global_illumination_side_by_side() {
    let report = Report::<voxel_gi::Rows>::read(folder().join("solari.json"));
    let boxes = report.expect("committed measurements").rows.boxes;
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
    let settings = still.map(String::from).into_iter().chain(frames);
    let settings = settings.map(|setting| (setting.clone(), setting));
    assert_rows("choosing-gi.md", settings, &GI_SCENES, |setting, scene| {
        let row = light(&boxes, scene, setting);
        let flicker = row.flicker.filter(|_| setting.ends_with("64"));
        let flicker = flicker.map_or(String::new(), |f| format!(", flicker {:.1}%", 100.0 * f));
        error_and_bias(row) + &flicker
    });
    let bakes = ["lightmaps, bake", "irradiance volume, bake"].map(|name| (name, name));
    assert_rows("choosing-gi.md", bakes, &GI_SCENES, |setting, scene| {
        let row = light(&boxes, scene, setting);
        let bytes = row.bytes.expect("bytes") as f64;
        let ms = row.times.cpu_ms.expect("a time");
        format!("{:.1} MiB in {:.0} s", bytes / 1024.0 / 1024.0, ms / 1e3)
    });
}

/// Fails with all tables that pages do not have between their marks.
fn assert_tables(tables: impl IntoIterator<Item = (PathBuf, String, String)>) {
    for (page, name, table) in tables {
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
fn times_of_the_demos() {
    let report = Report::read(folder().join(demo::FILE)).expect("committed figures");
    assert_tables(demo::pages(&report));
}

#[test]
fn compiled_cost_fetches_and_time_of_the_cpu() {
    let folder = Path::new(ROOT).join(cost::record::FOLDER);
    let rows = cost::record::read(&folder).expect("committed figures");
    assert_tables(cost::tables::pages(&rows, &folder).expect("committed figures"));
}
