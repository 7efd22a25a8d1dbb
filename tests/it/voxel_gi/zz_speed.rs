use super::scene::{app_with, block, matt, settings, under_sky};
use crate::support::gpu;
use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};
use bevy_voxel_gi::VoxelGiVolume;

fn terrain(n: u32, size: f32) -> Mesh {
    let mut positions = Vec::new();
    for z in 0..=n {
        for x in 0..=n {
            let p = Vec2::new(x as f32, z as f32) / n as f32 * size - 0.5 * size;
            positions.push([p.x, -1.0 + 0.4 * (p.x * 1.3).sin() * (p.y * 0.9).cos(), p.y]);
        }
    }
    let mut indices = Vec::new();
    for z in 0..n {
        for x in 0..n {
            let a = z * (n + 1) + x;
            let b = a + n + 1;
            indices.extend([a, b, a + 1, a + 1, b, b + 1]);
        }
    }
    Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::default(),
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
    .with_inserted_indices(Indices::U32(indices))
    .with_computed_normals()
}

#[test]
fn zz_speed() {
    let _gpu = gpu();
    for (n, many) in [(96, false), (512, false), (128, true)] {
        let mut app = app_with(|_| ());
        let world = app.world_mut();
        let material = matt(world, 0.5);
        let tiles = if many { 4 } else { 1 };
        let size = 14.0 / tiles as f32;
        let mesh = world.resource_mut::<Assets<Mesh>>().add(terrain(n, size));
        for x in 0..tiles {
            for z in 0..tiles {
                let at = Vec3::new(
                    (x as f32 + 0.5) * size - 7.0,
                    0.0,
                    (z as f32 + 0.5) * size - 7.0,
                );
                world.spawn((
                    Mesh3d(mesh.clone()),
                    MeshMaterial3d(material.clone()),
                    Transform::from_translation(at),
                ));
            }
        }
        let mover = block(world, Vec3::new(0.0, 0.5, 0.0), Vec3::splat(1.0));
        settings(world).resolution = 32;
        settings(world).pause_when_settled = false;
        world.spawn(VoxelGiVolume {
            size: 16.0,
            ..under_sky(1.0)
        });
        app.run_until_ready(200).unwrap();
        app.render_frames(5).unwrap();
        for mode in ["still", "moving", "whole", "still", "moving", "whole"] {
            let mut sums = std::collections::BTreeMap::<String, Vec<f64>>::new();
            let mut cpu = Vec::new();
            for frame in 0..8 {
                let world = app.world_mut();
                if mode != "still" {
                    world.get_mut::<Transform>(mover).unwrap().translation.x = 0.1 * frame as f32;
                }
                if mode == "whole" {
                    let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
                    materials.get_mut(&material).unwrap().base_color =
                        Color::linear_rgb(0.5 + 0.01 * frame as f32, 0.5, 0.5);
                }
                let begin = std::time::Instant::now();
                let (_, spans) = app.measure_spans(1).unwrap();
                cpu.push(begin.elapsed().as_secs_f64() * 1e3);
                for (name, ms) in spans {
                    sums.entry(name).or_default().push(ms);
                }
            }
            let median = |v: &mut Vec<f64>| {
                v.sort_by(f64::total_cmp);
                v[v.len() / 2]
            };
            let mut all = 0.0;
            let text: Vec<_> = sums
                .iter_mut()
                .filter(|(name, _)| name.contains("voxel_gi"))
                .map(|(name, v)| {
                    let m = median(v);
                    all += m;
                    format!("{} {m:.2}", name.replace("voxel_gi_", ""))
                })
                .collect();
            println!("ZZ {n} {many} {mode}: {all:.1} ms; {}", text.join(", "));
        }
    }
}
