//! Adapter, device and queue, and the place where their errors are collected.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use wgpu::{Adapter, Backends, DeviceType, Features, Instance, InstanceDescriptor, InstanceFlags, PollError, PollType};

use crate::RenderError;

/// The longest wait for the GPU. A lost GPU may never signal its fence, so no wait is endless.
const PATIENCE: Duration = Duration::from_secs(60);

/// Requested where the adapter has them; everything works without, with less to see or to measure.
const WANTED_FEATURES: Features = Features::TIMESTAMP_QUERY
    .union(Features::PIPELINE_STATISTICS_QUERY)
    .union(Features::POLYGON_MODE_LINE)
    .union(Features::INDIRECT_FIRST_INSTANCE);

/// Which adapter to draw on. The default takes the strongest one; what is unset is read from the environment.
#[derive(Clone, Debug, Default)]
pub struct AdapterChoice {
    /// `vulkan`, `metal`, `dx12`, `gl` or `noop`, or several separated by commas; without it `WGPU_BACKEND`, without
    /// that Vulkan, Metal and DX12. GL only when asked for: it cannot read depth back and its submit blocks.
    pub backend: Option<String>,
    /// Part of the adapter's name, in any case; without it `WGPU_ADAPTER_NAME`.
    pub name: Option<String>,
    /// Accept software adapters (CPU rasterisers) only.
    pub software: bool,
}

/// What a measurement has to say about the adapter that it ran on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterFacts {
    /// Name that the driver gives.
    pub name: String,
    /// `discrete`, `integrated`, `virtual`, `software` or `other`.
    pub adapter_type: &'static str,
    /// `vulkan`, `metal`, `dx12`, `gl` or `noop`.
    pub backend: &'static str,
    /// Driver and its version.
    pub driver: String,
    /// Whether GPU times can be measured.
    pub timestamps: bool,
    /// Whether the GPU can count primitives.
    pub pipeline_statistics: bool,
    /// Whether a wireframe can be drawn.
    pub wireframe: bool,
    /// Whether [`Submission::MultiIndirect`](crate::Submission) is possible; without it draws are sent one by one.
    pub multi_draw_indirect: bool,
}

/// A device and its queue.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// Makes buffers, textures, pipelines.
    pub device: wgpu::Device,
    /// Takes uploads and command buffers.
    pub queue: wgpu::Queue,
    facts: AdapterFacts,
    faults: Arc<Mutex<Vec<String>>>,
}

impl AdapterChoice {
    /// An instance with the chosen backends.
    pub fn instance(&self) -> Result<Instance, RenderError> {
        let mut descriptor = InstanceDescriptor::new_without_display_handle_from_env();
        descriptor.backends = self.backends()?;
        if descriptor.backends.contains(Backends::NOOP) {
            descriptor.backend_options.noop.enable = true;
            // wgpu 30 asserts a storage alignment of 32 to 256 bytes in its validation of indirect draws; noop has 1.
            descriptor.flags.remove(InstanceFlags::VALIDATION_INDIRECT_CALL);
        }
        Ok(Instance::new(descriptor))
    }

    /// The strongest adapter that fits the choice.
    pub fn adapter(&self, instance: &Instance) -> Result<Adapter, RenderError> {
        let adapters = pollster::block_on(instance.enumerate_adapters(self.backends()?));
        let found = adapters.iter().map(|adapter| adapter.get_info().name).collect::<Vec<_>>().join(", ");
        let name = self.name.clone().or_else(|| std::env::var("WGPU_ADAPTER_NAME").ok());
        let fits = |adapter: &Adapter| {
            let info = adapter.get_info();
            let named = name.as_ref().is_none_or(|part| info.name.to_lowercase().contains(&part.to_lowercase()));
            named && (!self.software || info.device_type == DeviceType::Cpu)
        };
        let strongest =
            adapters.into_iter().filter(fits).min_by_key(|adapter| weakness(adapter.get_info().device_type));
        strongest.ok_or_else(|| {
            let kind = if self.software { "software" } else { "graphics" };
            let named = name.map_or(String::new(), |part| format!(" '{part}'"));
            RenderError::NoAdapter { wanted: format!("{kind}{named}"), found }
        })
    }

    fn backends(&self) -> Result<Backends, RenderError> {
        match self.backend.clone().or_else(|| std::env::var("WGPU_BACKEND").ok()) {
            Some(names) => names.split(',').try_fold(Backends::empty(), |all, name| Ok(all | backend(name.trim())?)),
            None => Ok(Backends::VULKAN | Backends::METAL | Backends::DX12),
        }
    }
}

fn backend(name: &str) -> Result<Backends, RenderError> {
    match name.to_lowercase().as_str() {
        "vulkan" | "vk" => Ok(Backends::VULKAN),
        "metal" | "mtl" => Ok(Backends::METAL),
        "dx12" | "d3d12" => Ok(Backends::DX12),
        "gl" | "gles" | "opengl" => Ok(Backends::GL),
        "noop" => Ok(Backends::NOOP),
        _ => Err(RenderError::UnknownBackend(name.to_owned())),
    }
}

fn weakness(device_type: DeviceType) -> u32 {
    match device_type {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    }
}

impl AdapterFacts {
    fn of(adapter: &Adapter) -> Self {
        let (info, features) = (adapter.get_info(), adapter.features());
        let adapter_type = match info.device_type {
            DeviceType::DiscreteGpu => "discrete",
            DeviceType::IntegratedGpu => "integrated",
            DeviceType::VirtualGpu => "virtual",
            DeviceType::Cpu => "software",
            DeviceType::Other => "other",
        };
        Self {
            name: info.name,
            adapter_type,
            backend: info.backend.to_str(),
            driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
            timestamps: features.contains(Features::TIMESTAMP_QUERY),
            pipeline_statistics: features.contains(Features::PIPELINE_STATISTICS_QUERY),
            wireframe: features.contains(Features::POLYGON_MODE_LINE),
            multi_draw_indirect: features.contains(Features::INDIRECT_FIRST_INSTANCE),
        }
    }
}

impl Gpu {
    /// A device on the chosen adapter, without any window.
    pub fn headless(choice: &AdapterChoice) -> Result<Self, RenderError> {
        Self::on(&choice.adapter(&choice.instance()?)?)
    }

    /// A device on this adapter, with all its limits and those of its features that the renderer can use.
    pub fn on(adapter: &Adapter) -> Result<Self, RenderError> {
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("terrain"),
            required_features: adapter.features() & WANTED_FEATURES,
            required_limits: adapter.limits(),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| RenderError::NoDevice(one_line(&error.to_string())))?;
        let faults = Arc::new(Mutex::new(Vec::new()));
        watch(&device, &faults);
        Ok(Self { device, queue, facts: AdapterFacts::of(adapter), faults })
    }

    /// What the adapter is and can do.
    pub fn facts(&self) -> &AdapterFacts {
        &self.facts
    }

    /// Fails with the first error that the device reported since the last check: wgpu reports most errors not where
    /// they are made but to a handler of the device.
    pub fn check(&self) -> Result<(), RenderError> {
        let faults = std::mem::take(&mut *self.faults.lock().unwrap_or_else(PoisonError::into_inner));
        // The first is the cause; the others follow from it, such as the submit of a broken command buffer.
        faults.into_iter().next().map_or(Ok(()), |fault| Err(RenderError::Gpu(fault)))
    }

    /// Waits until a submission has finished on the GPU.
    pub fn wait(&self, submission: wgpu::SubmissionIndex) -> Result<(), RenderError> {
        self.poll(Some(submission))
    }

    /// All bytes of a buffer, when the submissions so far have finished.
    pub(crate) fn read(&self, buffer: &wgpu::Buffer) -> Result<Vec<u8>, RenderError> {
        let (sender, receiver) = std::sync::mpsc::channel();
        // The receiver can only be gone after a timeout, which is reported already.
        buffer.map_async(wgpu::MapMode::Read, .., move |mapped| sender.send(mapped).unwrap_or(()));
        self.poll(None)?;
        self.check()?;
        let failed = |error: &dyn std::fmt::Display| RenderError::Gpu(one_line(&error.to_string()));
        receiver.try_recv().map_err(|error| failed(&error))?.map_err(|error| failed(&error))?;
        let bytes = buffer.get_mapped_range(..).map_err(|error| failed(&error))?.to_vec();
        buffer.unmap();
        Ok(bytes)
    }

    fn poll(&self, submission_index: Option<wgpu::SubmissionIndex>) -> Result<(), RenderError> {
        match self.device.poll(PollType::Wait { submission_index, timeout: Some(PATIENCE) }) {
            Ok(_) => Ok(()),
            Err(PollError::Timeout) => Err(RenderError::Timeout { seconds: PATIENCE.as_secs() }),
            Err(error) => Err(RenderError::Gpu(one_line(&error.to_string()))),
        }
    }
}

/// Collects what wgpu would otherwise panic about.
fn watch(device: &wgpu::Device, faults: &Arc<Mutex<Vec<String>>>) {
    let note = |faults: &Mutex<Vec<String>>, fault: String| {
        faults.lock().unwrap_or_else(PoisonError::into_inner).push(one_line(&fault));
    };
    let uncaptured = Arc::clone(faults);
    device.on_uncaptured_error(Arc::new(move |error| note(&uncaptured, error.to_string())));
    let lost = Arc::clone(faults);
    device.set_device_lost_callback(move |reason, message| {
        // A device that is dropped is "destroyed": that is no fault.
        if reason != wgpu::DeviceLostReason::Destroyed {
            note(&lost, format!("device lost: {message}"));
        }
    });
}

fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choice(backend: &str) -> AdapterChoice {
        AdapterChoice { backend: Some(backend.to_owned()), ..Default::default() }
    }

    #[test]
    fn backends_by_name() {
        assert_eq!(choice("Vulkan").backends().unwrap(), Backends::VULKAN);
        assert_eq!(choice("metal, dx12").backends().unwrap(), Backends::METAL | Backends::DX12);
        let refused = choice("glide").backends().unwrap_err().to_string();
        assert_eq!(refused, "unknown graphics backend 'glide': expected vulkan, metal, dx12, gl or noop");
    }

    #[test]
    fn a_missing_adapter_is_named_with_those_that_are_there() {
        let choice = AdapterChoice { name: Some("voodoo".to_owned()), ..choice("noop") };
        let refused = Gpu::headless(&choice).unwrap_err().to_string();
        assert!(refused.starts_with("no graphics 'voodoo' adapter among ["), "{refused}");
    }
}
