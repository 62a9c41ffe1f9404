//! Plans, views and looks become draws in a pass of the caller.
//!
//! ```text
//!  for each method:   pass.prepare(view, plan, look, buffers, bindings) ──> PreparedFrame
//!  once:              TerrainPass::begin(..) ──> wgpu::RenderPass
//!  for each method:   set_viewport, frame.draw(..), frame.draw_wireframe(..)
//!  once:              submit
//! ```
//!
//! What is queued is written before the submission, whatever is drawn in it. So a [`PreparedFrame`] borrows all that it
//! was prepared with: nothing can be prepared over it before it is drawn.

use terrain_core::{FramePlan, Morph, VertexKind, View};
use wgpu::TextureFormat;

use crate::look::Shading;
use crate::pipelines::{HeightSource, PipelineFactory, Pipelines, Variant, binding_layout, bindings};
use crate::submission::{DrawNumbers, draw_numbered, draw_one_by_one};
use crate::{Colour, FrameUniforms, Gpu, Look, MethodBuffers, RenderError, Scene, Submission};

/// Draws plans over one scene, into any pass with the formats that it was built for.
#[derive(Debug)]
pub struct TerrainPass {
    scene: Scene,
    pipelines: Pipelines,
    binding_layout: wgpu::BindGroupLayout,
    draw_numbers: DrawNumbers,
    submission: Submission,
}

/// The camera and the look of one view on the GPU. Each view of a submission needs its own.
#[derive(Debug)]
pub struct ViewBindings {
    uniforms: wgpu::Buffer,
    group: wgpu::BindGroup,
}

/// One plan in one view, ready to be drawn.
#[derive(Debug)]
pub struct PreparedFrame<'a> {
    fill: wgpu::RenderPipeline,
    /// Where the look has a wireframe.
    lines: Option<wgpu::RenderPipeline>,
    submission: Submission,
    is_numbered: bool,
    plan: &'a FramePlan,
    buffers: &'a MethodBuffers,
    bindings: &'a ViewBindings,
}

impl TerrainPass {
    /// Makes ready for a colour format; pipelines are built when a look needs them first. The depth format is [`Target::DEPTH_FORMAT`](crate::Target).
    pub fn new(
        gpu: &Gpu,
        scene: Scene,
        colour_format: TextureFormat,
        submission: Submission,
    ) -> Result<Self, RenderError> {
        let binding_layout = binding_layout(&gpu.device, &scene);
        let factory = PipelineFactory::new(gpu, &binding_layout, colour_format, scene.void_quads().is_some());
        let pass = Self {
            pipelines: Pipelines::new(factory),
            scene,
            binding_layout,
            draw_numbers: DrawNumbers::new(gpu),
            submission: submission.possible_on(gpu),
        };
        gpu.check()?;
        Ok(pass)
    }

    /// How draws are sent: what was asked for, where the adapter can do it.
    pub fn submission(&self) -> Submission {
        self.submission
    }

    /// Sends draws another way from the next frame on.
    pub fn submit_by(&mut self, gpu: &Gpu, submission: Submission) {
        self.submission = submission.possible_on(gpu);
    }

    /// Room for the camera and the look of one view.
    pub fn view_bindings(&self, gpu: &Gpu) -> ViewBindings {
        let uniforms = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame uniforms"),
            size: size_of::<FrameUniforms>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let group = bindings(&gpu.device, &self.binding_layout, &uniforms, &self.draw_numbers, &self.scene);
        ViewBindings { group, uniforms }
    }

    /// Queues the plan's uploads and all else that its draws will read.
    pub fn prepare<'a>(
        &'a self,
        gpu: &Gpu,
        view: &View,
        plan: &'a FramePlan,
        look: &Look,
        buffers: &'a mut MethodBuffers,
        bindings: &'a mut ViewBindings,
    ) -> Result<PreparedFrame<'a>, RenderError> {
        if buffers.vertex_kind() == VertexKind::Displaced && !buffers.has_tiles() && !self.scene.has_heights() {
            return Err(RenderError::NoHeights);
        }
        if look.wireframe && !gpu.facts().wireframe {
            return Err(RenderError::NoWireframe(gpu.facts().name.clone()));
        }
        buffers.apply(gpu, plan)?;
        if self.submission == Submission::MultiIndirect {
            buffers.write_arguments(gpu, &plan.draws)?;
        }
        let uniforms = FrameUniforms::new(view, &self.scene, plan, look, buffers.cell_side());
        gpu.queue.write_buffer(&bindings.uniforms, 0, bytemuck::bytes_of(&uniforms));
        let variant = Variant {
            source: height_source(buffers, plan),
            shading: Shading::of(look, self.scene.has_heights(), buffers.cell_side().is_some()),
            as_lines: false,
        };
        Ok(PreparedFrame {
            fill: self.pipelines.get(gpu, variant),
            lines: look.wireframe.then(|| self.pipelines.get(gpu, Variant { as_lines: true, ..variant })),
            submission: self.submission,
            is_numbered: look.colour == Colour::ByDraw,
            plan,
            buffers,
            bindings,
        })
    }

    /// Begins a pass that clears to the background and to the infinite distance.
    pub fn begin<'encoder>(
        encoder: &'encoder mut wgpu::CommandEncoder,
        colour: &wgpu::TextureView,
        depth: &wgpu::TextureView,
        look: &Look,
        timestamp_writes: Option<wgpu::RenderPassTimestampWrites>,
    ) -> wgpu::RenderPass<'encoder> {
        let [r, g, b, a] = look.background.map(f64::from);
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("terrain"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: colour,
                depth_slice: None,
                resolve_target: None,
                ops: clear(wgpu::Color { r, g, b, a }),
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: depth,
                depth_ops: Some(clear(0.0)),
                stencil_ops: None,
            }),
            timestamp_writes,
            ..Default::default()
        })
    }
}

fn height_source(buffers: &MethodBuffers, plan: &FramePlan) -> HeightSource {
    match buffers.vertex_kind() {
        VertexKind::Baked => HeightSource::Vertex,
        // Tiles do not glide: no method has both.
        VertexKind::Displaced if buffers.has_tiles() => HeightSource::Tiles,
        VertexKind::Displaced => {
            plan.morph.map_or(HeightSource::Scene, |Morph { k, levels, .. }| HeightSource::Morph { k, levels })
        }
    }
}

fn clear<T>(to: T) -> wgpu::Operations<T> {
    wgpu::Operations { load: wgpu::LoadOp::Clear(to), store: wgpu::StoreOp::Store }
}

impl PreparedFrame<'_> {
    /// Draws the plan's triangles; returns the number of draw calls made.
    pub fn draw(&self, pass: &mut wgpu::RenderPass) -> u32 {
        self.draw_with(&self.fill, pass)
    }

    /// Draws the triangles' edges over them, with a look that has a wireframe; returns the number of draw calls made.
    pub fn draw_wireframe(&self, pass: &mut wgpu::RenderPass) -> u32 {
        self.lines.as_ref().map_or(0, |lines| self.draw_with(lines, pass))
    }

    fn draw_with(&self, pipeline: &wgpu::RenderPipeline, pass: &mut wgpu::RenderPass) -> u32 {
        // Where nothing has ever been drawn the buffers may be empty, and wgpu panics where such are bound.
        if self.plan.draws.is_empty() {
            return 0;
        }
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &self.bindings.group, &[DrawNumbers::offset(0)]);
        self.buffers.bind(pass);
        match self.submission {
            Submission::Direct if self.is_numbered => draw_numbered(pass, &self.bindings.group, &self.plan.draws),
            Submission::Direct => draw_one_by_one(pass, &self.plan.draws),
            Submission::MultiIndirect => self.buffers.arguments().draw(pass),
        }
    }
}
