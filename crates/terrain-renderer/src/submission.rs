//! The two ways of sending a plan's draws: one call each, or one call for all. The pictures are the same.

use terrain_core::Draw;
use wgpu::BufferUsages;
use wgpu::util::DrawIndexedIndirectArgs;

use crate::Gpu;

/// How the draws of a plan are sent. That is the renderer's choice, not the method's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Submission {
    /// One draw call for each draw.
    #[default]
    Direct,
    /// The draws' arguments in a buffer, and one multi-draw-indirect call. Needs an adapter on which indirect draws
    /// may start at any instance ([`AdapterFacts::multi_draw_indirect`](crate::AdapterFacts)); on others the draws are
    /// sent one by one. wgpu validates the arguments on the GPU, in a compute pass of its own.
    MultiIndirect,
}

impl Submission {
    /// What is asked for where the adapter can do it, otherwise [`Submission::Direct`].
    pub(crate) fn possible_on(self, gpu: &Gpu) -> Self {
        if gpu.facts().multi_draw_indirect { self } else { Self::Direct }
    }
}

/// The indirect buffer of a method. It grows and never shrinks, so that the steady state allocates nothing.
#[derive(Debug)]
pub(crate) struct DrawArguments {
    arguments: Vec<DrawIndexedIndirectArgs>,
    buffer: wgpu::Buffer,
}

impl DrawArguments {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        Self { arguments: Vec::new(), buffer: create(gpu, 64) }
    }

    /// Queues the arguments of these draws; they are in the buffer before the next submission.
    pub(crate) fn write(&mut self, gpu: &Gpu, draws: &[Draw]) {
        self.arguments.clear();
        self.arguments.extend(draws.iter().map(arguments_of));
        let bytes: &[u8] = bytemuck::cast_slice(&self.arguments);
        if self.buffer.size() < bytes.len() as u64 {
            self.buffer = create(gpu, draws.len().next_power_of_two());
        }
        gpu.queue.write_buffer(&self.buffer, 0, bytes);
    }

    /// Draws everything that was written last; returns the number of calls made.
    pub(crate) fn draw(&self, pass: &mut wgpu::RenderPass) -> u32 {
        if self.arguments.is_empty() {
            return 0;
        }
        pass.multi_draw_indexed_indirect(&self.buffer, 0, self.arguments.len() as u32);
        1
    }
}

/// The numbers of draws, for colours alone: after the last one they begin again.
#[derive(Debug)]
pub(crate) struct DrawNumbers(wgpu::Buffer);

impl DrawNumbers {
    const COUNT: u32 = 64;
    /// What every adapter takes for a dynamic offset.
    const STRIDE: u32 = 256;
    /// Of one number, as the shader has it.
    pub(crate) const BYTES: u64 = 16;

    pub(crate) fn new(gpu: &Gpu) -> Self {
        let words = |draw| [draw].into_iter().chain([0; (Self::STRIDE / 4 - 1) as usize]);
        let numbers: Vec<u32> = (0..Self::COUNT).flat_map(words).collect();
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("draw numbers"),
            size: size_of_val(&numbers[..]) as u64,
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&numbers));
        Self(buffer)
    }

    pub(crate) fn binding(&self) -> wgpu::BindingResource<'_> {
        let size = wgpu::BufferSize::new(Self::BYTES);
        wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer: &self.0, offset: 0, size })
    }

    /// The dynamic offset of a draw.
    pub(crate) fn offset(draw: usize) -> u32 {
        draw as u32 % Self::COUNT * Self::STRIDE
    }
}

/// The same as [`draw_one_by_one`], each with a number of its own.
pub(crate) fn draw_numbered(pass: &mut wgpu::RenderPass, group: &wgpu::BindGroup, draws: &[Draw]) -> u32 {
    for (number, draw) in draws.iter().enumerate() {
        pass.set_bind_group(0, group, &[DrawNumbers::offset(number)]);
        pass.draw_indexed(draw.indices.clone(), draw.base_vertex, draw.instances.clone());
    }
    draws.len() as u32
}

/// One call for each draw; returns their number.
pub(crate) fn draw_one_by_one(pass: &mut wgpu::RenderPass, draws: &[Draw]) -> u32 {
    for draw in draws {
        pass.draw_indexed(draw.indices.clone(), draw.base_vertex, draw.instances.clone());
    }
    draws.len() as u32
}

fn arguments_of(draw: &Draw) -> DrawIndexedIndirectArgs {
    DrawIndexedIndirectArgs {
        index_count: draw.indices.len() as u32,
        instance_count: draw.instances.len() as u32,
        first_index: draw.indices.start,
        base_vertex: draw.base_vertex,
        first_instance: draw.instances.start,
    }
}

fn create(gpu: &Gpu, draws: usize) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("draw arguments"),
        size: (draws * size_of::<DrawIndexedIndirectArgs>()) as u64,
        usage: BufferUsages::INDIRECT | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}
