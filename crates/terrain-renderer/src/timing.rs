//! What the GPU itself says of a pass: how long it took, and how many primitives it was given.

use std::time::Duration;

use wgpu::{BufferUsages, PipelineStatisticsTypes, QueryType};

use crate::{Gpu, RenderError};

/// Begin and end of a pass, as GPU timestamps.
#[derive(Debug)]
pub(crate) struct PassTimer {
    queries: Queries,
    tick_ns: f64,
}

impl PassTimer {
    /// A timer, where the adapter has timestamps.
    pub(crate) fn new(gpu: &Gpu) -> Option<Self> {
        let tick_ns = f64::from(gpu.queue.get_timestamp_period());
        gpu.facts().timestamps.then(|| Self { queries: Queries::new(gpu, QueryType::Timestamp, 2), tick_ns })
    }

    pub(crate) fn writes(&self) -> wgpu::RenderPassTimestampWrites<'_> {
        wgpu::RenderPassTimestampWrites {
            query_set: &self.queries.set,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        }
    }

    pub(crate) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        self.queries.resolve(encoder);
    }

    /// Duration of the pass that finished last.
    pub(crate) fn read(&self, gpu: &Gpu) -> Result<Duration, RenderError> {
        let ticks = self.queries.read(gpu)?;
        Ok(Duration::from_nanos((ticks[1].saturating_sub(ticks[0]) as f64 * self.tick_ns) as u64))
    }
}

/// Primitives that reach the clipper: all triangles of the draws, visible or not.
#[derive(Debug)]
pub(crate) struct PrimitiveCounter(Queries);

impl PrimitiveCounter {
    /// A counter, where the adapter has pipeline statistics.
    pub(crate) fn new(gpu: &Gpu) -> Option<Self> {
        let query = QueryType::PipelineStatistics(PipelineStatisticsTypes::CLIPPER_INVOCATIONS);
        gpu.facts().pipeline_statistics.then(|| Self(Queries::new(gpu, query, 1)))
    }

    pub(crate) fn begin(&self, pass: &mut wgpu::RenderPass) {
        pass.begin_pipeline_statistics_query(&self.0.set, 0);
    }

    pub(crate) fn end(&self, pass: &mut wgpu::RenderPass) {
        pass.end_pipeline_statistics_query();
    }

    pub(crate) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        self.0.resolve(encoder);
    }

    /// Count of the pass that finished last.
    pub(crate) fn read(&self, gpu: &Gpu) -> Result<u64, RenderError> {
        Ok(self.0.read(gpu)?[0])
    }
}

/// A query set whose results are single `u64`s, and the way back to the CPU: set, resolved, readable.
#[derive(Debug)]
struct Queries {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readable: wgpu::Buffer,
}

impl Queries {
    fn new(gpu: &Gpu, ty: QueryType, count: u32) -> Self {
        let set = gpu.device.create_query_set(&wgpu::QuerySetDescriptor { label: Some("queries"), ty, count });
        let buffer = |usage| {
            let size = u64::from(count) * size_of::<u64>() as u64;
            let label = Some("query results");
            gpu.device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false })
        };
        Self {
            set,
            resolved: buffer(BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC),
            readable: buffer(BufferUsages::MAP_READ | BufferUsages::COPY_DST),
        }
    }

    fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.set, 0..self.set.count(), &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.readable, 0, self.readable.size());
    }

    fn read(&self, gpu: &Gpu) -> Result<Vec<u64>, RenderError> {
        Ok(bytemuck::pod_collect_to_vec(&gpu.read(&self.readable)?))
    }
}
