//! The DEM on the GPU: a height and a normal for every sample, made once and used by every method. Or no more than its
//! extent, for a DEM that is larger than the adapter's textures, or not in memory.

use terrain_core::{Heightmap, Sample, VoidMask, VoidQuads};
use wgpu::{TextureFormat, TextureUsages};

use crate::{Gpu, RenderError};

/// Texels in a row of the void quads' texture; that of 23,170 x 23,170 samples has 8,202 rows then.
const VOID_TEXELS: usize = 2048;

/// The textures of one heightmap and what a frame's uniforms need to know of it.
#[derive(Clone, Debug)]
pub struct Scene {
    size_samples: [u32; 2],
    spacing_m: [f64; 2],
    height_range_m: [f32; 2],
    half_light_m: f32,
    has_heights: bool,
    heights: wgpu::TextureView,
    normals: wgpu::TextureView,
    void_quads: Option<wgpu::TextureView>,
}

impl Scene {
    /// Uploads heights, normals, and which quads are void if any are; refuses a DEM that is wider or longer than the
    /// adapter's textures.
    pub fn new(gpu: &Gpu, heightmap: &Heightmap) -> Result<Self, RenderError> {
        let size_samples = [heightmap.columns(), heightmap.rows()];
        let limit = gpu.device.limits().max_texture_dimension_2d;
        if size_samples.iter().any(|&side| side > limit) {
            return Err(RenderError::TextureTooLarge { what: "DEM", size: size_samples, limit });
        }
        let normals: Vec<[u16; 2]> = heightmap.normals().iter().map(|[x, _, z]| [half(*x), half(*z)]).collect();
        let [first, last] = [[0, 0], size_samples.map(|side| side - 1)].map(|[column, row]| Sample { column, row });
        let scene = Self {
            size_samples,
            spacing_m: heightmap.spacing_m(),
            height_range_m: heightmap.height_range_m(first, last),
            half_light_m: diagonal_m(size_samples, heightmap.spacing_m()),
            has_heights: true,
            heights: texture(gpu, "heights", TextureFormat::R32Float, size_samples, heightmap.heights_m()),
            normals: texture(gpu, "normals", TextureFormat::Rg16Float, size_samples, &normals),
            void_quads: None,
        };
        gpu.check()?; // out of memory, for one
        match heightmap.voids() {
            Some(voids) => scene.with_voids(gpu, voids),
            None => Ok(scene),
        }
    }

    /// A scene without heights and normals: for methods that bring their heights along, and for baked vertices. The
    /// light falls on the triangles as they are.
    pub fn without_heights(
        gpu: &Gpu,
        size_samples: [u32; 2],
        spacing_m: [f64; 2],
        height_range_m: [f32; 2],
    ) -> Result<Self, RenderError> {
        let scene = Self {
            size_samples,
            spacing_m,
            height_range_m,
            half_light_m: diagonal_m(size_samples, spacing_m),
            has_heights: false,
            heights: texture(gpu, "no heights", TextureFormat::R32Float, [1; 2], &[0.0_f32]),
            normals: texture(gpu, "no normals", TextureFormat::Rg16Float, [1; 2], &[[0_u16; 2]]),
            void_quads: None,
        };
        gpu.check()?;
        Ok(scene)
    }

    /// Leaves the void quads undrawn, whatever mesh lies over them. Its pipelines can no longer test depth before they
    /// shade, so a DEM without voids is better off without.
    pub fn with_voids(self, gpu: &Gpu, voids: &VoidMask) -> Result<Self, RenderError> {
        assert_eq!([voids.columns(), voids.rows()], self.size_samples, "a void mask of another DEM");
        let mut words = VoidQuads::of(voids).words().to_vec();
        // One row of texels after the other is filled: a DEM may have more rows than a texture.
        let width = words.len().min(VOID_TEXELS);
        let height = words.len().div_ceil(width);
        words.resize(width * height, 0);
        let size = [width as u32, height as u32];
        let limit = gpu.device.limits().max_texture_dimension_2d;
        if size.iter().any(|side| *side > limit) {
            return Err(RenderError::TextureTooLarge { what: "void mask", size, limit });
        }
        let void_quads = Some(texture(gpu, "void quads", TextureFormat::R32Uint, size, &words));
        gpu.check()?;
        Ok(Self { void_quads, ..self })
    }

    /// Whether there is more than placeholders.
    pub(crate) fn has_heights(&self) -> bool {
        self.has_heights
    }

    /// A bit a quad, 32 quads a texel; `None` where no quad is void.
    pub(crate) fn void_quads(&self) -> Option<&wgpu::TextureView> {
        self.void_quads.as_ref()
    }

    pub(crate) fn size_samples(&self) -> [u32; 2] {
        self.size_samples
    }

    pub(crate) fn spacing_m(&self) -> [f64; 2] {
        self.spacing_m
    }

    pub(crate) fn height_range_m(&self) -> [f32; 2] {
        self.height_range_m
    }

    /// The DEM's diagonal: thin enough to see across the whole DEM, thick enough to tell near from far.
    pub(crate) fn half_light_m(&self) -> f32 {
        self.half_light_m
    }

    /// Metres, one texel a sample.
    pub(crate) fn heights(&self) -> &wgpu::TextureView {
        &self.heights
    }

    /// x and z of the unit normal, one texel a sample. y is positive and follows from the two: half floats at the
    /// size of four 8-bit numbers, and free of their bands.
    pub(crate) fn normals(&self) -> &wgpu::TextureView {
        &self.normals
    }
}

fn diagonal_m(size_samples: [u32; 2], spacing_m: [f64; 2]) -> f32 {
    let [x_m, z_m] = [0, 1].map(|axis| (size_samples[axis] - 1) as f64 * spacing_m[axis]);
    x_m.hypot(z_m) as f32
}

fn texture<T: bytemuck::NoUninit>(
    gpu: &Gpu,
    label: &str,
    format: TextureFormat,
    [width, height]: [u32; 2],
    texels: &[T],
) -> wgpu::TextureView {
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let rows = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(width * size_of::<T>() as u32),
        rows_per_image: Some(height),
    };
    gpu.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(texels), rows, size);
    texture.create_view(&Default::default())
}

/// The bits of the nearest half float, for numbers from -1 to 1.
///
/// Multiplied by 2^-112, a single float has its exponent and mantissa where a half float has them, 13 bits higher.
fn half(number: f32) -> u16 {
    const TWO_TO_MINUS_112: f32 = f32::from_bits((127 - 112) << 23);
    let magnitude = (number.abs() * TWO_TO_MINUS_112).to_bits();
    let sign = (number.to_bits() >> 31) << 15;
    (sign | (magnitude + (1 << 12)) >> 13) as u16
}

#[cfg(test)]
mod tests {
    use super::half;

    #[test]
    fn half_floats_of_known_numbers() {
        assert_eq!([0.0, 1.0, -1.0, 0.5, -0.25].map(half), [0x0000, 0x3c00, 0xbc00, 0x3800, 0xb400]);
        assert_eq!(half(1.0 / 3.0), 0x3555);
        assert_eq!(half(2.0_f32.powi(-24)), 0x0001, "the smallest one is denormal");
        assert_eq!(half(0.99999), 0x3c00, "rounded up into the next exponent");
    }
}
