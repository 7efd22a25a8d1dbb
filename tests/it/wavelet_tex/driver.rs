//! How the driver decodes BC3: the format leaves the rounding of interpolated values to it.
//!
//! Lavapipe, for one, makes the end points `a` and `b` bytes (bits repeated) and step `w` of `n`
//! between them `a + ((b - a) * (255 * w / n) >> 8)` in integers: up to 1.7 levels off.

use bevy::{
    prelude::*,
    render::renderer::{RenderDevice, RenderQueue},
};
use bevy_frugal_lab::headless::{HeadlessApp, HeadlessSettings};
use bevy_wavelet_tex::codec::blocks::{BlockFormat, decode_bc3};
use wgpu::util::DeviceExt;

use crate::support::gpu;

/// Reads texels without filtering or arithmetic, and apart from the shaders under test.
const SHADER: &str = "
@group(0) @binding(0) var blocks: texture_2d_array<f32>;
@group(0) @binding(1) var<storage, read_write> texels: array<vec4<f32>>;

@compute @workgroup_size(4, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let width = textureDimensions(blocks).x;
    texels[id.y * width + id.x] = textureLoad(blocks, id.xy, 0u, 0u);
}
";

/// The BC3 decoder of the driver.
pub struct Driver(HeadlessApp);

impl Driver {
    pub fn new() -> Self {
        Self(HeadlessApp::new(HeadlessSettings::with_size(16, 16), |_| {}).expect("an adapter"))
    }

    /// As [`decode_bc3`].
    pub fn decode_bc3(&self, blocks: &[u8], size: [u32; 2]) -> Vec<[f32; 4]> {
        self.decode(BlockFormat::Bc3, blocks, size)
    }

    /// As `decode_blocks`.
    pub fn decode(&self, format: BlockFormat, blocks: &[u8], size: [u32; 2]) -> Vec<[f32; 4]> {
        let padded = size.map(|s| s.next_multiple_of(4));
        let format = match format {
            BlockFormat::Bc1 => wgpu::TextureFormat::Bc1RgbaUnorm,
            BlockFormat::Bc3 => wgpu::TextureFormat::Bc3RgbaUnorm,
            BlockFormat::Bc4 => wgpu::TextureFormat::Bc4RUnorm,
            BlockFormat::Bc5 => wgpu::TextureFormat::Bc5RgUnorm,
            BlockFormat::Bc7 => wgpu::TextureFormat::Bc7RgbaUnorm,
        };
        let texels = self.texels(format, blocks, padded);
        let rows = texels.chunks_exact(padded[0] as usize);
        rows.take(size[1] as usize)
            .flat_map(|row| &row[..size[0] as usize])
            .copied()
            .collect()
    }

    /// The linear values that the driver has for the 256 values of sRGB, which lavapipe approximates.
    pub fn linear_from_srgb(&self) -> Vec<f32> {
        let bytes: Vec<u8> = (0..=255).flat_map(|v| [v; 4]).collect();
        let texels = self.texels(wgpu::TextureFormat::Rgba8UnormSrgb, &bytes, [16, 16]);
        texels.into_iter().map(|texel| texel[0]).collect()
    }

    fn texels(
        &self,
        format: wgpu::TextureFormat,
        bytes: &[u8],
        [width, height]: [u32; 2],
    ) -> Vec<[f32; 4]> {
        let device = self.0.world().resource::<RenderDevice>().wgpu_device();
        let queue = self.0.world().resource::<RenderQueue>();
        let descriptor = wgpu::TextureDescriptor {
            label: Some("raw_blocks"),
            size: wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        };
        let order = wgpu::util::TextureDataOrder::LayerMajor;
        let texture = device.create_texture_with_data(queue, &descriptor, order, bytes);
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..default()
        });
        let buffer = |usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("raw_texels"),
                size: u64::from(width * height) * 16,
                usage,
                mapped_at_creation: false,
            })
        };
        let written = buffer(wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
        let read = buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);

        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("raw_texels"),
            source: wgpu::ShaderSource::Wgsl(SHADER.into()),
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("raw_texels"),
            layout: None,
            module: &module,
            entry_point: None,
            compilation_options: default(),
            cache: None,
        });
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(&view),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: written.as_entire_binding(),
                },
            ],
        });
        let mut encoder = device.create_command_encoder(&default());
        {
            let mut pass = encoder.begin_compute_pass(&default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &bind_group, &[]);
            pass.dispatch_workgroups(width / 4, height / 4, 1);
        }
        encoder.copy_buffer_to_buffer(&written, 0, &read, 0, None);
        queue.submit([encoder.finish()]);
        read.map_async(wgpu::MapMode::Read, .., |result| result.expect("mapped"));
        device
            .poll(wgpu::PollType::wait_indefinitely())
            .expect("the GPU is done");
        let mapped = read.slice(..).get_mapped_range().expect("mapped");
        bytemuck::pod_collect_to_vec(&mapped)
    }
}

/// The block whose texels are all end point `index`, 0 or 1.
fn with_all_indices(block: &[u8; 16], index: u64) -> [u8; 16] {
    let mut block = *block;
    block[2..8].copy_from_slice(&(index * 0x2492_4924_9249).to_le_bytes()[..6]);
    block[12..].copy_from_slice(&(index as u32 * 0x5555_5555).to_le_bytes());
    block
}

/// Blocks with every bit pattern equally likely.
pub fn random_blocks(count: usize) -> Vec<[u8; 16]> {
    let mut state = 1u64;
    let mut next = || {
        // SplitMix64.
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    let mut block = || bytemuck::cast([next(), next()]);
    (0..count).map(|_| block()).collect()
}

#[test]
fn the_driver_decodes_blocks_within_its_freedom_to_round() {
    let _gpu = gpu();
    let blocks = random_blocks(64 * 64);
    let size = [256, 256];
    let driver = Driver::new().decode_bc3(blocks.as_flattened(), size);
    let exact = decode_bc3(blocks.as_flattened(), size);
    let [end_0, end_1] = [0, 1].map(|index| {
        let all = |block: &[u8; 16]| with_all_indices(block, index);
        decode_bc3(
            blocks.iter().flat_map(all).collect::<Vec<_>>().as_slice(),
            size,
        )
    });
    let mut worst = [0.0f32; 4];
    for texel in 0..exact.len() {
        for (channel, worst) in worst.iter_mut().enumerate() {
            let of = |texels: &[[f32; 4]]| texels[texel][channel];
            let difference = (of(&driver) - of(&exact)).abs();
            *worst = worst.max(difference * 255.0);
            // Vulkan gives no bound. Direct3D 11 allows one level and 3 % of the way between the end
            // points; half a level is for end points made bytes before they are mixed.
            let tolerance = 1.5 / 255.0 + 0.03 * (of(&end_0) - of(&end_1)).abs();
            assert!(
                difference <= tolerance,
                "texel {texel}, channel {channel}: {difference}"
            );
        }
    }
    println!("levels off in R, G, B, A: {worst:.3?}");
}
