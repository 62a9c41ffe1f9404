//! One frame of a mesh, and what it left behind.

use image::{Rgba, RgbaImage};
use terrain_core::{Heightmap, View};
use terrain_renderer::{Colour, FrameTimes, Gpu, Look, Renderer, RendererSettings, Submission};

use super::{MAGENTA, Mesh, SIZE_PX};

/// What one frame left behind.
pub struct Shot {
    pub picture: RgbaImage,
    /// Empty on GL, which cannot copy depth.
    pub depth: Vec<f32>,
    pub times: FrameTimes,
}

pub fn shoot(gpu: &Gpu, heightmap: &Heightmap, submission: Submission, mesh: &Mesh, view: &View, look: &Look) -> Shot {
    let settings = RendererSettings { size_px: SIZE_PX, submission, count_primitives: true };
    let mut renderer = Renderer::new(gpu.clone(), heightmap, &settings).unwrap();
    let mut buffers = renderer.buffers(mesh.sizes).unwrap();
    let times = renderer.frame(view, &mesh.plan, &mut buffers, look).unwrap();
    let picture = renderer.target().read_back(gpu).unwrap();
    let depth = if gpu.facts().backend == "gl" { Vec::new() } else { renderer.target().read_depth(gpu).unwrap() };
    Shot { picture, depth, times }
}

/// Light, and a background that no terrain has.
pub fn shaded(colour: Colour) -> Look {
    Look { colour, background: MAGENTA, ..Default::default() }
}

/// Whether nothing was drawn there.
pub fn is_background(pixel: &Rgba<u8>) -> bool {
    *pixel == Rgba([255, 0, 255, 255])
}

/// Pixels of terrain in the columns `from..to` of the picture.
pub fn terrain_pixels(picture: &RgbaImage, columns: std::ops::Range<u32>) -> usize {
    picture.enumerate_pixels().filter(|(x, _, pixel)| columns.contains(x) && !is_background(pixel)).count()
}
