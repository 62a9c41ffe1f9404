//! The pipelines of `shaders/terrain.wgsl` and what they bind.
//!
//! | pipeline | vertex entry point | fragment entry point | depth |
//! |---|---|---|---|
//! | baked | `vertex_baked` | `fragment_terrain` | tested and written |
//! | displaced | `vertex_displaced` | `fragment_terrain` | tested and written |
//! | morphed | `vertex_morphed` | `fragment_terrain` | tested and written |
//! | tiled | `vertex_tiled` | `fragment_terrain` | tested and written |
//! | the same as lines | the same | `fragment_wireframe` | a little nearer, tested |
//! | each of these over voids | the same | the same `.._with_voids` | the same, but not before the fragments |

use std::sync::{Mutex, PoisonError};

use terrain_core::{BakedVertex, LocalVertex, PatchInstance};
use wgpu::{ShaderStages, TextureFormat, VertexStepMode, vertex_attr_array};

use crate::look::Shading;
use crate::submission::DrawNumbers;
use crate::tiles::tile_layout;
use crate::{FrameUniforms, Gpu, Scene, Target};

const SHADER: &str = include_str!("../../../shaders/terrain.wgsl");

/// Where a pipeline's vertices get their heights from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HeightSource {
    /// [`VertexKind::Baked`](terrain_core::VertexKind): the vertex.
    Vertex,
    /// [`VertexKind::Displaced`](terrain_core::VertexKind): the scene.
    Scene,
    /// The same, moved by the plan's [`Morph`](terrain_core::Morph) with these numbers.
    Morph { k: u32, levels: u32 },
    /// The same, with [`HeightTiles`](terrain_core::HeightTiles): the method's tiles.
    Tiles,
}

/// What tells one pipeline from another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Variant {
    pub(crate) source: HeightSource,
    pub(crate) shading: Shading,
    pub(crate) as_lines: bool,
}

/// The pipelines that have been asked for so far: a program uses few of all that there could be.
#[derive(Debug)]
pub(crate) struct Pipelines {
    factory: PipelineFactory,
    made: Mutex<Vec<(Variant, wgpu::RenderPipeline)>>,
}

impl Pipelines {
    pub(crate) fn new(factory: PipelineFactory) -> Self {
        Self { factory, made: Mutex::default() }
    }

    /// Made when it is asked for first.
    pub(crate) fn get(&self, gpu: &Gpu, variant: Variant) -> wgpu::RenderPipeline {
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, pipeline)) = made.iter().find(|(other, _)| *other == variant) {
            return pipeline.clone();
        }
        let pipeline = self.factory.pipeline(gpu, variant);
        made.push((variant, pipeline.clone()));
        pipeline
    }
}

/// Group 0 of the shader: uniforms, heights, normals, the sampler of the normals, the number of the draw, and the void quads
/// where there are any.
pub(crate) fn binding_layout(device: &wgpu::Device, scene: &Scene) -> wgpu::BindGroupLayout {
    let entry = |binding, visibility, ty| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
    let texture = |sample_type| wgpu::BindingType::Texture {
        sample_type,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let uniforms = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: wgpu::BufferSize::new(size_of::<FrameUniforms>() as u64),
    };
    let draw_numbers = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: true,
        min_binding_size: wgpu::BufferSize::new(DrawNumbers::BYTES),
    };
    let float = |filterable| texture(wgpu::TextureSampleType::Float { filterable });
    let mut entries = vec![
        entry(0, ShaderStages::VERTEX_FRAGMENT, uniforms),
        entry(1, ShaderStages::VERTEX_FRAGMENT, float(false)),
        entry(2, ShaderStages::VERTEX_FRAGMENT, float(true)),
        entry(3, ShaderStages::FRAGMENT, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
        entry(5, ShaderStages::FRAGMENT, draw_numbers),
    ];
    let void_quads = || entry(4, ShaderStages::FRAGMENT, texture(wgpu::TextureSampleType::Uint));
    entries.extend(scene.void_quads().map(|_| void_quads()));
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("terrain"), entries: &entries })
}

pub(crate) fn bindings(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    uniforms: &wgpu::Buffer,
    draw_numbers: &DrawNumbers,
    scene: &Scene,
) -> wgpu::BindGroup {
    let bilinear = device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("bilinear"),
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    });
    let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
    let mut entries = vec![
        entry(0, uniforms.as_entire_binding()),
        entry(1, wgpu::BindingResource::TextureView(scene.heights())),
        entry(2, wgpu::BindingResource::TextureView(scene.normals())),
        entry(3, wgpu::BindingResource::Sampler(&bilinear)),
        entry(5, draw_numbers.binding()),
    ];
    entries.extend(scene.void_quads().map(|quads| entry(4, wgpu::BindingResource::TextureView(quads))));
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some("terrain"), layout, entries: &entries })
}

/// The darker of two colours, channel by channel: the order of drawing leaves no trace. (Maximum of alpha, so that a
/// line over a transparent background is seen.)
const DARKER: wgpu::BlendState =
    wgpu::BlendState { color: component(wgpu::BlendOperation::Min), alpha: component(wgpu::BlendOperation::Max) };

const fn component(operation: wgpu::BlendOperation) -> wgpu::BlendComponent {
    wgpu::BlendComponent { src_factor: wgpu::BlendFactor::One, dst_factor: wgpu::BlendFactor::One, operation }
}

/// Reversed depth: nearer is greater. Lines are tested against the finished terrain and not against each other.
///
/// A line passes up to half a pixel beside the centres of the pixels that it covers, and the terrain's depth is that of
/// the centres. So a line is pulled nearer by what its triangle's depth changes over a pixel and a half.
fn depth_state(as_lines: bool) -> wgpu::DepthStencilState {
    let pulled = wgpu::DepthBiasState { constant: 4, slope_scale: 1.5, clamp: 0.0 };
    wgpu::DepthStencilState {
        format: Target::DEPTH_FORMAT,
        depth_write_enabled: Some(!as_lines),
        depth_compare: Some(wgpu::CompareFunction::Greater),
        stencil: wgpu::StencilState::default(),
        bias: if as_lines { pulled } else { wgpu::DepthBiasState::default() },
    }
}

/// The values of all `override`s of the shader.
fn constants(Variant { source, shading, .. }: Variant) -> [(&'static str, f64); 5] {
    let (k, levels) = match source {
        HeightSource::Morph { k, levels } => (k, levels),
        _ => (1, 0),
    };
    [
        ("COLOUR", shading.colour.into()),
        ("NORMALS", shading.normals.into()),
        ("MARK_STALE", u8::from(shading.mark_stale).into()),
        ("MORPH_K", k.into()),
        ("MORPH_LEVELS", levels.into()),
    ]
}

/// What all pipelines share.
#[derive(Debug)]
pub(crate) struct PipelineFactory {
    shader: wgpu::ShaderModule,
    /// Without and with the group of the height tiles.
    layouts: [wgpu::PipelineLayout; 2],
    colour_format: TextureFormat,
    has_voids: bool,
}

impl PipelineFactory {
    pub(crate) fn new(
        gpu: &Gpu,
        binding_layout: &wgpu::BindGroupLayout,
        colour_format: TextureFormat,
        has_voids: bool,
    ) -> Self {
        let shader = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("terrain.wgsl"),
            source: wgpu::ShaderSource::Wgsl(SHADER.into()),
        });
        let layout = |bind_group_layouts: &[Option<&wgpu::BindGroupLayout>]| {
            let label = Some("terrain");
            let descriptor = wgpu::PipelineLayoutDescriptor { label, bind_group_layouts, immediate_size: 0 };
            gpu.device.create_pipeline_layout(&descriptor)
        };
        let tiles = tile_layout(&gpu.device);
        let layouts = [layout(&[Some(binding_layout)]), layout(&[Some(binding_layout), Some(&tiles)])];
        Self { shader, layouts, colour_format, has_voids }
    }

    fn pipeline(&self, gpu: &Gpu, variant: Variant) -> wgpu::RenderPipeline {
        let Variant { source, as_lines, .. } = variant;
        let polygon_mode = if as_lines { wgpu::PolygonMode::Line } else { wgpu::PolygonMode::Fill };
        let constants = constants(variant);
        let compilation_options =
            wgpu::PipelineCompilationOptions { constants: &constants, ..wgpu::PipelineCompilationOptions::default() };
        let fragment = match (as_lines, self.has_voids) {
            (false, false) => "fragment_terrain",
            (false, true) => "fragment_terrain_with_voids",
            (true, false) => "fragment_wireframe",
            (true, true) => "fragment_wireframe_with_voids",
        };
        let target = wgpu::ColorTargetState {
            format: self.colour_format,
            blend: as_lines.then_some(DARKER),
            write_mask: wgpu::ColorWrites::ALL,
        };
        gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(fragment),
            layout: Some(&self.layouts[(source == HeightSource::Tiles) as usize]),
            vertex: self.vertex_state(source, compilation_options.clone()),
            primitive: wgpu::PrimitiveState { cull_mode: Some(wgpu::Face::Back), polygon_mode, ..Default::default() },
            depth_stencil: Some(depth_state(as_lines)),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &self.shader,
                entry_point: Some(fragment),
                compilation_options,
                targets: &[Some(target)],
            }),
            multiview_mask: None,
            cache: None,
        })
    }

    fn vertex_state<'a>(
        &'a self,
        source: HeightSource,
        compilation_options: wgpu::PipelineCompilationOptions<'a>,
    ) -> wgpu::VertexState<'a> {
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
        let (entry_point, buffers) = match source {
            HeightSource::Vertex => ("vertex_baked", BAKED),
            HeightSource::Scene => ("vertex_displaced", DISPLACED),
            HeightSource::Morph { .. } => ("vertex_morphed", DISPLACED),
            HeightSource::Tiles => ("vertex_tiled", DISPLACED),
        };
        wgpu::VertexState { module: &self.shader, entry_point: Some(entry_point), compilation_options, buffers }
    }
}
