//! `mesh`: what one frame draws, with nothing culled, as a PLY file.

use std::sync::Arc;

use serde::Serialize;
use terrain_core::{FlightPath, FramePlan, Heightmap, MeshMirror, Triangle, View};
use terrain_dem::{write_atomically, write_ply};

use crate::cli::MeshArgs;
use crate::error_pass::tidy;
use crate::fault::{Cause, Fault};
use crate::methods::{Run, Settings};
use crate::output::print;
use crate::progress::Progress;
use crate::suite::open_flight;

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
}

pub fn run(args: &MeshArgs) -> Result<(), Fault> {
    let dem = terrain_dem::open(args.dem.dem.as_deref().unwrap_or("jacksboro"), &args.dem.read_options())?;
    let heightmap = dem.heightmap;
    if args.frame >= args.frames {
        let message =
            format!("frame {} of a flight of {} frames: expected 0 to {}", args.frame, args.frames, args.frames - 1);
        return Err(Fault::usage(message));
    }
    let path = FlightPath::new(&open_flight(&args.flight)?, &heightmap, args.frames)?;
    let run = Run { method: args.method, settings: settings(args) };
    let (view, triangles) = replay(&run, &heightmap, &path, args)?;
    let (vertices, faces) = share_vertices(&heightmap, &triangles);
    write_atomically(&args.out, |file| write_ply(file, &vertices, &faces)).map_err(|e| Fault::write(&args.out, e))?;
    let line = MeshLine {
        eye: view.eye_world.to_array(),
        clip_from_world: view.clip_from_world.to_cols_array(),
        fov_y: tidy(view.fov_y.to_degrees()),
        width: args.size[0],
        height: args.size[1],
        triangles: faces.len(),
        vertices: vertices.len(),
    };
    print(&(serde_json::to_string(&line).expect("numbers become JSON") + "\n"))
}

fn settings(args: &MeshArgs) -> Settings {
    Settings {
        tolerance_px: args.tolerance,
        patch: args.patch,
        max_spacing: args.settings.max_spacing,
        leg_px: args.leg_px,
        k: args.settings.k.unwrap_or(3),
        layers: args.settings.layers.unwrap_or(3),
        threads: args.settings.threads.unwrap_or(1).into(),
        culling: false,
    }
}

/// Flies up to the frame: what a frame draws may depend on the frames before.
fn replay(
    run: &Run,
    heightmap: &Arc<Heightmap>,
    path: &FlightPath,
    args: &MeshArgs,
) -> Result<(View, Vec<Triangle>), Fault> {
    let mut method = run.build(heightmap)?;
    let mut mirror = MeshMirror::new(&method.buffers(), heightmap);
    let mut plan = FramePlan::default();
    let view_at = |frame| path.view(frame, args.size).map_err(|e| Fault::new(Cause::BadInput, e));
    let progress = Progress::new("replay", args.frame as u64 + 1);
    for frame in 0..=args.frame {
        method.plan(&view_at(frame)?, &mut plan);
        mirror.replay(&plan).map_err(|e| Fault::new(Cause::Failure, e))?;
        progress.step();
    }
    Ok((view_at(args.frame)?, mirror.triangles().to_vec()))
}

/// World positions in metres of the samples in use, each once, and the triangles over them.
fn share_vertices(heightmap: &Heightmap, triangles: &[Triangle]) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let mut vertex_of = vec![u32::MAX; heightmap.heights_m().len()];
    let (mut vertices, mut faces) = (Vec::new(), Vec::with_capacity(triangles.len()));
    for triangle in triangles {
        let mut corner = 0;
        faces.push(triangle.samples.map(|sample| {
            let vertex = &mut vertex_of[heightmap.index(sample) as usize];
            if *vertex == u32::MAX {
                *vertex = vertices.len() as u32;
                let [x, _, z] = heightmap.world(sample);
                vertices.push([x as f32, triangle.heights_m[corner], z as f32]);
            }
            corner += 1;
            *vertex
        }));
    }
    (vertices, faces)
}
