//! The GPU rows of a study.

use bevy_frugal_lab::{
    content,
    tradeoff::{options::Plan, wavelet_tex::render},
};
use indicatif::ProgressBar;

use crate::support::gpu;

#[test]
fn a_filter_is_compared_with_the_hardware() {
    let _gpu = gpu();
    let plan = Plan {
        rounds: 1,
        frames: 2,
        ..Plan::new(true)
    };
    let photo = content::photo_like(48, 32, 7);
    let filters = &render::FILTERS[2..3];
    let (adapter, rows) =
        render::rows(&photo, filters, [32, 24], &plan, &ProgressBar::hidden()).expect("rows");
    assert!(!adapter.name.is_empty());
    assert!(rows.iter().all(|row| row.cpu_ms.is_some()));
    assert_eq!(rows[0].setting, "rgba8 bilinear");
    // None where the adapter has no BC textures.
    if let Some(row) = rows.get(1) {
        assert_eq!(row.setting, "color3 bilinear");
        assert_eq!(row.fetches, Some(40.0));
        assert!(row.psnr_db.is_some_and(|psnr| psnr > 20.0), "{row:?}");
    }
}
