//! The runs of a result folder: which rows of the summary and which files belong to each, and a short name for it.

use crate::fault::Fault;
use crate::report::folder::Folder;
use crate::report::look::Look;
use crate::report::sheet::Sheet;

/// A run.
#[derive(Default)]
pub struct Run {
    pub look: Look,
    /// Short, and no other run's.
    pub label: String,
    /// The name that its files share; `None` where it left none.
    pub stem: Option<String>,
    /// Its rows of the summary. One that takes no tolerance has a row for each, which differ in nothing that is drawn.
    pub rows: Vec<usize>,
}

impl Run {
    /// A number of its summary.
    pub fn number(&self, summary: &Sheet, column: &str) -> Result<Option<f64>, Fault> {
        self.rows.first().map_or(Ok(None), |row| summary.number(*row, column))
    }
}

/// The runs in the order of the summary, then those whose files alone are there. They are numbered from `first`.
pub fn of(folder: &Folder, first: usize) -> Vec<Run> {
    let stems: Vec<&str> = folder.frames.keys().map(String::as_str).collect();
    let mut runs: Vec<Run> = Vec::new();
    for row in 0..folder.summary.len() {
        let stem = stem_of(&folder.summary, row, &stems).map(str::to_owned);
        match runs.iter_mut().find(|run| stem.is_some() && run.stem == stem) {
            Some(run) => run.rows.push(row),
            None => runs.push(Run { stem, rows: vec![row], ..Default::default() }),
        }
    }
    let is_new = |stem: &&&str| !runs.iter().any(|run| run.stem.as_deref() == Some(**stem));
    let others: Vec<String> = stems.iter().filter(is_new).map(|stem| stem.to_string()).collect();
    runs.extend(others.into_iter().map(|stem| Run { label: stem.clone(), stem: Some(stem), ..Default::default() }));
    label(&folder.summary, &mut runs);
    dress(&folder.summary, &mut runs, first);
    runs
}

/// Gives the runs their looks: a family is of one method and setting.
fn dress(summary: &Sheet, runs: &mut [Run], first: usize) {
    let mut families: Vec<(Option<[&str; 2]>, usize)> = Vec::new();
    for (i, run) in runs.iter_mut().enumerate() {
        let kind = run.rows.first().map(|row| [summary.text(*row, "method"), summary.text(*row, "setting")]);
        let known = families.iter().position(|(other, _)| kind.is_some() && *other == kind);
        let family = known.unwrap_or(families.len());
        if known.is_none() {
            families.push((kind, 0));
        }
        run.look = Look { run: first + i, family, rank: families[family].1 };
        families[family].1 += 1;
    }
}

/// The files of a row: those that its column `run` names or, in folders without that column, the one name of which every
/// word is the method's or one of the row's settings.
fn stem_of<'a>(summary: &Sheet, row: usize, stems: &[&'a str]) -> Option<&'a str> {
    let run = summary.text(row, "run");
    if !run.is_empty() {
        return stems.iter().copied().find(|stem| *stem == run);
    }
    let words = words_of(summary, row);
    // The more of a name the method explains the better: "htp-instanced" begins with "htp" too.
    let methods = (0..summary.len()).map(|row| summary.text(row, "method"));
    let longest = |stem: &str| methods.clone().filter(|method| rest(stem, method).is_some()).max_by_key(|m| m.len());
    let explains = |stem: &&'a str| {
        let method = summary.text(row, "method");
        let rest = rest(stem, method).filter(|_| longest(stem) == Some(method));
        rest.is_some_and(|rest| rest.split('-').all(|word| word.is_empty() || words.iter().any(|known| known == word)))
    };
    stems.iter().copied().find(explains)
}

/// What follows the method's name in the name of a file.
fn rest<'a>(stem: &'a str, method: &str) -> Option<&'a str> {
    stem.strip_prefix(method).filter(|rest| rest.is_empty() || rest.starts_with('-'))
}

/// The words of which a file's name can be made: `bounded`, `patch32`, `k3`, `l4`, `leg8px`, `1px`.
fn words_of(summary: &Sheet, row: usize) -> Vec<String> {
    let tolerance = summary.text(row, "tolerance_px");
    let mut words = vec![format!("{}px", tolerance.strip_suffix(".0").unwrap_or(tolerance))];
    for (name, value) in settings(summary.text(row, "setting")) {
        words.extend(value.split('-').map(str::to_owned));
        let first: String = name.chars().take(1).collect();
        words.extend([format!("{name}{value}"), format!("{first}{value}")]);
        words.extend(name.strip_suffix("-px").map(|name| format!("{name}{value}px")));
    }
    words
}

/// `patch=32 smoothing=true` as names and values; a word alone, as older folders have it, is its own value.
pub fn settings(setting: &str) -> impl Iterator<Item = (&str, &str)> {
    setting.split_ascii_whitespace().map(|word| word.split_once('=').unwrap_or((word, word)))
}

/// Labels the runs by method and by as few settings as tell the method's runs apart.
fn label(summary: &Sheet, runs: &mut [Run]) {
    let known: Vec<Known> = runs.iter().map(|run| names_of(summary, run)).collect();
    let methods: Vec<&str> =
        runs.iter().map(|run| run.rows.first().map_or("", |r| summary.text(*r, "method"))).collect();
    let labels = labels(&methods, &known);
    for (run, label) in runs.iter_mut().zip(labels).filter(|(run, _)| !run.rows.is_empty()) {
        run.label = label;
    }
}

/// Settings by name and value.
pub type Known = Vec<(String, String)>;

/// A method each, and as few settings as tell the method's own apart.
pub fn labels(methods: &[&str], known: &[Known]) -> Vec<String> {
    let label = |i: usize| {
        let peers: Vec<&Known> = (0..known.len()).filter(|j| methods[*j] == methods[i]).map(|j| &known[j]).collect();
        let words = telling_names(&peers).into_iter().filter_map(|name| word(&known[i], &name));
        [methods[i].to_owned()].into_iter().chain(words).collect::<Vec<_>>().join(" ")
    };
    (0..known.len()).map(label).collect()
}

/// Settings of a run, the tolerance last.
fn names_of(summary: &Sheet, run: &Run) -> Known {
    let Some(row) = run.rows.first() else { return Vec::new() };
    let settings = settings(summary.text(*row, "setting")).map(|(name, value)| (name.to_owned(), value.to_owned()));
    let tolerance = summary.text(*row, "tolerance_px");
    let tolerance = tolerance.strip_suffix(".0").unwrap_or(tolerance).to_owned();
    settings.chain([("tolerance".to_owned(), tolerance)]).collect()
}

/// The names that, one after the other, tell more of the runs apart.
fn telling_names(peers: &[&Known]) -> Vec<String> {
    let mut chosen: Vec<String> = Vec::new();
    let apart = |names: &[String]| {
        let mut all: Vec<Vec<Option<&str>>> =
            peers.iter().map(|known| names.iter().map(|name| value(known, name)).collect()).collect();
        all.sort();
        all.dedup();
        all.len()
    };
    for (name, _) in peers.iter().flat_map(|known| known.iter()) {
        let more = [&chosen[..], std::slice::from_ref(name)].concat();
        if apart(&more) > apart(&chosen) {
            chosen = more;
        }
    }
    chosen
}

fn value<'a>(known: &'a [(String, String)], name: &str) -> Option<&'a str> {
    known.iter().find(|(other, _)| other == name).map(|(_, value)| value.as_str())
}

/// A setting as short as it can be understood: names speak for themselves, numbers do not.
fn word(known: &[(String, String)], name: &str) -> Option<String> {
    let value = value(known, name)?;
    let speaks = value.parse::<f64>().is_err() && !["true", "false"].contains(&value);
    Some(match name {
        "tolerance" => format!("{value} px"),
        _ if speaks => value.to_owned(),
        _ => format!("{name}={value}"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SUMMARY: &[u8] = b"method,setting,tolerance_px\n\
        tin,selector=bounded patch=32 group=2 triangulator=grid schedule=live,1.0\n\
        tin,selector=algorithm1 patch=32 max-spacing=16 triangulator=grid schedule=live,1.0\n\
        htp,metric=error k=3 layers=4 batching=instanced,0.5\n\
        htp-instanced,metric=error k=3 layers=4 batching=instanced,0.5\n\
        htp,metric=box leg-px=8 k=3 layers=3 batching=per-patch,0.5\n\
        full-grid,step=1,0.5\n\
        full-grid,step=1,2.0\n\
        rqt,,0.5\n";

    fn runs() -> Vec<Run> {
        let files = [
            "full-grid",
            "htp-box-leg8px-k3-l3-per-patch",
            "htp-error-0.5px-k3-l4-instanced",
            "htp-instanced-error-0.5px-k3-l4-instanced",
            "tin-algorithm1-1px-patch32-grid-live",
            "tin-bounded-1px-patch32-grid-live",
            "zzz-of-a-later-version",
        ];
        let folder = Folder {
            path: Default::default(),
            name: String::new(),
            machine: serde_json::json!({}),
            is_incomplete: false,
            summary: Sheet::parse("summary.csv", SUMMARY).unwrap(),
            summary_md: String::new(),
            popping: None,
            frames: files.iter().map(|stem| (stem.to_string(), Default::default())).collect(),
            shots: Vec::new(),
            pictures: None,
        };
        of(&folder, 0)
    }

    #[test]
    fn rows_find_their_files() {
        let found: Vec<(Option<String>, Vec<usize>)> = runs().into_iter().map(|run| (run.stem, run.rows)).collect();
        let stem = |stem: &str| Some(stem.to_owned());
        let expected = [
            (stem("tin-bounded-1px-patch32-grid-live"), vec![0]),
            (stem("tin-algorithm1-1px-patch32-grid-live"), vec![1]),
            (stem("htp-error-0.5px-k3-l4-instanced"), vec![2]),
            (stem("htp-instanced-error-0.5px-k3-l4-instanced"), vec![3]),
            (stem("htp-box-leg8px-k3-l3-per-patch"), vec![4]),
            (stem("full-grid"), vec![5, 6]),
            (None, vec![7]),
            (stem("zzz-of-a-later-version"), vec![]),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn labels_say_what_differs_and_no_more() {
        let labels: Vec<String> = runs().into_iter().map(|run| run.label).collect();
        let expected = [
            "tin bounded",
            "tin algorithm1",
            "htp error",
            "htp-instanced",
            "htp box",
            "full-grid",
            "rqt",
            "zzz-of-a-later-version",
        ];
        assert_eq!(labels, expected);
    }

    #[test]
    fn runs_that_differ_in_tolerance_alone_are_a_family() {
        let csv = b"method,setting,tolerance_px\ntin,a=1,1\nrqt,,1\ntin,a=1,2\ntin,a=2,4\n";
        let mut runs: Vec<Run> =
            (0..5).map(|i| Run { rows: (i < 4).then_some(i).into_iter().collect(), ..Default::default() }).collect();
        dress(&Sheet::parse("", csv).unwrap(), &mut runs, 7);
        let looks: Vec<_> = runs.iter().map(|run| (run.look.run, run.look.family, run.look.rank)).collect();
        assert_eq!(looks, [(7, 0, 0), (8, 1, 0), (9, 0, 1), (10, 2, 0), (11, 3, 0)]);
    }

    #[test]
    fn a_column_that_names_the_files_is_believed() {
        let summary = Sheet::parse("", b"method,setting,tolerance_px,run\ntin,,1.0,tin-b\n").unwrap();
        assert_eq!(stem_of(&summary, 0, &["tin", "tin-b"]), Some("tin-b"));
    }
}
