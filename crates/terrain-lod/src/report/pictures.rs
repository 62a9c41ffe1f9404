//! The pictures: all of them side by side, and two of choice on top of each other where the script runs.

use std::fmt::Write;

use crate::fault::Fault;
use crate::report::album::Album;
use crate::report::bench_page::BenchPage;
use crate::report::html::{Column, escape, group, number, table};
use crate::report::sheet::Sheet;

/// What the script fills: two pictures, a slider between them, keys A and B.
const COMPARE: &str = r#"<div class="compare" hidden>
<div class="controls">
<label>Moment <select class="shot-kind"></select></label>
<label>A <select class="shot-a"></select></label>
<label>B <select class="shot-b"></select></label>
<button type="button" class="flip">Flip A and B</button>
</div>
<div class="stage"><img class="image-b" alt=""><img class="image-a" alt=""><span class="edge"></span>
<span class="tag left"></span><span class="tag right"></span></div>
<input type="range" class="slider" min="0" max="100" step="0.1" value="50" aria-label="Share of the width that shows A">
<p class="hint">Drag the slider. Key A shows all of A, key B all of B, and space flips between them.</p>
</div>
"#;

/// All pictures of a bench, embedded; HTML.
pub fn html(part: &BenchPage, album: &mut Album) -> Result<String, Fault> {
    let shots = &part.folder.shots;
    let measured = part.folder.pictures.as_ref().map_or_else(String::new, measured);
    if shots.is_empty() {
        return Ok(format!("<p>This folder has no pictures.</p>\n{measured}"));
    }
    if !album.is_open() {
        let left_out = "<p>Left out by <code>--no-pictures</code>. They are in the folder <code>shots</code>.</p>\n";
        return Ok(format!("{left_out}{measured}"));
    }
    let before = album.left_out;
    let mut text = String::new();
    let mut kinds: Vec<(u32, &str)> = shots.iter().map(|shot| (shot.frame, shot.look.as_str())).collect();
    kinds.dedup();
    for kind in kinds {
        text += &side_by_side(part, kind, album)?;
    }
    let left_out = match album.left_out - before {
        0 => String::new(),
        count => format!(
            "<p>{count} pictures would make this file too large; they are in the folder <code>{}</code>.</p>\n",
            escape(&shots_of(part))
        ),
    };
    Ok(format!(
        "{left_out}<div class=\"album\">{COMPARE}<details class=\"all-shots\" open><summary>All pictures side by side</summary>\n\
         {text}</details>\n</div>\n{measured}"
    ))
}

fn shots_of(part: &BenchPage) -> String {
    if part.folder.name.is_empty() { "shots".into() } else { format!("{}/shots", part.folder.name) }
}

/// One moment in one look, in the order of the runs.
fn side_by_side(part: &BenchPage, (frame, look): (u32, &str), album: &mut Album) -> Result<String, Fault> {
    let name = format!("Frame {}, {}", number(frame.into(), 0), escape(&look.replace('-', " ")));
    let mut text = format!("<h3>{name}</h3>\n<div class=\"shots\" data-kind=\"{name}\">");
    for run in &part.runs {
        let is_its = |shot: &&crate::report::folder::Shot| {
            (shot.frame, shot.look.as_str()) == (frame, look) && run.stem.as_ref() == Some(&shot.stem)
        };
        for shot in part.folder.shots.iter().filter(is_its) {
            let Some(uri) = album.embed(&shot.path)? else { continue };
            let (i, label) = (run.look.run, escape(&run.label));
            let _ = writeln!(
                text,
                "<figure class=\"r{i}\"><img loading=\"lazy\" data-run=\"{i}\" alt=\"{label}, {name}\" src=\"{uri}\"><figcaption>{label}</figcaption></figure>"
            );
        }
    }
    Ok(text + "</div>\n")
}

/// What was measured of the pictures, as it stands in `pictures.csv`.
fn measured(sheet: &Sheet) -> String {
    let is_number = |column: &String| {
        let cells = (0..sheet.len()).map(|row| sheet.text(row, column));
        cells.clone().any(|cell| !cell.is_empty())
            && cells.clone().all(|cell| cell.is_empty() || cell.parse::<f64>().is_ok())
    };
    // What no row has tells nothing.
    let is_any = |column: &&String| (0..sheet.len()).any(|row| !sheet.text(row, column).is_empty());
    let names: Vec<&String> = sheet.columns().iter().filter(is_any).collect();
    let columns: Vec<Column> =
        names.iter().map(|name| Column::new(escape(&name.replace('_', " ")), is_number(name))).collect();
    let cells = |row: usize| names.iter().map(|name| escape(&group(sheet.text(row, name)))).collect();
    let rows: Vec<Vec<String>> = (0..sheet.len()).map(cells).collect();
    format!("<h3>Pictures against the full grid (<code>pictures.csv</code>)</h3>\n{}", table(&columns, &rows))
}
