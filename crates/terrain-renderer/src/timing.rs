//! What the GPU itself says of a pass: how long it took, and how many primitives it was given.

use std::time::Duration;

use wgpu::{BufferUsages, PipelineStatisticsTypes, QueryType};

use crate::{Gpu, RenderError};

/// What measures one pass, as far as the adapter can.
#[derive(Debug)]
pub(crate) struct Gauges {
    timer: Option<PassTimer>,
    counter: Option<PrimitiveCounter>,
}

impl Gauges {
    pub(crate) fn new(gpu: &Gpu, count_primitives: bool) -> Self {
        let counter = count_primitives.then(|| PrimitiveCounter::new(gpu)).flatten();
        Self { timer: PassTimer::new(gpu), counter }
    }

    pub(crate) fn timestamp_writes(&self) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        self.timer.as_ref().map(PassTimer::writes)
    }

    /// Draws, and counts the primitives of these draws.
    pub(crate) fn count<T>(&self, pass: &mut wgpu::RenderPass, draw: impl FnOnce(&mut wgpu::RenderPass) -> T) -> T {
        match &self.counter {
            Some(counter) => counter.around(pass, draw),
            None => draw(pass),
        }
    }

    /// Makes the measurements readable; to be recorded after the pass.
    pub(crate) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        let queries =
            [self.timer.as_ref().map(|timer| &timer.queries), self.counter.as_ref().map(|counter| &counter.0)];
        queries.into_iter().flatten().for_each(|queries| queries.resolve(encoder));
    }

    /// Duration and primitives of the pass that finished last.
    pub(crate) fn read(&self, gpu: &Gpu) -> Result<(Option<Duration>, Option<u64>), RenderError> {
        let duration = self.timer.as_ref().map(|timer| timer.read(gpu)).transpose()?;
        let primitives = self.counter.as_ref().map(|counter| counter.read(gpu)).transpose()?;
        Ok((duration, primitives))
    }
}

/// Begin and end of a pass, as GPU timestamps.
#[derive(Debug)]
struct PassTimer {
    queries: Queries,
    tick_ns: f64,
}

impl PassTimer {
    /// A timer, where the adapter has timestamps.
    fn new(gpu: &Gpu) -> Option<Self> {
        let tick_ns = f64::from(gpu.queue.get_timestamp_period());
        gpu.facts().timestamps.then(|| Self { queries: Queries::new(gpu, QueryType::Timestamp, 2), tick_ns })
    }

    fn writes(&self) -> wgpu::RenderPassTimestampWrites<'_> {
        wgpu::RenderPassTimestampWrites {
            query_set: &self.queries.set,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        }
    }

    /// Duration of the pass that finished last.
    fn read(&self, gpu: &Gpu) -> Result<Duration, RenderError> {
        let ticks = self.queries.read(gpu)?;
        Ok(Duration::from_nanos((ticks[1].saturating_sub(ticks[0]) as f64 * self.tick_ns) as u64))
    }
}

/// Primitives that reach the clipper: all triangles of the draws, visible or not.
#[derive(Debug)]
struct PrimitiveCounter(Queries);

impl PrimitiveCounter {
    /// A counter, where the adapter has pipeline statistics.
    fn new(gpu: &Gpu) -> Option<Self> {
        let query = QueryType::PipelineStatistics(PipelineStatisticsTypes::CLIPPER_INVOCATIONS);
        gpu.facts().pipeline_statistics.then(|| Self(Queries::new(gpu, query, 1)))
    }

    fn around<T>(&self, pass: &mut wgpu::RenderPass, draw: impl FnOnce(&mut wgpu::RenderPass) -> T) -> T {
        pass.begin_pipeline_statistics_query(&self.0.set, 0);
        let drawn = draw(pass);
        pass.end_pipeline_statistics_query();
        drawn
    }

    /// Count of the pass that finished last.
    fn read(&self, gpu: &Gpu) -> Result<u64, RenderError> {
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
