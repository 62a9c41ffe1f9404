//! Reads the Markdown that this project writes (headings, paragraphs, lists, tables, code, bold) and writes it as HTML.

use std::fmt::Write;

use crate::report::html::{Column, escape, group, table};

/// A piece of a document. Texts are Markdown still.
#[derive(Debug, PartialEq)]
pub enum Block {
    /// Level from 1, text.
    Heading(usize, String),
    Paragraph(String),
    List(Vec<String>),
    Table(Table),
}

#[derive(Debug, Default, PartialEq)]
pub struct Table {
    pub heads: Vec<String>,
    /// Whether a column stands to the right.
    pub right: Vec<bool>,
    pub rows: Vec<Vec<String>>,
}

pub fn read(text: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut lines = text.lines().peekable();
    while let Some(line) = lines.next() {
        let level = line.bytes().take_while(|byte| *byte == b'#').count();
        if line.trim().is_empty() {
            continue;
        }
        if (1..=6).contains(&level) {
            blocks.push(Block::Heading(level, line[level..].trim().into()));
            continue;
        }
        let mut whole = vec![line];
        let is_more = |next: &&str| !next.trim().is_empty() && !next.starts_with('#');
        while let Some(next) = lines.next_if(is_more) {
            whole.push(next);
        }
        blocks.push(block(&whole));
    }
    blocks
}

/// A block of lines without an empty one.
fn block(lines: &[&str]) -> Block {
    if lines[0].starts_with('|') {
        return Block::Table(read_table(lines));
    }
    if !lines[0].starts_with("- ") {
        return Block::Paragraph(lines.join("\n"));
    }
    let mut items: Vec<String> = Vec::new();
    for line in lines {
        match line.strip_prefix("- ") {
            Some(item) => items.push(item.into()),
            None => items.last_mut().expect("the first line begins an item").push_str(&format!("\n{}", line.trim())),
        }
    }
    Block::List(items)
}

fn read_table(lines: &[&str]) -> Table {
    let mut rows = lines.iter().map(|line| cells(line));
    let heads = rows.next().unwrap_or_default();
    let right = rows.next().unwrap_or_default().iter().map(|rule| rule.ends_with(':')).collect();
    Table { heads, right, rows: rows.collect() }
}

fn cells(line: &str) -> Vec<String> {
    let line = line.trim();
    let inner = line.strip_prefix('|').unwrap_or(line);
    let inner = inner.strip_suffix('|').unwrap_or(inner);
    inner.split('|').map(|cell| cell.trim().to_owned()).collect()
}

/// The document as HTML; its headings begin at `top`.
pub fn html(blocks: &[Block], top: usize) -> String {
    let highest =
        blocks.iter().filter_map(|block| if let Block::Heading(level, _) = block { Some(*level) } else { None }).min();
    let mut text = String::new();
    for block in blocks {
        let _ = match block {
            Block::Heading(level, heading) => {
                let level = (top + level - highest.unwrap_or(1)).min(6);
                writeln!(text, "<h{level}>{}</h{level}>", inline(heading))
            }
            Block::Paragraph(paragraph) => writeln!(text, "<p>{}</p>", inline(paragraph)),
            Block::List(items) => {
                let items: String = items.iter().map(|item| format!("<li>{}</li>\n", inline(item))).collect();
                writeln!(text, "<ul>\n{items}</ul>")
            }
            Block::Table(table) => write!(text, "{}", table.html()),
        };
    }
    text
}

impl Table {
    pub fn html(&self) -> String {
        let right = |i: usize| self.right.get(i).copied().unwrap_or(false);
        let columns: Vec<Column> =
            self.heads.iter().enumerate().map(|(i, head)| Column::new(inline(head), right(i))).collect();
        let cell = |(i, cell): (usize, &String)| if right(i) { inline(&group(cell)) } else { inline(cell) };
        let rows: Vec<Vec<String>> = self.rows.iter().map(|row| row.iter().enumerate().map(cell).collect()).collect();
        table(&columns, &rows)
    }
}

/// Code and bold text. All else is text as it stands there.
pub fn inline(text: &str) -> String {
    let pieces: Vec<&str> = text.split('`').collect();
    let mut html = String::new();
    for (i, piece) in pieces.iter().enumerate() {
        let is_code = i % 2 == 1 && i + 1 < pieces.len();
        let _ = match (is_code, i % 2) {
            (true, _) => write!(html, "<code>{}</code>", escape(piece)),
            (false, 1) => write!(html, "`{}", bold(piece)),
            _ => write!(html, "{}", bold(piece)),
        };
    }
    html
}

fn bold(text: &str) -> String {
    let pieces: Vec<&str> = text.split("**").collect();
    if pieces.len().is_multiple_of(2) {
        return escape(text);
    }
    let piece = |(i, piece): (usize, &&str)| match i % 2 {
        1 => format!("<strong>{}</strong>", escape(piece)),
        _ => escape(piece),
    };
    pieces.iter().enumerate().map(piece).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_bench_writes_is_read() {
        let text =
            "On **software**.\nMore.\n\n| a  | n |\n| -- | -: |\n| x | 34619 |\n\n### Title\n\n- one\n  more\n- two\n";
        let blocks = read(text);
        let table = Table {
            heads: vec!["a".into(), "n".into()],
            right: vec![false, true],
            rows: vec![vec!["x".into(), "34619".into()]],
        };
        let expected = [
            Block::Paragraph("On **software**.\nMore.".into()),
            Block::Table(table),
            Block::Heading(3, "Title".into()),
            Block::List(vec!["one\nmore".into(), "two".into()]),
        ];
        assert_eq!(blocks, expected);
        let html = html(&blocks, 4);
        assert!(html.contains("<h4>Title</h4>") && html.contains("<td class=\"number\">34\u{202f}619</td>"), "{html}");
    }

    #[test]
    fn text_is_escaped_and_stray_marks_stay() {
        assert_eq!(inline("`<b>` **&** x"), "<code>&lt;b&gt;</code> <strong>&amp;</strong> x");
        assert_eq!(inline("2 ** 3 and `x"), "2 ** 3 and `x");
        assert_eq!(html(&read("# <script>"), 2), "<h2>&lt;script&gt;</h2>\n");
    }
}
