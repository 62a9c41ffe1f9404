//! The pictures: all of them side by side, and two of choice on top of each other where the script runs.

use std::fmt::Write;
use std::fs;

use crate::fault::Fault;
use crate::report::Report;
use crate::report::html::{escape, number, png_uri};

/// What the script fills: two pictures, a slider between them, keys A and B.
const COMPARE: &str = r#"<div class="compare" id="compare" hidden>
<div class="controls">
<label>Moment <select id="shot-kind"></select></label>
<label>A <select id="shot-a"></select></label>
<label>B <select id="shot-b"></select></label>
<button type="button" id="flip">Flip A and B</button>
</div>
<div class="stage" id="stage"><img id="image-b" alt=""><img id="image-a" alt=""><span class="edge" id="edge"></span>
<span class="tag left" id="tag-a"></span><span class="tag right" id="tag-b"></span></div>
<input type="range" id="slider" min="0" max="100" step="0.1" value="50" aria-label="Share of the width that shows A">
<p class="hint">Drag the slider. Key A shows all of A, key B all of B, and space flips between them.</p>
</div>
"#;

/// All pictures, embedded; HTML.
pub fn html(report: &Report, embed: bool) -> Result<String, Fault> {
    let shots = &report.folder.shots;
    if shots.is_empty() {
        return Ok("<p>This folder has no pictures.</p>\n".into());
    }
    if !embed {
        return Ok("<p>Left out by <code>--no-pictures</code>. They are in the folder <code>shots</code>.</p>\n".into());
    }
    let mut text = format!(
        "{COMPARE}<details class=\"all-shots\" id=\"all-shots\" open><summary>All pictures side by side</summary>\n"
    );
    let mut kinds: Vec<(u32, &str)> = shots.iter().map(|shot| (shot.frame, shot.look.as_str())).collect();
    kinds.dedup();
    for (frame, look) in kinds {
        let name = format!("Frame {}, {}", number(frame.into(), 0), escape(look));
        let _ = writeln!(text, "<h3>{name}</h3>\n<div class=\"shots\" data-kind=\"{name}\">");
        // In the order of the runs, and last what belongs to none.
        for (i, run) in report.runs.iter().enumerate() {
            for shot in shots.iter().filter(|shot| (shot.frame, shot.look.as_str()) == (frame, look)) {
                if run.stem.as_ref() == Some(&shot.stem) {
                    let png = fs::read(&shot.path).map_err(|e| Fault::read(&shot.path, &e, "a picture of a bench"))?;
                    let label = escape(&run.label);
                    let _ = writeln!(
                        text,
                        "<figure class=\"r{i}\"><img loading=\"lazy\" data-run=\"{i}\" alt=\"{label}, {name}\" src=\"{}\"><figcaption>{label}</figcaption></figure>",
                        png_uri(&png)
                    );
                }
            }
        }
        text += "</div>\n";
    }
    Ok(text + "</details>\n")
}
