//! The GPU rows of a study.

use bevy_frugal_lab::{
    content,
    testing::{gpu, skipped},
};
use indicatif::ProgressBar;

use crate::{
    plan::Plan,
    wavelet_tex::tunnel::{self, TunnelRow},
};

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
