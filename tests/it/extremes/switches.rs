//! Hundreds of switches, with all plugins in one app.

use std::ops::Range;

use bevy_frugal_lab::headless::HeadlessApp;

use super::stage::{app, difference, picture, switch};
use crate::support::gpu_alone;

/// Memory of this process in bytes, where the system tells; on a software driver that of the GPU
/// is part of it.
fn resident_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/statm").ok()?;
    let pages: u64 = text.split(' ').nth(1)?.parse().ok()?;
    Some(4096 * pages)
}

/// All combinations, in an order that has no system.
fn combination(step: u32) -> [bool; 4] {
    let bits = step.wrapping_mul(2_654_435_761) >> 28;
    [0, 1, 2, 3].map(|i| bits >> i & 1 == 1)
}

#[test]
fn hundreds_of_switches_leave_nothing_behind() {
    let _gpu = gpu_alone();
    let mut app = app([32, 16], [16, 16]);
    app.run_until_ready(200).expect("ready");
    let toggle = |app: &mut HeadlessApp, steps: Range<u32>| {
        for step in steps {
            switch(app.world_mut(), combination(step));
            app.render_frames(1).expect("a frame");
        }
        switch(app.world_mut(), [false; 4]);
        picture(app, 4)
    };
    // Pipelines, caches and pools are made once.
    let before = toggle(&mut app, 0..200);
    let entities = app.world().entities().count_spawned();
    let memory = resident_bytes();
    let after = toggle(&mut app, 200..700);
    assert_eq!(app.world().entities().count_spawned(), entities);
    let found = difference(&before, &after);
    assert!(
        found == 0.0,
        "the picture without plugins has changed: {found}"
    );
    if let (Some(before), Some(after)) = (memory, resident_bytes()) {
        let growth = after.saturating_sub(before);
        println!("{} KiB more after 500 switches", growth / 1024);
        assert!(growth < 16 << 20, "{} KiB more", growth / 1024);
    }
}
