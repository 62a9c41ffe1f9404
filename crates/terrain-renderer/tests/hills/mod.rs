//! Small terrains and hand-made plans for the tests of this crate: no method is involved.
#![allow(dead_code)] // Every test file compiles its own copy and uses a part of it.

pub mod shot;

use std::f64::consts::FRAC_PI_2;
use std::io::Write;

use terrain_core::{
    BakedVertex, Buffer, BufferSizes, Camera, Draw, FramePlan, HeightFormat, HeightTiles, Heightmap, IndexFormat, Lens,
    LocalVertex, PatchInstance, PatchTag, Sample, VertexKind, View,
};
use terrain_renderer::{AdapterChoice, Gpu};

pub const SIZE_PX: [u32; 2] = [320, 180];
pub const MAGENTA: [f32; 4] = [1.0, 0.0, 1.0, 1.0];
/// No binary fraction, so that rounding shows where there is any.
pub const SPACING_M: f64 = 30.87;

/// The machine's adapter, or `None` with a message: tests of pictures are skipped where nothing can draw.
pub fn adapter() -> Option<Gpu> {
    match Gpu::headless(&AdapterChoice::default()) {
        Ok(gpu) if gpu.facts().backend != "noop" => Some(gpu),
        Ok(_) => skip("the noop backend draws nothing"),
        Err(error) => skip(&error.to_string()),
    }
}

/// Says on the terminal why a test is skipped.
pub fn skip(why: &str) -> Option<Gpu> {
    // Not `eprintln!`, which the test harness captures.
    let mut stderr = std::io::stderr();
    writeln!(stderr, "skipped: {why}").unwrap();
    None
}

/// A device that validates everything and draws nothing; needs no driver.
pub fn noop() -> Gpu {
    Gpu::headless(&AdapterChoice { backend: Some("noop".to_owned()), ..Default::default() }).unwrap()
}

pub fn heightmap(columns: u32, rows: u32, height_m: impl Fn(u32, u32) -> f64) -> Heightmap {
    let samples = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
    let heights = samples.map(|(column, row)| height_m(column, row) as f32).collect();
    Heightmap::new(columns, rows, [SPACING_M; 2], heights).unwrap()
}

/// Hills of up to 360 m; neither side is a multiple of a patch.
pub fn hills() -> Heightmap {
    heightmap(59, 43, |column, row| {
        let (x, z) = (f64::from(column), f64::from(row));
        200.0 * (0.31 * x).sin() * (0.23 * z).cos() + 110.0 * (0.71 * x + 0.4).cos() * (0.83 * z).sin()
    })
}

/// A method's sizes together with its only plan.
pub struct Mesh {
    pub sizes: BufferSizes,
    pub plan: FramePlan,
}

impl Mesh {
    pub fn triangles(&self) -> u64 {
        self.plan.draws.iter().map(Draw::triangles).sum()
    }
}

/// Every sample, two triangles a quad, `quads_per_draw` quads a draw.
pub fn baked_grid(heightmap: &Heightmap, quads_per_draw: usize) -> Mesh {
    let indices = grid_indices(heightmap.columns(), heightmap.rows());
    let mut plan = FramePlan::default();
    let vertices = BakedVertex::whole_dem(heightmap);
    plan.upload(Buffer::Vertices, 0, &vertices);
    plan.upload(Buffer::Indices, 0, &indices);
    let starts = (0..indices.len()).step_by(quads_per_draw * 6);
    plan.draws = starts
        .enumerate()
        .map(|(patch, start)| {
            let end = indices.len().min(start + quads_per_draw * 6);
            Draw::baked(start as u32..end as u32, 0, tag(patch))
        })
        .collect();
    let sizes = BufferSizes {
        vertex_kind: VertexKind::Baked,
        index_format: IndexFormat::U32,
        vertices: size_of_val(&vertices[..]) as u64,
        indices: size_of_val(&indices[..]) as u64,
        instances: 0,
        heights: None,
        cell_side: None,
    };
    Mesh { sizes, plan }
}

/// The same triangles as [`baked_grid`], as instances of one square patch that reach over the rim.
pub fn displaced_grid(heightmap: &Heightmap, quads: u16) -> Mesh {
    coarse_grid(heightmap, quads, 1)
}

/// Instances of one patch of `quads` x `quads` squares, each with a side of `step` samples, numbered row by row.
pub fn coarse_grid(heightmap: &Heightmap, quads: u16, step: i16) -> Mesh {
    let side = u32::from(quads) + 1;
    let vertices: Vec<_> = (0..=quads).flat_map(|v| (0..=quads).map(move |u| LocalVertex { uv: [u, v] })).collect();
    let indices = grid_indices(side, side);
    let origins = |samples: u32| (0..samples as i32 - 1).step_by(usize::from(quads) * step as usize);
    let instances: Vec<_> = origins(heightmap.rows())
        .flat_map(|row| origins(heightmap.columns()).map(move |column| [column, row]))
        .enumerate()
        .map(|(patch, origin)| PatchInstance {
            origin,
            leg_u: [step, 0],
            leg_v: [0, step],
            tag: tag(patch).to_instance(),
        })
        .collect();
    let mut plan = FramePlan::default();
    plan.upload(Buffer::Vertices, 0, &vertices);
    plan.upload(Buffer::Indices, 0, &indices);
    plan.upload(Buffer::Instances, 0, &instances);
    // Two draws, so that the second one starts at an instance other than 0.
    let (all, half) = (instances.len() as u32, instances.len() as u32 / 2);
    plan.draws = [0..half, half..all]
        .map(|instances| Draw { indices: 0..indices.len() as u32, base_vertex: 0, instances })
        .to_vec();
    let sizes = BufferSizes {
        vertex_kind: VertexKind::Displaced,
        index_format: IndexFormat::U32,
        vertices: size_of_val(&vertices[..]) as u64,
        indices: size_of_val(&indices[..]) as u64,
        instances: size_of_val(&instances[..]) as u64,
        heights: None,
        cell_side: None,
    };
    Mesh { sizes, plan }
}

/// The same mesh with heights of its own, in tiles of cells of 8 x 8 quads. Of a coarse mesh, with steps of 4, levels 0 and
/// 1 read tiles of 1 and 2, all others the coarse grid of 4; elsewhere all read every sample, levels 0 to 5 from tiles.
/// The windows hold all 8 x 6 cells of [`hills`].
pub fn tiled(heightmap: &Heightmap, mesh: &Mesh, format: HeightFormat, coarse: bool) -> Mesh {
    let samples = [heightmap.columns(), heightmap.rows()];
    let (k, coarse_level) = if coarse { (2, 2) } else { (1, 6) };
    let windows = std::array::from_fn(|level| if level < coarse_level { 8 } else { 0 });
    let tiles = HeightTiles { format, samples, k, coarse_level: coarse_level as u32, cell_side: 8, windows };
    let mut plan = mesh.plan.clone();
    let code = &|column: u32, row: u32| {
        let at = Sample { column: column.min(samples[0] - 1), row: row.min(samples[1] - 1) };
        let height_m = heightmap.height_m(at);
        match format {
            HeightFormat::F32 => height_m.to_le_bytes().to_vec(),
            HeightFormat::U16 { scale_m, offset_m } => {
                (((f64::from(height_m) - offset_m) / scale_m) as u16).to_le_bytes().to_vec()
            }
        }
    };
    let mut send = |first: u64, codes: Vec<u8>| {
        let padded = codes.len().next_multiple_of(4);
        let mut codes = codes;
        codes.resize(padded, 0);
        plan.upload(Buffer::Heights, first * format.bytes(), &codes);
    };
    let [columns, rows] = tiles.coarse_size();
    let step = tiles.coarse_step();
    send(0, (0..rows).flat_map(|row| (0..columns).flat_map(move |column| code(step * column, step * row))).collect());
    let cells = || (0..6).flat_map(|row| (0..8).map(move |column| [column, row]));
    for (level, cell) in (0..tiles.coarse_level).flat_map(|level| cells().map(move |cell| (level, cell))) {
        let along = |axis: usize| (8 * cell[axis]..=8 * cell[axis] + 8).step_by(tiles.step(level) as usize);
        let samples = along(1).flat_map(|row| along(0).map(move |column| (column, row)));
        send(tiles.tile(level, cell), samples.flat_map(|(column, row)| code(column, row)).collect());
    }
    Mesh { sizes: BufferSizes { heights: Some(tiles), ..mesh.sizes }, plan }
}

/// Patches take turns through all levels.
fn tag(patch: usize) -> PatchTag {
    PatchTag { patch: patch as u32, level: patch as u32 % 16 }
}

/// ```text
///  a──b    counter-clockwise seen from above (x to the right, z down):
///  │ /│    a, c, b and b, c, d
///  │/ │
///  c──d
/// ```
fn grid_indices(columns: u32, rows: u32) -> Vec<u32> {
    let quads = (0..rows - 1).flat_map(|row| (0..columns - 1).map(move |column| row * columns + column));
    quads
        .flat_map(|a| {
            let (b, c, d) = (a + 1, a + columns, a + columns + 1);
            [a, c, b, b, c, d]
        })
        .collect()
}

/// A camera over a point given in samples.
pub fn view(column: f64, row: f64, height_m: f64, heading: f64, pitch: f64) -> View {
    let eye_world = [column * SPACING_M, height_m, row * SPACING_M].into();
    let lens = Lens { fov_y: 1.0, size_px: SIZE_PX, near_m: 1.0 };
    View::new(&Camera { eye_world, heading, pitch }, &lens).unwrap()
}

/// Over the southern rim, to the north, a little down.
pub fn oblique(heightmap: &Heightmap) -> View {
    view(0.45 * f64::from(heightmap.columns()), f64::from(heightmap.rows()) + 4.0, 700.0, 0.05, -0.5)
}

/// Over the middle and the highest hill, straight down; the whole picture is inside the terrain.
pub fn straight_down(heightmap: &Heightmap) -> View {
    view(0.5 * f64::from(heightmap.columns()), 0.5 * f64::from(heightmap.rows()), 500.0, 0.0, -FRAC_PI_2)
}

/// A plain with one peak.
pub fn peak_at(columns: u32, rows: u32, peak: Sample) -> Heightmap {
    heightmap(columns, rows, |column, row| {
        let distance = f64::from(column.abs_diff(peak.column)).hypot(f64::from(row.abs_diff(peak.row)));
        (1500.0 - 250.0 * distance).max(0.0)
    })
}
