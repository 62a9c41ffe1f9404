//! A chart as SVG: title, axes, grid, and whatever marks it is given. Colours come from `chart.css`, which the page and the
//! charts in files of their own share.
//!
//! ```text
//!  title
//!  y label
//!  |                        Y_ENDS[1]
//!  |          marks
//!  +---------------------   Y_ENDS[0]
//!  X_ENDS[0]      X_ENDS[1]
//!                 x label
//! ```

use std::fmt::Write;

use crate::report::axis::Axis;
use crate::report::html::escape;
use crate::report::look::Look;
use crate::report::runs::Run;

pub const CHART_CSS: &str = include_str!("chart.css");

/// In units of the view box, which the page scales.
const WIDTH: f64 = 600.0;
const HEIGHT: f64 = 330.0;
/// Coordinates of the ends of the axes.
pub const X_ENDS: [f64; 2] = [60.0, 580.0];
pub const Y_ENDS: [f64; 2] = [286.0, 54.0];
/// Of a line of a legend.
const KEY_HEIGHT: f64 = 18.0;
/// Of its text, after the sample.
const KEY_INDENT: f64 = 42.0;
/// Around a chart in a file of its own; in the page, it lines up with the text.
const MARGIN: f64 = 12.0;

/// What a look stands for.
#[derive(Clone)]
pub struct Key {
    pub look: Look,
    pub label: String,
}

/// A chart without its frame drawn.
pub struct Chart {
    /// In the page and as a file's name.
    pub id: String,
    pub title: String,
    pub x_label: &'static str,
    pub y_label: String,
    pub x: Axis,
    pub y: Axis,
    /// SVG.
    pub marks: String,
    /// Whether the x axis counts frames: then the script draws the shared cursor.
    pub has_cursor: bool,
    /// What its marks are, where that is not the runs of the page's legend.
    pub keys: Vec<Key>,
}

impl Chart {
    /// The chart in a page that has `chart.css`.
    pub fn inline(&self) -> String {
        let ends = [X_ENDS[0], X_ENDS[1], Y_ENDS[0], Y_ENDS[1]].map(|end| end.to_string()).join(" ");
        let cursor = match self.has_cursor {
            true => format!(" data-curve=\"{}\" data-ends=\"{ends}\" tabindex=\"0\"", self.id),
            false => String::new(),
        };
        format!(
            "<svg class=\"chart\" viewBox=\"0 0 {WIDTH} {}\" role=\"img\" aria-labelledby=\"{1}-title\"{cursor}>\
             <title id=\"{1}-title\">{2}</title>\n{3}{4}</svg>\n",
            HEIGHT + height(&self.keys),
            self.id,
            escape(&self.title),
            self.content(),
            legend(&self.keys)
        )
    }

    /// The chart as a file, with its legend, or that of the runs.
    pub fn file(&self, runs: &[Run]) -> String {
        let of_runs = runs.iter().map(|run| Key { look: run.look, label: run.label.clone() });
        let keys = if self.keys.is_empty() { of_runs.collect() } else { self.keys.clone() };
        let (width, height) = (WIDTH + MARGIN, HEIGHT + height(&keys) + 2.0 * MARGIN);
        let legend = legend(&keys);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"chart\" viewBox=\"-{MARGIN} -{MARGIN} {width} {height}\" \
             width=\"{width}\" height=\"{height}\" role=\"img\">\n<title>{}</title>\n<style>\n{CHART_CSS}</style>\n\
             <rect class=\"paper\" x=\"-{MARGIN}\" y=\"-{MARGIN}\" width=\"{width}\" height=\"{height}\"/>\n{}{legend}</svg>\n",
            escape(&self.title),
            self.content()
        )
    }

    fn content(&self) -> String {
        let mut text = format!(
            "<text class=\"title\" x=\"0\" y=\"18\">{}</text><text class=\"label\" x=\"0\" y=\"36\">{}</text>\
             <text class=\"label\" x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>\n",
            escape(&self.title),
            escape(&self.y_label),
            X_ENDS[1],
            Y_ENDS[0] + 37.0,
            escape(self.x_label)
        );
        text += &self.y_axis();
        text += &self.x_axis();
        text + "\n" + &self.marks
    }

    fn y_axis(&self) -> String {
        let mut text = String::from("<g class=\"grid\">");
        for tick in self.y.ticks(6) {
            let y = self.y.at(tick.value);
            let class = if tick.value == 0.0 { " class=\"zero\"" } else { "" };
            let _ = write!(
                text,
                "<path{class} d=\"M{} {y:.1}H{}\"/><text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                X_ENDS[0],
                X_ENDS[1],
                X_ENDS[0] - 7.0,
                y + 4.0,
                tick.label
            );
        }
        text + "</g>\n"
    }

    fn x_axis(&self) -> String {
        let mut text = String::from("<g class=\"grid\">");
        for tick in self.x.ticks(7) {
            let x = self.x.at(tick.value);
            let class = if tick.value == 0.0 { " class=\"zero\"" } else { "" };
            let _ = write!(
                text,
                "<path{class} d=\"M{x:.1} {}V{}\"/><text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                Y_ENDS[0],
                Y_ENDS[1],
                Y_ENDS[0] + 18.0,
                tick.label
            );
        }
        text + "</g>\n"
    }
}

/// As many columns as the longest label lets there be, at the size that text has on narrow screens.
fn columns(keys: &[Key]) -> usize {
    let longest = keys.iter().map(|key| key.label.chars().count()).max().unwrap_or(0);
    let width = KEY_INDENT + 10.0 * longest as f64;
    (((X_ENDS[1] - X_ENDS[0]) / width) as usize).clamp(1, 4)
}

/// Of the legend.
fn height(keys: &[Key]) -> f64 {
    keys.len().div_ceil(columns(keys)) as f64 * KEY_HEIGHT
}

/// The legend under the chart.
fn legend(keys: &[Key]) -> String {
    let mut legend = String::new();
    for (i, Key { look, label }) in keys.iter().enumerate() {
        let x = X_ENDS[0] + ((i % columns(keys)) as f64 * (X_ENDS[1] - X_ENDS[0]) / columns(keys) as f64).round();
        let y = HEIGHT + (i / columns(keys)) as f64 * KEY_HEIGHT;
        let _ = writeln!(
            legend,
            "<g class=\"{}\" transform=\"translate({x} {y})\">{}<text x=\"{KEY_INDENT}\" y=\"11\">{}</text></g>",
            look.classes(),
            look.sample(),
            escape(label)
        );
    }
    legend
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::axis::Scale;

    fn chart() -> Chart {
        let axis = |ends| Axis::fit([1.0, 2.0].into_iter(), Scale::Linear, ends);
        Chart {
            id: "c".into(),
            title: "a < b".into(),
            x_label: "x",
            y_label: "ms".into(),
            x: axis(X_ENDS),
            y: axis(Y_ENDS),
            marks: String::new(),
            has_cursor: false,
            keys: Vec::new(),
        }
    }

    #[test]
    fn every_chart_has_its_title_and_a_file_its_legend() {
        let run = Run { label: "<b>".into(), ..Default::default() };
        for svg in [chart().inline(), chart().file(&[run])] {
            assert!(svg.contains("a &lt; b</title>") && !svg.contains("<b>"), "{svg}");
        }
        let run = Run { label: "tin \"x\"".into(), ..Default::default() };
        assert!(chart().file(&[run]).contains("tin &quot;x&quot;"));
    }
}
