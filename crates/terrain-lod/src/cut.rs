//! `dem cells`: cuts a DEM into cells, row of cells by row of cells, in little memory.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

use htp_lod::{CellsHeader, CutError, Cutter, Options, Scan};

use crate::cells_file::{self, Partial};
use crate::dem::Rows;
use crate::dem_args::CellsArgs;
use crate::fault::{Cause, Fault};
use crate::interrupt;
use crate::output::print;
use crate::progress::Progress;
use crate::results::probe_parent;

pub fn run(args: &CellsArgs) -> Result<(), Fault> {
    interrupt::listen();
    let (start, out) = (Instant::now(), with_ending(&args.out));
    let partial = cells_file::partial_of(&out)?;
    probe_parent(&out)?;
    let rows = Rows::open(&args.dem, &args.read.options())?;
    let mut provenance = rows.provenance();
    provenance.notice = args.notice.clone().or(provenance.notice);
    provenance.check().map_err(Fault::usage)?;
    let header = CellsHeader { provenance, ..scan(&rows, args)? };
    let line = Line::of(&header);
    let kept = cut(&rows, header, &partial, &out)?;
    print(&line.text(&out, kept, start.elapsed().as_secs_f64()))
}

/// With `.cells` if the name has no ending.
fn with_ending(out: &Path) -> PathBuf {
    if out.extension().is_some() || out.is_dir() { out.to_owned() } else { out.with_extension("cells") }
}

/// The first pass.
fn scan(rows: &Rows, args: &CellsArgs) -> Result<CellsHeader, Fault> {
    let options = Options { k: args.k, layers: args.layers, ..Options::default() };
    let mut scan = Scan::new(rows.samples(), rows.spacing_m(), Some(rows.steps()), &options).map_err(Fault::usage)?;
    let progress = Progress::new("reading", rows.samples()[1] as u64);
    rows.voids().into_iter().for_each(|mask| scan.set_voids(mask));
    for_each(rows, &mut |row_m| {
        scan.push(row_m);
        progress.step();
        Ok(())
    })?;
    Ok(scan.finish())
}

/// The second pass; the rows of cells that were there already.
fn cut(rows: &Rows, header: CellsHeader, partial: &Path, out: &Path) -> Result<u32, Fault> {
    let (all, mut kept) = (header.cells()[1], 0);
    let mut cutter = Cutter::new(header);
    let partial = Partial::begin(partial, out, &cutter)?;
    let changed = |error: CutError| {
        partial.discard();
        Fault::new(Cause::BadInput, error)
    };
    if let Some(mask) = rows.voids() {
        let (at, piece) = cutter.cut_voids(mask).map_err(changed)?;
        partial.write_at(at, &piece)?;
    }
    let progress = Progress::new("cutting", all as u64);
    for_each(rows, &mut |row_m| {
        let Some(row) = cutter.push(row_m) else { return Ok(()) };
        if cutter.has_row(&partial.file, row).unwrap_or(false) {
            kept += 1;
        } else {
            cutter.cut().map_err(changed)?.iter().try_for_each(|(at, piece)| partial.write_at(*at, piece))?;
        }
        progress.step();
        Ok(())
    })?;
    cutter.finish().map_err(changed)?;
    partial.finish()?;
    Ok(kept)
}

/// Calls with each row until that fails, or Ctrl-C is pressed.
fn for_each(rows: &Rows, on_row: &mut dyn FnMut(&[f32]) -> Result<(), Fault>) -> Result<(), Fault> {
    let mut ended = Ok(());
    rows.for_each(&mut |row_m| {
        ended = interrupted().and_then(|()| on_row(row_m));
        if ended.is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    })?;
    ended
}

fn interrupted() -> Result<(), Fault> {
    match interrupt::is_asked() {
        true => Err(Fault::new(Cause::Interrupted, "interrupted; the same command goes on with what has been cut")),
        false => Ok(()),
    }
}

/// What is said at the end.
struct Line {
    samples: [u32; 2],
    cells: [u32; 2],
    side: u32,
    bits: u64,
}

impl Line {
    fn of(header: &CellsHeader) -> Self {
        let CellsHeader { samples, format, .. } = *header;
        Self { samples, cells: header.cells(), side: header.cell_side(), bits: 8 * format.bytes() }
    }

    fn text(&self, out: &Path, kept: u32, seconds: f64) -> String {
        let Self { samples: [columns, rows], cells, side, bits } = self;
        let (file, resident) = sizes(out);
        let each = file as f64 / (*columns as f64 * *rows as f64);
        let kept = if kept == 0 { String::new() } else { format!(", {kept} of {} rows of cells were there", cells[1]) };
        format!(
            "{}: {columns} x {rows} samples of {bits} bits in {} x {} cells of {side} x {side} intervals; {:.1} MB, {:.1} \
             of them resident, {each:.2} bytes a sample; {seconds:.1} s{kept}\n",
            out.display(),
            cells[0],
            cells[1],
            file as f64 / 1e6,
            resident as f64 / 1e6,
        )
    }
}

/// Bytes of the file, and of what stays resident.
fn sizes(out: &Path) -> (u64, u64) {
    let bytes = out.metadata().map_or(0, |file| file.len());
    let resident = cells_file::open(out).map_or(0, |(file, _)| file.resident_bytes());
    (bytes, resident)
}
