//! What is drawn of a frame: both methods into one picture with a divider, one alone, or the difference of the two.

use terrain_core::{Heightmap, View};
use terrain_renderer::{Gpu, Look, RenderError, Scene, Submission, Target, TerrainPass};

use crate::command::{Mode, Side};
use crate::difference::Difference;
use crate::gui::{Gui, Layout};
use crate::pane::{Pane, PreparedPane};
use crate::state::{Shown, State};

/// All that is on the GPU besides the methods' buffers.
pub struct Stage {
    pub pass: TerrainPass,
    format: wgpu::TextureFormat,
    /// The depths of the pictures, and a second picture for differences.
    targets: Option<[Target; 2]>,
    difference: Difference,
}

impl Stage {
    pub fn new(
        gpu: &Gpu,
        heightmap: &Heightmap,
        format: wgpu::TextureFormat,
        submission: Submission,
    ) -> Result<Self, RenderError> {
        let pass = TerrainPass::new(gpu, Scene::new(gpu, heightmap)?, format, submission)?;
        Ok(Self { pass, format, targets: None, difference: Difference::new(gpu, format) })
    }

    /// Sends draws another way from the next frame on.
    pub fn submit_by(&mut self, gpu: &Gpu, submission: Submission) {
        self.pass.submit_by(gpu, submission);
    }

    /// Textures of a window's size.
    fn resize(&mut self, gpu: &Gpu, size_px: [u32; 2]) -> Result<(), RenderError> {
        if self.targets.as_ref().is_none_or(|targets| targets[0].size_px() != size_px) {
            self.targets = None;
            let target = || Target::with_format(gpu, size_px, self.format);
            self.targets = Some([target()?, target()?]);
        }
        Ok(())
    }

    /// Draws the planned methods and the interface, and submits them.
    pub fn draw(
        &mut self,
        gpu: &Gpu,
        gui: &mut Gui,
        frame: &Frame,
        panes: &mut [Pane; 2],
    ) -> Result<wgpu::SubmissionIndex, RenderError> {
        self.resize(gpu, frame.view.size_px)?;
        let look = frame.state.look();
        let shown = if self.shows_difference(frame.state, panes) { Shown::Both } else { frame.state.shown };
        let [left, right] = panes;
        let prepared = [(Side::Left, left), (Side::Right, right)].map(|(side, pane)| {
            if shown.includes(side) {
                pane.prepare(gpu, &self.pass, frame.view, &look)
            } else {
                pane.upload(gpu).map(|()| None)
            }
        });
        let [left, right] = prepared;
        // egui panics on a device that is lost; what was queued so far has told of it.
        gpu.check()?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        gui.upload(gpu, frame.layout, &mut encoder);
        let targets = self.targets.as_ref().expect("made above");
        match [left?, right?] {
            [Some(mut left), Some(mut right)] if frame.state.mode == Mode::Difference => {
                draw_alone(&mut encoder, &targets[0], &mut left, &look);
                draw_alone(&mut encoder, &targets[1], &mut right, &look);
                self.difference.draw(gpu, &mut encoder, frame.colour, targets);
            }
            ready => draw_side_by_side(&mut encoder, frame, targets[0].depth_view(), ready, &look),
        }
        gui.draw(frame.layout, &mut encoder, frame.colour);
        let submission = gpu.queue.submit([encoder.finish()]);
        gui.free(frame.layout);
        Ok(submission)
    }

    /// Both methods must be there for it.
    fn shows_difference(&self, state: &State, panes: &[Pane; 2]) -> bool {
        state.mode == Mode::Difference && panes.iter().all(|pane| pane.run().is_some())
    }
}

/// What is drawn, and where.
pub struct Frame<'a> {
    pub state: &'a State,
    pub view: &'a View,
    pub layout: &'a Layout,
    pub colour: &'a wgpu::TextureView,
}

fn draw_alone(encoder: &mut wgpu::CommandEncoder, target: &Target, pane: &mut PreparedPane, look: &Look) {
    let mut pass = TerrainPass::begin(encoder, target.colour_view(), target.depth_view(), look, None);
    pane.draw(&mut pass, look.wireframe);
}

/// Each method draws the whole view; scissors cut it at the divider.
fn draw_side_by_side(
    encoder: &mut wgpu::CommandEncoder,
    frame: &Frame,
    depth: &wgpu::TextureView,
    panes: [Option<PreparedPane>; 2],
    look: &Look,
) {
    let [width, height] = frame.view.size_px;
    let divider = match frame.state.shown {
        Shown::Both => divider_px(frame.state.divider, width),
        Shown::One(Side::Left) => width,
        Shown::One(Side::Right) => 0,
    };
    let mut pass = TerrainPass::begin(encoder, frame.colour, depth, look, None);
    for (pane, columns) in panes.into_iter().zip([0..divider, divider..width]) {
        let Some(mut pane) = pane.filter(|_| !columns.is_empty()) else { continue };
        pass.set_scissor_rect(columns.start, 0, columns.end - columns.start, height);
        pane.draw(&mut pass, look.wireframe);
    }
}

/// The first column of the right method.
pub fn divider_px(share: f64, width: u32) -> u32 {
    ((share * f64::from(width)).round() as u32).min(width)
}
