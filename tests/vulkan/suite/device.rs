//! A Vulkan device by way of wgpu, which hands shaders through.

use brdfc_formats::bindings::{Resource, Texels};
use brdfc_formats::container::{Extent, TexelFormat};
use brdfc_gpu::texture_format;
use brdfc_shaders::{BindingKind, Interface};
use brdfc_testing::engines::{Case, SIDE};
use std::borrow::Cow;
use wgpu::util::{DeviceExt as _, TextureDataOrder};
use wgpu::*;

/// An open device.
pub struct Vulkan {
    device: Device,
    queue: Queue,
}

impl Vulkan {
    /// The first adapter; nothing where there is none, which is said.
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
        // SAFETY: what may go wrong is a crash of the driver, in a test.
        let experimental_features = unsafe { ExperimentalFeatures::enabled() };
        let descriptor = DeviceDescriptor { required_features, experimental_features, ..Default::default() };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
        Some(Self { device, queue })
    }

    /// The answers of a module to the queries of a case. `groups` are those of the queries and of the pack.
    pub fn evaluate(&self, words: &[u32], groups: [u32; 2], interface: &Interface, case: &Case) -> Vec<[f32; 4]> {
        let entry = PassthroughShaderEntryPoint { name: Cow::Borrowed("evaluate"), workgroup_size: (64, 1, 1) };
        let descriptor = ShaderModuleDescriptorPassthrough {
            label: None,
            entry_points: Cow::Owned(vec![entry]),
            spirv: Some(Cow::Borrowed(words)),
            ..Default::default()
        };
        // SAFETY: the words are SPIR-V that its validator takes, with bindings of the layouts below.
        let module = unsafe { self.device.create_shader_module_passthrough(descriptor) };
        let (pack_layout, pack) = self.pack(interface, case);
        let (item_layout, items, answers) = self.items(case);
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
            module: &module,
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
    fn items(&self, case: &Case) -> (BindGroupLayout, BindGroup, Buffer) {
        let contents: Vec<f32> = case.queries.iter().flatten().flatten().copied().collect();
        let buffer = |contents, usage| {
            self.device.create_buffer_init(&util::BufferInitDescriptor { label: None, contents, usage })
        };
        let queries = buffer(bytemuck::cast_slice(&contents), BufferUsages::STORAGE);
        let answers = buffer(&vec![0; 16 * SIDE * SIDE], BufferUsages::STORAGE | BufferUsages::COPY_SRC);
        let ty = |read_only| BindingType::Buffer {
            ty: BufferBindingType::Storage { read_only },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let (layout, group) =
            self.group(&[(0, ty(true), queries.as_entire_binding()), (1, ty(false), answers.as_entire_binding())]);
        (layout, group, answers)
    }

    /// What a pack binds.
    fn pack(&self, interface: &Interface, case: &Case) -> (BindGroupLayout, BindGroup) {
        let mut bound = Vec::new();
        for (slot, _, resource) in case.bound() {
            let kind = &interface.bindings.iter().find(|bound| bound.binding == slot).unwrap().kind;
            bound.push((slot, self.resource(&resource, kind)));
        }
        let entries: Vec<_> = bound
            .iter()
            .map(|(binding, (ty, resource))| {
                let resource = match resource {
                    Made::Buffer(buffer) => buffer.as_entire_binding(),
                    Made::Texture(view) => BindingResource::TextureView(view),
                    Made::Sampler(sampler) => BindingResource::Sampler(sampler),
                };
                (*binding, *ty, resource)
            })
            .collect();
        self.group(&entries)
    }

    fn group(&self, entries: &[(u32, BindingType, BindingResource<'_>)]) -> (BindGroupLayout, BindGroup) {
        let entry = |(binding, ty, _): &(u32, BindingType, BindingResource<'_>)| BindGroupLayoutEntry {
            binding: *binding,
            visibility: ShaderStages::COMPUTE,
            ty: *ty,
            count: None,
        };
        let layouts: Vec<_> = entries.iter().map(entry).collect();
        let descriptor = BindGroupLayoutDescriptor { label: None, entries: &layouts };
        let layout = self.device.create_bind_group_layout(&descriptor);
        let entries: Vec<_> = entries
            .iter()
            .map(|(binding, _, resource)| BindGroupEntry { binding: *binding, resource: resource.clone() })
            .collect();
        let group =
            self.device.create_bind_group(&BindGroupDescriptor { label: None, layout: &layout, entries: &entries });
        (layout, group)
    }

    fn resource(&self, resource: &Resource<'_>, kind: &BindingKind) -> (BindingType, Made) {
        match (resource, kind) {
            (Resource::Uniform(bytes), _) => {
                let descriptor =
                    util::BufferInitDescriptor { label: None, contents: bytes, usage: BufferUsages::UNIFORM };
                let ty = BufferBindingType::Uniform;
                let ty = BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
                (ty, Made::Buffer(self.device.create_buffer_init(&descriptor)))
            }
            (Resource::Sampler { repeats }, _) => {
                let mode = if *repeats { AddressMode::Repeat } else { AddressMode::ClampToEdge };
                let sampler = self.device.create_sampler(&SamplerDescriptor {
                    address_mode_u: mode,
                    address_mode_v: mode,
                    mag_filter: FilterMode::Linear,
                    min_filter: FilterMode::Linear,
                    mipmap_filter: MipmapFilterMode::Linear,
                    ..Default::default()
                });
                (BindingType::Sampler(SamplerBindingType::Filtering), Made::Sampler(sampler))
            }
            (Resource::Texture(texels), BindingKind::Texture { dimension, samples }) => {
                let view_dimension = match dimension.as_str() {
                    "3d" => TextureViewDimension::D3,
                    "2d-array" => TextureViewDimension::D2Array,
                    _ => TextureViewDimension::D2,
                };
                let full = [TexelFormat::Rg32Float, TexelFormat::Rgba32Float].contains(&texels.format);
                let sample_type = match samples.as_str() {
                    "uint" => TextureSampleType::Uint,
                    _ => TextureSampleType::Float { filterable: !full },
                };
                (
                    BindingType::Texture { sample_type, view_dimension, multisampled: false },
                    self.texture(texels, view_dimension),
                )
            }
            (resource, kind) => panic!("{resource:?} for {kind:?}"),
        }
    }

    fn texture(&self, texels: &Texels<'_>, dimension: TextureViewDimension) -> Made {
        let [width, height, depth_or_array_layers] = match texels.extent {
            Extent::D2([width, height]) => [width, height, 1],
            Extent::D2Array(size) | Extent::D3(size) => size,
        };
        let is_volume = dimension == TextureViewDimension::D3;
        let descriptor = TextureDescriptor {
            label: None,
            size: Extent3d { width, height, depth_or_array_layers },
            mip_level_count: texels.levels,
            sample_count: 1,
            dimension: if is_volume { TextureDimension::D3 } else { TextureDimension::D2 },
            format: texture_format(texels.format),
            usage: TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        };
        let order = TextureDataOrder::MipMajor;
        let texture = self.device.create_texture_with_data(&self.queue, &descriptor, order, &texels.bytes);
        Made::Texture(texture.create_view(&TextureViewDescriptor { dimension: Some(dimension), ..Default::default() }))
    }
}

/// What was uploaded.
enum Made {
    Buffer(Buffer),
    Texture(TextureView),
    Sampler(Sampler),
}
