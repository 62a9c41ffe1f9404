//! Voids: the samples of a DEM without a height. Where they are, and which quads and triangles lie in them.
//!
//! A quad is void if any of its corners is one, so that nothing that was measured ends in a height that was not:
//!
//! ```text
//!  o───o───o───o
//!  │   │ x │ x │      o  a sample with a height
//!  o───o───•───o      •  a void
//!  │   │ x │ x │      x  a void quad
//!  o───o───o───o
//! ```

use crate::{Sample, Triangle};

/// Which samples of a DEM are voids, one bit each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VoidMask {
    columns: u32,
    rows: u32,
    count: u64,
    words: Vec<u64>,
}

impl VoidMask {
    /// The samples that are NaN, of a grid row by row.
    pub fn of(columns: u32, heights_m: &[f32]) -> Self {
        Self::new(columns, heights_m, |height_m| height_m.is_nan())
    }

    /// One flag a sample, row by row.
    pub fn of_flags(columns: u32, is_void: &[bool]) -> Self {
        Self::new(columns, is_void, |is_void| *is_void)
    }

    /// The words of such a mask; `None` if they are too few, too many, or have bits after the last sample.
    pub fn from_words(columns: u32, rows: u32, words: Vec<u64>) -> Option<Self> {
        let samples = columns as u64 * rows as u64;
        let beyond = words.last().filter(|_| !samples.is_multiple_of(64)).map_or(0, |last| last >> (samples % 64));
        let count = words.iter().map(|word| u64::from(word.count_ones())).sum();
        (words.len() as u64 == samples.div_ceil(64) && beyond == 0).then_some(Self { columns, rows, count, words })
    }

    fn new<T>(columns: u32, samples: &[T], is_void: impl Fn(&T) -> bool) -> Self {
        let count = samples.iter().filter(|sample| is_void(sample)).count() as u64;
        let word = |chunk: &[T]| {
            chunk.iter().enumerate().fold(0, |word, (bit, sample)| word | u64::from(is_void(sample)) << bit)
        };
        let rows = (samples.len() / columns.max(1) as usize) as u32;
        Self { columns, rows, count, words: samples.chunks(64).map(word).collect() }
    }

    /// Samples along x.
    pub fn columns(&self) -> u32 {
        self.columns
    }

    /// Samples along z.
    pub fn rows(&self) -> u32 {
        self.rows
    }

    /// How many samples are voids.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Whether a sample is a void.
    pub fn is_void(&self, column: u32, row: u32) -> bool {
        self.has(row as usize * self.columns as usize + column as usize)
    }

    /// As [`Self::is_void`], by the sample's place in [`Heightmap::heights_m`](crate::Heightmap::heights_m).
    pub fn has(&self, index: usize) -> bool {
        self.words[index / 64] >> (index % 64) & 1 == 1
    }

    /// The bits of all samples, row by row: 64 samples a word, the first in its lowest bit.
    pub fn words(&self) -> &[u64] {
        &self.words
    }

    /// The voids' indices, rising.
    pub fn indices(&self) -> impl DoubleEndedIterator<Item = usize> {
        let words = self.words.iter().enumerate().filter(|(_, word)| **word != 0);
        words.flat_map(|(w, word)| (0..64).filter(move |bit| word >> bit & 1 == 1).map(move |bit| w * 64 + bit))
    }
}

/// Which quads of a DEM are void, one bit each; a quad has the column and the row of its north-western corner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VoidQuads {
    words_a_row: u32,
    words: Vec<u32>,
}

impl VoidQuads {
    /// The quads with a void at any corner.
    pub fn of(mask: &VoidMask) -> Self {
        let (columns, rows) = (mask.columns.saturating_sub(1), mask.rows.saturating_sub(1));
        let words_a_row = columns.div_ceil(32);
        let mut quads = Self { words_a_row, words: vec![0; words_a_row as usize * rows as usize] };
        for index in mask.indices() {
            let [column, row] = [index % mask.columns as usize, index / mask.columns as usize].map(|at| at as u32);
            for row in row.saturating_sub(1)..=row.min(rows.saturating_sub(1)) {
                for column in column.saturating_sub(1)..=column.min(columns.saturating_sub(1)) {
                    quads.words[(row * words_a_row + column / 32) as usize] |= 1 << (column % 32);
                }
            }
        }
        quads
    }

    /// Whether a quad is void.
    pub fn is_void(&self, column: u32, row: u32) -> bool {
        self.words[(row * self.words_a_row + column / 32) as usize] >> (column % 32) & 1 == 1
    }

    /// The bits of all quads, row by row, as the GPU reads them: 32 quads a word, the first in its lowest bit. Each row
    /// begins with a word of its own.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// Whether a triangle lies in voids: each quad of which it covers a part is void. One that covers a part of any other
    /// quad does not, however little.
    pub fn contain(&self, triangle: &Triangle) -> bool {
        Self::covered_by(triangle).all(|[column, row]| self.is_void(column, row))
    }

    /// Whether a triangle covers a part of any void quad.
    pub fn reach_into(&self, triangle: &Triangle) -> bool {
        Self::covered_by(triangle).any(|[column, row]| self.is_void(column, row))
    }

    /// The quads of which a triangle covers a part, row by row, as `[column, row]`.
    pub fn covered_by(triangle: &Triangle) -> impl Iterator<Item = [u32; 2]> {
        let [columns, rows] = [|s: Sample| s.column, |s: Sample| s.row].map(|axis| {
            let [a, b, c] = triangle.samples.map(axis);
            a.min(b).min(c)..a.max(b).max(c)
        });
        let quads = rows.flat_map(move |row| columns.clone().map(move |column| [column, row]));
        quads.filter(move |quad| covers_part_of(triangle, *quad))
    }
}

/// Whether a triangle and a quad of its bounding box share more than a border. They do not if all of the quad lies on the
/// outer side of one of the triangle's sides, or on it.
fn covers_part_of(triangle: &Triangle, quad: [u32; 2]) -> bool {
    let [column, row] = quad.map(i64::from);
    let corners = [[column, row], [column + 1, row], [column, row + 1], [column + 1, row + 1]];
    let [a, b, c] = triangle.samples.map(|s| [s.column as i64, s.row as i64]);
    let orientation = triangle.doubled_area().signum();
    [(a, b), (b, c), (c, a)].into_iter().all(|(from, to)| {
        let inwards = |p: [i64; 2]| (p[0] - from[0]) * (to[1] - from[1]) - (to[0] - from[0]) * (p[1] - from[1]);
        corners.into_iter().any(|p| inwards(p) * orientation > 0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SplitMix64;

    fn random_flags(seed: u64, samples: u32, one_in: u64) -> Vec<bool> {
        let mut random = SplitMix64::new(seed);
        (0..samples).map(|_| random.below(one_in) == 0).collect()
    }

    #[test]
    fn masks_hold_what_they_are_told() {
        for (seed, [columns, rows]) in [[2, 2], [9, 7], [64, 3], [65, 4], [130, 70]].into_iter().enumerate() {
            let flags = random_flags(seed as u64, columns * rows, 3);
            let mask = VoidMask::of_flags(columns, &flags);
            let heights_m: Vec<f32> = flags.iter().map(|is_void| if *is_void { f32::NAN } else { -0.0 }).collect();
            assert_eq!(mask, VoidMask::of(columns, &heights_m));
            assert_eq!((mask.columns(), mask.rows()), (columns, rows));
            assert_eq!(mask.count() as usize, flags.iter().filter(|is_void| **is_void).count());
            let indices: Vec<usize> = (0..flags.len()).filter(|index| flags[*index]).collect();
            assert_eq!(mask.indices().collect::<Vec<_>>(), indices);
            let mut words = mask.words().to_vec();
            assert_eq!(VoidMask::from_words(columns, rows, words.clone()), Some(mask.clone()));
            assert_eq!(VoidMask::from_words(columns, rows, [&words[..], &[0]].concat()), None);
            *words.last_mut().unwrap() |= 1 << 63;
            let is_sample = (columns * rows).is_multiple_of(64);
            assert_eq!(VoidMask::from_words(columns, rows, words).is_some(), is_sample, "a bit after the last sample");
            assert!((0..columns * rows).all(|i| mask.is_void(i % columns, i / columns) == flags[i as usize]));
        }
    }

    #[test]
    fn a_quad_is_void_if_any_of_its_corners_is() {
        for (seed, [columns, rows]) in [[2, 2], [3, 9], [33, 5], [34, 40], [97, 65]].into_iter().enumerate() {
            let flags = random_flags(seed as u64, columns * rows, 12);
            let quads = VoidQuads::of(&VoidMask::of_flags(columns, &flags));
            let mut void = 0;
            for (column, row) in (0..rows - 1).flat_map(|row| (0..columns - 1).map(move |column| (column, row))) {
                let at = |c: u32, r: u32| flags[((row + r) * columns + column + c) as usize];
                let expected = at(0, 0) || at(1, 0) || at(0, 1) || at(1, 1);
                assert_eq!(quads.is_void(column, row), expected, "{columns} x {rows}: quad {column}, {row}");
                void += expected as u32;
            }
            let bits: u32 = quads.words().iter().map(|word| word.count_ones()).sum();
            assert_eq!(bits, void, "no bits beside the quads");
        }
    }

    fn triangle(corners: [[u32; 2]; 3]) -> Triangle {
        Triangle { samples: corners.map(|[column, row]| Sample { column, row }), heights_m: [0.0; 3] }
    }

    /// What a triangle covers of a quad, by clipping it at the quad's four sides.
    fn covered_area(triangle: &Triangle, column: u32, row: u32) -> f64 {
        let mut polygon: Vec<[f64; 2]> = triangle.samples.map(|s| [s.column as f64, s.row as f64]).to_vec();
        let sides = [(0, column, 1.0), (0, column + 1, -1.0), (1, row, 1.0), (1, row + 1, -1.0)];
        for (axis, at, inwards) in sides {
            let depth = |p: [f64; 2]| (p[axis] - at as f64) * inwards;
            let mut clipped = Vec::new();
            for (i, &from) in polygon.iter().enumerate() {
                let to = polygon[(i + 1) % polygon.len()];
                if depth(from) >= 0.0 {
                    clipped.push(from);
                }
                if depth(from) * depth(to) < 0.0 {
                    let share = depth(from) / (depth(from) - depth(to));
                    clipped.push([0, 1].map(|i| from[i] + share * (to[i] - from[i])));
                }
            }
            polygon = clipped;
        }
        let doubled = (0..polygon.len()).map(|i| {
            let (p, q) = (polygon[i], polygon[(i + 1) % polygon.len()]);
            p[0] * q[1] - q[0] * p[1]
        });
        0.5 * doubled.sum::<f64>().abs()
    }

    /// Against the areas that triangles of either turn cover of each quad.
    #[test]
    fn triangles_lie_in_voids_if_they_cover_nothing_else() {
        let (mut contained, mut straddling) = (0, 0);
        for seed in 0..400 {
            let mut random = SplitMix64::new(seed);
            let flags = random_flags(seed, 12 * 11, 2 + seed % 5);
            let mask = VoidMask::of_flags(12, &flags);
            let quads = VoidQuads::of(&mask);
            for _ in 0..20 {
                let (side, origin) = (1 + random.below(6), [random.below(6), random.below(5)]);
                let corner =
                    |random: &mut SplitMix64| origin.map(|from| (from + random.below(side + 1)).min(10) as u32);
                let triangle = triangle([(); 3].map(|()| corner(&mut random)));
                if triangle.doubled_area() == 0 {
                    continue;
                }
                let all = (0..10).flat_map(|row| (0..11).map(move |column| (column, row)));
                let covered = |is_void: bool| {
                    let such = all.clone().filter(|(column, row)| quads.is_void(*column, *row) == is_void);
                    such.map(|(column, row)| covered_area(&triangle, column, row)).sum::<f64>()
                };
                let (in_voids, beside) = (covered(true), covered(false));
                let area = 0.5 * triangle.doubled_area().abs() as f64;
                assert!((in_voids + beside - area).abs() < 1e-9);
                assert_eq!(quads.contain(&triangle), beside < 1e-9, "seed {seed}: {triangle:?}");
                assert_eq!(quads.reach_into(&triangle), in_voids >= 1e-9, "seed {seed}: {triangle:?}");
                contained += (beside < 1e-9) as u32;
                straddling += (beside >= 1e-9 && in_voids >= 1e-9) as u32;
            }
        }
        assert!(contained > 500 && straddling > 500, "{contained} contained, {straddling} straddling");
    }

    #[test]
    fn a_triangle_that_touches_a_sound_quad_with_a_side_or_a_corner_lies_in_voids() {
        // One void: the quads around (2, 2), rows and columns 1 and 2.
        let mut flags = [false; 36];
        flags[2 * 6 + 2] = true;
        let quads = VoidQuads::of(&VoidMask::of_flags(6, &flags));
        assert!(quads.contain(&triangle([[1, 1], [1, 3], [3, 1]])));
        assert!(quads.contain(&triangle([[1, 1], [3, 3], [3, 1]])), "the other diagonal");
        assert!(!quads.contain(&triangle([[1, 1], [1, 3], [4, 1]])));
        assert!(!quads.contain(&triangle([[0, 3], [1, 3], [1, 2]])));
    }
}
