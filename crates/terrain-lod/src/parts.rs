//! The units of a bench: written as soon as one is done, and not done again by `--resume`.
//!
//! A unit is the error flight of a run, the live flights of a run, one flight of a run in the speed pass, or the pictures of
//! a run. A kill loses what is under way, and the unit's files are whole or not there. The frames of a unit are written
//! before its part, so a part says that they are there.

use serde::{Deserialize, Serialize};

use crate::error_pass::ErrorFrame;
use crate::fault::{Cause, Fault};
use crate::live_pass::LiveFrame;
use crate::methods::Run;
use crate::pictures::PictureRow;
use crate::popping_bins::PoppingBin;
use crate::results::Results;
use crate::speed_pass::{Copy, Lane, SpeedFrame};
use crate::suite::Bench;
use crate::summary::SummaryRow;

/// What the error pass, or the live pass, found for a run: its rows so far, and the former's popping.
#[derive(Serialize, Deserialize)]
pub struct Part {
    pub rows: Vec<SummaryRow>,
    pub popping: Vec<PoppingBin>,
}

/// What the error pass found for a run; `None` where it has not flown.
pub fn errors(results: &Results, run: &Run) -> Result<Option<Part>, Fault> {
    results.read_part(&format!("{}-error", run.file_stem()))
}

pub fn keep_errors(results: &Results, run: &Run, frames: &[ErrorFrame], part: &Part) -> Result<(), Fault> {
    write_frames(results, run, "error", frames)?;
    results.write_part(&format!("{}-error", run.file_stem()), part)
}

/// What the live pass found for a run; `None` where it has not flown as often as it should.
pub fn live(results: &Results, run: &Run) -> Result<Option<Part>, Fault> {
    results.read_part(&format!("{}-live", run.file_stem()))
}

/// The live frames of a run so far.
pub fn keep_live(results: &Results, run: &Run, frames: &[LiveFrame]) -> Result<(), Fault> {
    write_frames(results, run, "live", frames)
}

/// The live flights of a run are all done.
pub fn finish_live(results: &Results, run: &Run, part: &Part) -> Result<(), Fault> {
    results.write_part(&format!("{}-live", run.file_stem()), part)
}

/// The flights of a run, or of its copy, in the speed pass so far.
pub fn speed(bench: &Bench, results: &Results, run: &Run, copy: Copy) -> Result<Vec<SpeedFrame>, Fault> {
    let name = frames_file(run, speed_pass(copy));
    let frames: Vec<SpeedFrame> = results.read_csv(&name)?.unwrap_or_default();
    let is_ours =
        |(i, frame): (u32, &SpeedFrame)| [frame.repeat, frame.frame] == [i / bench.path.len(), i % bench.path.len()];
    if (0..).zip(&frames).all(is_ours) && frames.len().is_multiple_of(bench.path.len() as usize) {
        return Ok(frames);
    }
    let path = results.path(&name);
    Err(Fault::new(Cause::BadInput, format_args!("{}: expected whole flights of this bench, in order", path.display())))
}

pub fn keep_speed(results: &Results, lane: &Lane) -> Result<(), Fault> {
    match &lane.frames {
        Ok(frames) => write_frames(results, lane.run, speed_pass(lane.copy), frames),
        Err(_) => Ok(()),
    }
}

/// What the pictures of a run are worth; `None` where they are not taken.
pub fn shots(results: &Results, run: &Run) -> Result<Option<Vec<PictureRow>>, Fault> {
    results.read_part(&format!("{}-shots", run.file_stem()))
}

pub fn finish_shots(results: &Results, run: &Run, pictures: &[PictureRow]) -> Result<(), Fault> {
    results.write_part(&format!("{}-shots", run.file_stem()), &pictures)
}

fn speed_pass(copy: Copy) -> &'static str {
    match copy {
        Copy::A => "speed",
        Copy::B => "speed-b",
    }
}

fn frames_file(run: &Run, pass: &str) -> String {
    format!("frames/{}-{pass}.csv", run.file_stem())
}

fn write_frames<T: Serialize>(results: &Results, run: &Run, pass: &str, frames: &[T]) -> Result<(), Fault> {
    results.write_csv(&frames_file(run, pass), frames)
}
