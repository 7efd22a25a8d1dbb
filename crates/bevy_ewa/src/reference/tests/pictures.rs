//! Errors of small pictures against the ground truth.

use super::{
    super::{ground_truth::ground_truth, sample::sample, scenes::Surface},
    *,
};

/// Returns the mean squared error of linear values in squared 8-bit units, and the mean fetches per
/// pixel.
fn error(surface: &Surface, method: EwaMethod) -> (f64, f64) {
    const SIZE: u32 = 24;
    let texture = Texture::from_fn([256, 256], |x, y| {
        let v = if (x / 32 + y / 32) % 2 == 0 { 0.9 } else { 0.1 };
        [v, v, v, 1.0]
    });
    let settings = EwaSettings::with_method(method);
    let (mut sum, mut fetches) = (0.0, 0);
    for y in 0..SIZE {
        for x in 0..SIZE {
            let (uv, derivatives) = surface.pixel(SIZE, [x, y]);
            let found = sample(&texture, uv, derivatives, &settings, 0);
            let wanted = ground_truth(&texture, surface, SIZE, [x, y], settings.kernel, 24);
            sum += ((found.color[0] - wanted[0]) * 255.0).powi(2);
            fetches += found.fetches;
        }
    }
    let pixels = f64::from(SIZE * SIZE);
    (sum / pixels, f64::from(fetches) / pixels)
}

#[test]
fn the_methods_are_ordered_on_grazing_planes() {
    for rotation in [0.0f64, 45.0] {
        let surface = Surface::Plane {
            grazing_angle: 5f64.to_radians(),
            tan_half_fov: 3f64.to_radians().tan(),
            rotation: rotation.to_radians(),
            scale: 0.5,
            camera_position: 0.0,
        };
        let approximate = EwaMethod::Approximate { probes: FIVE };
        let [linear, bilinear, approximate, hardware, trilinear] = [
            EwaMethod::Linear,
            EwaMethod::Bilinear,
            approximate,
            EwaMethod::SoftwareAnisotropic,
            EwaMethod::Hardware,
        ]
        .map(|method| error(&surface, method));
        println!("{rotation}: {linear:?} {bilinear:?} {approximate:?} {hardware:?} {trilinear:?}");
        assert!(linear.0 < 10.0);
        assert!(bilinear.0 < 1.5 * linear.0 + 3.0 && bilinear.1 < linear.1);
        assert!(linear.0 < approximate.0 && approximate.0 < hardware.0);
        assert!(linear.0 < trilinear.0);
    }
}

#[test]
fn derivatives_are_continuous_at_the_seam_of_the_tunnel() {
    let surface = Surface::Tunnel {
        tan_half_fov: 1.0,
        around: 4.0,
        along: 0.5,
        camera_position: 0.0,
    };
    // u wraps around between these two pixels.
    let [(above, a), (below, b)] = [[3, 31], [3, 32]].map(|pixel| surface.pixel(64, pixel));
    assert!((above[0] - below[0]).abs() > 3.0);
    assert!((a.dy[0] - b.dy[0]).abs() < 1e-6, "{a:?} {b:?}");
}
