//! The page: a header and its sections, style and script included. Of a suite each bench is a section with sections of its own.

use std::fmt::Write;

use crate::fault::Fault;
use crate::report::album::Album;
use crate::report::bench_page::BenchPage;
use crate::report::chart::{CHART_CSS, Chart};
use crate::report::flights::Flights;
use crate::report::html::escape;
use crate::report::runs::Run;
use crate::report::warnings::{self, Warning};
use crate::report::whole::Suite;
use crate::report::{Report, facts, figures, headline, markdown, pictures, tables};

const PAGE_CSS: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("script.js");
/// The definitions have one place; the report quotes it.
const METHODOLOGY: &str = include_str!("../../../../METHODOLOGY.md");

/// A section, as the table of contents and the page show it.
struct Section {
    id: String,
    title: String,
    /// How to read it.
    lead: String,
    /// What made it.
    command: String,
    /// HTML.
    body: String,
    /// HTML between it and what was before.
    before: String,
}

impl Section {
    /// `lead` and `body` are HTML.
    fn new(id: impl Into<String>, title: &str, command: &str, lead: impl Into<String>, body: String) -> Self {
        let (id, title, command) = (id.into(), escape(title), command.into());
        Self { id, title, lead: lead.into(), command, body, before: String::new() }
    }

    fn html(&self, level: usize, number: &str) -> String {
        let Self { id, title, lead, command, body, before } = self;
        let lead = if lead.is_empty() { String::new() } else { format!("<p class=\"lead\">{lead}</p>\n") };
        format!(
            "{before}<section id=\"{id}\">\n<h{level}>{number}{title}</h{level}>\n{lead}<p class=\"command\"><code>{}</code></p>\n\
             {body}</section>\n",
            escape(command)
        )
    }
}

pub fn html(report: &Report, with_pictures: bool) -> Result<String, Fault> {
    let title = escape(&title(report));
    let sections = sections(report, &mut Album::new(with_pictures))?;
    let version = match &report.whole.suite {
        Some(_) => report.whole.fact("version"),
        None => report.parts[0].folder.fact("version"),
    };
    let mut text = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>terrain-lod: {title}</title>\n<style>\n{CHART_CSS}{PAGE_CSS}{}</style>\n</head>\n<body>\n\
         <header>\n<p class=\"kicker\">terrain-lod {}</p>\n<h1>{title}</h1>\n{}",
        hiding_rules(report),
        escape(&version),
        all_warnings(report)?
    );
    text += "<nav aria-label=\"Sections\"><ol>";
    for Section { id, title, .. } in &sections {
        let _ = write!(text, "<li><a href=\"#{id}\">{title}</a></li>");
    }
    text += "</ol></nav>\n</header>\n<main>\n";
    for (i, section) in sections.iter().enumerate() {
        text += &section.html(2, &format!("{}. ", i + 1));
    }
    let values: Vec<&str> = report.parts.iter().map(|part| part.curves.values.as_str()).collect();
    let _ = write!(
        text,
        "</main>\n<footer><p>Made by <code>cargo xtask report DIR</code> from the result folder alone.</p></footer>\n\
         <script type=\"application/json\" id=\"curve-values\">[{}]</script>\n<script>\n{SCRIPT}</script>\n</body>\n</html>\n",
        values.join(",\n")
    );
    Ok(text)
}

fn title(report: &Report) -> String {
    match &report.whole.suite {
        Some(_) => format!("{}: {} benches", report.whole.fact("suite"), report.parts.len()),
        None => format!("{} on {}", report.parts[0].folder.fact("suite"), report.parts[0].folder.fact("dem")),
    }
}

fn all_warnings(report: &Report) -> Result<String, Fault> {
    let mut all = warnings::warnings(&report.parts)?;
    if report.whole.suite.as_ref().is_some_and(|suite| suite.is_incomplete) {
        let body = "The suite has not finished. What follows is what it had written: do not trust it.";
        all.insert(0, Warning::bad("Incomplete.", body));
    }
    Ok(all.iter().map(Warning::html).collect())
}

fn sections(report: &Report, album: &mut Album) -> Result<Vec<Section>, Fault> {
    let command = match &report.whole.suite {
        Some(suite) => facts::command(&suite.facts, ""),
        None => facts::command(&report.parts[0].folder.machine, ""),
    };
    let mut of_all = Vec::new();
    if let Some(families) = &report.families {
        let body = legend(&families.runs) + &charts(&families.charts);
        of_all.push(Section::new("equal-error", "Costs at equal measured error", &command, EQUAL_ERROR, body));
    }
    if !report.flights.is_empty() || !report.whole.figures.is_empty() {
        let body = flights(report) + &figures::html(&report.whole.figures, album)?;
        of_all.push(Section::new("figures", "Figures", &command, FIGURES, body));
    }
    let mut definitions = match &report.whole.suite {
        None => of_bench(&report.parts[0], &command, album, Some(of_all))?,
        Some(suite) => of_suite(report, suite, &command, of_all, album)?,
    };
    let methodology = markdown::html(&markdown::read(METHODOLOGY), 3);
    let title = "Definitions of all columns, and how each number is made (<code>METHODOLOGY.md</code>)";
    definitions.last_mut().expect("the facts are the last section").body += &folded(title, &methodology);
    Ok(definitions)
}

/// Of a suite: what is said of all benches together, and then each by itself.
fn of_suite(
    report: &Report,
    suite: &Suite,
    command: &str,
    of_all: Vec<Section>,
    album: &mut Album,
) -> Result<Vec<Section>, Fault> {
    let flown = facts::flown_by_suite(&report.whole, suite, &report.parts);
    let mut sections = vec![Section::new("flown", "What was flown", command, FLOWN_BY_SUITE, flown)];
    let tables = match suite.tables_md.is_empty() {
        true => "<p>This folder has no <code>tables.md</code>: no bench has come so far.</p>\n".into(),
        false => markdown::html(&markdown::read(&suite.tables_md), 3),
    };
    sections.push(Section::new("tables", "Tables over all benches", command, TABLES_OF_SUITE, tables));
    sections.extend(of_all);
    for part in &report.parts {
        let own = facts::command(&part.folder.machine, &part.folder.name);
        let body: String = of_bench(part, &own, album, None)?.iter().map(|section| section.html(3, "")).collect();
        let title = format!("Bench {}", part.folder.name);
        sections.push(Section::new(part.folder.id("bench"), &title, &own, "", body));
    }
    let facts = folded("Facts of the suite (<code>suite.json</code>)", &facts::of_json(&suite.facts));
    sections.push(Section::new("facts", "The suite, definitions", command, FACTS, facts));
    Ok(sections)
}

/// Of one bench; `of_all` comes before what the runs' legend is for.
fn of_bench(
    part: &BenchPage,
    command: &str,
    album: &mut Album,
    of_all: Option<Vec<Section>>,
) -> Result<Vec<Section>, Fault> {
    let folder = &part.folder;
    let has_frame_times = headline::has_frame_times(folder)?;
    let section = |id: &str, title, lead: &str, body| Section::new(folder.id(id), title, command, lead, body);
    let mut sections = vec![section("flown", "What was flown", FLOWN, facts::flown(folder))];
    sections.extend(of_all.into_iter().flatten());
    let mut headline =
        section("headline", "Cost and measured error", &headline_lead(has_frame_times), charts(&part.headline));
    // The legend stays in sight from here on.
    headline.before = legend(&part.runs);
    sections.push(headline);
    sections.extend([
        section("summary", "Tables", SUMMARY, tables::html(part)?),
        section("curves", "Frame by frame", &curves_lead(part), charts(&part.curves.charts)),
        section("distributions", "Distributions", DISTRIBUTIONS, charts(&part.distributions)),
        section("pictures", "Pictures", PICTURES, pictures::html(part, album)?),
        section("facts", "Machine, settings, definitions", FACTS, of_machine(part)),
    ]);
    Ok(sections)
}

const FLOWN: &str = "All runs flew the same frames over the same elevation data. Errors and counts of the error pass are the same on every machine; times are this one's.";
const FLOWN_BY_SUITE: &str = "The runs of one bench flew the same frames over the same elevation data. Benches were flown one after \
    the other, so compare times within a bench.";
const TABLES_OF_SUITE: &str = "Made from the rows of all benches (<code>summary.csv</code>).";
const EQUAL_ERROR: &str = "Settings promise different things; the error on the screen does not. A curve is one family, with the \
    setting swept: further down and left is better. Marks are runs, faint ones are beaten by another of their family in error and \
    triangles, and rings are the numbers of <code>equal-error.csv</code>. Both axes are logarithmic.";
const FIGURES: &str = "The papers' figures, made from this bench.";
const SUMMARY: &str = "A row for each run and tolerance. What was not measured is empty. An interval holds the median with \
    95 % confidence, over the repeats.";
const DISTRIBUTIONS: &str = "How many percent of the frames, of all repeats together, took at most a time: a line further \
    left is faster, and one that leans right at its top has slow frames.";
const PICTURES: &str = "The same camera for every run. Wireframes show where a method spends its triangles.";
const FACTS: &str = "What it takes to repeat the bench, and what each column means.";

fn headline_lead(has_frame_times: bool) -> String {
    let time = match has_frame_times {
        true => "",
        false => " Nothing was timed on a GPU, so <strong>plan time stands for frame time</strong>.",
    };
    format!(
        "A mark a run, at the error that was measured and not at the tolerance that was asked for: further down and left is \
         better. Both axes are logarithmic, with a place for 0. A thin line joins one method at several tolerances.{time}"
    )
}

fn curves_lead(part: &BenchPage) -> String {
    let mut text = String::from(
        "One number a frame, without warm-up. Move over a chart, or use the arrow keys in it: all charts show all runs at that frame.",
    );
    if part.curves.width > 1 {
        let _ = write!(text, " Each point is the largest of {} frames.", part.curves.width);
    }
    if !part.curves.absent.is_empty() {
        let _ = write!(text, " Not measured: {}.", part.curves.absent.join("; ").to_lowercase().replace("p99", "P99"));
    }
    text
}

/// Rules by which the legends' boxes hide a run without a script.
fn hiding_rules(report: &Report) -> String {
    let of_families = report.families.iter().flat_map(|families| &families.runs);
    let runs = report.parts.iter().flat_map(|part| &part.runs).chain(of_families).map(|run| run.look.run);
    runs.map(|run| format!("body:has(#run{run}:not(:checked)) .r{run}{{display:none}}\n")).collect()
}

fn legend(runs: &[Run]) -> String {
    // Many labels are easier to find in columns, few to read in a line.
    let class = if runs.len() > 8 { "keys many" } else { "keys" };
    let mut text = format!("<details class=\"legend\" open><summary>Runs</summary>\n<div class=\"{class}\">\n");
    for run in runs {
        let (i, label) = (run.look.run, escape(&run.label));
        let _ = writeln!(
            text,
            "<label><input type=\"checkbox\" id=\"run{i}\" checked autocomplete=\"off\">{}<span>{label}</span></label>",
            run.look.swatch(&run.label)
        );
    }
    text + "</div></details>\n"
}

fn charts(charts: &[Chart]) -> String {
    if charts.is_empty() {
        return "<p>Nothing of this was measured.</p>\n".into();
    }
    let charts: String =
        charts.iter().map(|chart| format!("<figure class=\"plot\">{}</figure>\n", chart.inline())).collect();
    format!("<div class=\"plots\">\n{charts}</div>\n")
}

/// The curves over the flight, with what they were flown over.
fn flights(report: &Report) -> String {
    let mut text = String::new();
    for Flights { curves, part, charts: drawn, width } in &report.flights {
        let _ = writeln!(text, "<h3>{}</h3>", escape(&curves.title));
        text += &markdown::html(&markdown::read(&curves.note), 4);
        let Some(folder) = part.map(|i| &report.parts[i].folder) else {
            text += "<p>None of the benches that it is made of was flown.</p>\n";
            continue;
        };
        let bench = if folder.name.is_empty() { String::new() } else { format!("Bench {}: ", folder.name) };
        let size = format!("{} x {} samples", folder.fact("dem_columns"), folder.fact("dem_rows"));
        let point = if *width > 1 { format!(", each point {width} of them together") } else { String::new() };
        let (dem, flight, frames) = (folder.fact("dem"), folder.fact("flight"), folder.fact("frames"));
        let said = format!("{bench}DEM {dem} ({size}), flight {flight}, {frames} frames{point}, all repeats together.");
        let _ = writeln!(text, "<p class=\"lead\">{}</p>", escape(&said));
        text += &charts(drawn);
    }
    text
}

fn folded(title: &str, body: &str) -> String {
    format!("<details><summary>{title}</summary>\n{body}</details>\n")
}

fn of_machine(part: &BenchPage) -> String {
    folded("Settings of every run", &facts::settings(part))
        + &folded(
            "Facts of the machine and the bench (<code>machine.json</code>)",
            &facts::of_json(&part.folder.machine),
        )
}
