//! Every ray ends: rays along borders, with components near zero or not finite, through a volume full
//! of surfaces that many of them only pass.
//!
//! Mesa 22's software driver ends every loop after 65,536 iterations by itself; later ones and GPUs do not.

use proptest::{
    prelude::*,
    strategy::ValueTree,
    test_runner::{Config, RngAlgorithm, TestRng, TestRunner},
};

use crate::support::{
    compose::Composer,
    compute::{Binding, dispatch},
    gpu,
};

const RESOLUTION: u32 = 16;
const RAYS: u32 = 64 * 256;
/// In voxels: as far as the volume is wide.
const REACH: f32 = 32.0;
const NOTHING: u32 = u32::MAX;

const SHADER: &str = "
import bevy_voxel_gi::shaders::trace::trace;

struct Ray {
    origin: vec4<f32>,
    direction: vec4<f32>,
}

struct End {
    index: u32,
    distance: f32,
}

@group(1) @binding(0) var<storage, read_write> ends: array<End>;
@group(1) @binding(1) var<storage, read> rays: array<Ray>;

@compute @workgroup_size(64)
fn trace_all(@builtin(global_invocation_id) id: vec3<u32>) {
    let ray = rays[id.x];
    let hit = trace(0u, ray.origin.xyz, ray.direction.xyz, ray.origin.w);
    ends[id.x] = End(hit.index, hit.distance);
}
";

/// One level at the origin with voxels of a metre; the fields are those of `Volume`.
fn volume() -> Vec<u8> {
    let mut words = vec![0u32; 11 * 16];
    words[3] = 1f32.to_bits();
    words.extend([RESOLUTION, 1, 1]);
    words.resize(words.len() + 17, 0);
    bytemuck::cast_slice(&words).to_vec()
}

fn word(runner: &mut TestRunner) -> u32 {
    runner.rng().next_u32()
}

/// A coordinate at a border of a voxel or sub-voxel, near one, or anywhere.
fn coordinate() -> impl Strategy<Value = f32> {
    let border = (0..=4 * RESOLUTION).prop_map(|n| n as f32 * 0.25);
    let off = prop_oneof![
        Just(0.0f32),
        Just(1e-7),
        Just(-1e-7),
        Just(1e-6),
        Just(-1e-6),
        Just(4e-6),
        -0.25f32..0.25
    ];
    prop_oneof![
        20 => (border, off).prop_map(|(border, off)| border + off),
        1 => prop_oneof![
            Just(f32::NAN), Just(f32::INFINITY), Just(-1e30f32), Just(1e7f32)
        ],
    ]
}

/// A component of a direction: of any size, and what no direction has.
fn component() -> impl Strategy<Value = f32> {
    prop_oneof![
        8 => -1.0f32..1.0,
        8 => (-8.0f32..0.0, any::<bool>())
            .prop_map(|(power, negative)| 10f32.powf(power) * if negative { -1.0 } else { 1.0 }),
        4 => prop_oneof![Just(0.0f32), Just(-0.0), Just(1.0), Just(-1.0)],
        1 => prop_oneof![Just(f32::NAN), Just(f32::INFINITY), Just(1e-40f32), Just(1e30)],
    ]
}

fn normalized(v: [f32; 3]) -> [f32; 3] {
    let length = v.iter().map(|x| x * x).sum::<f32>().sqrt();
    if length > 1e-20 && length.is_finite() {
        v.map(|x| x / length)
    } else {
        v
    }
}

/// A ray that leaves a sub-voxel so slowly along one axis that rounding keeps it at the border: just
/// above one, downwards.
fn creeping() -> impl Strategy<Value = ([f32; 3], [f32; 3])> {
    let border = (1..4 * RESOLUTION).prop_map(|n| n as f32 * 0.25);
    (
        [border.clone(), border.clone(), border],
        [-0.25f32..0.25, -0.25f32..0.25, -0.25f32..0.25],
        [-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0],
        (0..3usize, 1..4u32, -5.5f32..-3.0),
    )
        .prop_map(|(border, off, mut direction, (axis, ulps, power))| {
            let mut origin = [0, 1, 2].map(|i| border[i] + off[i]);
            origin[axis] = f32::from_bits(border[axis].to_bits() + ulps);
            direction[axis] = -(10f32.powf(power));
            (origin, direction)
        })
}

#[test]
fn every_ray_ends() {
    let _gpu = gpu();
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]);
    let mut runner = TestRunner::new_with_rng(Config::default(), rng);
    let ray = prop_oneof![
        (
            [coordinate(), coordinate(), coordinate()],
            [component(), component(), component()],
        ),
        creeping(),
    ];
    let mut rays: Vec<[f32; 8]> = Vec::new();
    for _ in 0..RAYS {
        let tree = ray.new_tree(&mut runner).expect("a ray");
        let ([x, y, z], direction) = tree.current();
        let [dx, dy, dz] = normalized(direction);
        rays.push([x, y, z, REACH, dx, dy, dz, 0.0]);
    }
    let voxels = RESOLUTION.pow(3) as usize;
    // Only what is free in front has a surface that a ray can graze.
    let masks: Vec<u32> = (0..2 * voxels)
        .map(|_| word(&mut runner) & word(&mut runner))
        .collect();
    // All faces have surfaces; slot 0 is that of none.
    let packed_surfaces: Vec<u32> = (0..=6 * voxels)
        .map(|slot| (word(&mut runner) | 1 << 24) * u32::from(slot > 0))
        .collect();
    let face_slots: Vec<u32> = (0..voxels as u32)
        .map(|voxel| (6 * voxel + 1) << 7 | 63)
        .collect();
    let mut composer = Composer::of_crate("bevy_voxel_gi");
    let source = composer
        .compose_source(SHADER, &[])
        .unwrap_or_else(|error| panic!("{error}"));
    let output = dispatch(
        &source,
        &[
            Binding::Uniform(&volume()),
            Binding::Storage(bytemuck::cast_slice(&masks)),
            Binding::Storage(bytemuck::cast_slice(&packed_surfaces)),
            Binding::Storage(bytemuck::cast_slice(&face_slots)),
        ],
        bytemuck::cast_slice(&rays),
        u64::from(RAYS) * 8,
        RAYS / 64,
    );
    let mut hits = 0;
    for (end, ray) in output.chunks_exact(8).zip(&rays) {
        let word = |at: usize| u32::from_le_bytes([0, 1, 2, 3].map(|i| end[at + i]));
        if word(0) == NOTHING {
            continue;
        }
        hits += 1;
        assert!((word(0) as usize) < voxels, "{ray:?}");
        let distance = f32::from_bits(word(4));
        assert!((-1e-3..=REACH).contains(&distance), "{ray:?}: {distance}");
    }
    assert!(hits > RAYS / 2, "{hits}");
}
