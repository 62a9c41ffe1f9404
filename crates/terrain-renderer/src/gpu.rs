//! Adapter, device and queue, and the place where their errors are collected.

use std::env::VarError;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use wgpu::{
    Adapter, AdapterInfo, Backend, Backends, DeviceType, DownlevelFlags, Features, Instance, InstanceDescriptor,
    InstanceFlags, PollError, PollType,
};

use crate::RenderError;

/// The longest wait for the GPU. A lost GPU may never signal its fence, so no wait is endless.
const PATIENCE: Duration = Duration::from_secs(60);

/// Requested where the adapter has them; everything works without, with less to see or to measure.
const WANTED_FEATURES: Features = Features::TIMESTAMP_QUERY
    .union(Features::PIPELINE_STATISTICS_QUERY)
    .union(Features::POLYGON_MODE_LINE)
    .union(Features::INDIRECT_FIRST_INSTANCE);

const DEFAULT_BACKENDS: Backends = Backends::VULKAN.union(Backends::METAL).union(Backends::DX12);

/// Which adapter to draw on. The default takes the strongest one; what is unset is read from the environment, where an
/// empty variable counts as unset.
#[derive(Clone, Debug, Default)]
pub struct AdapterChoice {
    /// `vulkan`, `metal`, `dx12`, `gl` or `noop`, or several separated by commas; without it `WGPU_BACKEND`, without
    /// that Vulkan, Metal and DX12. GL only when asked for: it cannot read depth back and its submit blocks.
    pub backend: Option<String>,
    /// Part of the adapter's name, in any case; without it `WGPU_ADAPTER_NAME`.
    pub name: Option<String>,
}

/// What a measurement has to say about the adapter that it ran on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterFacts {
    /// Name that the driver gives.
    pub name: String,
    /// `discrete`, `integrated`, `virtual`, `software`, `other`, or `none` for noop, which draws nothing.
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
    /// Whether vertices can read the height tiles that a method brings along.
    pub height_tiles: bool,
}

/// An adapter of this machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ListedAdapter {
    /// What it is and can do.
    pub facts: AdapterFacts,
    /// Whether it is the one that [`Gpu::headless`] takes.
    pub chosen: bool,
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
        Ok(instance(self.backends()?))
    }

    /// The strongest adapter that fits the choice.
    pub fn adapter(&self, instance: &Instance) -> Result<Adapter, RenderError> {
        let backends = self.backends()?;
        let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
        match self.strongest(backends, &adapters) {
            Some(at) => Ok(adapters.swap_remove(at)),
            None => Err(self.no_adapter(&adapters)),
        }
    }

    /// All adapters, those of backends that are not chosen included, and which one is chosen. Noop, which every machine
    /// has, is among them where it is asked for.
    pub fn list(&self) -> Result<Vec<ListedAdapter>, RenderError> {
        let backends = self.backends()?;
        let all = backends | DEFAULT_BACKENDS | Backends::GL;
        let adapters = pollster::block_on(instance(all).enumerate_adapters(all));
        let strongest = self.strongest(backends, &adapters);
        let listed = |(at, adapter)| ListedAdapter { facts: AdapterFacts::of(adapter), chosen: strongest == Some(at) };
        Ok(adapters.iter().enumerate().map(listed).collect())
    }

    /// Position of the strongest adapter of these backends and of the chosen name; the first among equals.
    fn strongest(&self, backends: Backends, adapters: &[Adapter]) -> Option<usize> {
        let name = self.name().map(|name| name.to_lowercase());
        let fits = |info: &AdapterInfo| {
            let named = name.as_ref().is_none_or(|part| info.name.to_lowercase().contains(part));
            named && backends.contains(Backends::from(info.backend))
        };
        let infos = adapters.iter().map(Adapter::get_info).enumerate().filter(|(_, info)| fits(info));
        infos.min_by_key(|(_, info)| weakness(info.device_type)).map(|(at, _)| at)
    }

    fn no_adapter(&self, adapters: &[Adapter]) -> RenderError {
        let wanted = self.name().map_or("graphics".to_owned(), |part| format!("graphics '{part}'"));
        let found = adapters.iter().map(|adapter| adapter.get_info().name).collect::<Vec<_>>().join(", ");
        RenderError::NoAdapter { wanted, found }
    }

    fn name(&self) -> Option<String> {
        self.name.clone().or_else(|| set(std::env::var("WGPU_ADAPTER_NAME")))
    }

    fn backends(&self) -> Result<Backends, RenderError> {
        match self.backend.clone().or_else(|| set(std::env::var("WGPU_BACKEND"))) {
            Some(names) => names.split(',').try_fold(Backends::empty(), |all, name| Ok(all | backend(name.trim())?)),
            None => Ok(DEFAULT_BACKENDS),
        }
    }
}

fn instance(backends: Backends) -> Instance {
    let mut descriptor = InstanceDescriptor::new_without_display_handle_from_env();
    descriptor.backends = backends;
    if backends.contains(Backends::NOOP) {
        descriptor.backend_options.noop.enable = true;
        // wgpu 30 asserts a storage alignment of 32 to 256 bytes in its validation of indirect draws; noop has 1.
        descriptor.flags.remove(InstanceFlags::VALIDATION_INDIRECT_CALL);
    }
    Instance::new(descriptor)
}

/// The value of an environment variable, if it says anything.
fn set(variable: Result<String, VarError>) -> Option<String> {
    variable.ok().filter(|value| !value.trim().is_empty())
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
        let downlevel = adapter.get_downlevel_capabilities().flags;
        let adapter_type = match (info.backend, info.device_type) {
            (Backend::Noop, _) => "none",
            (_, DeviceType::DiscreteGpu) => "discrete",
            (_, DeviceType::IntegratedGpu) => "integrated",
            (_, DeviceType::VirtualGpu) => "virtual",
            (_, DeviceType::Cpu) => "software",
            (_, DeviceType::Other) => "other",
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
            height_tiles: downlevel.contains(DownlevelFlags::VERTEX_STORAGE),
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

    /// All bytes of a buffer, when the submissions so far have finished. It is never left mapped: a later frame may
    /// write to it.
    pub(crate) fn read(&self, buffer: &wgpu::Buffer) -> Result<Vec<u8>, RenderError> {
        let (sender, receiver) = std::sync::mpsc::channel();
        // The receiver can only be gone after a timeout, which is reported already.
        buffer.map_async(wgpu::MapMode::Read, .., move |mapped| sender.send(mapped).unwrap_or(()));
        let waited = self.poll(None).and_then(|()| self.check());
        let mapped = receiver.try_recv();
        let bytes = waited.and_then(|()| match &mapped {
            Ok(Ok(())) => buffer.get_mapped_range(..).map(|range| range.to_vec()).map_err(|error| fault(&error)),
            Ok(Err(error)) => Err(fault(error)),
            Err(error) => Err(fault(error)),
        });
        // Mapped or still on its way there; a buffer that failed to map must not be unmapped.
        if !matches!(mapped, Ok(Err(_))) {
            buffer.unmap();
        }
        bytes
    }

    fn poll(&self, submission_index: Option<wgpu::SubmissionIndex>) -> Result<(), RenderError> {
        match self.device.poll(PollType::Wait { submission_index, timeout: Some(PATIENCE) }) {
            Ok(_) => Ok(()),
            Err(PollError::Timeout) => Err(RenderError::Timeout { seconds: PATIENCE.as_secs() }),
            Err(error) => Err(fault(&error)),
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

fn fault(error: &dyn std::fmt::Display) -> RenderError {
    RenderError::Gpu(one_line(&error.to_string()))
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

    #[test]
    fn empty_variables_are_unset() {
        assert_eq!(set(Ok("gl".to_owned())), Some("gl".to_owned()));
        assert_eq!(
            [set(Ok(String::new())), set(Ok(" ".to_owned())), set(Err(VarError::NotPresent))],
            [None, None, None]
        );
    }

    #[test]
    fn one_of_the_listed_adapters_is_chosen_and_it_is_the_one_that_is_taken() {
        let listed = choice("noop").list().unwrap();
        let chosen: Vec<_> = listed.iter().filter(|listed| listed.chosen).map(|listed| &listed.facts).collect();
        assert_eq!(chosen, [Gpu::headless(&choice("noop")).unwrap().facts()]);
        assert_eq!((chosen[0].backend, chosen[0].adapter_type), ("noop", "none"));
        let unknown = AdapterChoice { name: Some("voodoo".to_owned()), ..choice("noop") };
        assert!(unknown.list().unwrap().iter().all(|listed| !listed.chosen));
    }

    #[test]
    fn a_buffer_is_never_left_mapped() {
        let gpu = Gpu::headless(&choice("noop")).unwrap();
        let buffer = |usage| {
            let descriptor = wgpu::BufferDescriptor { label: None, size: 8, usage, mapped_at_creation: false };
            gpu.device.create_buffer(&descriptor)
        };
        let readable = buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
        gpu.faults.lock().unwrap().push("while a buffer is read".to_owned());
        assert!(gpu.read(&readable).unwrap_err().to_string().ends_with("while a buffer is read"));
        assert_eq!(gpu.read(&readable).unwrap(), [0; 8], "it was unmapped");
        gpu.read(&buffer(wgpu::BufferUsages::COPY_DST)).unwrap_err();
        gpu.check().expect("a buffer that cannot be mapped is not unmapped");
    }
}
