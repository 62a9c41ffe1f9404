//! `dem synth`: writes synthetic ground of any size, with some rows of it in memory.

use std::io;
use std::path::Path;

use rayon::prelude::*;
use terrain_dem::synthetic::{Kind, SPACING_M};
use terrain_dem::{DemError, SIDECAR_MARK, sidecar_of, write_atomically, write_png16_rows};

use crate::dem_args::SynthArgs;
use crate::fault::{Cause, Fault};
use crate::interrupt;
use crate::output::print;
use crate::progress::Progress;
use crate::results::probe_parent;
use crate::sidecar_file;

/// Metres a step of the values: all heights of all kinds fit 16 bits.
const SCALE_M: f64 = 0.05;

/// Rows that are made at once, on all threads.
const BATCH: u32 = 64;

pub fn run(args: &SynthArgs) -> Result<(), Fault> {
    interrupt::listen();
    let ([columns, rows], out) = (args.size, &args.out);
    if !matches!(ending(out), Some("png" | "r16")) {
        return Err(Fault::usage(format_args!("{}: expected a name that ends in .png or .r16", out.display())));
    }
    sidecar_file::check_place(Path::new(""), out)?;
    probe_parent(out)?;
    let mut source = Rows::new(args);
    match ending(out) {
        Some("png") => write_png16_rows(out, columns, rows, &mut |row| source.fill(row)).map_err(or_interrupted)?,
        _ => write_raw(out, args.size, &mut source)?,
    }
    write_sidecar(args)?;
    print(&format!("{}: {columns} x {rows} samples of {SCALE_M} m a step\n", out.display()))
}

fn ending(out: &Path) -> Option<&str> {
    out.extension().and_then(|ending| ending.to_str())
}

fn or_interrupted(error: DemError) -> Fault {
    if interrupt::is_asked() { Fault::new(Cause::Interrupted, "interrupted; nothing is written") } else { error.into() }
}

fn write_raw(out: &Path, [columns, rows]: [u32; 2], source: &mut Rows) -> Result<(), Fault> {
    let mut row = vec![0; columns as usize];
    let written = write_atomically(out, |file| {
        for _ in 0..rows {
            source.fill(&mut row)?;
            let bytes: Vec<u8> = row.iter().flat_map(|value| value.to_le_bytes()).collect();
            file.write_all(&bytes)?;
        }
        Ok(())
    });
    written.map_err(|source| or_interrupted(DemError::Io { action: "write", path: out.to_owned(), source }))
}

/// What the numbers mean, for whoever reads them.
fn write_sidecar(args: &SynthArgs) -> Result<(), Fault> {
    let (path, [columns, rows]) = (sidecar_of(&args.out), args.size);
    let kind = clap::ValueEnum::to_possible_value(&args.kind).expect("a name");
    let raw =
        if ending(&args.out) == Some("r16") { format!("raw = \"{columns}x{rows}:uint16\"\n") } else { String::new() };
    let text = format!(
        "{SIDECAR_MARK}\nspacing_m = {SPACING_M:?}\nscale = {SCALE_M:?}\n{raw}source = \"terrain-lod dem synth --size {columns}x{rows} --seed {} \
         --kind {}\"\n",
        args.seed,
        kind.get_name(),
    );
    write_atomically(&path, |file| file.write_all(text.as_bytes())).map_err(|e| Fault::write(&path, e))
}

/// The values row by row.
struct Rows {
    kind: Kind,
    seed: u64,
    size: [u32; 2],
    /// The next one.
    row: u32,
    /// Those of the batch that the next row is in.
    values: Vec<u16>,
    progress: Progress,
}

impl Rows {
    fn new(args: &SynthArgs) -> Self {
        let progress = Progress::new("terrain", args.size[1] as u64);
        Self { kind: args.kind.into(), seed: args.seed, size: args.size, row: 0, values: Vec::new(), progress }
    }

    fn fill(&mut self, row: &mut [u16]) -> io::Result<()> {
        if interrupt::is_asked() {
            return Err(io::ErrorKind::Interrupted.into());
        }
        let at = (self.row % BATCH) as usize * row.len();
        if at == 0 {
            self.make_batch();
        }
        row.copy_from_slice(&self.values[at..at + row.len()]);
        self.row += 1;
        self.progress.step();
        Ok(())
    }

    fn make_batch(&mut self) {
        let ([columns, rows], first) = (self.size, self.row);
        self.values.resize((BATCH.min(rows - first) * columns) as usize, 0);
        self.values.par_chunks_mut(columns as usize).enumerate().for_each(|(i, values)| {
            let mut row_m = vec![0.0; values.len()];
            self.kind.fill_row(self.seed, first + i as u32, &mut row_m);
            for (value, height_m) in values.iter_mut().zip(row_m) {
                *value = (height_m as f64 / SCALE_M).round() as u16;
            }
        });
    }
}
