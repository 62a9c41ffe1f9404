//! `mesh`: what one frame draws, with nothing culled, as a file for other programs.

use serde::Serialize;
use terrain_core::{FramePlan, Heightmap, MeshMirror, Triangle, VoidQuads};
use terrain_dem::{Mesh, MeshFormat, write_atomically};

use crate::cli::MeshArgs;
use crate::fault::{Cause, Fault};
use crate::output::{print, tidy};
use crate::progress::Progress;
use crate::read_failures::ReadFailures;
use crate::results::probe_parent;
use crate::suite::{Bench, Suite, override_with};

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
    let mut triangles = replay(&bench, args.frame)?;
    let left_out = leave_out_voids(&bench.dem.heightmap, &mut triangles);
    if triangles.is_empty() {
        let message = format!(
            "{}: all {left_out} triangles lie in voids; expected some elsewhere, or --voids fill",
            bench.dem.name
        );
        return Err(Fault::new(Cause::BadInput, message));
    }
    let mesh = share_vertices(&bench.dem.heightmap, &triangles);
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

/// Takes the triangles away that cover nothing but void quads; the number of them. A triangle that covers some ground stays
/// as it is, so no ground is lost, and over voids the mesh reaches as far as its triangles do.
fn leave_out_voids(heightmap: &Heightmap, triangles: &mut Vec<Triangle>) -> usize {
    let (Some(voids), all) = (heightmap.voids(), triangles.len()) else { return 0 };
    let quads = VoidQuads::of(voids);
    triangles.retain(|triangle| !quads.contain(triangle));
    all - triangles.len()
}

/// The samples in use, each once, and the triangles over them.
fn share_vertices(heightmap: &Heightmap, triangles: &[Triangle]) -> Mesh {
    let mut vertex_of = vec![u32::MAX; heightmap.heights_m().len()];
    let mut mesh = Mesh::default();
    for triangle in triangles {
        let mut corner = 0;
        mesh.triangles.push(triangle.samples.map(|sample| {
            let vertex = &mut vertex_of[heightmap.index(sample) as usize];
            if *vertex == u32::MAX {
                *vertex = mesh.positions_m.len() as u32;
                let [x, _, z] = heightmap.world(sample);
                mesh.positions_m.push([x as f32, triangle.heights_m[corner], z as f32]);
                mesh.normals.push(heightmap.normal(sample));
            }
            corner += 1;
            *vertex
        }));
    }
    mesh
}
