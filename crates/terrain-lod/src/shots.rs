//! Pictures of each method at three moments of the flight, and the GPU's own count of triangles beside the plan's.

use std::path::Path;

use terrain_core::{FramePlan, FrameStats, View};
use terrain_renderer::{Look, MethodBuffers, Renderer};

use crate::fault::{Cause, Fault};
use crate::interrupt;
use crate::methods::Run;
use crate::progress::Progress;
use crate::suite::Bench;

/// Flies one run and writes `shots/<run>-frame<N>-{shaded,wireframe}.png`. The renderer must count primitives.
pub fn take(
    bench: &Bench,
    run: &Run,
    renderer: &mut Renderer,
    folder: &Path,
    progress: &Progress,
) -> Result<(), Fault> {
    let mut method = run.converged().build(&bench.dem.heightmap, &bench.prepared)?;
    let mut buffers = renderer.buffers(method.buffers())?;
    let mut plan = FramePlan::default();
    let moments = moments(bench.path.len());
    for frame in 0..=moments[2] {
        interrupt::check()?;
        let view = bench.view(frame)?;
        method.plan(&view, &mut plan);
        if moments.contains(&frame) {
            let stem = folder.join(format!("{}-frame{frame:04}", run.file_stem()));
            shoot(renderer, &view, &plan, &mut buffers, &bench.look, &stem)?;
            progress.step();
        } else {
            buffers.apply(renderer.gpu(), &plan)?;
            renderer.gpu().queue.submit([]);
        }
    }
    Ok(())
}

/// A sixth, a half and five sixths of the way.
pub fn moments(frames: u32) -> [u32; 3] {
    [1, 3, 5].map(|sixths| (frames - 1) * sixths / 6)
}

fn shoot(
    renderer: &mut Renderer,
    view: &View,
    plan: &FramePlan,
    buffers: &mut MethodBuffers,
    look: &Look,
    stem: &Path,
) -> Result<(), Fault> {
    let times = renderer.frame(view, plan, buffers, look)?;
    let planned = FrameStats::of(plan).triangles;
    if let Some(counted) = times.primitives.filter(|counted| *counted != planned) {
        let message = format!("the plan has {planned} triangles, the GPU counted {counted}");
        return Err(Fault::new(Cause::Failure, message));
    }
    save(renderer, stem, "shaded")?;
    if renderer.gpu().facts().wireframe {
        renderer.frame(view, plan, buffers, &Look { wireframe: true, ..*look })?;
        save(renderer, stem, "wireframe")?;
    }
    Ok(())
}

fn save(renderer: &Renderer, stem: &Path, look: &str) -> Result<(), Fault> {
    let path = format!("{}-{look}.png", stem.display());
    Ok(renderer.target().save_png(renderer.gpu(), Path::new(&path))?)
}
