//! The buffers of one method on the GPU, and the arguments of its draws.

use terrain_core::{Buffer, BufferSizes, Draw, FramePlan, Growth, IndexFormat, PatchInstance, VertexKind};
use wgpu::BufferUsages;

use crate::submission::DrawArguments;
use crate::tiles::TileBuffer;
use crate::{Gpu, RenderError};

/// Vertices, indices, instances and height tiles of one method; written by its plans alone. They hold one plan: a method that is
/// drawn twice in one submission, by two plans, needs them twice.
#[derive(Debug)]
pub struct MethodBuffers {
    sizes: BufferSizes,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    instances: wgpu::Buffer,
    heights: Option<TileBuffer>,
    arguments: DrawArguments,
}

impl MethodBuffers {
    /// Buffers of these sizes; refuses what the adapter cannot hold.
    pub fn new(gpu: &Gpu, sizes: BufferSizes) -> Result<Self, RenderError> {
        let buffers = Self {
            sizes,
            vertices: create(gpu, "vertex", sizes.vertices, BufferUsages::VERTEX)?,
            indices: create(gpu, "index", sizes.indices, BufferUsages::INDEX)?,
            instances: create(gpu, "instance", sizes.instances, BufferUsages::VERTEX)?,
            heights: sizes.heights.as_ref().map(|tiles| TileBuffer::new(gpu, tiles)).transpose()?,
            arguments: DrawArguments::new(gpu),
        };
        gpu.check()?; // out of memory, for one
        Ok(buffers)
    }

    /// Where the vertices get their heights from.
    pub fn vertex_kind(&self) -> VertexKind {
        self.sizes.vertex_kind
    }

    /// Sample intervals along the cells that the method loads; none where it has no such.
    pub(crate) fn cell_side(&self) -> Option<u32> {
        self.sizes.cell_side
    }

    /// Whether displaced vertices take their heights from the method's own tiles.
    pub fn has_tiles(&self) -> bool {
        self.heights.is_some()
    }

    /// Enlarges what the plan enlarges and queues its uploads, in order; they happen before the next submission. For
    /// plans that are not drawn: [`TerrainPass::prepare`](crate::TerrainPass::prepare) does the same.
    pub fn apply(&mut self, gpu: &Gpu, plan: &FramePlan) -> Result<(), RenderError> {
        for growth in &plan.growths {
            self.grow(gpu, growth)?;
        }
        for upload in &plan.uploads {
            gpu.queue.write_buffer(self.get_mut(upload.buffer), upload.offset, plan.bytes_of(upload));
        }
        Ok(())
    }

    /// Moves a buffer's content to a larger one. Submitted at once: what is queued later must find it there.
    fn grow(&mut self, gpu: &Gpu, growth: &Growth) -> Result<(), RenderError> {
        let (label, usage) = match growth.buffer {
            Buffer::Vertices => ("vertex", BufferUsages::VERTEX),
            Buffer::Indices => ("index", BufferUsages::INDEX),
            Buffer::Instances => ("instance", BufferUsages::VERTEX),
            Buffer::Heights => unreachable!("height tiles keep their size"),
        };
        let larger = create(gpu, label, growth.bytes, usage)?;
        gpu.check()?; // out of memory, for one
        let smaller = self.get_mut(growth.buffer);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(smaller, 0, &larger, 0, smaller.size());
        gpu.queue.submit([encoder.finish()]);
        *smaller = larger;
        self.sizes.grow(growth);
        Ok(())
    }

    /// Makes them the vertex and index buffers of a pass, and its height tiles.
    pub(crate) fn bind(&self, pass: &mut wgpu::RenderPass) {
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        if self.sizes.vertex_kind == VertexKind::Displaced {
            pass.set_vertex_buffer(1, self.instances.slice(..));
        }
        if let Some(heights) = &self.heights {
            pass.set_bind_group(1, &heights.group, &[]);
        }
        let format = match self.sizes.index_format {
            IndexFormat::U16 => wgpu::IndexFormat::Uint16,
            IndexFormat::U32 => wgpu::IndexFormat::Uint32,
        };
        pass.set_index_buffer(self.indices.slice(..), format);
    }

    /// Queues the arguments of indirect draws.
    pub(crate) fn write_arguments(&mut self, gpu: &Gpu, draws: &[Draw]) -> Result<(), RenderError> {
        self.check(draws)?;
        self.arguments.write(gpu, draws);
        Ok(())
    }

    /// What was written last.
    pub(crate) fn arguments(&self) -> &DrawArguments {
        &self.arguments
    }

    /// Fails where a draw reads beyond the index or the instance buffer: wgpu refuses a direct draw that does so but
    /// silently drops an indirect one.
    fn check(&self, draws: &[Draw]) -> Result<(), RenderError> {
        let displaced = self.sizes.vertex_kind == VertexKind::Displaced;
        for (draw, Draw { indices, instances, .. }) in draws.iter().enumerate() {
            if u64::from(indices.end) * self.sizes.index_format.bytes() > self.sizes.indices {
                return Err(RenderError::DrawBeyondBuffer { draw, buffer: "index", bytes: self.sizes.indices });
            }
            if displaced && u64::from(instances.end) * size_of::<PatchInstance>() as u64 > self.sizes.instances {
                return Err(RenderError::DrawBeyondBuffer { draw, buffer: "instance", bytes: self.sizes.instances });
            }
        }
        Ok(())
    }

    fn get_mut(&mut self, buffer: Buffer) -> &mut wgpu::Buffer {
        match buffer {
            Buffer::Vertices => &mut self.vertices,
            Buffer::Indices => &mut self.indices,
            Buffer::Instances => &mut self.instances,
            Buffer::Heights => &mut self.heights.as_mut().expect("a plan with heights has tiles").codes,
        }
    }
}

fn create(gpu: &Gpu, label: &'static str, bytes: u64, usage: BufferUsages) -> Result<wgpu::Buffer, RenderError> {
    let limit = gpu.device.limits().max_buffer_size;
    if bytes > limit {
        return Err(RenderError::BufferTooLarge { buffer: label, bytes, limit });
    }
    Ok(gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: bytes,
        usage: usage | BufferUsages::COPY_DST | BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    }))
}
