//! Selection of an adapter, opening of a device, and conversion of wgpu's failures to errors.

use brdfc_core::words::{one_of, quoted};
use schemars::JsonSchema;
use serde::Serialize;
use std::sync::{Arc, Mutex};
use wgpu::{
    Backends, BufferUsages, DeviceDescriptor, DeviceType, Features, Instance, InstanceDescriptor, Limits, MapMode,
    PollType, PowerPreference, RequestAdapterOptions,
};

/// Errors of the graphics adapter or its driver.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    /// There is no adapter.
    #[error("no usable graphics adapter: {0}")]
    NoAdapter(String),
    /// No adapter has the requested name.
    #[error("graphics adapter: found {}, expected a part of the name or driver of {available}", quoted(.found))]
    NoSuchAdapter {
        /// Requested text.
        found: String,
        /// Names of the adapters.
        available: String,
    },
    /// The driver failed.
    #[error("graphics: {0}")]
    Failed(String),
    /// The request exceeds the adapter's limits.
    #[error("{0}")]
    TooLarge(String),
}

const NO_DRIVER: &str = "no Vulkan driver was found";

/// Choice of an adapter.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum AdapterChoice {
    /// The fastest adapter.
    #[default]
    Best,
    /// The first adapter whose name or driver contains this text, ignoring case.
    Named(String),
}

/// Adapter that drew an image.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct AdapterDescription {
    /// The adapter's name.
    pub name: String,
    /// The driver and its version.
    pub driver: String,
    /// True if the adapter is a program on the CPU.
    pub software: bool,
}

/// An open device.
pub struct Gpu {
    /// The device.
    #[doc(hidden)]
    pub device: wgpu::Device,
    /// Queue of the device.
    #[doc(hidden)]
    pub queue: wgpu::Queue,
    description: AdapterDescription,
    /// The first error that no call returned.
    error: Arc<Mutex<Option<String>>>,
}

impl Gpu {
    /// Opens an adapter. Needs no display.
    ///
    /// # Errors
    /// Returns [`GpuError::NoAdapter`] if there is none, or if it lacks textures of 16-bit components.
    pub fn open(choice: &AdapterChoice) -> Result<Self, GpuError> {
        let mut descriptor = InstanceDescriptor::new_without_display_handle();
        descriptor.backends = Backends::VULKAN;
        let instance = Instance::new(descriptor);
        let adapter = match choice {
            AdapterChoice::Best => {
                let options =
                    RequestAdapterOptions { power_preference: PowerPreference::HighPerformance, ..Default::default() };
                pollster::block_on(instance.request_adapter(&options)).map_err(|error| match error {
                    wgpu::RequestAdapterError::NotFound { .. } => GpuError::NoAdapter(NO_DRIVER.to_owned()),
                    other => GpuError::NoAdapter(other.to_string()),
                })?
            }
            AdapterChoice::Named(text) => {
                let all = pollster::block_on(instance.enumerate_adapters(Backends::VULKAN));
                let names: Vec<String> = all.iter().map(|adapter| adapter.get_info().name).collect();
                let requested = text.to_lowercase();
                let fits = |info: wgpu::AdapterInfo| {
                    info.name.to_lowercase().contains(&requested) || info.driver.to_lowercase().contains(&requested)
                };
                all.into_iter().find(|adapter| fits(adapter.get_info())).ok_or_else(|| match &names[..] {
                    [] => GpuError::NoAdapter(NO_DRIVER.to_owned()),
                    _ => GpuError::NoSuchAdapter { found: text.clone(), available: one_of(&names) },
                })?
            }
        };
        let info = adapter.get_info();
        let features = Features::TEXTURE_FORMAT_16BIT_NORM;
        if !adapter.features().contains(features) {
            return Err(GpuError::NoAdapter(format!("{} has no textures of 16-bit components", info.name)));
        }
        let all = adapter.limits();
        let limits = Limits {
            max_buffer_size: all.max_buffer_size,
            max_storage_buffer_binding_size: all.max_storage_buffer_binding_size,
            ..Limits::default().using_resolution(all)
        };
        let descriptor =
            DeviceDescriptor { required_features: features, required_limits: limits, ..DeviceDescriptor::default() };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| GpuError::NoAdapter(format!("{}: {error}", info.name)))?;
        let error = Arc::new(Mutex::new(None));
        let keep = |first: &Mutex<Option<String>>, text: String| {
            if let Ok(mut slot) = first.lock() {
                slot.get_or_insert(text);
            }
        };
        let slot = Arc::clone(&error);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| keep(&slot, error.to_string())));
        let slot = Arc::clone(&error);
        device.set_device_lost_callback(move |reason, text| keep(&slot, format!("device lost ({reason:?}): {text}")));
        let description = AdapterDescription {
            name: info.name,
            driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
            software: info.device_type == DeviceType::Cpu,
        };
        Ok(Self { device, queue, description, error })
    }

    /// Description of the adapter.
    pub fn description(&self) -> &AdapterDescription {
        &self.description
    }

    /// Returns the first error since the last call.
    #[doc(hidden)]
    pub fn check(&self) -> Result<(), GpuError> {
        match self.error.lock().map(|mut slot| slot.take()) {
            Ok(None) => Ok(()),
            Ok(Some(text)) => Err(GpuError::Failed(text)),
            Err(_) => Err(GpuError::Failed("an error handler panicked".to_owned())),
        }
    }

    /// Waits until everything submitted is done.
    #[doc(hidden)]
    pub fn wait(&self) -> Result<(), GpuError> {
        self.device.poll(PollType::wait_indefinitely()).map_err(|error| GpuError::Failed(error.to_string()))?;
        self.check()
    }

    /// Creates a buffer for [`Self::read`].
    #[doc(hidden)]
    pub fn read_buffer(&self, bytes: u64) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: bytes,
            usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    }

    /// Waits for the queue and passes the bytes of a buffer to `take`.
    #[doc(hidden)]
    pub fn read<T>(&self, buffer: &wgpu::Buffer, take: impl FnOnce(&[u8]) -> T) -> Result<T, GpuError> {
        let (sender, receiver) = std::sync::mpsc::channel();
        buffer.map_async(MapMode::Read, .., move |result| drop(sender.send(result)));
        self.wait()?;
        let failed = |text: String| GpuError::Failed(format!("reading back: {text}"));
        receiver.recv().map_err(|error| failed(error.to_string()))?.map_err(|error| failed(error.to_string()))?;
        let value = take(&buffer.get_mapped_range(..).map_err(|error| failed(error.to_string()))?);
        buffer.unmap();
        Ok(value)
    }

    /// Waits for the queue and returns `count` values of a buffer, starting at this index.
    pub(super) fn read_values<T: bytemuck::Pod>(
        &self,
        source: &wgpu::Buffer,
        first: usize,
        count: usize,
    ) -> Result<Vec<T>, GpuError> {
        let size = size_of::<T>();
        if count == 0 {
            return Ok(Vec::new());
        }
        let buffer = self.read_buffer((count * size) as u64);
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(source, (first * size) as u64, &buffer, 0, buffer.size());
        self.queue.submit([encoder.finish()]);
        self.read(&buffer, bytemuck::pod_collect_to_vec)
    }
}
