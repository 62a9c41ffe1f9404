//! Letters in pictures: an alphabet of 5 x 7 squares, and 2 more below the line.

use image::{Rgb, RgbImage};

/// Blocks of one line of letters and nine lines of squares each, in columns of six.
const LETTERS: &str = include_str!("lettering/letters.txt");

const COLUMNS: usize = 5;
const ROWS: usize = 9;

/// Squares from one letter to the next.
const ADVANCE: u32 = 6;

/// Squares from the top of the tallest letter to the foot of the lowest.
pub const HEIGHT: u32 = ROWS as u32;

/// Squares from one end of a text to the other.
pub fn width(text: &str) -> u32 {
    (text.chars().count() as u32 * ADVANCE).saturating_sub(1)
}

/// Writes a text with its upper left corner at a pixel, each square `scale` pixels wide; what is beyond the picture is
/// left out. A letter that is not in the alphabet is a box.
pub fn write(picture: &mut RgbImage, [left, top]: [i64; 2], scale: u32, colour: Rgb<u8>, text: &str) {
    for (i, letter) in text.chars().enumerate() {
        let squares = squares(letter);
        let left = left + i as i64 * i64::from(ADVANCE * scale);
        for (row, column) in squares {
            let square = [left + column as i64 * i64::from(scale), top + row as i64 * i64::from(scale)];
            fill(picture, square, [scale; 2], colour);
        }
    }
}

/// Fills a rectangle, as much of it as is in the picture.
pub fn fill(picture: &mut RgbImage, [left, top]: [i64; 2], [width, height]: [u32; 2], colour: Rgb<u8>) {
    let within = |first: i64, length: u32, end: u32| first.max(0)..(first + i64::from(length)).min(i64::from(end));
    let (columns, rows) = (within(left, width, picture.width()), within(top, height, picture.height()));
    for row in rows {
        columns.clone().for_each(|column| picture.put_pixel(column as u32, row as u32, colour));
    }
}

/// Rows and columns of the squares that are black.
fn squares(letter: char) -> Vec<(usize, usize)> {
    if letter == ' ' {
        return Vec::new();
    }
    let lines: Vec<&str> = LETTERS.lines().collect();
    for block in lines.chunks(ROWS + 1) {
        if let Some(at) = block[0].find(letter).filter(|at| at.is_multiple_of(COLUMNS + 1)) {
            let is_black = |row: usize, column: usize| block[row + 1].as_bytes()[at + column] == b'#';
            let all = (0..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| (row, column)));
            return all.filter(|(row, column)| is_black(*row, *column)).collect();
        }
    }
    let is_rim = |(row, column): &(usize, usize)| row % 6 == 0 || column % 4 == 0;
    (0..7).flat_map(|row| (0..COLUMNS).map(move |column| (row, column))).filter(is_rim).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_has_a_shape_of_its_own() {
        let alphabet: Vec<char> = (' '..='~').filter(|letter| squares(*letter) != squares('\u{7f}')).collect();
        let expected = " %'()+,-./0123456789:<=>ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz";
        assert_eq!(alphabet.iter().collect::<String>(), expected);
        for (i, letter) in alphabet.iter().enumerate() {
            let twin = alphabet[..i].iter().find(|other| squares(**other) == squares(*letter));
            assert_eq!(twin, None, "{letter}");
        }
    }

    #[test]
    fn a_text_stands_where_it_should_and_ends_at_the_rim() {
        let white = Rgb([255; 3]);
        let mut picture = RgbImage::new(20, 12);
        write(&mut picture, [2, 1], 1, white, "1-");
        let row = |row: u32| {
            (0..20).map(|column| if picture[(column, row)] == white { '#' } else { '.' }).collect::<String>()
        };
        assert_eq!([1, 4, 7].map(row), ["....#...............", "....#....###........", "...###.............."]);
        assert_eq!(width("1-"), 11);
        write(&mut picture, [-3, -3], 4, white, "88888");
        fill(&mut picture, [15, 8], [99, 99], white);
        assert_eq!(picture[(19, 11)], white);
    }
}
