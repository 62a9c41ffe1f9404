//! `mesh`: what one frame draws, with nothing culled, as a file for other programs.

use std::collections::HashMap;

use serde::Serialize;
use terrain_core::{FramePlan, Heightmap, MeshMirror, Triangle};
use terrain_dem::{Mesh, MeshFormat, write_atomically};

use crate::cli::MeshArgs;
use crate::fault::{Cause, Fault};
use crate::output::{print, tidy};
use crate::progress::Progress;
use crate::read_failures::ReadFailures;
use crate::results::probe_parent;
use crate::suite::{Bench, Suite, override_with};
use crate::void_cut::{Cut, Place, along_voids};

/// The line on stdout: the camera that the mesh is made for, and the size of the mesh.
#[derive(Serialize)]
struct MeshLine {
    /// World position in metres.
    eye: [f64; 3],
    /// Column by column.
    clip_from_world: [f64; 16],
    /// Degrees.
    fov_y: f64,
    width: u32,
    height: u32,
    triangles: usize,
    vertices: usize,
    /// Triangles that lie in voids.
    left_out: usize,
    /// Triangles of which a part lies in voids, and that are there as their other parts.
    cut: usize,
}

pub fn run(args: &MeshArgs) -> Result<(), Fault> {
    if args.frame >= args.frames {
        let last = args.frames - 1;
        return Err(Fault::usage(format!("frame {} of {} frames: expected 0 to {last}", args.frame, args.frames)));
    }
    let format = MeshFormat::of(&args.out).ok_or_else(|| {
        Fault::usage(format!("{}: expected a name that ends in {}", args.out.display(), MeshFormat::ENDINGS))
    })?;
    let mut bench = Bench::new("mesh", suite(args), args.dem.read_options())?;
    probe_parent(&args.out)?;
    bench.prepare(args.settings.keep_maps, true)?;
    let cut = along_voids(&bench.dem.heightmap, replay(&bench, args.frame)?);
    let left_out = cut.left_out;
    if cut.whole.is_empty() && cut.parts.is_empty() {
        let message = format!(
            "{}: all {left_out} triangles lie in voids; expected some elsewhere, or --voids fill",
            bench.dem.name
        );
        return Err(Fault::new(Cause::BadInput, message));
    }
    let mesh = share_vertices(&bench.dem.heightmap, &cut);
    write_atomically(&args.out, |file| format.write(file, &mesh)).map_err(|e| Fault::write(&args.out, e))?;
    let view = bench.view(args.frame)?;
    let line = MeshLine {
        eye: view.eye_world.to_array(),
        clip_from_world: view.clip_from_world.to_cols_array(),
        fov_y: tidy(view.fov_y.to_degrees()),
        width: view.size_px[0],
        height: view.size_px[1],
        triangles: mesh.triangles.len(),
        vertices: mesh.positions_m.len(),
        left_out,
        cut: cut.cut,
    };
    print(&(serde_json::to_string(&line).expect("numbers become JSON") + "\n"))
}

/// A suite of one run.
fn suite(args: &MeshArgs) -> Suite {
    let mut suite = Suite { methods: vec![args.method], frames: Some(args.frames), ..Default::default() };
    override_with(&mut suite.dem, &args.dem.dem);
    override_with(&mut suite.flight, &args.flight);
    override_with(&mut suite.tolerance_px, &args.tolerance.map(|px| vec![px]));
    override_with(&mut suite.selector, &args.selector.map(|selector| vec![selector]));
    override_with(&mut suite.triangulator, &args.triangulator.map(|triangulator| vec![triangulator]));
    override_with(&mut suite.patch, &args.patch.map(|patch| vec![patch]));
    override_with(&mut suite.leg_px, &args.leg_px.map(|px| vec![px]));
    override_with(&mut suite.metric, &args.metric.map(|metric| vec![metric]));
    override_with(&mut suite.batching, &args.batching.map(|batching| vec![batching]));
    override_with(&mut suite.k, &args.k.map(|k| vec![k]));
    override_with(&mut suite.window_mib, &args.window_mib.map(|mib| vec![mib]));
    suite.step = vec![args.step];
    override_with(&mut suite.size_px, &args.size);
    suite.override_settings(&args.settings);
    suite
}

/// Flies up to the frame as the bench does, since what a frame draws may depend on the frames before; then plans it once
/// more with culling off.
fn replay(bench: &Bench, last: u32) -> Result<Vec<Triangle>, Fault> {
    let mut method = bench.runs[0].converged().build(&bench.dem.heightmap, &bench.prepared)?;
    let mut mirror = MeshMirror::new(&method.buffers(), &bench.dem.heightmap);
    let (mut plan, mut failures) = (FramePlan::default(), ReadFailures::of(&bench.runs[0]));
    let progress = Progress::new("replay", last as u64 + 1);
    for (frame, culling) in (0..=last).map(|frame| (frame, true)).chain([(last, false)]) {
        method.set_culling(culling);
        method.plan(&bench.view(frame)?, &mut plan);
        failures.tell(&mut *method);
        mirror.replay(&plan).map_err(|e| Fault::new(Cause::Failure, e))?;
        progress.step();
    }
    failures.finish(&mut *method, &plan);
    Ok(mirror.triangles().to_vec())
}

/// The places in use, each once, and the triangles over them. A place between samples has the normal of the nearest one.
fn share_vertices(heightmap: &Heightmap, cut: &Cut) -> Mesh {
    let mut shared = Shared::new(heightmap);
    let whole = cut.whole.iter().map(|triangle| (triangle.samples.map(Place::from), triangle.heights_m));
    let parts = cut.parts.iter().map(|part| (part.corners, part.heights_m));
    for (corners, heights_m) in whole.chain(parts) {
        let corner = |at: usize| shared.vertex(corners[at], heights_m[at]);
        let triangle = [0, 1, 2].map(corner);
        shared.mesh.triangles.push(triangle);
    }
    shared.mesh
}

/// A mesh that grows, and where its vertices are.
struct Shared<'a> {
    heightmap: &'a Heightmap,
    mesh: Mesh,
    /// Of each sample; `u32::MAX` where there is none.
    at_samples: Vec<u32>,
    between: HashMap<Place, u32>,
}

impl<'a> Shared<'a> {
    fn new(heightmap: &'a Heightmap) -> Self {
        let at_samples = vec![u32::MAX; heightmap.heights_m().len()];
        Self { heightmap, mesh: Mesh::default(), at_samples, between: HashMap::new() }
    }

    fn vertex(&mut self, place: Place, height_m: f32) -> u32 {
        let vertex = match place.sample() {
            Some(sample) => &mut self.at_samples[self.heightmap.index(sample) as usize],
            None => self.between.entry(place).or_insert(u32::MAX),
        };
        if *vertex == u32::MAX {
            *vertex = self.mesh.positions_m.len() as u32;
            let ([x, z], spacing_m) = (place.at(), self.heightmap.spacing_m());
            self.mesh.positions_m.push([(x * spacing_m[0]) as f32, height_m, (z * spacing_m[1]) as f32]);
            self.mesh.normals.push(self.heightmap.normal(place.nearest()));
        }
        *vertex
    }
}
