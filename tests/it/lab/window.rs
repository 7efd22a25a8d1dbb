use bevy_frugal_lab::runner::{
    MemoryFigures,
    window::{rows, text},
};

#[test]
fn sides_of_a_name_share_a_row() {
    let figure = |(name, bytes): (&str, u64)| (name.to_string(), bytes);
    let figures = [("a after", 2), ("a before", 1), ("b after", 3), ("c", 4)];
    let figures = MemoryFigures(figures.map(figure).into());
    let rows: Vec<_> = rows(&figures).into_iter().collect();
    let expected = [
        ("a", [Some(1), Some(2)]),
        ("b", [None, Some(3)]),
        ("c", [Some(4), None]),
    ];
    assert_eq!(rows, expected);
}

#[test]
fn large_figures_are_in_mebibytes() {
    assert_eq!(text(1536), "1.5 KiB");
    assert_eq!(text(3 << 19), "1.50 MiB");
}
