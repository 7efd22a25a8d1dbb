//! The shaders compute what the reference computes.

use bevy_ewa::{
    EwaMethod, EwaProbes, EwaSettings,
    reference::{Derivatives, Texture, sample, scenes::Surface},
};
use bevy_frugal_lab::tradeoff::ewa::lookup::{Lookups, TexelFormat};

use crate::support::gpu;

const SIZE: u32 = 64;

fn checker() -> Texture {
    Texture::from_fn([256, 256], |x, y| {
        let v = f64::from(u8::from((x / 32 + y / 32) % 2 == 0));
        [v, v * 0.5, 1.0 - v, 1.0]
    })
}

#[test]
fn tunnel() {
    let _gpu = gpu();
    let surface = Surface::Tunnel {
        half_view: 1.0,
        around: 4.0,
        along: 0.5,
        moved: 0.0,
    };
    let texture = checker();
    let as_f32 = |c: [f64; 2]| c.map(|c| f64::from(c as f32));
    let coordinates: Vec<_> = (0..SIZE * SIZE)
        .map(|i| surface.pixel(SIZE, [i % SIZE, i / SIZE]))
        .map(|(uv, d)| {
            (
                as_f32(uv),
                Derivatives {
                    dx: as_f32(d.dx),
                    dy: as_f32(d.dy),
                },
            )
        })
        .collect();
    let mut lookups =
        Lookups::new(SIZE, &texture, TexelFormat::Float32, 1, &coordinates).expect("an app");
    let five = EwaProbes::Five;
    for method in [
        EwaMethod::Reference,
        EwaMethod::Linear,
        EwaMethod::Bilinear,
        EwaMethod::Approximate { probes: five },
        EwaMethod::Spatial { probes: five },
        EwaMethod::Temporal { probes: five },
        EwaMethod::SpatialTemporal { probes: five },
        EwaMethod::SoftwareAnisotropic,
        EwaMethod::Hardware,
    ] {
        let settings = EwaSettings::with_method(method);
        let start = std::time::Instant::now();
        let picture = lookups.picture(&settings, 0).expect("a picture");
        let t = start.elapsed();
        let (mut worst, mut at, mut mse) = (0.0f64, 0, 0.0);
        for (i, ((uv, d), found)) in coordinates.iter().zip(&picture).enumerate() {
            let wanted = sample(&texture, *uv, *d, &settings, 0).color;
            for c in 0..3 {
                let e = (f64::from(found[c]) - wanted[c]).abs() * 255.0;
                mse += e * e;
                if !(e <= worst) {
                    worst = e;
                    at = i;
                }
            }
        }
        println!(
            "{method:?}: max {worst:.4} at {},{} mse {:.6} {t:?}",
            at as u32 % SIZE,
            at as u32 / SIZE,
            mse / f64::from(3 * SIZE * SIZE)
        );
    }
}
