//! Frames of an unchanged view leave no memory behind, in the driver neither. On a real adapter, and on Linux, which says how
//! much memory a process has; skipped with a message elsewhere. The only test of its file: others would share the memory.

mod hills;

use std::fmt::Write;

use hills::{Mesh, adapter, baked_grid, coarse_grid, displaced_grid, oblique, tiled};
use terrain_core::{HeightFormat, Morph, View};
use terrain_renderer::{Colour, Gpu, Look, Normals, Renderer, RendererSettings};

/// Until everything is compiled and every pool is filled.
const WARM_UP: u32 = 5;
const FRAMES: u32 = 25;
/// A shader that is compiled anew for each frame and never freed takes 5 MiB and more.
const MOST_MIB: f64 = 2.5;

/// `None` where the system is none that says it.
fn resident_mib() -> Option<f64> {
    const PAGE_MIB: f64 = 4096.0 / (1 << 20) as f64;
    let text = std::fs::read_to_string("/proc/self/statm").ok()?;
    text.split(' ').nth(1)?.parse::<f64>().ok().map(|pages| pages * PAGE_MIB)
}

/// MiB by which the process grows. The renderer is kept: what it frees, the next one would take without growing.
fn growth_mib(gpu: &Gpu, mesh: &Mesh, view: &View, look: &Look, kept: &mut Vec<Renderer>) -> f64 {
    let settings = RendererSettings { size_px: hills::SIZE_PX, ..Default::default() };
    let mut renderer = Renderer::new(gpu.clone(), &hills::hills(), &settings).unwrap();
    let mut buffers = renderer.buffers(mesh.sizes).unwrap();
    let mut draw = |frames| {
        (0..frames).for_each(|_| {
            renderer.frame(view, &mesh.plan, &mut buffers, look).unwrap();
        })
    };
    draw(WARM_UP);
    let before = resident_mib().unwrap();
    draw(FRAMES);
    let grown = resident_mib().unwrap() - before;
    kept.push(renderer);
    grown
}

/// Lavapipe (Mesa 22.3) compiled the vertex shader of instances anew for every frame: uniforms alone decided one of its
/// branches.
#[test]
fn frames_of_an_unchanged_view_leave_no_memory_behind() {
    let Some(gpu) = adapter() else { return };
    if resident_mib().is_none() {
        hills::skip("the system does not say how much memory a process has");
        return;
    }
    let (dem, view) = (hills::hills(), oblique(&hills::hills()));
    let displaced = displaced_grid(&dem, 8);
    let mut gliding = displaced_grid(&dem, 8);
    gliding.plan.morph = Some(Morph { eye_world: view.eye_world.into(), k: 3, levels: 3, reach_m: 400.0 });
    let meshes = [
        ("baked", baked_grid(&dem, 100)),
        ("tiled, f32", tiled(&dem, &displaced, HeightFormat::F32, false)),
        ("tiled, u16", {
            let format = HeightFormat::U16 { scale_m: 0.05, offset_m: -400.0 };
            tiled(&dem, &coarse_grid(&dem, 2, 4), format, true)
        }),
        ("displaced", displaced),
        ("gliding", gliding),
    ];
    let looks = [
        (Colour::Shaded, Normals::PerPixel),
        (Colour::Shaded, Normals::PerVertex),
        (Colour::Plain, Normals::PerTriangle),
        (Colour::ByNormal, Normals::PerPixel),
        (Colour::ByError, Normals::PerPixel),
    ];
    let (mut grown, mut kept) = (String::new(), Vec::new());
    for (name, mesh) in &meshes {
        for (colour, normals) in looks {
            let look = Look { colour, normals, wireframe: gpu.facts().wireframe, ..Default::default() };
            let mib = growth_mib(&gpu, mesh, &view, &look, &mut kept);
            if mib > MOST_MIB {
                writeln!(grown, "{name}, {colour:?}, {normals:?}: {mib:.1} MiB in {FRAMES} frames").unwrap();
            }
        }
    }
    assert!(grown.is_empty(), "{grown}");
}
