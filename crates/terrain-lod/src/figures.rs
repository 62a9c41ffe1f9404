//! The figures of a suite: pictures and drawings beside its tables, in the folder `figures`, and `figures.csv`, which says
//! what each of them shows.

mod htp;
mod spec;
mod svg;
mod views;

use image::ImageFormat;
use serde::Serialize;
use serde_json::Value;
use terrain_dem::write_atomically;

use crate::attempt::attempt;
use crate::bench::Sitting;
use crate::benches::SUITE_FILE;
use crate::fault::Fault;
use crate::interrupt;
use crate::progress::Progress;
use crate::report;
use crate::results::Results;
use crate::suite::{Bench, NamedSuite, SuiteFile};

pub use spec::{Figure, Kind};

/// A row of `figures.csv`.
#[derive(Serialize)]
struct FigureRow<'a> {
    file: String,
    title: &'a str,
    caption: String,
    command: &'a str,
}

/// Refuses figures that cannot be made, and names that are taken.
pub fn validate(figures: &[Figure]) -> Result<(), String> {
    figures.iter().try_for_each(Figure::validate)?;
    let is_taken = |(i, figure): &(usize, &Figure)| figures[..*i].iter().any(|other| other.name == figure.name);
    match figures.iter().enumerate().find(is_taken) {
        Some((_, figure)) => Err(format!("figure {:?}: the name is taken; expected one of its own", figure.name)),
        None => Ok(()),
    }
}

/// Refuses figures of benches that the suite does not have.
pub fn refuse_benches(figures: &[Figure], known: &[&str]) -> Result<(), String> {
    for figure in figures {
        if let Some(name) = figure.bench.iter().find(|name| !known.contains(&name.as_str())) {
            let known =
                if known.is_empty() { "none, since the suite has no [[benches]]".into() } else { known.join(", ") };
            return Err(format!("figure {:?}: bench {name}; expected of {known}", figure.name));
        }
    }
    Ok(())
}

/// What became of the figures. The `Err` inside is of a figure: the others are made all the same.
pub type Made = Result<Result<(), Fault>, Fault>;

/// Makes the figures of a suite that are not there yet, and lists all that are.
pub fn make(file: &SuiteFile, sitting: &Sitting, results: &Results) -> Made {
    if file.figures.is_empty() {
        return Ok(Ok(()));
    }
    results.prepare("figures")?;
    let progress = Progress::new("figures", file.figures.len() as u64);
    let (command, mut rows, mut answer) = (begun_with(results)?, Vec::new(), Ok(()));
    for figure in &file.figures {
        interrupt::check()?;
        match attempt(|| made(figure, file, sitting, results))? {
            Ok(Some(caption)) => {
                rows.push(FigureRow { file: figure.file(), title: &figure.title, caption, command: &command })
            }
            Ok(None) => {}
            Err(fault) => {
                answer = answer.and(Err(Fault::new(fault.cause, format_args!("figure {}: {fault}", figure.name))))
            }
        }
        progress.step();
    }
    results.write_csv("figures.csv", &rows)?;
    Ok(answer)
}

/// The command that the folder was begun with: a later sitting's names the folder alone.
fn begun_with(results: &Results) -> Result<String, Fault> {
    let facts: Option<Value> = match results.read_json("machine.json")? {
        Some(facts) => Some(facts),
        None => results.read_json(SUITE_FILE)?,
    };
    Ok(report::command(&facts.unwrap_or_default(), ""))
}

/// Makes one figure unless it is there, and returns its caption; nothing where it is left out, which a note says.
fn made(figure: &Figure, file: &SuiteFile, sitting: &Sitting, results: &Results) -> Result<Option<String>, Fault> {
    let path = results.path(&figure.file());
    if figure.kind != Kind::Views {
        if !path.exists() {
            results.write_text(&figure.file(), &drawing(figure))?;
        }
        return Ok(Some(figure.caption.clone()));
    }
    let shown = match Shown::of(figure, file, sitting) {
        Ok(shown) => shown,
        Err(reason) => {
            eprintln!("note: figure {} is left out: {reason}", figure.name);
            return Ok(None);
        }
    };
    let bench = Bench::of(&file.name, shown.named, sitting.args)?;
    if let Some(panel) = figure.panels.iter().find(|panel| panel.run_of(&bench).is_none()) {
        eprintln!("note: figure {} is left out: no run matches '{}'", figure.name, panel.run);
        return Ok(None);
    }
    if !path.exists() {
        let picture = views::draw(figure, &bench, shown.gpu)?;
        let mut bytes = std::io::Cursor::new(Vec::new());
        picture.write_to(&mut bytes, ImageFormat::Png).map_err(|e| Fault::write(&path, e))?;
        write_atomically(&path, |file| file.write_all(bytes.get_ref())).map_err(|e| Fault::write(&path, e))?;
    }
    Ok(Some(caption(figure, &bench)))
}

/// What a picture needs beside its figure.
struct Shown<'a> {
    named: &'a NamedSuite,
    gpu: &'a terrain_renderer::Gpu,
}

impl<'a> Shown<'a> {
    fn of(figure: &Figure, file: &'a SuiteFile, sitting: &'a Sitting) -> Result<Self, String> {
        let gpu = sitting.gpu.as_ref().ok_or("without a GPU")?;
        if figure.panels.iter().any(|panel| panel.wireframe) && !gpu.facts().wireframe {
            return Err(format!("{} cannot draw wireframes", gpu.facts().name));
        }
        let named = bench_of(figure, file).ok_or_else(|| format!("of {} none is flown", figure.bench.join(", ")))?;
        Ok(Self { named, gpu })
    }
}

/// The first of the figure's benches that is flown.
fn bench_of<'a>(figure: &Figure, file: &'a SuiteFile) -> Option<&'a NamedSuite> {
    if figure.bench.is_empty() {
        return file.benches.first();
    }
    figure.bench.iter().find_map(|name| file.benches.iter().find(|bench| bench.name.as_ref() == Some(name)))
}

fn drawing(figure: &Figure) -> String {
    match figure.kind {
        Kind::HtpLayers => htp::layers_figure(figure),
        Kind::HtpBlocks => htp::blocks_figure(figure),
        Kind::HtpOrientations => htp::orientations_figure(figure),
        Kind::Views => unreachable!("views are drawn by the GPU"),
    }
}

/// The author's caption, and what was drawn of what.
fn caption(figure: &Figure, bench: &Bench) -> String {
    let heightmap = &bench.dem.heightmap;
    let dem = format!("DEM {}, {} x {} samples.", bench.dem.name, heightmap.columns(), heightmap.rows());
    let mut runs: Vec<String> = Vec::new();
    for panel in &figure.panels {
        let run = panel.run_of(bench).map(|run| run.title().split_whitespace().collect::<Vec<_>>().join(" "));
        runs.extend(run.filter(|run| !runs.contains(run)));
    }
    format!("{} {dem} Runs: {}.", figure.caption.trim(), runs.join("; ")).trim().to_owned()
}

/// What `--dry-run` says.
pub fn describe(file: &SuiteFile, sitting: &Sitting) -> String {
    let line = |figure: &Figure| {
        let left_out = match figure.kind {
            Kind::Views => Shown::of(figure, file, sitting).err(),
            _ => None,
        };
        let left_out = left_out.map_or_else(String::new, |reason| format!("  (left out: {reason})"));
        format!("Figure {}: {}{left_out}\n", figure.file(), figure.title)
    };
    file.figures.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(kind: Kind) -> Figure {
        Figure { name: "f".into(), kind, ..Default::default() }
    }

    /// A drawing of any k is whole: it has as many triangles as the hierarchy and the lists say.
    #[test]
    fn drawings_have_every_triangle_of_the_lists() {
        let triangles = |svg: &str| svg.matches("<polygon").count() as u32;
        for (k, layers) in [(2, 2), (3, 3), (4, 2)] {
            let of = |kind| drawing(&Figure { k: Some(k), layers: Some(layers), ..figure(kind) });
            // Of half a cell: patches and their triangles of each layer, and two coloured ones between layers.
            let patches: u32 = (0..layers).map(|coarser| (k * k).pow(coarser)).sum();
            assert_eq!(triangles(&of(Kind::HtpLayers)), patches * (1 + k * k) + 2 * (layers - 1), "k {k}");
            // Each block and its three neighbours: of a coarser one a single triangle.
            let blocks: u32 = (0..8_u32)
                .map(|mask| {
                    let coarser = mask.count_ones();
                    htp_lod::index_list(k, mask as u8).len() as u32 + coarser + (3 - coarser) * k * k
                })
                .sum();
            assert_eq!(triangles(&of(Kind::HtpBlocks)), blocks, "k {k}");
            assert_eq!(triangles(&of(Kind::HtpOrientations)), 8 * (1 + k * k), "four squares of two patches");
        }
    }

    #[test]
    fn what_is_no_figure_is_named() {
        let parse = |text: &str| toml::from_str::<Figure>(text).unwrap().validate().unwrap_err();
        for (text, expected) in [
            ("name = 'a/b'", "figure \"a/b\": its name is a file's"),
            ("name = 'a'", "figure \"a\": no panels"),
            ("name = 'a'\nkind = 'htp-layers'\nk = 1", "figure \"a\": k of 1"),
            ("name = 'a'\nkind = 'htp-blocks'\nlayers = 1", "figure \"a\": layers = 1"),
            ("name = 'a'\nzoom = 0.5\n[[panels]]", "figure \"a\": zoom"),
            ("name = 'a'\n[[panels]]\nrun = '('", "figure \"a\": run \"(\": "),
            (
                "name = 'a'\ncamera = { at = [0, 0], above_ground_share = 1, look_at = [1, 1], fov_y_deg = 200 }\n[[panels]]",
                "figure \"a\": camera:2:13: ",
            ),
        ] {
            let refused = parse(text);
            assert!(refused.starts_with(expected) && !refused.contains('\n'), "{refused}");
        }
    }
}
