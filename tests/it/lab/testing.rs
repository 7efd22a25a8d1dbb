use std::collections::BTreeSet;

use bevy_frugal_lab::testing::draw;

#[test]
fn seeds_draw_all_rows_in_time_and_each_the_same_again() {
    let of = |seed: u32| draw(&seed.to_string(), Some("a test"), 3, 10);
    let all: BTreeSet<_> = (0..40).flat_map(of).collect();
    assert_eq!(all.len(), 10);
    for seed in 0..40 {
        let rows: BTreeSet<_> = of(seed).into_iter().collect();
        assert_eq!(rows.len(), 3);
        assert_eq!(of(seed), of(seed));
    }
    assert_eq!(draw("7", None, 3, 2).len(), 2);
}
