//! The pipelines of `shaders/terrain.wgsl` and the one pass that draws a plan with them.
//!
//! | pipeline | vertex entry point | fragment entry point |
//! |---|---|---|
//! | baked | `vertex_baked` | `fragment_terrain` |
//! | displaced | `vertex_displaced` | `fragment_terrain` |
//! | the same as lines | the same, pulled towards the eye | `fragment_wireframe` |

use terrain_core::{BakedVertex, FramePlan, LocalVertex, PatchInstance, VertexKind, View};
use wgpu::{ShaderStages, TextureFormat, VertexStepMode, vertex_attr_array};

use crate::submission::{DrawArguments, draw_one_by_one};
use crate::{FrameUniforms, Gpu, Look, MethodBuffers, RenderError, Scene, Submission, Target};

const SHADER: &str = include_str!("../../../shaders/terrain.wgsl");

/// Share of its distance by which a wireframe stands nearer to the eye than the triangles that it outlines.
const WIREFRAME_PULL: f64 = 0.002;

/// Draws plans over one scene, into any pass with the formats that it was built for.
#[derive(Debug)]
pub struct TerrainPass {
    baked: Pipelines,
    displaced: Pipelines,
    uniforms: wgpu::Buffer,
    bindings: wgpu::BindGroup,
    submission: Submission,
    arguments: DrawArguments,
}

#[derive(Debug)]
struct Pipelines {
    fill: wgpu::RenderPipeline,
    /// Only on adapters that can draw triangles as lines.
    lines: Option<wgpu::RenderPipeline>,
}

impl TerrainPass {
    /// Builds the pipelines for a colour format; the depth format is [`Target::DEPTH_FORMAT`].
    pub fn new(
        gpu: &Gpu,
        scene: &Scene,
        colour_format: TextureFormat,
        submission: Submission,
    ) -> Result<Self, RenderError> {
        let uniforms = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame uniforms"),
            size: size_of::<FrameUniforms>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let binding_layout = binding_layout(&gpu.device);
        let factory = PipelineFactory::new(gpu, &binding_layout, colour_format);
        let pass = Self {
            baked: factory.pipelines(VertexKind::Baked),
            displaced: factory.pipelines(VertexKind::Displaced),
            bindings: bindings(&gpu.device, &binding_layout, &uniforms, scene),
            uniforms,
            submission: submission.possible_on(gpu),
            arguments: DrawArguments::new(gpu),
        };
        gpu.check()?;
        Ok(pass)
    }

    /// How draws are sent: what was asked for, where the adapter can do it.
    pub fn submission(&self) -> Submission {
        self.submission
    }

    /// Queues what the draws of a frame read besides the method's buffers. To be called before the submission.
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        view: &View,
        plan: &FramePlan,
        buffers: &MethodBuffers,
        look: &Look,
    ) -> Result<(), RenderError> {
        if look.wireframe && self.baked.lines.is_none() {
            return Err(RenderError::NoWireframe(gpu.facts().name.clone()));
        }
        let uniforms = FrameUniforms::new(view, scene, look);
        gpu.queue.write_buffer(&self.uniforms, 0, bytemuck::bytes_of(&uniforms));
        if self.submission == Submission::MultiIndirect {
            // wgpu refuses a direct draw beyond the buffers but silently drops an indirect one.
            buffers.check(&plan.draws)?;
            self.arguments.write(gpu, &plan.draws);
        }
        Ok(())
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

    /// Draws the plan's triangles; returns the number of draw calls made.
    pub fn draw(&self, pass: &mut wgpu::RenderPass, plan: &FramePlan, buffers: &MethodBuffers) -> u32 {
        self.draw_with(&self.pipelines(buffers).fill, pass, plan, buffers)
    }

    /// Draws the triangles' edges over them; returns the number of draw calls made, which is 0 on an adapter that
    /// cannot ([`Self::prepare`] has failed there).
    pub fn draw_wireframe(&self, pass: &mut wgpu::RenderPass, plan: &FramePlan, buffers: &MethodBuffers) -> u32 {
        let lines = self.pipelines(buffers).lines.as_ref();
        lines.map_or(0, |pipeline| self.draw_with(pipeline, pass, plan, buffers))
    }

    fn draw_with(
        &self,
        pipeline: &wgpu::RenderPipeline,
        pass: &mut wgpu::RenderPass,
        plan: &FramePlan,
        buffers: &MethodBuffers,
    ) -> u32 {
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &self.bindings, &[]);
        buffers.bind(pass);
        match self.submission {
            Submission::Direct => draw_one_by_one(pass, &plan.draws),
            Submission::MultiIndirect => self.arguments.draw(pass),
        }
    }

    fn pipelines(&self, buffers: &MethodBuffers) -> &Pipelines {
        match buffers.vertex_kind() {
            VertexKind::Baked => &self.baked,
            VertexKind::Displaced => &self.displaced,
        }
    }
}

fn clear<T>(to: T) -> wgpu::Operations<T> {
    wgpu::Operations { load: wgpu::LoadOp::Clear(to), store: wgpu::StoreOp::Store }
}

/// Group 0 of the shader: uniforms, heights, normals, and the sampler of the normals.
fn binding_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry = |binding, visibility, ty| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
    let texture = |filterable| wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let uniforms = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: wgpu::BufferSize::new(size_of::<FrameUniforms>() as u64),
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("terrain"),
        entries: &[
            entry(0, ShaderStages::VERTEX_FRAGMENT, uniforms),
            entry(1, ShaderStages::VERTEX, texture(false)),
            entry(2, ShaderStages::FRAGMENT, texture(true)),
            entry(3, ShaderStages::FRAGMENT, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
        ],
    })
}

fn bindings(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    uniforms: &wgpu::Buffer,
    scene: &Scene,
) -> wgpu::BindGroup {
    let bilinear = device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("bilinear"),
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    });
    let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("terrain"),
        layout,
        entries: &[
            entry(0, uniforms.as_entire_binding()),
            entry(1, wgpu::BindingResource::TextureView(scene.heights())),
            entry(2, wgpu::BindingResource::TextureView(scene.normals())),
            entry(3, wgpu::BindingResource::Sampler(&bilinear)),
        ],
    })
}

/// What all pipelines share.
struct PipelineFactory<'a> {
    gpu: &'a Gpu,
    shader: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
    colour_format: TextureFormat,
}

impl<'a> PipelineFactory<'a> {
    fn new(gpu: &'a Gpu, binding_layout: &wgpu::BindGroupLayout, colour_format: TextureFormat) -> Self {
        let shader = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("terrain.wgsl"),
            source: wgpu::ShaderSource::Wgsl(SHADER.into()),
        });
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("terrain"),
            bind_group_layouts: &[Some(binding_layout)],
            immediate_size: 0,
        });
        Self { gpu, shader, layout, colour_format }
    }

    fn pipelines(&self, kind: VertexKind) -> Pipelines {
        let lines = || self.pipeline(kind, wgpu::PolygonMode::Line);
        Pipelines { fill: self.pipeline(kind, wgpu::PolygonMode::Fill), lines: self.gpu.facts().wireframe.then(lines) }
    }

    fn pipeline(&self, kind: VertexKind, polygon_mode: wgpu::PolygonMode) -> wgpu::RenderPipeline {
        let (fragment, pull, blend) = match polygon_mode {
            wgpu::PolygonMode::Line => ("fragment_wireframe", WIREFRAME_PULL, wgpu::BlendState::ALPHA_BLENDING),
            _ => ("fragment_terrain", 0.0, wgpu::BlendState::REPLACE),
        };
        let target = wgpu::ColorTargetState {
            format: self.colour_format,
            blend: Some(blend),
            write_mask: wgpu::ColorWrites::ALL,
        };
        self.gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(fragment),
            layout: Some(&self.layout),
            vertex: self.vertex_state(kind, &[("pull", pull)]),
            primitive: wgpu::PrimitiveState { cull_mode: Some(wgpu::Face::Back), polygon_mode, ..Default::default() },
            depth_stencil: Some(wgpu::DepthStencilState {
                format: Target::DEPTH_FORMAT,
                depth_write_enabled: Some(true),
                // Reversed depth: nearer is greater.
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &self.shader,
                entry_point: Some(fragment),
                compilation_options: Default::default(),
                targets: &[Some(target)],
            }),
            multiview_mask: None,
            cache: None,
        })
    }

    fn vertex_state<'b>(&'b self, kind: VertexKind, constants: &'b [(&'b str, f64)]) -> wgpu::VertexState<'b> {
        const BAKED: &[Option<wgpu::VertexBufferLayout<'static>>] = &[Some(wgpu::VertexBufferLayout {
            array_stride: size_of::<BakedVertex>() as u64,
            step_mode: VertexStepMode::Vertex,
            attributes: &vertex_attr_array![0 => Uint16x2, 1 => Float32],
        })];
        const DISPLACED: &[Option<wgpu::VertexBufferLayout<'static>>] = &[
            Some(wgpu::VertexBufferLayout {
                array_stride: size_of::<LocalVertex>() as u64,
                step_mode: VertexStepMode::Vertex,
                attributes: &vertex_attr_array![0 => Uint16x2],
            }),
            Some(wgpu::VertexBufferLayout {
                array_stride: size_of::<PatchInstance>() as u64,
                step_mode: VertexStepMode::Instance,
                attributes: &vertex_attr_array![1 => Sint32x2, 2 => Sint16x2, 3 => Sint16x2, 4 => Uint32],
            }),
        ];
        let (entry_point, buffers) = match kind {
            VertexKind::Baked => ("vertex_baked", BAKED),
            VertexKind::Displaced => ("vertex_displaced", DISPLACED),
        };
        wgpu::VertexState {
            module: &self.shader,
            entry_point: Some(entry_point),
            compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
            buffers,
        }
    }
}
