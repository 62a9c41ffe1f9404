//! Smooth pictures: drawn at twice the size, and each pixel the mean light of four. Edges and triangles smaller than a pixel
//! would else be noise, which says nothing of a mesh.

use image::{Rgb, RgbImage, RgbaImage};
use terrain_core::{FramePlan, View};
use terrain_renderer::{Gpu, Look, MethodBuffers, Renderer, RendererSettings, Scene, Submission};

use crate::fault::Fault;

/// Draws such pictures.
pub struct FineRenderer {
    pub renderer: Renderer,
    /// Points along each side of a pixel: 2, or 1 where the adapter's textures are too small.
    factor: u32,
}

impl FineRenderer {
    pub fn new(gpu: &Gpu, scene: Scene, submission: Submission, size_px: [u32; 2]) -> Result<Self, Fault> {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        let factor = if size_px.iter().all(|side| side * 2 <= limit) { 2 } else { 1 };
        let size_px = size_px.map(|side| side * factor);
        let settings = RendererSettings { size_px, submission, count_primitives: false };
        Ok(Self { renderer: Renderer::over(gpu.clone(), scene, &settings)?, factor })
    }

    /// What is really drawn: the size that views must have.
    pub fn size_px(&self) -> [u32; 2] {
        self.renderer.target().size_px()
    }

    /// Points along each side of a pixel.
    pub fn factor(&self) -> u32 {
        self.factor
    }

    /// The picture of one frame.
    pub fn draw(
        &mut self,
        view: &View,
        plan: &FramePlan,
        buffers: &mut MethodBuffers,
        look: &Look,
    ) -> Result<RgbImage, Fault> {
        self.renderer.frame(view, plan, buffers, look)?;
        Ok(shrink(&self.renderer.target().read_back(self.renderer.gpu())?, self.factor))
    }

    /// The reversed depths of the points of the last picture; none on GL, which cannot copy them.
    pub fn read_depths(&self) -> Result<Option<Vec<f32>>, Fault> {
        let gpu = self.renderer.gpu();
        let can_copy = gpu.facts().backend != "gl";
        Ok(can_copy.then(|| self.renderer.target().read_depth(gpu)).transpose()?)
    }
}

/// Each pixel the mean of `factor` x `factor`, as light: sRGB is decoded and encoded again.
fn shrink(fine: &RgbaImage, factor: u32) -> RgbImage {
    let light: Vec<f64> = (0..=255).map(|byte| decode(f64::from(byte) / 255.0)).collect();
    let points = f64::from(factor * factor);
    RgbImage::from_fn(fine.width() / factor, fine.height() / factor, |x, y| {
        let places = (0..factor).flat_map(|row| (0..factor).map(move |column| (x * factor + column, y * factor + row)));
        let sum = places.fold([0.0; 3], |sum, (x, y)| {
            let pixel = fine[(x, y)];
            [0, 1, 2].map(|channel| sum[channel] + light[pixel[channel] as usize])
        });
        Rgb(sum.map(|sum| (255.0 * encode(sum / points)).round() as u8))
    })
}

/// sRGB (IEC 61966-2-1) to linear light, both 0 to 1.
pub fn decode(stored: f64) -> f64 {
    if stored <= 0.04045 { stored / 12.92 } else { ((stored + 0.055) / 1.055).powf(2.4) }
}

/// The inverse of [`decode`].
pub fn encode(light: f64) -> f64 {
    if light <= 0.0031308 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use image::Rgba;

    use super::*;

    #[test]
    fn what_is_shrunk_keeps_its_light() {
        for factor in [1, 2, 3] {
            for byte in 0..=255 {
                let even = RgbaImage::from_pixel(6, 6, Rgba([byte, 255 - byte, 7, 255]));
                let small = shrink(&even, factor);
                assert_eq!((small.width(), small[(0, 0)]), (6 / factor, Rgb([byte, 255 - byte, 7])));
            }
        }
        // Half of the light of white is 188 of 255 in sRGB, not 128.
        let stripes = RgbaImage::from_fn(4, 2, |x, _| Rgba(if x % 2 == 0 { [255; 4] } else { [0, 0, 0, 255] }));
        assert_eq!(shrink(&stripes, 2).pixels().collect::<Vec<_>>(), [&Rgb([188; 3]); 2]);
    }
}
