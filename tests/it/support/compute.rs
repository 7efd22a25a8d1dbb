//! Runs compute shaders on one device that all tests share, without an app.

use std::{sync::OnceLock, time::Duration};

use bevy::tasks::block_on;
use wgpu::util::DeviceExt;

static DEVICE: OnceLock<(wgpu::Device, wgpu::Queue)> = OnceLock::new();

/// A shader that takes longer than this does not end.
const TIMEOUT: Duration = Duration::from_secs(60);

/// A resource of group 0; the bindings are numbered in order.
pub enum Binding<'a> {
    Uniform(&'a [u8]),
    Storage(&'a [u8]),
    Texture(&'a wgpu::TextureView),
}

fn open_device() -> (wgpu::Device, wgpu::Queue) {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
    let adapter = adapter.expect("an adapter");
    let device = block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_limits: adapter.limits(),
        ..wgpu::DeviceDescriptor::default()
    }));
    device.expect("a device")
}

/// Runs the only entry point of a shader and returns what it wrote to the storage buffer at group 1,
/// binding 0, of `output_bytes` bytes. `input` is bound beside it, at binding 1.
pub fn dispatch(
    source: &str,
    group: &[Binding],
    input: &[u8],
    output_bytes: u64,
    workgroups: u32,
) -> Vec<u8> {
    let (device, queue) = DEVICE.get_or_init(open_device);
    let input = Binding::Storage(input);
    dispatch_on(
        device,
        queue,
        source,
        [group, &[input]],
        output_bytes,
        [workgroups, 1],
    )
}

/// As [`dispatch`], on a device of the caller's; `inputs` are group 0, and group 1 from its binding 1 on.
pub fn dispatch_on(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    source: &str,
    inputs: [&[Binding]; 2],
    output_bytes: u64,
    workgroups: [u32; 2],
) -> Vec<u8> {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("test"),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("test"),
        layout: None,
        module: &module,
        entry_point: None,
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    let empty = |usage| {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("test_output"),
            size: output_bytes,
            usage,
            mapped_at_creation: false,
        })
    };
    let written = empty(wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
    let read = empty(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
    let [first, second] = inputs.map(|bindings| resources(device, bindings));
    let mut outputs = vec![Resource::Buffer(written.clone())];
    outputs.extend(second);

    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        for (index, resources) in (0..).zip([first, outputs]) {
            let entries: Vec<_> = (0..)
                .zip(&resources)
                .map(|(binding, resource)| wgpu::BindGroupEntry {
                    binding,
                    resource: resource.binding(),
                })
                .collect();
            let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("test"),
                layout: &pipeline.get_bind_group_layout(index),
                entries: &entries,
            });
            pass.set_bind_group(index, &bind_group, &[]);
        }
        pass.dispatch_workgroups(workgroups[0], workgroups[1], 1);
    }
    encoder.copy_buffer_to_buffer(&written, 0, &read, 0, None);
    queue.submit([encoder.finish()]);
    read.map_async(wgpu::MapMode::Read, .., |result| result.expect("mapped"));
    device
        .poll(wgpu::PollType::Wait {
            submission_index: None,
            timeout: Some(TIMEOUT),
        })
        .expect("the shader ends");
    let mapped = read.slice(..).get_mapped_range();
    mapped.expect("mapped").to_vec()
}

enum Resource<'a> {
    Buffer(wgpu::Buffer),
    Texture(&'a wgpu::TextureView),
}

impl Resource<'_> {
    fn binding(&self) -> wgpu::BindingResource<'_> {
        match self {
            Self::Buffer(buffer) => buffer.as_entire_binding(),
            Self::Texture(view) => wgpu::BindingResource::TextureView(view),
        }
    }
}

fn resources<'a>(device: &wgpu::Device, bindings: &[Binding<'a>]) -> Vec<Resource<'a>> {
    let filled = |contents: &[u8], usage| {
        let label = Some("test_input");
        Resource::Buffer(
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label,
                contents,
                usage,
            }),
        )
    };
    let resource = |binding: &Binding<'a>| match binding {
        Binding::Uniform(bytes) => filled(bytes, wgpu::BufferUsages::UNIFORM),
        Binding::Storage(bytes) => filled(bytes, wgpu::BufferUsages::STORAGE),
        Binding::Texture(view) => Resource::Texture(view),
    };
    bindings.iter().map(resource).collect()
}
