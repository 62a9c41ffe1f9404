//! The passes of a bench, one after the other: while one measures time, nothing else runs. What `--resume` finds is taken
//! as it is.

use rayon::prelude::*;
use terrain_renderer::{Gpu, Renderer};

use crate::attempt::attempt;
use crate::compare::Comparison;
use crate::error_pass;
use crate::fault::Fault;
use crate::frame_times::RepeatTimes;
use crate::live_pass;
use crate::methods::Run;
use crate::parts::{self, Part};
use crate::pictures::PictureRow;
use crate::popping_bins::{self, PoppingBin};
use crate::progress::Progress;
use crate::repeats;
use crate::results::Results;
use crate::shots::Studio;
use crate::speed_pass::{self, Copy, Lane};
use crate::suite::Bench;
use crate::summary::{self, SummaryRow, Surroundings};

/// What became of one run.
pub struct Flown {
    pub rows: Vec<SummaryRow>,
    /// What the error pass found beside them.
    pub popping: Vec<PoppingBin>,
    /// What its pictures are worth.
    pub pictures: Vec<PictureRow>,
    /// Of each repeat of the speed pass.
    pub times: RepeatTimes,
    /// Its two sets of flights, where there are two.
    pub aa: Option<Comparison>,
    /// Why it failed, if it did.
    pub fault: Option<Fault>,
}

impl Flown {
    fn of(rows: Vec<SummaryRow>) -> Self {
        Self { rows, popping: Vec::new(), pictures: Vec::new(), times: RepeatTimes::default(), aa: None, fault: None }
    }

    fn part(&self) -> Part {
        Part { rows: self.rows.clone(), popping: self.popping.clone() }
    }

    /// The first failure counts, and stands in every row of the run.
    pub fn fail(&mut self, stage: &str, fault: Fault) {
        if self.fault.is_none() {
            self.rows.iter_mut().for_each(|row| row.err = format!("{stage}: {fault}"));
            self.fault = Some(fault);
        }
    }

    fn fill(&mut self, mut fill: impl FnMut(&mut SummaryRow, usize)) {
        self.rows.iter_mut().enumerate().for_each(|(i, row)| fill(row, i));
    }

    fn take_pictures(&mut self, pictures: Vec<PictureRow>) {
        self.rows.iter_mut().for_each(|row| summary::fill_pictures(row, &pictures));
        self.pictures = pictures;
    }

    fn take_speed(&mut self, lane: &Lane) {
        match &lane.frames {
            Ok(frames) => {
                self.times = lane.times();
                let times = &self.times;
                self.rows.iter_mut().for_each(|row| summary::fill_speed(row, frames, times));
            }
            Err(fault) => self.fail("speed pass", fault.clone()),
        }
    }

    fn check_aa(&mut self, copy: &Lane) {
        match &copy.frames {
            Ok(_) => self.aa = repeats::check_aa(&self.rows[0], &self.times, &copy.times()),
            Err(fault) => self.fail("speed pass of the copy", fault.clone()),
        }
    }
}

/// All passes but the pictures.
pub fn fly(
    bench: &Bench,
    renderer: &mut Option<Renderer>,
    results: &Results,
    surroundings: &Surroundings,
) -> Result<Vec<Flown>, Fault> {
    let mut flown = fly_errors(bench, results, surroundings)?;
    fly_live(bench, results, &mut flown)?;
    fly_speed(bench, renderer, results, &mut flown)?;
    Ok(flown)
}

/// All runs at once, on all cores.
fn fly_errors(bench: &Bench, results: &Results, surroundings: &Surroundings) -> Result<Vec<Flown>, Fault> {
    let found = bench.runs.iter().map(|run| parts::errors(results, run)).collect::<Result<Vec<_>, _>>()?;
    let to_fly = found.iter().filter(|part| part.is_none()).count();
    let progress = Progress::new("errors", to_fly as u64 * bench.path.len() as u64);
    let fly = |(run, part): (&Run, Option<Part>)| match part {
        Some(Part { rows, popping }) => Ok(Flown { popping, ..Flown::of(rows) }),
        None => fly_errors_of(bench, run, results, surroundings, &progress),
    };
    bench.runs.par_iter().zip(found).map(fly).collect()
}

fn fly_errors_of(
    bench: &Bench,
    run: &Run,
    results: &Results,
    surroundings: &Surroundings,
    progress: &Progress,
) -> Result<Flown, Fault> {
    let mut flown = Flown::of(summary::rows(bench, run, surroundings));
    match attempt(|| error_pass::fly(bench, run, progress))? {
        Ok(flight) => {
            flown.fill(|row, i| summary::fill_errors(row, &flight, i));
            flown.popping = popping_bins::bins(run, &flight.popping);
            parts::keep_errors(results, run, &flight.frames, &flown.part())?;
        }
        Err(fault) => flown.fail("error pass", fault),
    }
    Ok(flown)
}

fn fly_live(bench: &Bench, results: &Results, flown: &mut [Flown]) -> Result<(), Fault> {
    let mut to_fly = Vec::new();
    for (run, flown) in bench.runs.iter().zip(flown).filter(|(run, _)| run.is_live()) {
        match parts::live(results, run)? {
            Some(part) if flown.fault.is_none() => flown.rows = part.rows,
            _ => to_fly.push((run, flown)),
        }
    }
    let runs: Vec<&Run> = to_fly.iter().map(|(run, _)| *run).collect();
    let flights = runs.len() as u64 * bench.suite.repeats as u64;
    let progress = Progress::new("live", flights * bench.path.len() as u64);
    let keep = |run: &Run, frames: &[_]| parts::keep_live(results, run, frames);
    for (flight, (run, flown)) in live_pass::fly_all(bench, &runs, &progress, keep)?.into_iter().zip(to_fly) {
        match flight {
            Ok(flight) => {
                let flight = flight.expect("a suite has at least one repeat");
                flown.fill(|row, i| summary::fill_live(row, bench, &flight, i));
            }
            Err(fault) => flown.fail("live pass", fault),
        }
        if flown.fault.is_none() {
            parts::finish_live(results, run, &flown.part())?;
        }
    }
    Ok(())
}

fn fly_speed(
    bench: &Bench,
    renderer: &mut Option<Renderer>,
    results: &Results,
    flown: &mut [Flown],
) -> Result<(), Fault> {
    let mut lanes = Vec::new();
    for copy in copies(bench) {
        for run in &bench.runs {
            lanes.push(Lane { run, copy: *copy, frames: Ok(parts::speed(bench, results, run, *copy)?) });
        }
    }
    let to_fly: u32 = lanes.iter().map(|lane| bench.suite.repeats.saturating_sub(lane.repeats())).sum();
    let progress = Progress::new("speed", to_fly as u64 * bench.path.len() as u64);
    speed_pass::fly_all(bench, renderer, &mut lanes, &progress, |lane| parts::keep_speed(results, lane))?;
    let (firsts, copies) = lanes.split_at(bench.runs.len());
    flown.iter_mut().zip(firsts).for_each(|(flown, lane)| flown.take_speed(lane));
    flown.iter_mut().zip(copies).for_each(|(flown, lane)| flown.check_aa(lane));
    Ok(())
}

/// The sets of flights that the speed pass flies of each run.
pub fn copies(bench: &Bench) -> &'static [Copy] {
    if bench.suite.aa { &[Copy::A, Copy::B] } else { &[Copy::A] }
}

/// Pictures of the runs that have come so far.
pub fn take_shots(bench: &Bench, gpu: &Gpu, results: &Results, flown: &mut [Flown]) -> Result<(), Fault> {
    let (folder, progress) = (results.path("shots"), Progress::new("pictures", 3 * bench.runs.len() as u64));
    let mut studio = None;
    for (run, flown) in bench.runs.iter().zip(flown).filter(|(_, flown)| flown.fault.is_none()) {
        if let Some(pictures) = parts::shots(results, run)? {
            flown.take_pictures(pictures);
            continue;
        }
        // Where all pictures are there, none is made.
        let studio = match &mut studio {
            Some(studio) => studio,
            None => studio.insert(Studio::new(bench, gpu)?),
        };
        match attempt(|| studio.take(run, &folder, &progress))? {
            Ok(pictures) => {
                parts::finish_shots(results, run, &pictures)?;
                flown.take_pictures(pictures);
            }
            Err(fault) => flown.fail("pictures", fault),
        }
    }
    Ok(())
}
