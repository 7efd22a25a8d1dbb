//! The shaders compute what the reference computes.

use bevy_ewa::{
    EwaKernel, EwaLevelOfDetail, EwaMethod, EwaProbes, EwaSettings,
    reference::{AddressMode, Derivatives, Texture, sample},
};
use bevy_frugal_lab::{
    lookups::{
        Lookups, TexelFormat, linear_error,
        scenes::{Pixels, SCENES, computed_picture, display},
    },
    metrics::max_error,
};

use crate::support::{gpu, skipped};

const FIVE: EwaProbes = EwaProbes::Five;

const METHODS: [EwaMethod; 9] = [
    EwaMethod::Reference,
    EwaMethod::Linear,
    EwaMethod::Bilinear,
    EwaMethod::Approximate { probes: FIVE },
    EwaMethod::Spatial { probes: FIVE },
    EwaMethod::Temporal { probes: FIVE },
    EwaMethod::SpatialTemporal { probes: FIVE },
    EwaMethod::Stochastic,
    EwaMethod::SoftwareAnisotropic,
];

fn rgb(picture: &[[f32; 4]]) -> Pixels {
    let colors = picture.iter().map(|p| [p[0], p[1], p[2]].map(f64::from));
    colors.collect()
}

#[test]
fn the_reference_is_within_two_levels_of_its_double_everywhere_on_every_scene() {
    let _gpu = gpu();
    const SIZE: u32 = 64;
    let settings = EwaSettings::with_method(EwaMethod::Reference);
    for scene in &SCENES {
        let texture = (scene.texture)();
        let coordinates = scene.coordinates(SIZE);
        let lookups = Lookups::new(SIZE, &texture, TexelFormat::Float32, 1, &coordinates);
        let picture = lookups.expect("an app").picture(&settings, 0);
        let picture = rgb(&picture.expect("a picture"));
        let expected = computed_picture(&texture, &coordinates, SIZE, &settings, 0).0;
        let actual = max_error(&display(&expected, SIZE), &display(&picture, SIZE));
        println!("{}: {actual:?} levels", scene.name);
        assert!(
            actual.expect("equal sizes") <= 2,
            "{}: {actual:?}",
            scene.name
        );
    }
}

#[test]
fn pairs_of_texels_are_as_good_as_single_ones() {
    let _gpu = gpu();
    let [linear, reference] =
        [EwaMethod::Linear, EwaMethod::Reference].map(EwaSettings::with_method);
    for scene in &SCENES {
        let actual = linear_error(scene, 48, [&linear, &reference], TexelFormat::Float32);
        let actual = actual.expect("a picture");
        println!("{}: {actual:.6}", scene.name);
        // The budget counts texels, so that it is the same for both.
        assert!(actual < 0.01, "{}: {actual}", scene.name);
    }
}

/// Numbers that are the same in every run, from 0 to 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = (self.0 ^ self.0 >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        (self.0 >> 40) as f64 / f64::from(1 << 24)
    }
}

fn noise(size: [u32; 2]) -> Texture {
    let random = std::cell::RefCell::new(Random(u64::from(size[0])));
    Texture::from_fn(size, |_, _| [0; 4].map(|_| random.borrow_mut().next()))
}

fn rounded(c: [f64; 2]) -> [f64; 2] {
    c.map(|c| f64::from(c as f32))
}

/// Ellipses of every size, shape and direction.
fn random_lookups(count: u32, uv_range: f64) -> Vec<([f64; 2], Derivatives)> {
    let mut random = Random(7);
    (0..count)
        .map(|_| {
            let uv = [0, 1].map(|_| (random.next() * 2.0 - 1.0) * uv_range);
            let major = (random.next() * 14.0 - 10.0).exp2();
            let minor = major / (random.next() * 9.0).exp2();
            let (sin, cos) = (random.next() * 6.3).sin_cos();
            let dx = rounded([major * cos, major * sin]);
            let dy = rounded([-minor * sin, minor * cos]);
            (rounded(uv), Derivatives { dx, dy })
        })
        .collect()
}

/// For each lookup the difference from the reference, in levels of 8 bits, and where it is.
fn differences(
    texture: &Texture,
    lookups: &mut Lookups,
    coordinates: &[([f64; 2], Derivatives)],
    settings: &EwaSettings,
) -> Vec<(f64, String)> {
    let picture = lookups.picture(settings, 1).expect("a picture");
    let pairs = coordinates.iter().zip(&picture);
    pairs
        .map(|((uv, derivatives), actual)| {
            let expected = sample(texture, *uv, *derivatives, settings, 1).color;
            let channels = actual.iter().zip(expected);
            let errors =
                channels.map(|(actual, expected)| (f64::from(*actual) - expected).abs() * 255.0);
            // A NaN is worse than everything.
            let worst = errors.map(|e| if e.is_nan() { f64::INFINITY } else { e });
            let place = format!("{uv:?} {derivatives:?}: {actual:?} for {expected:?}");
            (worst.fold(0.0, f64::max), place)
        })
        .collect()
}

/// An app that looks up the coordinates of a square picture.
fn lookups(texture: &Texture, coordinates: &[([f64; 2], Derivatives)]) -> Lookups {
    let size = coordinates.len().isqrt() as u32;
    let lookups = Lookups::new(size, texture, TexelFormat::Float32, 1, coordinates);
    lookups.expect("an app")
}

/// Demands that the largest difference is at most two levels, for each of the settings. Returns the app.
fn check(
    name: &str,
    texture: &Texture,
    coordinates: &[([f64; 2], Derivatives)],
    settings: impl IntoIterator<Item = EwaSettings>,
) -> Lookups {
    let mut lookups = lookups(texture, coordinates);
    for settings in settings {
        let all = differences(texture, &mut lookups, coordinates, &settings);
        let worst = all.into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
        let (error, place) = worst.expect("lookups");
        println!("{name}, {settings:?}: {error:.3}");
        assert!(error <= 2.0, "{name}, {settings:?}: {error} at {place}");
    }
    lookups
}

fn all_methods() -> impl Iterator<Item = EwaSettings> {
    METHODS.into_iter().map(EwaSettings::with_method)
}

#[test]
fn every_method_is_within_two_levels_of_the_reference_for_every_ellipse() {
    let _gpu = gpu();
    const SIZE: u32 = 48;
    for (size, address) in [
        ([64, 64], AddressMode::Repeat),
        ([37, 20], AddressMode::MirrorRepeat),
        ([50, 3], AddressMode::ClampToEdge),
        ([1, 1], AddressMode::Repeat),
    ] {
        let texture = noise(size).with_address([address; 2]);
        let coordinates = random_lookups(SIZE * SIZE, 2.0);
        let name = format!("{size:?} {address:?}");
        check(&name, &texture, &coordinates, all_methods());
    }
}

#[test]
fn every_kernel_and_level_of_detail_is_within_two_levels_of_the_reference() {
    let _gpu = gpu();
    const SIZE: u32 = 32;
    let texture = noise([64, 64]);
    let coordinates = random_lookups(SIZE * SIZE, 2.0);
    let base = EwaSettings::with_method(EwaMethod::Linear);
    let mut settings = vec![
        EwaSettings {
            minor_radius_texels: 3.0,
            max_anisotropy: 64.0,
            ..base
        },
        EwaSettings {
            max_fetches: 64,
            ..base
        },
        EwaSettings {
            level_blend: 1.0,
            ..base
        },
        // Where the formula of the hardware steps from one count to the next, 32 bits may take either.
        EwaSettings {
            level_of_detail: EwaLevelOfDetail::Hardware,
            ..base
        },
    ];
    for kernel in [
        EwaKernel::Tent,
        EwaKernel::Gaussian { sigma_pixels: 0.8 },
        EwaKernel::MitchellNetravali,
        EwaKernel::Lanczos,
    ] {
        settings.push(EwaSettings { kernel, ..base });
    }
    for probes in [EwaProbes::Three, EwaProbes::Seven, EwaProbes::ByAspect] {
        settings.push(EwaSettings::with_method(EwaMethod::Approximate { probes }));
    }
    let mut lookups = check("noise", &texture, &coordinates, settings);
    // A box has an edge, where 32 bits may find a texel on the other side.
    let cut = EwaSettings {
        kernel: EwaKernel::Box,
        ..base
    };
    let all = differences(&texture, &mut lookups, &coordinates, &cut);
    let off = all.iter().filter(|(error, _)| *error > 2.0).count();
    println!("box: {off} of {} lookups", all.len());
    assert!(off * 100 < all.len(), "box: {off} of {}", all.len());
}

#[test]
fn nothing_breaks_the_shaders() {
    let _gpu = gpu();
    const SIZE: u32 = 32;
    let values = [
        [0.0, 1e-30, 1e-6, 0.3, -0.3, 1e6, 1e30].as_slice(),
        &[f64::INFINITY, f64::NEG_INFINITY, f64::NAN],
        &[f64::from(f32::MAX)],
    ]
    .concat();
    let mut random = Random(3);
    let mut any = |values: &[f64]| values[(random.next() * values.len() as f64) as usize];
    let coordinates: Vec<_> = (0..SIZE * SIZE)
        .map(|i| {
            let mut two = || rounded([any(&values), any(&values)]);
            let (dx, dy) = (two(), two());
            let uv = if i % 8 == 0 {
                two()
            } else {
                rounded([0.3, 0.6])
            };
            (uv, Derivatives { dx, dy })
        })
        .collect();
    let texture = noise([32, 16]);
    let mut lookups = lookups(&texture, &coordinates);
    for method in METHODS {
        let settings = EwaSettings::with_method(method);
        let picture = lookups.picture(&settings, 0).expect("a picture");
        for (pixel, coordinates) in picture.iter().zip(&coordinates) {
            let is_color = pixel.iter().all(|c| (-0.01..=1.01).contains(c));
            assert!(is_color, "{method:?} {coordinates:?}: {pixel:?}");
        }
    }
}

#[test]
fn far_coordinates_keep_their_texels() {
    let _gpu = gpu();
    const SIZE: u32 = 32;
    let texture = noise([1024, 16]);
    // Texel centres that 32-bit floats have at 1e4: multiples of 1/1024.
    let mut coordinates = random_lookups(SIZE * SIZE, 1.0);
    for (i, (uv, d)) in coordinates.iter_mut().enumerate() {
        *uv = [1e4 + i as f64 / 1024.0, -9998.0 + 3.0 / 32.0];
        *d = Derivatives {
            dx: [1.5 / 1024.0, 0.0],
            dy: [0.0, 0.05],
        };
    }
    check("far", &texture, &coordinates, all_methods());
}

#[test]
fn textures_as_large_as_they_come_are_within_two_levels_of_the_reference() {
    let _gpu = gpu();
    const SIZE: u32 = 32;
    for size in [[8192, 8], [2048, 256]] {
        let texture = noise(size);
        // From a texel to the whole texture.
        let coordinates = random_lookups(SIZE * SIZE, 1.0);
        let methods = [
            EwaMethod::Linear,
            EwaMethod::Bilinear,
            EwaMethod::Approximate { probes: FIVE },
            EwaMethod::Spatial { probes: FIVE },
        ];
        let settings = methods.map(EwaSettings::with_method);
        let name = format!("{size:?}");
        check(&name, &texture, &coordinates, settings);
    }
}

#[test]
fn beyond_the_border_is_what_the_border_is() {
    let _gpu = gpu();
    const SIZE: u32 = 32;
    let border = AddressMode::ClampToBorder;
    let texture = noise([40, 24]).with_address([border; 2]);
    let coordinates = random_lookups(SIZE * SIZE, 1.5);
    let feature = wgpu::Features::ADDRESS_MODE_CLAMP_TO_BORDER;
    let features = lookups(&texture, &coordinates).app().features();
    if !features.contains(feature) {
        skipped("EWA at borders: the adapter has no border addressing");
        return;
    }
    let settings = all_methods().map(|settings| EwaSettings {
        periodic: false,
        ..settings
    });
    check("border", &texture, &coordinates, settings);
}
