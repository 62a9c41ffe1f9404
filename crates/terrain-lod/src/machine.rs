//! `machine.json`: what a reader must know to believe the numbers, or to repeat them.

use std::process::Command;

use serde::Serialize;
use sha2::{Digest, Sha256};
use sysinfo::System;
use terrain_core::{FlightPath, Heightmap, VoidMask};
use terrain_renderer::Renderer;

use crate::methods::Run;
use crate::output::tidy;
use crate::suite::{Bench, Suite};

#[derive(Serialize)]
pub struct Machine<'a> {
    pub program: &'static str,
    pub version: &'static str,
    pub utc: String,
    pub command: Vec<String>,
    pub cpu: String,
    pub cores: usize,
    pub memory_mib: u64,
    pub os: String,
    pub load_average: f64,
    /// `None` without a GPU.
    pub adapter: Option<String>,
    pub adapter_type: Option<String>,
    pub backend: Option<String>,
    pub driver: Option<String>,
    pub rustc: &'static str,
    pub profile: &'static str,
    pub commit: Option<String>,
    pub dirty: Option<bool>,
    /// Of the executable: two of one commit differ where its checkout was modified.
    pub program_sha256: Option<String>,
    pub dem: &'a str,
    pub dem_source: Option<&'a str>,
    pub dem_licence: Option<&'a str>,
    pub dem_notice: Option<&'a str>,
    pub dem_columns: u32,
    pub dem_rows: u32,
    pub dem_spacing_m: [f64; 2],
    /// Samples that are left out of pictures and errors.
    pub dem_voids: u64,
    pub dem_sha256: String,
    pub flight: &'a str,
    pub flight_sha256: String,
    pub frames: u32,
    pub fov_y_deg: f64,
    pub near_m: f64,
    pub suite: &'a str,
    /// Its name in a suite of several benches.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bench: Option<&'a str>,
    /// The names of the runs' files.
    pub runs: Vec<String>,
    /// What the triangles are coloured by, and where normals are read.
    pub look: String,
    /// How the draws were really sent; `None` without a GPU.
    pub submission: Option<String>,
    pub options: &'a Suite,
}

impl<'a> Machine<'a> {
    /// The facts of this machine and this bench.
    pub fn of(bench: &'a Bench, renderer: Option<&Renderer>, utc: String) -> Self {
        let adapter = renderer.map(|renderer| renderer.gpu().facts());
        let system = System::new_all().ok();
        let commit = git(&["rev-parse", "HEAD"]);
        Self {
            program: env!("CARGO_PKG_NAME"),
            version: env!("CARGO_PKG_VERSION"),
            utc,
            command: std::env::args().skip(1).collect(),
            cpu: cpu_name(system.as_ref()),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            memory_mib: system.as_ref().map_or(0, |system| system.total_memory() >> 20),
            os: System::long_os_version().unwrap_or_else(|_| std::env::consts::OS.into()),
            load_average: System::load_average().map_or(0.0, |load| load.one),
            adapter: adapter.map(|a| a.name.clone()),
            adapter_type: adapter.map(|a| a.adapter_type.to_string()),
            backend: adapter.map(|a| a.backend.to_string()),
            driver: adapter.map(|a| a.driver.clone()),
            rustc: env!("TERRAIN_LOD_RUSTC"),
            profile: if cfg!(debug_assertions) { "debug" } else { "release" },
            dirty: commit.as_ref().and_then(|_| git(&["status", "--porcelain"])).map(|changes| !changes.is_empty()),
            commit,
            program_sha256: program_checksum(),
            dem: &bench.dem.name,
            dem_source: bench.dem.source.as_deref(),
            dem_licence: bench.dem.licence.as_deref(),
            dem_notice: bench.dem.notice.as_deref(),
            dem_columns: bench.dem.heightmap.columns(),
            dem_rows: bench.dem.heightmap.rows(),
            dem_spacing_m: bench.dem.heightmap.spacing_m(),
            dem_voids: bench.dem.heightmap.voids().map_or(0, VoidMask::count),
            dem_sha256: dem_checksum(&bench.dem.heightmap),
            flight: &bench.flight_name,
            flight_sha256: flight_checksum(bench),
            frames: bench.path.len(),
            fov_y_deg: tidy(bench.path.fov_y().to_degrees()),
            near_m: FlightPath::NEAR_M,
            suite: &bench.suite_name,
            bench: bench.name.as_deref(),
            runs: bench.runs.iter().map(Run::file_stem).collect(),
            look: format!("{:?}, {:?}", bench.look.colour, bench.look.normals),
            submission: renderer.map(|renderer| format!("{:?}", renderer.submission())),
            options: &bench.suite,
        }
    }
}

fn cpu_name(system: Option<&System>) -> String {
    let first = system.and_then(|system| system.cpus().first());
    first.map_or_else(|| "unknown".into(), |cpu| cpu.brand().trim().into())
}

/// What git says now about the checkout that this program was built in; xtask has just built it. Nothing where it is gone.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_string())
}

/// SHA-256 over this executable; nothing where it cannot be read.
fn program_checksum() -> Option<String> {
    let program = std::fs::read(std::env::current_exe().ok()?).ok()?;
    Some(hex(&Sha256::digest(&program)))
}

/// SHA-256 over size, spacing, heights, and voids if there are any: of what was measured, whatever file it came from.
fn dem_checksum(heightmap: &Heightmap) -> String {
    let mut hash = Sha256::new();
    hash.update(heightmap.columns().to_le_bytes());
    hash.update(heightmap.rows().to_le_bytes());
    heightmap.spacing_m().iter().for_each(|s| hash.update(s.to_le_bytes()));
    heightmap.heights_m().iter().for_each(|h| hash.update(h.to_le_bytes()));
    let void_words = heightmap.voids().map_or(&[][..], VoidMask::words);
    void_words.iter().for_each(|word| hash.update(word.to_le_bytes()));
    hex(&hash.finalize())
}

/// SHA-256 over all cameras of the flight on this DEM, and their lens.
fn flight_checksum(bench: &Bench) -> String {
    let mut hash = Sha256::new();
    [bench.path.fov_y(), FlightPath::NEAR_M].iter().for_each(|number| hash.update(number.to_le_bytes()));
    for camera in (0..bench.path.len()).map(|frame| bench.path.camera(frame)) {
        let numbers = [camera.eye_world.x, camera.eye_world.y, camera.eye_world.z, camera.heading, camera.pitch];
        numbers.iter().for_each(|n| hash.update(n.to_le_bytes()));
    }
    hex(&hash.finalize())
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
