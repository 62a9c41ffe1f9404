//! Heights that a method brings along: a storage buffer and where its tiles are, group 1 of `shaders/terrain.wgsl`.

use bytemuck::{Pod, Zeroable};
use terrain_core::{HeightFormat, HeightTiles};
use wgpu::{BindGroupLayout, BufferUsages, ShaderStages};

use crate::{Gpu, RenderError};

/// `struct Tiles` of `shaders/terrain.wgsl`: [`HeightTiles`] as the shader needs them.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TileUniforms {
    /// [`HeightTiles::coarse_level`].
    pub coarse_level: u32,
    /// [`HeightTiles::coarse_step`].
    pub coarse_step: u32,
    /// Columns of the coarse grid.
    pub coarse_columns: u32,
    /// [`HeightTiles::cell_side`].
    pub cell_side: u32,
    /// Bytes of a code: 2, or 4 where it is the height itself.
    pub code_bytes: u32,
    /// Metres of one step.
    pub scale_m: f32,
    /// Metres at code 0.
    pub offset_m: f32,
    /// Up to a multiple of 16 bytes.
    pub padding: u32,
    /// By level below the coarse one.
    pub levels: [LevelUniforms; HeightTiles::MAX_LEVELS],
}

/// `struct TileLevel` of `shaders/terrain.wgsl`: the tiles of one level.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LevelUniforms {
    /// Of [`HeightTiles::windows`].
    pub window: u32,
    /// [`HeightTiles::step`].
    pub step: u32,
    /// Code at which the level's tiles begin.
    pub first_tile: u32,
    /// Codes from one tile to the next.
    pub tile_codes: u32,
}

impl LevelUniforms {
    fn new(tiles: &HeightTiles, level: u32) -> Self {
        Self {
            window: tiles.windows[level as usize],
            step: tiles.step(level),
            first_tile: tiles.first_tile(level) as u32,
            tile_codes: tiles.tile_codes(level) as u32,
        }
    }
}

impl TileUniforms {
    /// The uniforms of these tiles.
    ///
    /// The shader decodes in f32: heights differ from [`HeightFormat::decode`] by no more than offset and height are rounded,
    /// all vertices of one sample alike.
    pub fn new(tiles: &HeightTiles) -> Self {
        let [scale_m, offset_m] = match tiles.format {
            HeightFormat::F32 => [1.0, 0.0],
            HeightFormat::U16 { scale_m, offset_m } => [scale_m as f32, offset_m as f32],
        };
        let mut levels = [LevelUniforms::default(); HeightTiles::MAX_LEVELS];
        for (level, uniforms) in (0..tiles.coarse_level).zip(&mut levels) {
            *uniforms = LevelUniforms::new(tiles, level);
        }
        Self {
            coarse_level: tiles.coarse_level,
            coarse_step: tiles.coarse_step(),
            coarse_columns: tiles.coarse_size()[0],
            cell_side: tiles.cell_side,
            code_bytes: tiles.format.bytes() as u32,
            scale_m,
            offset_m,
            padding: 0,
            levels,
        }
    }
}

/// Group 1: the uniforms and the codes, both for vertices alone.
pub(crate) fn tile_layout(device: &wgpu::Device) -> BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: ShaderStages::VERTEX,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("height tiles"),
        entries: &[
            entry(0, wgpu::BufferBindingType::Uniform),
            entry(1, wgpu::BufferBindingType::Storage { read_only: true }),
        ],
    })
}

/// The heights of one method.
#[derive(Debug)]
pub(crate) struct TileBuffer {
    pub(crate) codes: wgpu::Buffer,
    pub(crate) group: wgpu::BindGroup,
}

impl TileBuffer {
    pub(crate) fn new(gpu: &Gpu, tiles: &HeightTiles) -> Result<Self, RenderError> {
        let (bytes, limits) = (tiles.bytes(), gpu.device.limits());
        if !gpu.facts().height_tiles {
            return Err(RenderError::NoHeightTiles(gpu.facts().name.clone()));
        }
        // The shader counts codes in 32 bits.
        let counted = u64::from(u32::MAX) * tiles.format.bytes();
        let limit = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size).min(counted);
        if bytes > limit {
            return Err(RenderError::BufferTooLarge { buffer: "height", bytes, limit });
        }
        let create = |label, size, usage| {
            let usage = usage | BufferUsages::COPY_DST;
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let codes = create("heights", bytes, BufferUsages::STORAGE);
        let uniforms = create("height tiles", size_of::<TileUniforms>() as u64, BufferUsages::UNIFORM);
        gpu.queue.write_buffer(&uniforms, 0, bytemuck::bytes_of(&TileUniforms::new(tiles)));
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("height tiles"),
            layout: &tile_layout(&gpu.device),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: uniforms.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: codes.as_entire_binding() },
            ],
        });
        Ok(Self { codes, group })
    }
}
