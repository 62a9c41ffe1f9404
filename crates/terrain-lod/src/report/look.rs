//! What a run looks like in all charts: colour, dashes, marker.

use crate::report::html::escape;

/// Colours and dashes in `chart.css`, and markers here. No two of the counts have a divisor in common, so 30 runs that
/// share no setting differ in colour or dashes, and 42 in colour or marker.
const COLOURS: usize = 6;
const DASHES: usize = 5;
/// Shapes around the origin: circle, square, triangle, diamond, triangle, plus, cross.
const MARKERS: [&str; 7] = [
    "M-4.2 0A4.2 4.2 0 1 0 4.2 0A4.2 4.2 0 1 0-4.2 0Z",
    "M-3.8-3.8H3.8V3.8H-3.8Z",
    "M0-5L4.8 3.6H-4.8Z",
    "M0-5.4L5.4 0L0 5.4L-5.4 0Z",
    "M0 5L4.8-3.6H-4.8Z",
    "M-1.6-5H1.6V-1.6H5V1.6H1.6V5H-1.6V1.6H-5V-1.6H-1.6Z",
    "M0-2.3L2.9-5.2L5.2-2.9L2.3 0L5.2 2.9L2.9 5.2L0 2.3L-2.9 5.2L-5.2 2.9L-2.3 0L-5.2-2.9L-2.9-5.2Z",
];

/// The look of one run. Runs of one method and setting, which differ in tolerance, are a family: they share colour and
/// marker, and differ in dashes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look {
    /// Position among all runs.
    pub run: usize,
    pub family: usize,
    /// Position in the family.
    pub rank: usize,
}

impl Look {
    fn colour(self) -> usize {
        self.family % COLOURS
    }

    fn dash(self) -> usize {
        (self.family + self.rank) % DASHES
    }

    /// The classes of a run's marks: what it is hidden by, colour, dashes.
    pub fn classes(self) -> String {
        format!("r{} c{} d{}", self.run, self.colour(), self.dash())
    }

    /// Where a line lies: solid ones at the bottom, dots on top, so that of two equal lines both can be seen.
    pub fn layer(self) -> usize {
        [0, 2, 4, 3, 1][self.dash()]
    }

    /// The marker at a place.
    pub fn marker(self, [x, y]: [f64; 2]) -> String {
        let shape = MARKERS[self.family % MARKERS.len()];
        format!("<path class=\"marker\" d=\"{shape}\" transform=\"translate({x:.1} {y:.1})\"/>")
    }

    /// A line with a marker, as wide as 34 units and as high as 14.
    pub fn sample(self) -> String {
        format!("<path class=\"line\" d=\"M1 7H33\"/>{}", self.marker([17.0, 7.0]))
    }

    /// The sample among text.
    pub fn swatch(self, label: &str) -> String {
        format!(
            "<svg class=\"swatch c{} d{}\" viewBox=\"0 0 34 14\" width=\"34\" height=\"14\" role=\"img\"><title>{}</title>{}</svg>",
            self.colour(),
            self.dash(),
            escape(label),
            self.sample()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thirty_families_differ_in_their_lines_and_a_family_in_its_dashes() {
        let lines = |look: Look| (look.colour(), look.dash());
        let families: std::collections::BTreeSet<_> =
            (0..30).map(|family| lines(Look { run: 0, family, rank: 0 })).collect();
        assert_eq!(families.len(), 30);
        let ranks: std::collections::BTreeSet<_> = (0..5).map(|rank| lines(Look { run: 0, family: 7, rank })).collect();
        assert_eq!(ranks.len(), 5);
    }
}
