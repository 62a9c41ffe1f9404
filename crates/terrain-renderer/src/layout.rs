//! The uniforms of a frame, laid out as `shaders/terrain.wgsl` declares them; a test compares the two.

use bytemuck::{Pod, Zeroable};
use terrain_core::{Draw, FramePlan, View};

use crate::{Colour, Look, Scene};

/// `struct Frame` of `shaders/terrain.wgsl`.
///
/// The eye is a whole sample plus a remainder: the shader subtracts the sample in integers, so that a vertex near the
/// eye keeps its full precision on a DEM of any extent.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct FrameUniforms {
    /// Position relative to the eye (metres, world axes) to clip space, by columns.
    pub clip_from_eye: [[f32; 4]; 4],
    /// Column and row of the sample to the north-west of the eye; may lie outside the DEM.
    pub eye_sample: [i32; 2],
    /// Metres from that sample to the eye, in x and z.
    pub eye_remainder_m: [f32; 2],
    /// Metres between samples in x and z.
    pub spacing_m: [f32; 2],
    /// Last column and last row of the DEM.
    pub last_sample: [i32; 2],
    /// Lowest and highest sample of the DEM in metres.
    pub height_range_m: [f32; 2],
    /// Height of the eye in metres.
    pub eye_height_m: f32,
    /// Distance in metres at which half of the ground's light is lost to the haze.
    pub half_light_m: f32,
    /// What the terrain fades into: linear red, green, blue.
    pub haze_colour: [f32; 3],
    /// Pixels that the wider spacing covers at a distance of 1 m.
    pub spacing_px_at_1_m: f32,
    /// Legs of the plan's triangles in pixels, if all were alike and filled the picture.
    pub mean_leg_px: f32,
    /// [`Morph::reach_m`](terrain_core::Morph::reach_m); 0 where the plan has no morph.
    pub morph_reach_m: f32,
    /// Pixels that a metre covers at a distance of 1 m.
    pub metre_px_at_1_m: f32,
    /// [`Look::error_scale_px`].
    pub error_scale_px: f32,
    /// [`Look::to_sun`], of length 1.
    pub to_sun: [f32; 3],
    /// [`BufferSizes::cell_side`](terrain_core::BufferSizes::cell_side); 1 where there are no cells.
    pub cell_side: u32,
}

impl FrameUniforms {
    /// The uniforms of one frame.
    pub fn new(view: &View, scene: &Scene, plan: &FramePlan, look: &Look, cell_side: Option<u32>) -> Self {
        let spacing_m = scene.spacing_m();
        let [x, z] = [view.eye_world.x, view.eye_world.z];
        let eye_sample = [(x / spacing_m[0]).floor(), (z / spacing_m[1]).floor()];
        let [r, g, b, _] = Look::SKY;
        let is_hazy = look.haze && look.colour != Colour::ByNormal;
        Self {
            clip_from_eye: view.clip_from_eye.as_mat4().to_cols_array_2d(),
            eye_sample: eye_sample.map(|at| at as i32),
            eye_remainder_m: [(x - eye_sample[0] * spacing_m[0]) as f32, (z - eye_sample[1] * spacing_m[1]) as f32],
            spacing_m: spacing_m.map(|metres| metres as f32),
            last_sample: scene.size_samples().map(|samples| samples as i32 - 1),
            height_range_m: scene.height_range_m(),
            eye_height_m: view.eye_world.y as f32,
            // A legend holds at any distance; and without haze, what fades is so far away that nothing is lost on the way.
            half_light_m: if is_hazy && look.colour != Colour::ByError { scene.half_light_m() } else { f32::MAX },
            haze_colour: [r, g, b],
            spacing_px_at_1_m: view.pixels(spacing_m[0].max(spacing_m[1]), 1.0) as f32,
            mean_leg_px: mean_leg_px(view, plan),
            morph_reach_m: plan.morph.map_or(0.0, |morph| morph.reach_m as f32),
            metre_px_at_1_m: view.pixels(1.0, 1.0) as f32,
            error_scale_px: look.error_scale_px,
            to_sun: unit(look.to_sun),
            cell_side: cell_side.unwrap_or(1),
        }
    }
}

fn unit(vector: [f32; 3]) -> [f32; 3] {
    let length = vector.iter().map(|x| x * x).sum::<f32>().sqrt();
    vector.map(|x| x / length)
}

/// Two triangles with legs of one pixel cover a pixel.
fn mean_leg_px(view: &View, plan: &FramePlan) -> f32 {
    let [width, height] = view.size_px.map(|side| side as f32);
    let triangles: u64 = plan.draws.iter().map(Draw::triangles).sum();
    (2.0 * width * height / triangles.max(1) as f32).sqrt()
}
