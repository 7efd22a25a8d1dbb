//! What a linear prediction of the detail bands of one map of a material from those of another would save.
//!
//! `cargo test --release -p bevy_wavelet_tex --no-default-features --features cli --test map_prediction --
//! --ignored --nocapture` prints the table of the materials in `../shared/data/game`.

use std::path::Path;

use bevy_wavelet_tex::codec::{
    color::ycocg_from_rgb,
    haar::haar,
    plane::Plane,
    predict::{best_predictor, predicted, slopes},
};

/// The three detail bands of a plane, without what the codec predicts from the plane's own low band.
type Bands = [Vec<f64>; 3];

/// Mean squared error of 40 dB, in units of the planes: coefficients below it need no bits.
const ERROR_40_DB: f64 = 1e-4;

fn bands(plane: &Plane, size: [u32; 2]) -> Bands {
    let half = size.map(|s| s / 2);
    let quad = |x, y| haar(plane.quad(x, y));
    let low = Plane::from_fn(half, |x, y| quad(x, y).ll / 2.0);
    let pairs = Plane::positions(half).map(|(x, y)| (slopes(&low, x, y), quad(x, y).details));
    let predictor = best_predictor(pairs);
    let residual = |band: usize| {
        let value = |(x, y)| {
            let own = predicted(&low, x, y, predictor);
            f64::from(quad(x, y).details[band] - own[band])
        };
        Plane::positions(half).map(value).collect()
    };
    [residual(0), residual(1), residual(2)]
}

/// The variance of `target`, and what is left of it by the best linear prediction from `sources` (least
/// squares, all of zero mean).
fn variances(target: &[f64], sources: &[&[f64]]) -> [f64; 2] {
    let n = target.len() as f64;
    let mean = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / n;
    let variance = mean(target, target);
    // Gram-Schmidt: each source explains what the ones before it did not.
    let mut left = target.to_vec();
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for source in sources {
        let scale = mean(source, source);
        let mut direction = source.to_vec();
        for other in &basis {
            let weight = mean(&direction, other) / mean(other, other);
            remove(&mut direction, other, weight);
        }
        // A source that the ones before explain has rounding errors alone.
        if mean(&direction, &direction) > 1e-9 * scale {
            let weight = mean(&left, &direction) / mean(&direction, &direction);
            remove(&mut left, &direction, weight);
            basis.push(direction);
        }
    }
    [variance, mean(&left, &left)]
}

fn remove(from: &mut [f64], direction: &[f64], weight: f64) {
    from.iter_mut()
        .zip(direction)
        .for_each(|(v, d)| *v -= weight * d);
}

/// Bits that a coefficient takes less, at the same mean squared error.
fn saved_bits([variance, left]: [f64; 2], error: f64) -> f64 {
    match variance > error {
        true => 0.5 * (variance / left.max(error)).log2(),
        false => 0.0,
    }
}

#[test]
fn known_correlations_are_found() {
    // Orthogonal by their parity and its half.
    let a: Vec<f64> = (0..64).map(|i| [1.0, -1.0][i % 2]).collect();
    let b: Vec<f64> = (0..64).map(|i| [1.0, -1.0][i / 2 % 2]).collect();
    let target: Vec<f64> = a.iter().zip(&b).map(|(a, b)| 0.6 * a + 0.8 * b).collect();
    let close = |found: [f64; 2], expected: [f64; 2]| {
        let near = |(a, b): (f64, f64)| (a - b).abs() < 1e-12;
        assert!(found.into_iter().zip(expected).all(near), "{found:?}");
    };
    close(variances(&target, &[&a]), [1.0, 0.64]);
    close(variances(&target, &[&b, &b]), [1.0, 0.36]);
    close(variances(&target, &[&target, &a]), [1.0, 0.0]);
    assert_eq!(saved_bits([1.0, 0.25], 0.0), 1.0);
    assert_eq!(saved_bits([1.0, 0.01], 0.25), 1.0);
    assert_eq!(saved_bits([0.2, 0.1], 0.25), 0.0);
}

/// A map: its planes in units of a channel, with their names.
fn map(path: &Path, names: [&'static str; 3], is_color: bool) -> Vec<(&'static str, Bands)> {
    let image = image::open(path).expect("an image").into_rgb8();
    let size = image.dimensions().into();
    let pixel = |x, y| image.get_pixel(x, y).0.map(|v| f32::from(v) / 255.0);
    let plane = |c: usize| {
        Plane::from_fn(size, |x, y| {
            let color = ycocg_from_rgb(pixel(x, y));
            match is_color {
                true => [color.y, color.co, color.cg][c],
                false => pixel(x, y)[c],
            }
        })
    };
    let named = names.into_iter().enumerate().filter(|(_, n)| !n.is_empty());
    named
        .map(|(c, name)| (name, bands(&plane(c), size)))
        .collect()
}

#[test]
#[ignore = "a measurement, which prints a table"]
fn table_of_the_materials() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/game");
    println!(
        "r2 of HL, LH, HH; bits per pixel saved without an error, at 40 dB, by weights of 32 x 32 at 40 dB"
    );
    let materials = [
        "GlassPlastic",
        "LeatherParts",
        "Lenses",
        "MetalParts",
        "RubberWood",
    ];
    let mut sums = [0.0; 3];
    for material in materials {
        let file =
            |map: &str| folder.join(format!("FlightHelmet_Materials_{material}Mat_{map}.png"));
        if !file("Normal").exists() {
            println!("skipped: {} is not there", file("Normal").display());
            return;
        }
        let base = map(&file("BaseColor"), ["Y", "Co", "Cg"], true);
        let normal = map(&file("Normal"), ["X", "Y", ""], false);
        let data = map(
            &file("OcclusionRoughMetal"),
            ["occlusion", "roughness", "metallic"],
            false,
        );
        let mut total = [0.0; 3];
        for (targets, sources) in [(&normal, vec![&base]), (&data, vec![&base, &normal])] {
            let sources: Vec<&Bands> = sources.into_iter().flatten().map(|(_, b)| b).collect();
            for (name, target) in targets {
                // A flat map of a few pixels predicts nothing and needs no prediction.
                let same = |source: &&Bands| source[0].len() == target[0].len();
                let sources: Vec<&Bands> = sources.iter().copied().filter(same).collect();
                let (r2, saved) = row(target, &sources);
                let r2 = r2.map(|r2| format!("{r2:>7.3}")).concat();
                let cells = saved.map(|s| format!("{s:>8.3}")).concat();
                println!("{material:13} {name:10}{r2}{cells}");
                (0..3).for_each(|i| total[i] += saved[i]);
            }
        }
        let cells = total.map(|s| format!("{s:>8.3}")).concat();
        println!("{material:13} all maps  {:21}{cells}", "");
        (0..3).for_each(|i| sums[i] += total[i] / materials.len() as f64);
    }
    println!(
        "mean {:40}{}",
        "",
        sums.map(|s| format!("{s:>8.3}")).concat()
    );
    // The decision not to predict one map from another.
    assert!(sums[1] < 0.5, "{sums:?}");
}

/// The part of the variance of each band that is predicted, and the bits per pixel saved: a quarter of a
/// plane's coefficients is in each band.
fn row(target: &Bands, sources: &[&Bands]) -> ([f64; 3], [f64; 3]) {
    let mut saved = [0.0; 3];
    let r2 = [0, 1, 2].map(|band| {
        let sources: Vec<&[f64]> = sources.iter().map(|s| s[band].as_slice()).collect();
        let target = target[band].as_slice();
        let [variance, left] = variances(target, &sources);
        saved[0] += 0.25 * saved_bits([variance, left], 0.0);
        saved[1] += 0.25 * saved_bits([variance, left], ERROR_40_DB);
        let blocks = blocks(target.len());
        let of = |values: &[f64], block: &[usize]| -> Vec<f64> {
            block.iter().map(|i| values[*i]).collect()
        };
        for block in &blocks {
            let sources: Vec<Vec<f64>> = sources.iter().map(|s| of(s, block)).collect();
            let sources: Vec<&[f64]> = sources.iter().map(Vec::as_slice).collect();
            let local = variances(&of(target, block), &sources);
            saved[2] += 0.25 * saved_bits(local, ERROR_40_DB) / blocks.len() as f64;
        }
        if variance > 0.0 {
            1.0 - left / variance
        } else {
            0.0
        }
    });
    (r2, saved)
}

/// The indices of the coefficients of a square image in each square of 32 x 32.
fn blocks(count: usize) -> Vec<Vec<usize>> {
    let side = count.isqrt();
    assert_eq!(side * side, count, "a square map");
    let columns = side / 32;
    let block = |b: usize| {
        let (left, top) = (b % columns * 32, b / columns * 32);
        let index = |i: usize| (top + i / 32) * side + left + i % 32;
        (0..32 * 32).map(index).collect()
    };
    (0..columns * columns).map(block).collect()
}
