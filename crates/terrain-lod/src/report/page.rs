//! The page: a header and seven sections, style and script included.

use std::fmt::Write;

use crate::fault::Fault;
use crate::report::chart::{CHART_CSS, Chart};
use crate::report::html::escape;
use crate::report::{Report, facts, headline, markdown, pictures, tables};

const PAGE_CSS: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("script.js");
/// The definitions have one place; the report quotes it.
const METHODOLOGY: &str = include_str!("../../../../METHODOLOGY.md");

/// A section, as the table of contents and the page show it.
struct Section {
    id: &'static str,
    title: &'static str,
    /// How to read it.
    lead: String,
    /// HTML.
    body: String,
}

pub fn html(report: &Report, with_pictures: bool) -> Result<String, Fault> {
    let folder = &report.folder;
    let title = escape(&format!("{} on {}", folder.fact("suite"), folder.fact("dem")));
    let sections = sections(report, with_pictures)?;
    let command = format!("<p class=\"command\"><code>{}</code></p>\n", escape(&facts::command(folder)));
    let mut text = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>terrain-lod: {title}</title>\n<style>\n{CHART_CSS}{PAGE_CSS}{}</style>\n</head>\n<body>\n\
         <header>\n<p class=\"kicker\">terrain-lod {}</p>\n<h1>{title}</h1>\n{}",
        hiding_rules(report),
        escape(&folder.fact("version")),
        facts::warnings(report)?
    );
    text += "<nav aria-label=\"Sections\"><ol>";
    for Section { id, title, .. } in &sections {
        let _ = write!(text, "<li><a href=\"#{id}\">{title}</a></li>");
    }
    text += "</ol></nav>\n</header>\n<main>\n";
    for (i, Section { id, title, lead, body }) in sections.iter().enumerate() {
        // The legend stays in sight from the first chart on.
        text += if i == 1 { legend(report) } else { String::new() }.as_str();
        let _ = write!(
            text,
            "<section id=\"{id}\">\n<h2>{}. {title}</h2>\n<p class=\"lead\">{lead}</p>\n{command}{body}</section>\n",
            i + 1
        );
    }
    let _ = write!(
        text,
        "</main>\n<footer><p>Made by <code>cargo xtask report DIR</code> from the result folder alone.</p></footer>\n\
         <script type=\"application/json\" id=\"curve-values\">{}</script>\n<script>\n{SCRIPT}</script>\n</body>\n</html>\n",
        report.curves.values
    );
    Ok(text)
}

fn sections(report: &Report, with_pictures: bool) -> Result<Vec<Section>, Fault> {
    let has_frame_times = headline::has_frame_times(&report.folder)?;
    let section = |id, title, lead: String, body| Section { id, title, lead, body };
    Ok(vec![
        section("flown", "What was flown", FLOWN.into(), facts::flown(&report.folder)),
        section("headline", "Cost and measured error", headline_lead(has_frame_times), charts(&report.headline)),
        section("summary", "Tables", SUMMARY.into(), tables::html(report)?),
        section("curves", "Frame by frame", curves_lead(report), charts(&report.curves.charts)),
        section("distributions", "Distributions", DISTRIBUTIONS.into(), charts(&report.distributions)),
        section("pictures", "Pictures", PICTURES.into(), pictures::html(report, with_pictures)?),
        section("facts", "Machine, settings, definitions", FACTS.into(), definitions(report)),
    ])
}

const FLOWN: &str = "All runs flew the same frames over the same elevation data. Errors and counts of the error pass are the same on every machine; times are this one's.";
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

fn curves_lead(report: &Report) -> String {
    let mut text = String::from(
        "One number a frame, without warm-up. Move over a chart, or use the arrow keys in it: all charts show all runs at that frame.",
    );
    if report.curves.width > 1 {
        let _ = write!(text, " Each point is the largest of {} frames.", report.curves.width);
    }
    if !report.curves.absent.is_empty() {
        let _ =
            write!(text, " Not measured: {}.", report.curves.absent.join("; ").to_lowercase().replace("p99", "P99"));
    }
    text
}

/// Rules by which the legend's boxes hide a run without a script.
fn hiding_rules(report: &Report) -> String {
    (0..report.runs.len()).map(|run| format!("body:has(#run{run}:not(:checked)) .r{run}{{display:none}}\n")).collect()
}

fn legend(report: &Report) -> String {
    // Many labels are easier to find in columns, few to read in a line.
    let class = if report.runs.len() > 8 { "keys many" } else { "keys" };
    let mut text =
        format!("<details class=\"legend\" open><summary>Runs</summary>\n<div class=\"{class}\" id=\"keys\">\n");
    for (i, run) in report.runs.iter().enumerate() {
        let label = escape(&run.label);
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

fn definitions(report: &Report) -> String {
    let folded = |title: &str, body: &str| format!("<details><summary>{title}</summary>\n{body}</details>\n");
    let methodology = markdown::html(&markdown::read(METHODOLOGY), 3);
    folded("Settings of every run", &facts::settings(report))
        + &folded("Facts of the machine and the bench (<code>machine.json</code>)", &facts::machine(&report.folder))
        + &folded("Definitions of all columns, and how each number is made (<code>METHODOLOGY.md</code>)", &methodology)
}
