//! Runs compute shaders on one device that all tests share, without an app.

use std::{
    sync::{Mutex, OnceLock, PoisonError},
    time::Duration,
};

use bevy::tasks::block_on;

struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
}

static GPU: OnceLock<Mutex<Gpu>> = OnceLock::new();

/// Longer than any of these shaders takes on a software driver.
const PATIENCE: Duration = Duration::from_secs(60);

/// What is bound to group 0 and binding `n`, in order of the bindings.
pub enum Binding<'a> {
    Uniform(&'a [u8]),
    Storage(&'a [u8]),
}

/// Runs the only entry point of a shader and gives what it wrote to the storage buffer of group 1,
/// binding 0, of so many bytes; `input` is binding 1 there.
pub fn dispatch(
    source: &str,
    group: &[Binding],
    input: &[u8],
    output_bytes: u64,
    workgroups: u32,
) -> Vec<u8> {
    let gpu = GPU.get_or_init(|| Mutex::new(Gpu::new()));
    let gpu = gpu.lock().unwrap_or_else(PoisonError::into_inner);
    gpu.dispatch(source, group, input, output_bytes, workgroups)
}

impl Gpu {
    fn new() -> Self {
        let descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        let instance = wgpu::Instance::new(descriptor);
        let adapter = block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
        let adapter = adapter.expect("an adapter");
        let device = block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            required_limits: adapter.limits(),
            ..wgpu::DeviceDescriptor::default()
        }));
        let (device, queue) = device.expect("a device");
        Self { device, queue }
    }

    fn buffer(&self, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        wgpu::util::DeviceExt::create_buffer_init(
            &self.device,
            &wgpu::util::BufferInitDescriptor {
                label: Some("test_input"),
                contents,
                usage,
            },
        )
    }

    fn dispatch(
        &self,
        source: &str,
        group: &[Binding],
        input: &[u8],
        output_bytes: u64,
        workgroups: u32,
    ) -> Vec<u8> {
        let module = self
            .device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("test"),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            });
        let pipeline = self
            .device
            .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some("test"),
                layout: None,
                module: &module,
                entry_point: None,
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            });
        let output = |usage| {
            self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("test_output"),
                size: output_bytes,
                usage,
                mapped_at_creation: false,
            })
        };
        let written = output(wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
        let read = output(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
        let inputs: Vec<_> = group
            .iter()
            .map(|binding| match binding {
                Binding::Uniform(bytes) => self.buffer(bytes, wgpu::BufferUsages::UNIFORM),
                Binding::Storage(bytes) => self.buffer(bytes, wgpu::BufferUsages::STORAGE),
            })
            .collect();
        let items = self.buffer(input, wgpu::BufferUsages::STORAGE);
        let entries: Vec<Vec<wgpu::BindGroupEntry>> = vec![
            (0..).zip(&inputs).map(entry).collect(),
            (0..).zip([&written, &items]).map(entry).collect(),
        ];
        let groups: Vec<_> = (0..)
            .zip(&entries)
            .map(|(index, entries)| {
                self.device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some("test"),
                    layout: &pipeline.get_bind_group_layout(index),
                    entries,
                })
            })
            .collect();
        let mut encoder = self
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&pipeline);
            for (index, group) in (0..).zip(&groups) {
                pass.set_bind_group(index, group, &[]);
            }
            pass.dispatch_workgroups(workgroups, 1, 1);
        }
        encoder.copy_buffer_to_buffer(&written, 0, &read, 0, None);
        self.queue.submit([encoder.finish()]);
        read.map_async(wgpu::MapMode::Read, .., |result| result.expect("mapped"));
        self.device
            .poll(wgpu::PollType::Wait {
                submission_index: None,
                timeout: Some(PATIENCE),
            })
            .expect("the shader ends");
        read.slice(..).get_mapped_range().expect("mapped").to_vec()
    }
}

fn entry((binding, buffer): (u32, &wgpu::Buffer)) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry {
        binding,
        resource: buffer.as_entire_binding(),
    }
}
