//! Axes: a range that ends at round numbers, ticks at round numbers.

use crate::report::html;

/// What of the axis' length lies between 0 and the rest, where a logarithmic axis has to show a 0 too.
const ZERO_SLOT: f64 = 0.085;
/// A range that spans this much is shown by its logarithm.
const WIDE: f64 = 20.0;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// From 0.
    Linear,
    Log,
}

/// One axis, from values to coordinates.
#[derive(Clone, Debug)]
pub struct Axis {
    scale: Scale,
    low: f64,
    high: f64,
    /// Whether a logarithmic axis has a place for 0 before its range.
    pub has_zero: bool,
    /// Coordinates of the ends.
    from: f64,
    to: f64,
}

/// A tick, with its label.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    pub value: f64,
    pub label: String,
}

impl Axis {
    /// The axis that holds all these values. Coordinates of its ends: `from`, `to`.
    pub fn fit(values: impl Iterator<Item = f64>, scale: Scale, [from, to]: [f64; 2]) -> Self {
        let (mut low, mut high, mut has_zero) = (f64::INFINITY, 0.0_f64, false);
        for value in values {
            match value > 0.0 {
                true => (low, high) = (low.min(value), high.max(value)),
                false => has_zero = true,
            }
        }
        if high == 0.0 {
            (low, high) = (1.0, 1.0);
        }
        match scale {
            Scale::Linear => {
                let step = step(high, 5);
                Self { scale, low: 0.0, high: (high / step - 1e-9).ceil() * step, has_zero: false, from, to }
            }
            Scale::Log => {
                let low = round_down(low);
                let high = round_up(high);
                let high = if low < high { high } else { round_up(high * 1.5) };
                Self { scale, low, high, has_zero, from, to }
            }
        }
    }

    /// The axis of whole numbers from `first` to `last`, such as frames.
    pub fn counting([first, last]: [f64; 2], [from, to]: [f64; 2]) -> Self {
        Self { scale: Scale::Linear, low: first, high: last.max(first + 1.0), has_zero: false, from, to }
    }

    /// The scale that suits values: logarithmic where they span much.
    pub fn scale_for(values: impl Iterator<Item = f64>) -> Scale {
        let (low, high) =
            values.filter(|v| *v > 0.0).fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
        if high > WIDE * low { Scale::Log } else { Scale::Linear }
    }

    pub fn is_log(&self) -> bool {
        self.scale == Scale::Log
    }

    /// The coordinate of a value; what lies below a logarithmic range is 0.
    pub fn at(&self, value: f64) -> f64 {
        let slot = if self.has_zero { ZERO_SLOT } else { 0.0 };
        let share = match self.scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Log if value <= 0.0 => return self.from,
            Scale::Log => slot + (1.0 - slot) * (value / self.low).ln() / (self.high / self.low).ln(),
        };
        self.from + share * (self.to - self.from)
    }

    /// Ticks from the low end to the high one, about `count` of them.
    pub fn ticks(&self, count: usize) -> Vec<Tick> {
        let values = match self.scale {
            Scale::Linear => linear_ticks(self.low, self.high, count),
            Scale::Log => log_ticks(self.low, self.high, count),
        };
        let zero = self.has_zero.then_some(0.0);
        zero.into_iter().chain(values).map(|value| Tick { value, label: tick_label(value) }).collect()
    }
}

/// A round step (1, 2 or 5 times a power of ten) with which `length` has at most `count` of them.
fn step(length: f64, count: usize) -> f64 {
    let least = length / count as f64;
    let power = 10_f64.powf(least.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    step.into_iter().find(|step| *step >= least * (1.0 - 1e-9)).unwrap_or(10.0 * power)
}

fn linear_ticks(low: f64, high: f64, count: usize) -> Vec<f64> {
    let step = step(high - low, count);
    let (first, last) = ((low / step - 1e-9).ceil() as i64, (high / step + 1e-9).floor() as i64);
    (first..=last).map(|i| i as f64 * step).collect()
}

/// The powers of ten, every n-th where they are many, with more between them where they are few.
fn log_ticks(low: f64, high: f64, count: usize) -> Vec<f64> {
    let (first, last) = ((low * (1.0 + 1e-9)).log10().floor() as i32, (high * (1.0 + 1e-9)).log10().floor() as i32);
    let decades = (high / low).log10();
    let every = (decades / count as f64).ceil().max(1.0) as usize;
    let factors: &[f64] = match decades {
        few if few * 9.0 <= count as f64 + 1.0 => &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0],
        some if some * 3.0 <= count as f64 + 2.0 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    let all = (first..=last).step_by(every).flat_map(|power| factors.iter().map(move |f| f * 10_f64.powi(power)));
    let is_within = |value: &f64| *value >= low * (1.0 - 1e-9) && *value <= high * (1.0 + 1e-9);
    all.filter(is_within).collect()
}

/// The next number of 1, 2, 5, 10, 20, ... that is not greater.
fn round_down(value: f64) -> f64 {
    let power = 10_f64.powi(value.log10().floor() as i32);
    let rounds = [5.0, 2.0, 1.0].map(|factor| factor * power);
    rounds.into_iter().find(|round| *round <= value * (1.0 + 1e-9)).unwrap_or(power)
}

/// Likewise, not less.
fn round_up(value: f64) -> f64 {
    let power = 10_f64.powi(value.log10().floor() as i32);
    let rounds = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    rounds.into_iter().find(|round| *round >= value * (1.0 - 1e-9)).unwrap_or(10.0 * power)
}

/// Short: 0.05, 200, 5 000, 20 k, 1 M.
fn tick_label(value: f64) -> String {
    let (scaled, unit) = match value.abs() {
        size if size >= 1e9 => (value / 1e9, "\u{202f}G"),
        size if size >= 1e6 => (value / 1e6, "\u{202f}M"),
        size if size >= 1e4 => (value / 1e3, "\u{202f}k"),
        size if size < 1e-4 && size > 0.0 => return format!("{value:.0e}"),
        _ => (value, ""),
    };
    html::digits(scaled) + unit
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(values: &[f64], scale: Scale) -> Vec<String> {
        let ticks = Axis::fit(values.iter().copied(), scale, [0.0, 100.0]).ticks(6);
        ticks.into_iter().map(|tick| tick.label).collect()
    }

    #[test]
    fn linear_axes_start_at_zero_and_end_at_a_round_number() {
        assert_eq!(labels(&[3.0, 47.0], Scale::Linear), ["0", "10", "20", "30", "40", "50"]);
        assert_eq!(labels(&[0.29, 0.3], Scale::Linear), ["0", "0.05", "0.1", "0.15", "0.2", "0.25", "0.3"]);
        assert_eq!(
            labels(&[275_772.0], Scale::Linear),
            ["0", "50\u{202f}k", "100\u{202f}k", "150\u{202f}k", "200\u{202f}k", "250\u{202f}k", "300\u{202f}k"]
        );
        assert_eq!(labels(&[], Scale::Linear).first().map(String::as_str), Some("0"));
    }

    #[test]
    fn logarithmic_axes_have_a_place_for_zero_where_there_is_one() {
        assert_eq!(labels(&[0.7, 11.2], Scale::Log), ["0.5", "1", "2", "5", "10", "20"]);
        assert_eq!(labels(&[0.0, 0.7, 11.2], Scale::Log)[..2], ["0", "0.5"]);
        assert_eq!(labels(&[1.0], Scale::Log), ["1", "2"]);
        assert_eq!(
            labels(&[1e-3, 1e9], Scale::Log),
            ["0.001", "0.1", "10", "1\u{202f}000", "100\u{202f}k", "10\u{202f}M", "1\u{202f}G"]
        );
    }

    #[test]
    fn values_lie_between_the_ends_in_order() {
        for scale in [Scale::Linear, Scale::Log] {
            let values = [0.0, 0.003, 0.9, 1.0, 77.0];
            let axis = Axis::fit(values.into_iter(), scale, [300.0, 20.0]);
            let at = values.map(|value| axis.at(value));
            assert!(at.windows(2).all(|pair| pair[0] > pair[1]), "{scale:?}: {at:?}");
            assert!(at[0] <= 300.0 && at[4] >= 20.0, "{scale:?}: {at:?}");
        }
    }

    #[test]
    fn ticks_fit_into_any_range() {
        for exponent in -5..9 {
            for factor in [1.0, 1.9, 3.3, 9.99] {
                let high = factor * 10_f64.powi(exponent);
                for (scale, span) in [(Scale::Linear, 1.0), (Scale::Log, 3.0), (Scale::Log, 1e3), (Scale::Log, 1e8)] {
                    let ticks = Axis::fit([high / span, high].into_iter(), scale, [0.0, 1.0]).ticks(6);
                    assert!((2..=9).contains(&ticks.len()), "{scale:?} {span} {high}: {ticks:?}");
                }
            }
        }
    }
}
