//! A Vulkan device of wgpu, which passes shaders through unchanged.

use crate::loader;
use brdfc_formats::bindings::{Binding, FrameBlock};
use brdfc_testing::engines::{Query, SIDE};
use std::borrow::Cow;
use wgpu::util::DeviceExt as _;
use wgpu::*;

/// An open device.
pub struct Vulkan {
    device: Device,
    queue: Queue,
}

impl Vulkan {
    /// Opens the first adapter; prints a message and returns `None` if there is none.
    pub fn open() -> Option<Self> {
        let mut descriptor = InstanceDescriptor::new_without_display_handle();
        descriptor.backends = Backends::VULKAN;
        let instance = Instance::new(descriptor);
        let adapter = match pollster::block_on(instance.request_adapter(&RequestAdapterOptions::default())) {
            Ok(adapter) => adapter,
            Err(error) => {
                println!("skipped: {error}");
                return None;
            }
        };
        let required_features = Features::PASSTHROUGH_SHADERS | Features::TEXTURE_FORMAT_16BIT_NORM;
        // SAFETY: the worst case is a crash of the driver, in a test.
        let experimental_features = unsafe { ExperimentalFeatures::enabled() };
        let descriptor = DeviceDescriptor { required_features, experimental_features, ..Default::default() };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
        Some(Self { device, queue })
    }

    /// A module of SPIR-V with a pack in a group.
    pub fn spirv(&self, words: &[u32], group: u32, pack: &[Binding<'_>]) -> ShaderModule {
        let words = numbered(words, group, pack);
        let entry = PassthroughShaderEntryPoint { name: Cow::Borrowed("evaluate"), workgroup_size: (64, 1, 1) };
        let descriptor = ShaderModuleDescriptorPassthrough {
            label: None,
            entry_points: Cow::Owned(vec![entry]),
            spirv: Some(Cow::Owned(words)),
            ..Default::default()
        };
        // SAFETY: the validator accepts the words as SPIR-V, with bindings of the layouts below.
        unsafe { self.device.create_shader_module_passthrough(descriptor) }
    }

    /// A module of WGSL, compiled by naga.
    pub fn wgsl(&self, source: String) -> ShaderModule {
        let source = ShaderSource::Wgsl(source.into());
        self.device.create_shader_module(ShaderModuleDescriptor { label: None, source })
    }

    /// Answers of a module to queries. `groups` are those of the queries and of the pack.
    pub fn evaluate(
        &self,
        module: &ShaderModule,
        groups: [u32; 2],
        queries: &[Query],
        (bindings, frame): (&[Binding<'_>], FrameBlock),
    ) -> Vec<[f32; 4]> {
        let (pack_layout, pack) = loader::bind(&self.device, &self.queue, bindings, frame);
        let (item_layout, items, answers) = self.items(queries);
        let mut layouts = [Some(&item_layout), Some(&pack_layout)];
        if groups[0] == 1 {
            layouts.reverse();
        }
        let layout = self.device.create_pipeline_layout(&PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &layouts,
            immediate_size: 0,
        });
        let pipeline = self.device.create_compute_pipeline(&ComputePipelineDescriptor {
            label: None,
            layout: Some(&layout),
            module,
            entry_point: Some("evaluate"),
            compilation_options: PipelineCompilationOptions::default(),
            cache: None,
        });
        let size = 16 * (SIDE * SIDE) as u64;
        let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
        let copy = self.device.create_buffer(&BufferDescriptor { label: None, size, usage, mapped_at_creation: false });
        let mut encoder = self.device.create_command_encoder(&CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(groups[0], &items, &[]);
            pass.set_bind_group(groups[1], &pack, &[]);
            pass.dispatch_workgroups((SIDE * SIDE).div_ceil(64) as u32, 1, 1);
        }
        encoder.copy_buffer_to_buffer(&answers, 0, &copy, 0, size);
        self.queue.submit([encoder.finish()]);
        copy.slice(..).map_async(MapMode::Read, |mapped| mapped.unwrap());
        self.device.poll(PollType::wait_indefinitely()).unwrap();
        let mapped = copy.slice(..).get_mapped_range().unwrap();
        bytemuck::cast_slice::<u8, [f32; 4]>(&mapped).to_vec()
    }

    /// Queries and answers.
    fn items(&self, queries: &[Query]) -> (BindGroupLayout, BindGroup, Buffer) {
        let buffer = |contents, usage| {
            self.device.create_buffer_init(&util::BufferInitDescriptor { label: None, contents, usage })
        };
        let queries = buffer(bytemuck::cast_slice(queries), BufferUsages::STORAGE);
        let answers = buffer(&vec![0; 16 * SIDE * SIDE], BufferUsages::STORAGE | BufferUsages::COPY_SRC);
        let entry = |binding, read_only| BindGroupLayoutEntry {
            binding,
            visibility: ShaderStages::COMPUTE,
            ty: BindingType::Buffer {
                ty: BufferBindingType::Storage { read_only },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let descriptor = BindGroupLayoutDescriptor { label: None, entries: &[entry(0, true), entry(1, false)] };
        let layout = self.device.create_bind_group_layout(&descriptor);
        let bound = |binding, buffer| BindGroupEntry { binding, resource: Buffer::as_entire_binding(buffer) };
        let entries = &[bound(0, &queries), bound(1, &answers)];
        let group = self.device.create_bind_group(&BindGroupDescriptor { label: None, layout: &layout, entries });
        (layout, group, answers)
    }
}

/// A module whose bindings are numbered consecutively per group, as wgpu's layouts of Vulkan number them, regardless of their slots.
/// wgpu does the same to WGSL, and leaves it to the user for modules that it passes through.
fn numbered(words: &[u32], group: u32, pack: &[Binding<'_>]) -> Vec<u32> {
    const DECORATE: u32 = 71;
    const BINDING: u32 = 33;
    const SET: u32 = 34;
    let mut words = words.to_vec();
    // Places and targets of instructions "OpDecorate target decoration literal".
    let (mut bindings, mut of_group) = (Vec::new(), Vec::new());
    let mut at = 5;
    while at < words.len() {
        let (count, code) = ((words[at] >> 16) as usize, words[at] & 0xffff);
        if code == DECORATE && words[at + 2] == BINDING {
            bindings.push((at + 3, words[at + 1]));
        } else if code == DECORATE && words[at + 2] == SET && words[at + 3] == group {
            of_group.push(words[at + 1]);
        }
        at += count;
    }
    for (place, target) in bindings {
        if of_group.contains(&target) {
            let slot = words[place];
            words[place] = pack.iter().filter(|binding| binding.slot < slot).count() as u32;
        }
    }
    words
}
