// The weight of a texel (thesis 2.1.5). As `reference::kernel`.
#define_import_path bevy_ewa::kernel

#import bevy_ewa::types::{KERNEL_BOX, KERNEL_TENT, KERNEL_GAUSSIAN, KERNEL_MITCHELL_NETRAVALI}

const PI: f32 = 3.14159265;
// Value of a Gaussian at twice its standard deviation.
const GAUSSIAN_EDGE: f32 = 0.13533528;

// At a squared distance from the centre in squares of the kernel's radius; 0 outside of 0 to 1.
fn weight(kernel: u32, distance_squared: f32) -> f32 {
    if distance_squared >= 1.0 {
        return 0.0;
    }
    let q = max(distance_squared, 0.0);
    if kernel == KERNEL_GAUSSIAN {
        return exp(-2.0 * q) - GAUSSIAN_EDGE;
    }
    if kernel == KERNEL_BOX {
        return 1.0;
    }
    let distance = sqrt(q);
    if kernel == KERNEL_TENT {
        return 1.0 - distance;
    }
    if kernel == KERNEL_MITCHELL_NETRAVALI {
        return mitchell_netravali(2.0 * distance);
    }
    return sinc(2.0 * distance) * sinc(distance);
}

fn mitchell_netravali(x: f32) -> f32 {
    if x < 1.0 {
        return (7.0 * x * x * x - 12.0 * x * x + 16.0 / 3.0) / 6.0;
    }
    return (-7.0 / 3.0 * x * x * x + 12.0 * x * x - 20.0 * x + 32.0 / 3.0) / 6.0;
}

fn sinc(x: f32) -> f32 {
    if abs(x) < 1e-4 {
        return 1.0;
    }
    return sin(PI * x) / (PI * x);
}
