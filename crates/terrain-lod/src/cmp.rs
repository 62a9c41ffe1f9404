//! `cmp A B`: what has changed between two benches, or between two suites of several, bench by bench. Counters are compared
//! exactly, times beyond noise.

mod columns;
mod pair;
mod side;
mod summary;
mod write;

use crate::cmp_args::CmpArgs;
use crate::compare::{Comparison, is_better_when_larger};
use crate::fault::{Cause, Fault};
use crate::interval::Verdict;
use crate::output::print;
use pair::Pairs;
use side::Side;

pub fn run(args: &CmpArgs) -> Result<(), Fault> {
    let (a, b) = (Side::open(&args.a)?, Side::open(&args.b)?);
    if a.is_suite != b.is_suite {
        let (suite, bench) = if a.is_suite { (&a.name, &b.name) } else { (&b.name, &a.name) };
        return Err(Fault::usage(format!(
            "{suite} is a suite of several benches and {bench} is one; name one of its folders"
        )));
    }
    if !args.force {
        refuse_to_mix(&a, &b)?;
    }
    let pairs = Pairs::of(&a, &b);
    print(&write::text(&pairs, &a, &b, args.format))?;
    match args.fail_on {
        Some(_) if a.rows() == pairs.only_in_a.len() => {
            let message = format!("{} and {} have no run in common; --fail-on needs one", a.name, b.name);
            Err(Fault::usage(message))
        }
        Some(share) => fail_on(&pairs, share),
        None => Ok(()),
    }
}

/// Numbers of another machine, DEM, flight or build are other numbers.
fn refuse_to_mix(a: &Side, b: &Side) -> Result<(), Fault> {
    if let Some(side) = [a, b].into_iter().find(|side| side.is_incomplete) {
        let name = &side.name;
        let message = format!("{name}: marked INCOMPLETE; finish it with bench --resume, or compare with --force");
        return Err(Fault::usage(message));
    }
    for bench in &a.benches {
        let Some(other) = b.bench(&bench.name) else { continue };
        let common = bench.summary.facts.iter().filter_map(|(fact, value)| Some((fact, value, other.facts.get(fact)?)));
        if let Some((fact, a_value, b_value)) = common.into_iter().find(|(_, a, b)| a != b) {
            let [a, b] = [a, b].map(|side| place(side, &bench.name));
            let message = format!("{fact} is {a_value} in {a} and {b_value} in {b}");
            return Err(Fault::usage(message + "; --force compares them all the same"));
        }
    }
    Ok(())
}

/// A bench as the user finds it.
fn place(side: &Side, bench: &str) -> String {
    if bench.is_empty() { side.name.clone() } else { format!("{bench} of {}", side.name) }
}

/// A run that B lacks counts as worse: a method that is not flown any more must not pass. Further runs in B are none.
fn fail_on(pairs: &Pairs, share: f64) -> Result<(), Fault> {
    let worse = pairs.comparisons.iter().filter(|comparison| is_worse_by(comparison, share)).count();
    let missing = pairs.only_in_a.len();
    if worse == 0 && missing == 0 {
        return Ok(());
    }
    let percent = 100.0 * share;
    let message = format!("{worse} numbers are worse by more than {percent} %, {missing} runs are missing in B");
    Err(Fault::new(Cause::Regression, message + "; see the table"))
}

/// What was 0 and is not is worse by more than any share, and so is a counter that B has lost.
fn is_worse_by(comparison: &Comparison, share: f64) -> bool {
    let factor = |ratio: f64| if is_better_when_larger(&comparison.measure) { 1.0 / ratio } else { ratio };
    match comparison.verdict {
        Verdict::Worse => comparison.ratio.is_none_or(|ratio| factor(ratio) > 1.0 + share),
        Verdict::Lost => true,
        Verdict::Better | Verdict::Same | Verdict::New => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn comparison(measure: &str, ratio: Option<f64>, verdict: Verdict) -> Comparison {
        let who = crate::compare::Who { bench: "", method: "tin", setting: "", tolerance_px: 1.0 };
        Comparison { ratio, ..who.compare(measure, Some(1.0), Some(1.0), verdict) }
    }

    #[test]
    fn worse_by_more_goes_by_what_is_better() {
        use Verdict::{Better, Lost, New, Same, Worse};
        let is_worse = |measure, ratio, verdict| is_worse_by(&comparison(measure, ratio, verdict), 0.05);
        assert!(is_worse("draws_mean", Some(1.06), Worse) && !is_worse("draws_mean", Some(1.04), Worse));
        assert!(is_worse("fps_mean", Some(0.9), Worse) && !is_worse("fps_mean", Some(0.97), Worse));
        assert!(!is_worse("frame_ms_p50", Some(1.2), Same), "noise");
        assert!(!is_worse("draws_mean", Some(0.5), Better) && is_worse("cracks", None, Worse));
        assert!(is_worse("draws_mean", None, Lost) && !is_worse("draws_mean", None, New));
    }
}
