//! An offscreen picture: colour and depth, and the way back to the CPU.

use std::path::Path;

use image::RgbaImage;
use wgpu::{TextureAspect, TextureFormat, TextureUsages};

use crate::{Gpu, RenderError};

/// Colour and depth textures of one size.
#[derive(Debug)]
pub struct Target {
    size_px: [u32; 2],
    colour: wgpu::Texture,
    depth: wgpu::Texture,
    colour_view: wgpu::TextureView,
    depth_view: wgpu::TextureView,
}

impl Target {
    /// The shader writes linear light, the texture stores sRGB: what a PNG holds.
    pub const COLOUR_FORMAT: TextureFormat = TextureFormat::Rgba8UnormSrgb;
    /// Reversed depth needs a float format.
    pub const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;

    /// An empty picture; refuses a size beyond the adapter's textures.
    pub fn new(gpu: &Gpu, size_px: [u32; 2]) -> Result<Self, RenderError> {
        Self::with_format(gpu, size_px, Self::COLOUR_FORMAT)
    }

    /// The same in the colour format of a window: four bytes for each pixel, with blue before red or not.
    pub fn with_format(gpu: &Gpu, size_px: [u32; 2], format: TextureFormat) -> Result<Self, RenderError> {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        if size_px.iter().any(|&side| side > limit) {
            return Err(RenderError::TextureTooLarge { what: "picture", size: size_px, limit });
        }
        let colour = attachment(gpu, "colour", format, size_px);
        let depth = attachment(gpu, "depth", Self::DEPTH_FORMAT, size_px);
        let [colour_view, depth_view] = [&colour, &depth].map(|texture| texture.create_view(&Default::default()));
        gpu.check()?;
        Ok(Self { size_px, colour, depth, colour_view, depth_view })
    }

    /// Width and height in pixels.
    pub fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// What a pass draws its colours into.
    pub fn colour_view(&self) -> &wgpu::TextureView {
        &self.colour_view
    }

    /// What a pass draws its depths into.
    pub fn depth_view(&self) -> &wgpu::TextureView {
        &self.depth_view
    }

    /// The picture as it was drawn last.
    pub fn read_back(&self, gpu: &Gpu) -> Result<RgbaImage, RenderError> {
        let mut bytes = self.read_texels(gpu, &self.colour, TextureAspect::All)?;
        if matches!(self.colour.format(), TextureFormat::Bgra8UnormSrgb | TextureFormat::Bgra8Unorm) {
            bytes.chunks_exact_mut(4).for_each(|pixel| pixel.swap(0, 2));
        }
        let [width, height] = self.size_px;
        Ok(RgbaImage::from_raw(width, height, bytes).expect("four bytes for each pixel"))
    }

    /// The depths of the picture that was drawn last, row by row: near plane over distance along the view direction,
    /// 0 where there is no terrain. Not on GL, which cannot copy depth.
    pub fn read_depth(&self, gpu: &Gpu) -> Result<Vec<f32>, RenderError> {
        let bytes = self.read_texels(gpu, &self.depth, TextureAspect::DepthOnly)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }

    /// Writes the picture as it was drawn last.
    pub fn save_png(&self, gpu: &Gpu, path: &Path) -> Result<(), RenderError> {
        let picture = self.read_back(gpu)?;
        let failed = |source| RenderError::Png { path: path.display().to_string(), source };
        picture.save_with_format(path, image::ImageFormat::Png).map_err(failed)
    }

    /// All texels without padding. Both formats have 4 bytes a texel.
    fn read_texels(&self, gpu: &Gpu, texture: &wgpu::Texture, aspect: TextureAspect) -> Result<Vec<u8>, RenderError> {
        let [width, height] = self.size_px;
        let row = width * 4;
        let padded_row = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let readable = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read-back"),
            size: u64::from(padded_row) * u64::from(height),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let rows =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded_row), rows_per_image: Some(height) };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo { aspect, ..texture.as_image_copy() },
            wgpu::TexelCopyBufferInfo { buffer: &readable, layout: rows },
            texture.size(),
        );
        gpu.queue.submit([encoder.finish()]);
        let padded = gpu.read(&readable)?;
        Ok(padded.chunks_exact(padded_row as usize).flat_map(|padded| &padded[..row as usize]).copied().collect())
    }
}

fn attachment(gpu: &Gpu, label: &str, format: TextureFormat, [width, height]: [u32; 2]) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC | TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
}
