//! The pictures that a suite was asked for: `figures.csv` names the files, their titles, captions and commands.

use std::fmt::Write;
use std::path::{Component, Path, PathBuf};

use crate::fault::{Cause, Fault};
use crate::report::album::Album;
use crate::report::html::escape;
use crate::report::markdown::inline;
use crate::report::sheet::Sheet;

/// One row of `figures.csv`.
pub struct Figure {
    pub path: PathBuf,
    /// As the file names it.
    file: String,
    title: String,
    caption: String,
    /// What made it; empty where that is the bench.
    command: String,
}

/// The figures of a folder; none where it has no `figures.csv`.
pub fn read(folder: &Path) -> Result<Vec<Figure>, Fault> {
    let Some(sheet) = Sheet::read(&folder.join("figures.csv"))? else { return Ok(Vec::new()) };
    let figure = |row| {
        let text = |column: &str| sheet.text(row, column).to_owned();
        let file = text("file");
        let path = place(folder, &file)?;
        Ok(Figure { path, file, title: text("title"), caption: text("caption"), command: text("command") })
    };
    (0..sheet.len()).map(figure).collect()
}

/// A file of the folder. What leads out of it is no picture of the bench.
fn place(folder: &Path, file: &str) -> Result<PathBuf, Fault> {
    let is_inside = |part: Component| matches!(part, Component::Normal(_));
    if file.is_empty() || !Path::new(file).components().all(is_inside) {
        let name = folder.join("figures.csv");
        let message = format!("{}: file is {file:?}; expected a path within the folder", name.display());
        return Err(Fault::new(Cause::BadInput, message));
    }
    let own = folder.join(file);
    // Names may be those in the folder of pictures alone.
    let alone = folder.join("figures").join(file);
    Ok(if !own.exists() && alone.exists() { alone } else { own })
}

/// All of them, embedded; HTML.
pub fn html(figures: &[Figure], album: &mut Album) -> Result<String, Fault> {
    let mut text = String::new();
    for figure in figures {
        let (title, caption) = (escape(&figure.title), inline(&figure.caption));
        let _ = writeln!(text, "<figure class=\"figure\">\n<h3>{title}</h3>");
        match album.embed(&figure.path)? {
            Some(uri) => {
                let _ = writeln!(text, "<img loading=\"lazy\" alt=\"{title}\" src=\"{uri}\">");
            }
            None => {
                let _ = writeln!(text, "<p>Not in this file: <code>{}</code>.</p>", escape(&figure.file));
            }
        }
        let _ = writeln!(text, "<figcaption>{caption}</figcaption>");
        if !figure.command.is_empty() {
            let _ = writeln!(text, "<p class=\"command\"><code>{}</code></p>", escape(&figure.command));
        }
        text += "</figure>\n";
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figures(file: &str) -> Result<Vec<Figure>, Fault> {
        let folder = tempfile::tempdir().unwrap();
        let row = format!("file,title,caption,command\n{file},A <b>,\"one, two\",cargo xtask x\n");
        std::fs::write(folder.path().join("figures.csv"), row).unwrap();
        read(folder.path())
    }

    #[test]
    fn a_figure_has_title_caption_and_command() {
        let found = figures("figures/a.svg").unwrap();
        let text = html(&found, &mut Album::new(false)).unwrap();
        for expected in ["A &lt;b&gt;", "one, two", "cargo xtask x", "<code>figures/a.svg</code>"] {
            assert!(text.contains(expected), "{text}");
        }
    }

    #[test]
    fn a_path_that_leads_out_of_the_folder_is_refused() {
        for file in ["../secret.png", "/secret.png", "figures/../../secret.png", ""] {
            assert!(figures(file).err().unwrap().to_string().contains("expected a path within the folder"), "{file}");
        }
    }
}
