//! Pictures of each method at three moments of the flight: as they are seen, as wireframes, and as maps of the error; how far
//! they are from those of the full grid; and the GPU's own count of triangles beside the plan's.

use std::path::{Path, PathBuf};

use image::{ImageFormat, RgbImage};
use lod_baselines::FullGrid;
use terrain_core::error::ErrorOracle;
use terrain_core::{FramePlan, FrameStats, LodMethod, MeshMirror, View};
use terrain_renderer::{Gpu, Look, MethodBuffers, RenderError, Renderer, RendererSettings};

use crate::bench::scene;
use crate::fault::{Cause, Fault};
use crate::fine::FineRenderer;
use crate::heat::HeatMap;
use crate::interrupt;
use crate::methods::Run;
use crate::pictures::{Measured, PictureRow, flat};
use crate::progress::Progress;
use crate::suite::Bench;

/// What the pictures of all runs are taken with.
pub struct Studio<'a> {
    bench: &'a Bench,
    /// Counts primitives.
    renderer: Renderer,
    fine: FineRenderer,
    /// The full grid at each of the moments; none where it cannot be drawn.
    references: Vec<Measured>,
    moments: Vec<u32>,
}

/// A run in flight.
struct Shot<'a> {
    run: &'a Run,
    frame: u32,
    view: &'a View,
    plan: &'a FramePlan,
    buffers: &'a mut MethodBuffers,
}

impl<'a> Studio<'a> {
    pub fn new(bench: &'a Bench, gpu: &Gpu) -> Result<Self, Fault> {
        let scene = scene(gpu, &bench.dem.heightmap)?;
        let size_px = bench.suite.size_px;
        let settings = RendererSettings { size_px, submission: bench.submission, count_primitives: true };
        let renderer = Renderer::over(gpu.clone(), scene.clone(), &settings)?;
        let fine = FineRenderer::new(gpu, scene, bench.submission, size_px)?;
        let mut moments = moments(bench.path.len()).to_vec();
        moments.dedup();
        let mut studio = Self { bench, renderer, fine, references: Vec::new(), moments };
        match studio.take_references() {
            Ok(references) => studio.references = references,
            Err(fault) => eprintln!("note: no full grid, so pictures are not compared with it: {fault}"),
        }
        Ok(studio)
    }

    fn take_references(&mut self) -> Result<Vec<Measured>, Fault> {
        let mut full_grid = FullGrid::new(&self.bench.dem.heightmap);
        let mut buffers = self.renderer.buffers(full_grid.buffers())?;
        let mut plan = FramePlan::default();
        let mut references = Vec::new();
        for frame in self.moments.clone() {
            interrupt::check()?;
            full_grid.plan(&self.bench.view(frame)?, &mut plan);
            references.push(self.measured(frame, &plan, &mut buffers)?);
        }
        Ok(references)
    }

    /// Flies one run, writes `shots/<run>-frame<N>-{shaded,wireframe,error}.png`, and returns what was measured.
    pub fn take(&mut self, run: &Run, folder: &Path, progress: &Progress) -> Result<Vec<PictureRow>, Fault> {
        let bench = self.bench;
        let heightmap = &bench.dem.heightmap;
        let mut method = run.converged().build(heightmap, &bench.prepared)?;
        let mut mirror = MeshMirror::new(&method.buffers(), heightmap);
        let mut buffers = self.renderer.buffers(method.buffers())?;
        let (mut plan, mut rows) = (FramePlan::default(), Vec::new());
        let last = self.moments[self.moments.len() - 1];
        for frame in 0..=last {
            interrupt::check()?;
            let view = bench.view(frame)?;
            method.plan(&view, &mut plan);
            mirror.replay(&plan).map_err(|e| Fault::new(Cause::Failure, e))?;
            if let Some(moment) = self.moments.iter().position(|moment| *moment == frame) {
                let mut shot = Shot { run, frame, view: &view, plan: &plan, buffers: &mut buffers };
                let stem = folder.join(format!("{}-frame{frame:04}", run.file_stem()));
                self.shoot(&mut shot, &stem)?;
                rows.extend(self.compare(&mut shot, moment)?);
                self.map_errors(&shot, moment, &mirror, &stem)?;
                progress.step();
            } else {
                buffers.apply(self.renderer.gpu(), &plan)?;
                self.renderer.gpu().queue.submit([]);
            }
        }
        Ok(rows)
    }

    fn shoot(&mut self, shot: &mut Shot, stem: &Path) -> Result<(), Fault> {
        let (renderer, look) = (&mut self.renderer, self.bench.look);
        let times = renderer.frame(shot.view, shot.plan, shot.buffers, &look)?;
        let planned = FrameStats::of(shot.plan).triangles;
        if let Some(counted) = times.primitives.filter(|counted| *counted != planned) {
            let message = format!("the plan has {planned} triangles, the GPU counted {counted}");
            return Err(Fault::new(Cause::Failure, message));
        }
        renderer.target().save_png(renderer.gpu(), &picture(stem, "shaded"))?;
        if renderer.gpu().facts().wireframe {
            renderer.frame(shot.view, shot.plan, shot.buffers, &Look { wireframe: true, ..look })?;
            renderer.target().save_png(renderer.gpu(), &picture(stem, "wireframe"))?;
        }
        Ok(())
    }

    fn compare(&mut self, shot: &mut Shot, moment: usize) -> Result<Option<PictureRow>, Fault> {
        if self.references.is_empty() {
            return Ok(None);
        }
        let measured = self.measured(shot.frame, shot.plan, shot.buffers)?;
        Ok(Some(PictureRow::new(shot.run, shot.frame, &measured, &self.references[moment])))
    }

    fn map_errors(&self, shot: &Shot, moment: usize, mirror: &MeshMirror, stem: &Path) -> Result<(), Fault> {
        let Some(depths) = self.references.get(moment).and_then(|reference| reference.depths.as_deref()) else {
            return Ok(());
        };
        let heightmap = &self.bench.dem.heightmap;
        let mut oracle = ErrorOracle::new(heightmap);
        oracle.set_mesh(mirror.triangles());
        // The first yardstick, where the method knows no tolerance.
        let tolerance_px = self.bench.suite.tolerances_of(shot.run)[0];
        let (oracle, factor) = (&oracle, self.fine.factor());
        save(
            &HeatMap { heightmap, oracle, view: shot.view, depths, factor, tolerance_px }.paint(),
            &picture(stem, "error"),
        )
    }

    fn measured(&mut self, frame: u32, plan: &FramePlan, buffers: &mut MethodBuffers) -> Result<Measured, Fault> {
        let view = self.bench.path.view(frame, self.fine.size_px())?;
        let shaded = self.fine.draw(&view, plan, buffers, &Look::default())?;
        let flat = self.fine.draw(&view, plan, buffers, &flat())?;
        Ok(Measured { flat, shaded, depths: self.fine.read_depths()? })
    }
}

/// A sixth, a half and five sixths of the way.
pub fn moments(frames: u32) -> [u32; 3] {
    [1, 3, 5].map(|sixths| (frames - 1) * sixths / 6)
}

fn picture(stem: &Path, look: &str) -> PathBuf {
    PathBuf::from(format!("{}-{look}.png", stem.display()))
}

fn save(picture: &RgbImage, path: &Path) -> Result<(), Fault> {
    let failed = |source| RenderError::Png { path: path.display().to_string(), source };
    Ok(picture.save_with_format(path, ImageFormat::Png).map_err(failed)?)
}
