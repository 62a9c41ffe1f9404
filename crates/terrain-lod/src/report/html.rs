//! The small pieces of HTML: escaped text, numbers, tables, embedded files.

use std::fmt::Write;

/// Between groups of three digits: narrow, and no line breaks there.
const THIN_SPACE: char = '\u{202f}';

/// Text as HTML and SVG show it as it is, in elements and in attributes. Control characters, which XML refuses, go.
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for char in text.chars() {
        match char {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            '\n' | '\t' => escaped.push(char),
            _ if char.is_control() => {}
            _ => escaped.push(char),
        }
    }
    escaped
}

/// A number with decimals, its thousands apart.
pub fn number(value: f64, decimals: usize) -> String {
    group(&format!("{value:.decimals$}"))
}

/// A number with four digits, or all of those before the point.
pub fn digits(value: f64) -> String {
    let before = if value == 0.0 { 1 } else { value.abs().log10().floor() as i32 + 1 };
    let text = number(value, (4 - before).clamp(0, 6) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// The same for a program.
pub fn plain_digits(value: f64) -> String {
    digits(value).replace(THIN_SPACE, "")
}

/// The digits before the point in groups of three, also of what is at most a number. Anything else stays as it is.
pub fn group(text: &str) -> String {
    let sign = ["-", "<= "].into_iter().find(|sign| text.starts_with(sign)).unwrap_or("");
    let rest = &text[sign.len()..];
    let (whole, fraction) = rest.split_at(rest.find('.').unwrap_or(rest.len()));
    if whole.len() < 4 || !whole.bytes().all(|byte| byte.is_ascii_digit()) {
        return text.to_owned();
    }
    let mut grouped = String::from(sign);
    for (i, digit) in whole.chars().enumerate() {
        if i > 0 && (whole.len() - i) % 3 == 0 {
            grouped.push(THIN_SPACE);
        }
        grouped.push(digit);
    }
    grouped + fraction
}

/// A size for people.
pub fn bytes(count: usize) -> String {
    match count {
        0..1_000 => format!("{count} bytes"),
        1_000..1_000_000 => format!("{:.0} kB", count as f64 / 1e3),
        _ => format!("{} MB", number(count as f64 / 1e6, 1)),
    }
}

/// A column of a table.
pub struct Column {
    /// HTML.
    pub head: String,
    /// Of its cells; empty for none. `number` stands to the right.
    pub class: &'static str,
}

impl Column {
    pub fn new(head: String, is_number: bool) -> Self {
        Self { head, class: if is_number { "number" } else { "" } }
    }
}

/// A table; heads and cells are HTML.
pub fn table(columns: &[Column], rows: &[Vec<String>]) -> String {
    let class = |i: usize| match columns.get(i).map_or("", |column| column.class) {
        "" => String::new(),
        class => format!(" class=\"{class}\""),
    };
    let mut text = String::from("<div class=\"wide\"><table>\n<thead><tr>");
    for (i, column) in columns.iter().enumerate() {
        let _ = write!(text, "<th scope=\"col\"{}>{}</th>", class(i), column.head);
    }
    text += "</tr></thead>\n<tbody>\n";
    for row in rows {
        text += "<tr>";
        for (i, cell) in row.iter().enumerate() {
            let _ = write!(text, "<td{}>{cell}</td>", class(i));
        }
        text += "</tr>\n";
    }
    text + "</tbody></table></div>\n"
}

/// The bytes of a picture as a URI that needs no file. `kind` is its media type.
pub fn data_uri(kind: &str, bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut uri = String::with_capacity(14 + kind.len() + bytes.len().div_ceil(3) * 4);
    let _ = write!(uri, "data:{kind};base64,");
    for chunk in bytes.chunks(3) {
        let bits = (0..3).fold(0_u32, |bits, i| bits << 8 | u32::from(chunk.get(i).copied().unwrap_or(0)));
        for i in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * i) & 63) as usize] as char;
            uri.push(if i <= chunk.len() { digit } else { '=' });
        }
    }
    uri
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_in_text_stays_text() {
        assert_eq!(
            escape("<script>'a' & \"b\"</script>\u{1b}"),
            "&lt;script&gt;&#39;a&#39; &amp; &quot;b&quot;&lt;/script&gt;"
        );
    }

    #[test]
    fn thousands_stand_apart() {
        assert_eq!([number(1_234_567.891, 1), number(999.0, 0)], ["1\u{202f}234\u{202f}567.9", "999"]);
        assert_eq!(
            [group("-1234"), group("12.3456"), group("2026-01-31"), group("1 234")].map(|g| g.len()),
            [8, 7, 10, 5]
        );
        assert_eq!(group("<= 650394"), "<= 650\u{202f}394");
        assert_eq!(
            [digits(0.0312345), digits(0.0), digits(12_345.6), digits(12.0)],
            ["0.03123", "0", "12\u{202f}346", "12"]
        );
    }

    #[test]
    fn base64_of_rfc_4648() {
        let base64 = |text: &str| data_uri("image/png", text.as_bytes()).split_off(22);
        let expected = ["", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"];
        assert_eq!(["", "f", "fo", "foo", "foob", "fooba", "foobar"].map(base64), expected);
    }
}
