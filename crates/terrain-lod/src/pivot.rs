//! The tables of a suite: a few numbers of the summary, by the settings that the suite varies.
//!
//! ```toml
//! [[tables]]
//! title = "Draws by batching and k"
//! only = { metric = "error" }     # of the rows of the summary; all without it
//! rows = ["batching"]             # what stands at the left
//! columns = "k"                   # what stands at the top; without it, the values alone
//! values = ["draws_mean"]         # columns of the summary
//! ```
//!
//! Names are those of the summary's columns, of what its column `setting` lists (`k=3`), and `bench`.
//!
//! Beside the numbers may stand those of a paper, by row and column, and several series:
//!
//! ```toml
//! series = [{ name = "published", only = { selector = "algorithm1" } }, { name = "ours", only = { selector = "bounded" } }]
//! [tables.paper.8]                # of the row 8: keys are the columns, or the values where there are no columns
//! draws_mean = 1200               # then a ratio (ours / paper) follows each number
//! ```
//!
//! Or the first of a kind: `ratio_within = ["bench"]` adds a ratio to the first row of the same bench, and the name
//! `changed` says in which settings a row differs from that.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::layout::{self, Heading};
use crate::record::{Record, digits, distinct, named, number, validate_columns};

/// What the column `setting` lists, of all methods together.
const SETTINGS: [&str; 22] = [
    "selector",
    "patch",
    "max-spacing",
    "group",
    "blocks",
    "triangulator",
    "edge-policy",
    "schedule",
    "index-store",
    "jitter",
    "smoothing",
    "metric",
    "leg-px",
    "k",
    "layers",
    "batching",
    "geomorph",
    "window-mib",
    "loading",
    "step",
    "distance",
    "threads",
];

/// One table.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Pivot {
    pub title: String,
    /// What a reader must know; a line under the title.
    pub note: String,
    /// The rows of the summary that count: those with all of these values; of a list any will do.
    pub only: BTreeMap<String, Values>,
    pub rows: Vec<String>,
    pub columns: Option<String>,
    pub values: Vec<String>,
    /// Neighbouring columns; all rows that count are one series without.
    pub series: Vec<Series>,
    /// Published numbers, in the unit of the summary: by what stands at the left, then by column, or by value.
    pub paper: BTreeMap<String, BTreeMap<String, f64>>,
    /// Adds ratios to the first row that has the same values of these.
    pub ratio_within: Vec<String>,
}

/// What a name may be: one value, or any of several.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Values {
    One(String),
    Any(Vec<String>),
}

impl Values {
    pub fn contains(&self, value: &str) -> bool {
        match self {
            Self::One(one) => one == value,
            Self::Any(any) => any.iter().any(|one| one == value),
        }
    }
}

/// Rows of the summary that stand in columns of their own.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Series {
    pub name: String,
    pub only: BTreeMap<String, Values>,
}

/// What stands under one head: a value, for one of [`Pivot::columns`].
struct Column<'a> {
    top: String,
    value: &'a str,
}

/// A row of the summary that counts, and the first of its kind.
struct Line<'a> {
    record: &'a Record,
    first: &'a Record,
}

impl Pivot {
    /// Refuses what would be no table. A setting that no run of the suite has is none the less a name: the command line may
    /// choose other methods.
    pub fn validate(&self) -> Result<(), String> {
        let refuse = |reason: &str| format!("table {:?}: {reason}", self.title);
        validate_columns(&self.values).map_err(|reason| refuse(&reason))?;
        if self.rows.is_empty() || self.values.is_empty() {
            return Err(refuse("expected rows and values"));
        }
        let mut names = self.rows.iter().chain(&self.columns).chain(self.only.keys()).chain(&self.ratio_within);
        if let Some(name) = names.find(|name| *name != "changed" && !is_name(name)) {
            return Err(refuse(&format!("{name} is no column of summary.csv and no setting")));
        }
        if !self.paper.is_empty() && self.columns.is_some() && self.values.len() > 1 {
            return Err(refuse("expected columns or several values beside a paper's numbers, not both"));
        }
        if !self.paper.is_empty() && !self.ratio_within.is_empty() {
            return Err(refuse("expected paper or ratio_within, not both"));
        }
        Ok(())
    }

    /// The table as Markdown, with its title. Where several rows of the summary fall together, the first counts.
    pub fn markdown(&self, records: &[Record]) -> String {
        let lines = self.lines(records);
        let tops = distinct(lines.iter().map(|line| self.top(line)));
        let columns = tops.iter().flat_map(|top| self.values.iter().map(|value| Column { top: top.clone(), value }));
        let columns: Vec<Column> = columns.collect();
        let sides = distinct(lines.iter().map(|line| self.side(line)));
        let cells = |side: Vec<String>| {
            let numbers: Vec<String> = columns.iter().flat_map(|column| self.cells(&lines, &side, column)).collect();
            side.into_iter().chain(numbers).collect()
        };
        let rows: Vec<Vec<String>> = sides.into_iter().map(cells).collect();
        let note = if self.note.is_empty() { String::new() } else { format!("{}\n\n", self.note.trim()) };
        format!("### {}\n\n{note}{}", self.title, layout::table(&self.headings(&columns), &rows))
    }

    /// The rows that count.
    fn lines<'a>(&self, records: &'a [Record]) -> Vec<Line<'a>> {
        let counting: Vec<&Record> = records.iter().filter(|record| has_all(record, &self.only)).collect();
        let is_alike = |a: &Record, b: &Record| self.ratio_within.iter().all(|name| named(a, name) == named(b, name));
        let first = |record: &Record| *counting.iter().find(|other| is_alike(other, record)).expect("at least itself");
        counting.iter().map(|record| Line { record, first: first(record) }).collect()
    }

    fn side(&self, line: &Line) -> Vec<String> {
        self.rows.iter().map(|name| if name == "changed" { line.changed() } else { named(line.record, name) }).collect()
    }

    fn top(&self, line: &Line) -> String {
        self.columns.as_ref().map(|name| named(line.record, name)).unwrap_or_default()
    }

    /// The numbers of one row under one head: the paper's, then of each series its own and the ratio.
    fn cells(&self, lines: &[Line], side: &[String], column: &Column) -> Vec<String> {
        let key = if self.columns.is_some() { column.top.as_str() } else { column.value };
        let paper = self.paper.get(&side.join(", ")).and_then(|row| row.get(key)).copied();
        let mut cells = Vec::new();
        if !self.paper.is_empty() {
            cells.push(paper.map_or_else(String::new, digits));
        }
        for series in self.all_series() {
            let is_here = |line: &&Line| self.side(line) == side && self.top(line) == column.top;
            let found = lines.iter().filter(is_here).find(|line| has_all(line.record, &series.only));
            cells.push(found.map_or_else(String::new, |line| named(line.record, column.value)));
            if self.has_ratios() {
                let base = paper.or_else(|| number(found?.first, column.value));
                let ratio = found.and_then(|line| Some(number(line.record, column.value)? / base?));
                cells.push(ratio.filter(|ratio| ratio.is_finite()).map_or_else(String::new, digits));
            }
        }
        cells
    }

    fn has_ratios(&self) -> bool {
        !self.paper.is_empty() || !self.ratio_within.is_empty()
    }

    fn all_series(&self) -> Vec<Series> {
        if self.series.is_empty() { vec![Series::default()] } else { self.series.clone() }
    }

    fn headings(&self, columns: &[Column]) -> Vec<Heading> {
        let left = self.rows.iter().map(|name| Heading { text: name.replace('_', " "), right: false });
        let numbers = columns.iter().flat_map(|column| self.heads(column));
        left.chain(numbers.map(|text| Heading { text, right: true })).collect()
    }

    /// The heads of what [`Self::cells`] returns: the column stands in the first of them.
    fn heads(&self, Column { top, value }: &Column) -> Vec<String> {
        let mut prefix = match &self.columns {
            None => value.replace('_', " "),
            Some(name) if self.values.len() == 1 => format!("{} {top}", name.replace('_', " ")),
            Some(name) => format!("{} {top}: {}", name.replace('_', " "), value.replace('_', " ")),
        };
        let mut heads = Vec::new();
        let mut push = |text: &str| {
            let colon = if prefix.is_empty() || text.is_empty() { "" } else { ": " };
            heads.push(format!("{}{colon}{text}", std::mem::take(&mut prefix)));
        };
        if !self.paper.is_empty() {
            push("paper");
        }
        for series in self.all_series() {
            push(if series.name.is_empty() && !self.paper.is_empty() { "ours" } else { &series.name });
            if self.has_ratios() {
                push("ratio");
            }
        }
        heads
    }
}

impl Line<'_> {
    /// The settings that the first of its kind does not have.
    fn changed(&self) -> String {
        let setting = |record| [named(record, "method"), named(record, "setting")].join(" ");
        let (own, first) = (setting(self.record), setting(self.first));
        let differs = |word: &&str| !first.split(' ').any(|other| other == *word);
        let words: Vec<&str> = own.split(' ').filter(differs).collect();
        match words.is_empty() {
            // What the first has and this has not, such as geomorph or the threads, is a difference too.
            true if own != first => {
                format!("without {}", first.split(' ').filter(|w| !own.contains(w)).collect::<Vec<_>>().join(" "))
            }
            true => "default".into(),
            false => words.join(" "),
        }
    }
}

/// Whether a record may have it: a column of the summary, a setting of any method, or the bench.
pub fn is_name(name: &str) -> bool {
    name == "bench" || SETTINGS.contains(&name) || validate_columns([&name.to_owned()]).is_ok()
}

fn has_all(record: &Record, values: &BTreeMap<String, Values>) -> bool {
    values.iter().all(|(name, expected)| expected.contains(&named(record, name)))
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum;

    use super::*;
    use crate::methods::MethodName;
    use crate::record::record;
    use crate::suite::Suite;
    use crate::summary::SummaryRow;

    fn row(setting: &str, draws: f64) -> Record {
        let setting = setting.into();
        record("", &SummaryRow { method: "htp".into(), setting, draws_mean: Some(draws), ..Default::default() })
    }

    #[test]
    fn settings_become_rows_and_columns() {
        let rows = [
            row("metric=error k=2 batching=per-patch", 34_619.0),
            row("metric=error k=3 batching=per-patch", 30_763.25),
            row("metric=box k=3 batching=per-patch", 1.0),
            row("metric=error k=3 batching=instanced", 7.0),
        ];
        let pivot = Pivot {
            title: "Draws".into(),
            only: BTreeMap::from([("metric".into(), Values::One("error".into()))]),
            rows: vec!["batching".into()],
            columns: Some("k".into()),
            values: vec!["draws_mean".into()],
            ..Default::default()
        };
        let expected = "\
### Draws

| batching  |   k 2 |   k 3 |
| --------- | ----: | ----: |
| per-patch | 34619 | 30763 |
| instanced |       |     7 |
";
        assert_eq!(pivot.markdown(&rows), expected);
    }

    #[test]
    fn what_is_no_column_is_refused() {
        let pivot = Pivot { rows: vec!["k".into()], values: vec!["draw_mean".into()], ..Default::default() };
        assert_eq!(pivot.validate().unwrap_err(), "table \"\": draw_mean is no column of summary.csv");
        assert!(Pivot::default().validate().is_err());
    }

    /// Found by a review: a misspelt name was an empty column.
    #[test]
    fn a_misspelt_setting_was_an_empty_column() {
        let good = Pivot { rows: vec!["batching".into()], values: vec!["draws_mean".into()], ..Default::default() };
        let good = Pivot { columns: Some("k".into()), ..good };
        assert_eq!(good.validate(), Ok(()));
        let wrong = [
            Pivot { rows: vec!["k".into(), "batchin".into()], ..good.clone() },
            Pivot { columns: Some("batchin".into()), ..good.clone() },
            Pivot { only: BTreeMap::from([("batchin".into(), Values::One("instanced".into()))]), ..good.clone() },
        ];
        for pivot in wrong {
            let expected = "table \"\": batchin is no column of summary.csv and no setting";
            assert_eq!(pivot.validate().unwrap_err(), expected);
        }
    }

    #[test]
    fn every_word_of_a_setting_is_a_name_that_tables_know() {
        let all = Suite { methods: MethodName::value_variants().to_vec(), ..Suite::default() };
        let window = Suite { window_mib: vec![4], methods: vec![MethodName::HtpInstanced], ..Suite::default() };
        for run in [all, window].iter().flat_map(|suite| suite.runs().unwrap()) {
            for word in run.setting().split_ascii_whitespace() {
                let (name, _) = word.split_once('=').unwrap_or_else(|| panic!("{word} has no value"));
                assert!(SETTINGS.contains(&name), "{name}");
            }
        }
    }

    fn by_k(values: &[&str]) -> Pivot {
        let values = values.iter().map(|name| name.to_string()).collect();
        Pivot { title: "T".into(), rows: vec!["k".into()], values, ..Default::default() }
    }

    #[test]
    fn a_papers_numbers_stand_beside_each_series_with_ratios() {
        let rows = [row("k=2 batching=per-patch", 50.0), row("k=2 batching=instanced", 150.0), row("k=3", 7.0)];
        let series = |name: &str| Series {
            name: name.into(),
            only: BTreeMap::from([("batching".into(), Values::Any(vec![name.into()]))]),
        };
        let paper = BTreeMap::from([("2".into(), BTreeMap::from([("draws_mean".into(), 100.0)]))]);
        let pivot = Pivot { series: vec![series("per-patch"), series("instanced")], paper, ..by_k(&["draws_mean"]) };
        let expected = "\
### T

| k  | draws mean: paper | per-patch | ratio | instanced | ratio |
| -- | ----------------: | --------: | ----: | --------: | ----: |
| 2  |               100 |        50 |   0.5 |       150 |   1.5 |
| 3  |                   |           |       |           |       |
";
        assert_eq!(pivot.markdown(&rows), expected);
    }

    #[test]
    fn ratios_are_to_the_first_of_a_kind_and_changes_are_named() {
        let rows = [row("k=3 layers=3 threads=2", 10.0), row("k=4 layers=3 threads=2", 5.0), row("k=3 layers=3", 0.0)];
        let rows = rows.into_iter().chain([row("k=3 layers=3 threads=2", 9.0)]);
        let mut rows: Vec<Record> = rows.collect();
        rows[3].insert("bench".into(), "other".into());
        let names = ["bench", "changed"].map(String::from).to_vec();
        let pivot = Pivot { ratio_within: vec!["bench".into()], rows: names, ..by_k(&["draws_mean"]) };
        let text = pivot.markdown(&rows);
        let lines: Vec<&str> = text.lines().skip(4).collect();
        assert_eq!(
            lines,
            [
                "|       | default           |         10 |     1 |",
                "|       | k=4               |          5 |   0.5 |",
                "|       | without threads=2 |          0 |     0 |",
                "| other | default           |          9 |     1 |",
            ]
        );
    }

    #[test]
    fn a_papers_numbers_need_one_key_each() {
        let paper = BTreeMap::from([("2".into(), BTreeMap::new())]);
        let both = Pivot { columns: Some("k".into()), paper, ..by_k(&["draws_mean", "error_px_max"]) };
        assert!(both.validate().unwrap_err().contains("not both"));
    }
}
