//! `report`: one HTML file from what `bench` leaves.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

use crate::program::{read_rows, terrain_lod};

/// A folder with `results` of a small bench.
fn flown(arguments: &[&str]) -> TempDir {
    let place = tempfile::tempdir().unwrap();
    let bench = ["bench", "--no-gpu", "--suite", "smoke", "--dem", "synthetic:65x49:1", "--out", "results"];
    let output = terrain_lod(place.path(), &[&bench, arguments].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    place
}

fn report(place: &Path, arguments: &[&str]) -> String {
    let output = terrain_lod(place, &[&["report", "results"], arguments].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    fs::read_to_string(place.join("results/report.html")).unwrap()
}

/// The error of a report that fails, and its exit code.
fn refused(place: &Path, arguments: &[&str]) -> (String, Option<i32>) {
    let output = terrain_lod(place, &[&["report"], arguments].concat());
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(said.lines().count(), 1, "{said}");
    (said, output.status.code())
}

#[test]
fn the_same_folder_gives_the_same_bytes_with_every_run_and_no_link() {
    let place = flown(&[]);
    let page = report(place.path(), &[]);
    // The report of the first time lies in the folder now, and changes nothing.
    assert!(page == report(place.path(), &[]), "two reports differ");
    for row in read_rows(&place.path().join("results/summary.csv")) {
        assert!(page.contains(&row["setting"]), "{}", row["setting"]);
    }
    for entry in fs::read_dir(place.path().join("results/frames")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let stem = name.strip_suffix("-error.csv").or(name.strip_suffix("-speed.csv")).unwrap();
        assert!(page.contains(&format!("<td>{stem}</td>")), "{stem} belongs to no row");
    }
    assert!(!page.contains("http://") && !page.contains("https://") && !page.contains(" src="), "it opens offline");
    assert!(page.contains("Plan time and P99 error") && page.contains("plan time stands for frame time"));
    well_formed(&page);
}

#[test]
fn charts_become_files() {
    let place = flown(&["--methods", "tin", "--tolerance", "1"]);
    report(place.path(), &["--svg", "figures", "--no-pictures"]);
    let mut names: Vec<PathBuf> =
        fs::read_dir(place.path().join("figures")).unwrap().map(|e| e.unwrap().path()).collect();
    names.sort();
    assert!(names.len() >= 8, "{names:?}");
    for name in names {
        let svg = fs::read_to_string(&name).unwrap();
        assert!(svg.starts_with("<svg xmlns=") && svg.contains("<title>") && svg.contains("tin bounded"), "{name:?}");
        well_formed(&svg);
    }
}

#[test]
fn text_from_files_is_never_markup() {
    let place = flown(&["--methods", "rqt", "--tolerance", "1"]);
    let path = |name: &str| place.path().join("results").join(name);
    let evil = "<script>document.documentElement.dataset.evil = 1</script>";
    for name in ["machine.json", "summary.csv", "summary.md"] {
        let text = fs::read_to_string(path(name)).unwrap();
        fs::write(path(name), text.replace("synthetic:65x49:1", evil).replace("rqt", "<b>rqt</b>")).unwrap();
    }
    let page = report(place.path(), &[]);
    assert!(page.contains("&lt;script&gt;document") && page.contains("&lt;b&gt;rqt&lt;/b&gt;"));
    assert!(!page.contains("<script>document.") && !page.contains("<b>rqt"));
    well_formed(&page);
}

#[test]
fn what_went_wrong_is_said_first() {
    let place = flown(&["--methods", "rqt", "--tolerance", "1"]);
    let results = place.path().join("results");
    assert!(!report(place.path(), &[]).contains("class=\"bad\""));
    fs::write(results.join("INCOMPLETE"), "").unwrap();
    let summary = fs::read_to_string(results.join("summary.csv")).unwrap();
    let (head, row) = summary.split_once('\n').unwrap();
    let cracks = head.split(',').position(|name| name == "cracks").unwrap();
    // No cell before it holds a comma.
    let cells: Vec<&str> = row.split(',').enumerate().map(|(i, cell)| if i == cracks { "7" } else { cell }).collect();
    fs::write(results.join("summary.csv"), format!("{head}\n{}", cells.join(","))).unwrap();
    let page = report(place.path(), &[]);
    let before_the_facts = page.split("id=\"flown\"").next().unwrap();
    assert!(before_the_facts.contains("<p class=\"bad\"><strong>Incomplete.</strong>"));
    assert!(before_the_facts.contains("rqt has cracks.</strong> 7 in the error pass."));
}

#[test]
fn a_bench_that_was_interrupted_early_has_a_report() {
    let place = flown(&["--methods", "rqt,full-grid", "--tolerance", "1"]);
    let results = place.path().join("results");
    fs::write(results.join("INCOMPLETE"), "").unwrap();
    fs::remove_file(results.join("summary.csv")).unwrap();
    fs::remove_file(results.join("summary.md")).unwrap();
    fs::remove_file(results.join("frames/rqt-1px-speed.csv")).unwrap();
    let page = report(place.path(), &[]);
    assert!(page.contains("Incomplete.") && page.contains("rqt-1px") && page.contains("frame-triangles-title"));
    well_formed(&page);
}

#[test]
fn facts_and_frames_that_make_no_sense_are_no_panic() {
    let place = flown(&["--methods", "rqt", "--tolerance", "1"]);
    let results = place.path().join("results");
    fs::write(results.join("machine.json"), "{\"command\": 7, \"options\": [], \"load_average\": \"high\"}").unwrap();
    let frames = results.join("frames/rqt-1px-error.csv");
    fs::write(&frames, "frame,triangles,error_px_max\n4294967295,1e-300,0\n-7,1e300,-1\n,,\n").unwrap();
    well_formed(&report(place.path(), &[]));
    fs::write(&frames, "").unwrap();
    well_formed(&report(place.path(), &[]));
}

#[test]
fn what_is_no_results_folder_is_refused_in_a_line() {
    let place = flown(&["--methods", "rqt", "--tolerance", "1"]);
    let (said, code) = refused(place.path(), &["results/frames"]);
    assert!(said.contains("no results folder") && said.contains("machine.json") && code == Some(4), "{said}");
    let (said, code) = refused(place.path(), &["results", "--out", "nowhere/report.html"]);
    assert!(said.contains("nowhere/report.html") && code == Some(6), "{said}");
    assert_eq!(refused(place.path(), &[]).1, Some(2));
    let frames = place.path().join("results/frames/rqt-1px-error.csv");
    let text = fs::read_to_string(&frames).unwrap();
    fs::write(&frames, text + "12,torn").unwrap();
    let (said, code) = refused(place.path(), &["results"]);
    assert!(said.contains("rqt-1px-error.csv") && said.contains("line: 14") && code == Some(4), "{said}");
}

/// Two benches, a sweep in each, and curves over the flight of one.
const SUITE: &str = r#"
methods = ["tin", "decimated"]
step = [2, 4]
size_px = [160, 90]
frames = 6
repeats = 2
warm_up = 1

[[tables]]
title = "Triangles <by> bench"
rows = ["bench", "method"]
values = ["triangles_mean"]

[[equal_error]]
title = "At equal error"
errors_px = [2, 20]
measures = ["error_px_max"]
costs = ["triangles_mean", "plan_ms_p50"]

[[flight_curves]]
file = "figure-6"
title = "Share of triangulation"
benches = ["huge", "large"]
measure = "triangulation-share"
curves = "tolerance_px"
series = [{ name = "one's own", only = { selector = "bounded" } }]

[[flight_curves]]
file = "figure-7"
title = "Triangles a second"
benches = ["large"]
measure = "triangles-per-second"
curves = "tolerance_px"

[[benches]]
name = "small"
dem = "synthetic:33x33:1"
methods = ["rqt", "decimated"]
tolerance_px = [2, 8]

[[benches]]
name = "large"
dem = "synthetic:97x97:1"
tolerance_px = [0.5, 1, 2, 4]

[[benches]]
name = "huge"
dem = "synthetic:129x129:1"
optional = true
"#;

/// A folder with `results` of the suite.
fn flown_suite() -> TempDir {
    let place = tempfile::tempdir().unwrap();
    fs::write(place.path().join("two.toml"), SUITE).unwrap();
    let output = terrain_lod(place.path(), &["bench", "--no-gpu", "--suite", "two.toml", "--out", "results"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    place
}

#[test]
fn a_suite_has_one_page_with_every_bench() {
    let place = flown_suite();
    let page = report(place.path(), &["--svg", "figures"]);
    assert!(page == report(place.path(), &[]), "two reports differ");
    well_formed(&page);
    assert!(!page.contains("http://") && !page.contains("https://") && !page.contains(" src="), "it opens offline");
    assert!(page.contains("<h1>two: 2 benches</h1>") && page.contains("Triangles &lt;by&gt; bench"));
    for bench in ["small", "large"] {
        assert!(page.contains(&format!("<section id=\"{bench}-bench\">")), "{bench}");
        let command = format!("cargo xtask bench --no-gpu --suite two.toml --out results --benches {bench}");
        assert!(page.contains(&command), "{command}");
        for row in read_rows(&place.path().join("results").join(bench).join("summary.csv")) {
            assert!(page.contains(&row["setting"]), "{}", row["setting"]);
        }
    }
    assert_eq!(page.matches("No frame times.").count(), 1, "what holds for all is said once");
    let mut ids: Vec<&str> = page.split(" id=\"").skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
    let count = ids.len();
    ids.sort();
    ids.dedup();
    assert_eq!(ids.len(), count, "two elements of one id");
    let names = ["equal-error-triangles-by-largest-error", "figure-6-one-s-own", "figure-7", "large-frame-plan-time"];
    for name in names {
        let svg = fs::read_to_string(place.path().join(format!("figures/{name}.svg"))).unwrap();
        well_formed(&svg);
        assert!(page.contains(&format!("id=\"{name}-title\"")), "{name}");
    }
    let figure = fs::read_to_string(place.path().join("figures/figure-7.svg")).unwrap();
    for curve in ["0.5 px", "1 px", "2 px", "4 px"] {
        assert!(figure.contains(&format!(">{curve}</text>")), "{curve}");
    }
}

#[test]
fn a_suite_that_was_interrupted_has_a_report() {
    let place = flown_suite();
    let results = place.path().join("results");
    fs::write(results.join("INCOMPLETE"), "").unwrap();
    fs::remove_dir_all(results.join("large")).unwrap();
    for name in ["summary.csv", "tables.md", "equal-error.csv"] {
        fs::remove_file(results.join(name)).unwrap();
    }
    let page = report(place.path(), &[]);
    well_formed(&page);
    assert!(
        page.contains("<strong>Incomplete.</strong> The suite")
            && page.contains("<dt>Not flown yet</dt><dd>large</dd>")
    );
    fs::remove_file(results.join("INCOMPLETE")).unwrap();
    let (said, code) = refused(place.path(), &["results"]);
    assert!(said.contains("large") && said.contains("no results folder") && code == Some(4), "{said}");
}

#[test]
fn figures_are_shown_with_what_made_them() {
    let place = flown(&["--methods", "rqt", "--tolerance", "1"]);
    let results = place.path().join("results");
    let png = fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/pixel.png")).unwrap();
    fs::create_dir_all(results.join("figures")).unwrap();
    fs::write(results.join("figures/a.png"), &png).unwrap();
    fs::write(results.join("figures/b.svg"), "<svg xmlns=\"http://www.w3.org/2000/svg\"/>").unwrap();
    let rows = "file,title,caption,command\nfigures/a.png,Figure <1>,Wire,\"make a, b\"\nfigures/b.svg,Figure 2,,\n";
    fs::write(results.join("figures.csv"), rows).unwrap();
    fs::write(results.join("shots/rqt-1px-frame0005-error.png"), &png).unwrap();
    fs::write(results.join("pictures.csv"), "run,frame,mssim\nrqt-1px,5,0.987\n").unwrap();
    let page = report(place.path(), &[]);
    well_formed(&page);
    for expected in [
        "Figure &lt;1&gt;",
        "make a, b",
        "data:image/svg+xml;base64,",
        "Frame 5, error",
        "<td class=\"number\">0.987</td>",
    ] {
        assert!(page.contains(expected), "{expected}");
    }
    assert_eq!(page.matches("data:image/png;base64,").count(), 2);
    fs::write(results.join("figures.csv"), "file,title,caption,command\n../a.png,x,,\n").unwrap();
    let (said, code) = refused(place.path(), &["results"]);
    assert!(said.contains("figures.csv") && said.contains("../a.png") && code == Some(4), "{said}");
}

#[test]
fn the_script_runs_in_chromium() {
    let place = flown(&[]);
    // A picture, for the script's other half. What it shows does not matter.
    let png = fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/pixel.png")).unwrap();
    for look in ["shaded", "wireframe"] {
        for stem in ["full-grid", "tin-bounded-2px-patch16-grid-blocking"] {
            fs::write(place.path().join(format!("results/shots/{stem}-frame0001-{look}.png")), &png).unwrap();
        }
    }
    report(place.path(), &[]);
    let Some(dom) = dom(place.path()) else { return };
    assert!(dom.contains("A: tin bounded 2 px") && dom.contains("B: full-grid"), "the pictures are paired");
    assert!(dom.contains("class=\"cursor\" d=\"M"), "the cursor stands in the charts");
}

#[test]
fn the_script_runs_over_a_suite_in_chromium() {
    let place = flown_suite();
    report(place.path(), &[]);
    let Some(dom) = dom(place.path()) else { return };
    let curves = dom.matches(" data-ends=").count();
    assert!(
        curves > 8 && dom.matches("class=\"cursor\" d=\"M").count() == curves,
        "a cursor in each chart of each bench"
    );
}

/// The page as Chromium has it after its script; `None` where there is no Chromium.
fn dom(place: &Path) -> Option<String> {
    let Some(chromium) = chromium() else {
        eprintln!("skipped: no chromium, chromium-browser or google-chrome on this machine");
        return None;
    };
    let output = Command::new(chromium)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--dump-dom"])
        .arg(format!("--user-data-dir={}", place.join("profile").display()))
        .arg(format!("file://{}", place.join("results/report.html").display()))
        .output()
        .unwrap();
    let (dom, said) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(dom.contains("data-script=\"ready\"") && !dom.contains("data-error"), "{said}");
    assert!(!said.contains("CONSOLE"), "{said}");
    Some(dom.into_owned())
}

fn chromium() -> Option<PathBuf> {
    let folders = std::env::var_os("PATH")?;
    let folders: Vec<PathBuf> = std::env::split_paths(&folders).collect();
    let names = ["chromium", "chromium-browser", "google-chrome"];
    names.iter().find_map(|name| folders.iter().map(|folder| folder.join(name)).find(|path| path.is_file()))
}

/// Every element is closed in order. Enough for what we write: no comments, and `>` in attributes is escaped.
fn well_formed(page: &str) {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = page;
    while let Some(start) = rest.find('<') {
        rest = &rest[start + 1..];
        let end = rest.find('>').expect("a tag ends");
        let (tag, after) = (&rest[..end], &rest[end + 1..]);
        assert!(!tag.contains('<'), "<{tag}>");
        let name = tag.trim_start_matches('/').split([' ', '\n', '/']).next().unwrap();
        rest = after;
        match tag {
            _ if tag.starts_with('/') => {
                assert_eq!(open.pop(), Some(name), "</{name}> before {}", &rest[..80.min(rest.len())])
            }
            _ if tag.ends_with('/') || ["!DOCTYPE", "meta", "img", "input"].contains(&name) => {}
            _ => open.push(name),
        }
        // Their content is no markup.
        if ["script", "style"].contains(&name) && !tag.starts_with('/') {
            rest = &rest[rest.find(&format!("</{name}")).expect("an end")..];
        }
    }
    assert!(open.is_empty(), "{open:?}");
}
