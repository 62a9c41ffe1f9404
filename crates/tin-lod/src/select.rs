//! Algorithm 1 of the paper: which samples of an edge and of a patch's interior are kept.
//!
//! A sample is kept where its height differs by more than `e` from *any* of: the previous column, the previous row,
//! the last kept sample on its row, the closest kept sample of the rows before (section 3.1). Edges compare along
//! themselves alone, so both neighbours get the same border without asking each other (section 3.2).
//!
//! ```text
//!   rows before   . x . . .      . left out   o kept   x the closest kept sample of the rows before
//!                 o . . b .      b previous row
//!   this row      o . p a ?      a previous column, p last kept on this row, ? the sample to decide
//! ```
//!
//! Also kept are the corners, the middle of every edge, and a lattice that bounds the spacing. "Kept" includes the
//! border of the patch: without it a smooth slope would stay unrefined until the first lattice row.
//!
//! Deviation: the closest kept sample is the closest in grid intervals, whatever the spacing in x and z.
//!
//! Deviation: the paper bounds the distance between selected points without saying how. Here every sample whose
//! coordinates within its patch are both multiples of the maximum spacing is kept; that needs no search and is the
//! same on both sides of an edge.

use terrain_core::{Heightmap, Sample};

use crate::patches::{EdgeRun, PatchArea};

/// Kept samples of a run of at most 64 intervals: bit `i` for the `i`-th sample. The ends are not in the mask:
/// corners are always kept, and the ends of interior rows belong to edges.
pub type Mask = u64;

/// The bits of the samples between both ends of a run of `length` intervals (1 to 64).
pub(crate) fn inner_bits(length: u32) -> Mask {
    ((1 << (length - 1)) - 1) << 1
}

/// Kept inner samples of an edge, from the edge's own samples alone.
pub(crate) fn select_edge(heightmap: &Heightmap, run: EdgeRun, tolerance_m: f64, max_spacing: u32) -> Mask {
    let differs = |a: u32, b: u32| {
        let rise = heightmap.height_m(run.sample(a)) as f64 - heightmap.height_m(run.sample(b)) as f64;
        rise.abs() > tolerance_m
    };
    let mut kept: Mask = 0;
    let mut last_kept = 0;
    for i in 1..run.length {
        let always = i == run.length / 2 || i.is_multiple_of(max_spacing);
        if always || differs(i - 1, i) || differs(last_kept, i) {
            kept |= 1 << i;
            last_kept = i;
        }
    }
    kept
}

/// The kept inner samples of a patch's four sides. Its interior selection starts from them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Border {
    /// From west to east.
    pub north: Mask,
    /// From west to east.
    pub south: Mask,
    /// From north to south.
    pub west: Mask,
    /// From north to south.
    pub east: Mask,
}

/// Kept interior samples of a patch: a mask for each of its interior rows.
pub(crate) fn select_interior(
    heightmap: &Heightmap,
    area: PatchArea,
    border: Border,
    tolerance_m: f64,
    max_spacing: u32,
) -> Vec<Mask> {
    let differs = |a: f32, b: f32| (a as f64 - b as f64).abs() > tolerance_m;
    let mut latest = LatestRows::new(area.width, border.north);
    let mut above = row_heights(heightmap, area, 0);
    let height_at = |column: u32, row: u32| {
        heightmap.height_m(Sample { column: area.first.column + column, row: area.first.row + row })
    };
    let mut rows = Vec::with_capacity(area.depth as usize - 1);
    for row in 1..area.depth {
        let heights = row_heights(heightmap, area, row);
        let mut last_kept = (border.west >> row & 1 == 1).then_some(heights[0]);
        let mut kept: Mask = 0;
        for column in 1..area.width {
            let (i, h) = (column as usize, heights[column as usize]);
            let keep = (column.is_multiple_of(max_spacing) && row.is_multiple_of(max_spacing))
                || differs(heights[i - 1], h)
                || differs(above[i], h)
                || last_kept.is_some_and(|last| differs(last, h))
                || {
                    let (x, z) = latest.closest(column, row);
                    differs(height_at(x, z), h)
                };
            if keep {
                kept |= 1 << column;
                last_kept = Some(h);
            }
        }
        latest.finish_row(row, kept, border.west >> row & 1 == 1, border.east >> row & 1 == 1);
        rows.push(kept);
        above = heights;
    }
    rows
}

/// Heights of one row of a patch, both ends included.
fn row_heights(heightmap: &Heightmap, area: PatchArea, row: u32) -> &[f32] {
    let start = heightmap.index(Sample { column: area.first.column, row: area.first.row + row }) as usize;
    &heightmap.heights_m()[start..=start + area.width as usize]
}

/// For each column of a patch the latest row before the present one that holds a kept sample.
///
/// The closest kept sample of the rows before is the closest of these: no more than one candidate a column.
struct LatestRows {
    width: u32,
    rows: [Option<u8>; 65],
}

impl LatestRows {
    fn new(width: u32, north: Mask) -> Self {
        let mut rows = [None; 65];
        for column in 0..=width {
            let corner = column == 0 || column == width;
            rows[column as usize] = (corner || north >> column & 1 == 1).then_some(0);
        }
        Self { width, rows }
    }

    /// Column and row of the kept sample that is closest in the grid; the fewest columns away, then the western one,
    /// among equals. There is always one: the corners of the first row.
    fn closest(&self, column: u32, row: u32) -> (u32, u32) {
        let mut best = (u32::MAX, (0, 0));
        for step in 0..=self.width {
            if step * step >= best.0 {
                break;
            }
            for x in [column.wrapping_sub(step), column + step] {
                if x > self.width {
                    continue;
                }
                if let Some(z) = self.rows[x as usize].map(u32::from) {
                    let distance = step * step + (row - z) * (row - z);
                    if distance < best.0 {
                        best = (distance, (x, z));
                    }
                }
            }
        }
        best.1
    }

    fn finish_row(&mut self, row: u32, kept: Mask, west: bool, east: bool) {
        for column in 1..self.width {
            if kept >> column & 1 == 1 {
                self.rows[column as usize] = Some(row as u8);
            }
        }
        for (column, on_edge) in [(0, west), (self.width, east)] {
            if on_edge {
                self.rows[column as usize] = Some(row as u8);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain_core::SplitMix64;

    fn dem(columns: u32, rows: u32, height: impl FnMut(u32) -> f32) -> Heightmap {
        Heightmap::new(columns, rows, [1.0; 2], (0..columns * rows).map(height).collect()).unwrap()
    }

    fn whole(dem: &Heightmap) -> PatchArea {
        PatchArea { first: Sample { column: 0, row: 0 }, width: dem.columns() - 1, depth: dem.rows() - 1 }
    }

    #[test]
    fn an_edge_keeps_its_middle_the_lattice_and_steps() {
        let flat = dem(17, 2, |_| 5.0);
        let run = EdgeRun { first: Sample { column: 0, row: 0 }, length: 16, along_x: true };
        assert_eq!(select_edge(&flat, run, 1.0, 16), 1 << 8);
        assert_eq!(select_edge(&flat, run, 1.0, 4), 1 << 4 | 1 << 8 | 1 << 12);
        let step = dem(17, 2, |i| if i % 17 >= 5 { 10.0 } else { 0.0 });
        assert_eq!(select_edge(&step, run, 1.0, 16), 1 << 5 | 1 << 8);
        // A gentle slope is caught by the last kept sample: 1 m a column, kept every 3rd above 2 m; 8 is the middle.
        let slope = dem(17, 2, |i| (i % 17) as f32);
        assert_eq!(select_edge(&slope, run, 2.0, 16), 1 << 3 | 1 << 6 | 1 << 8 | 1 << 11 | 1 << 14);
    }

    #[test]
    fn a_flat_interior_keeps_the_lattice_alone() {
        let flat = dem(17, 17, |_| 5.0);
        let border = Border { north: 1 << 8, south: 1 << 8, west: 1 << 8, east: 1 << 8 };
        let rows = select_interior(&flat, whole(&flat), border, 1.0, 8);
        assert_eq!(rows.iter().map(|m| m.count_ones()).sum::<u32>(), 1);
        assert_eq!(rows[7], 1 << 8, "row 8, column 8");
    }

    /// Algorithm 1 word by word, with a search over all kept points for `x`.
    fn plain_interior(dem: &Heightmap, border: Border, e: f64, max_spacing: u32) -> Vec<Mask> {
        let (width, depth) = (dem.columns() - 1, dem.rows() - 1);
        let h = |x: u32, z: u32| dem.height_m(Sample { column: x, row: z }) as f64;
        let mut kept: Vec<(u32, u32)> =
            (0..=width).filter(|x| *x == 0 || *x == width || border.north >> x & 1 == 1).map(|x| (x, 0)).collect();
        for z in 1..depth {
            if border.west >> z & 1 == 1 {
                kept.push((0, z));
            }
            for x in 1..width {
                let on_row = kept.iter().filter(|p| p.1 == z).max_by_key(|p| p.0);
                let before = kept.iter().filter(|p| p.1 < z);
                let key = |p: &&(u32, u32)| {
                    let dx = p.0.abs_diff(x);
                    (dx * dx + (z - p.1) * (z - p.1), dx, p.0)
                };
                let closest = before.min_by_key(key).unwrap();
                let diff = |a: u32, b: u32| (h(a, b) - h(x, z)).abs() > e;
                if x % max_spacing == 0 && z % max_spacing == 0
                    || diff(x - 1, z)
                    || diff(x, z - 1)
                    || on_row.is_some_and(|p| diff(p.0, p.1))
                    || diff(closest.0, closest.1)
                {
                    kept.push((x, z));
                }
            }
            if border.east >> z & 1 == 1 {
                kept.push((width, z));
            }
        }
        let row = |z| kept.iter().filter(|p| p.1 == z && p.0 > 0 && p.0 < width).fold(0, |m, p| m | 1 << p.0);
        (1..depth).map(row).collect()
    }

    #[test]
    fn equals_algorithm_1_word_by_word() {
        for seed in 0..300 {
            let mut random = SplitMix64::new(seed);
            let (columns, rows) = (2 + random.below(64) as u32, 2 + random.below(64) as u32);
            let roughness = random.range(0.1, 3.0);
            let dem = dem(columns, rows, |i| ((i % columns) as f64 * 0.2 + random.range(0.0, roughness)) as f32);
            let bits = |random: &mut SplitMix64, length| random.next_u64() & random.next_u64() & inner_bits(length);
            let border = Border {
                north: bits(&mut random, columns - 1),
                south: 0,
                west: bits(&mut random, rows - 1),
                east: bits(&mut random, rows - 1),
            };
            let e = random.range(0.1, 4.0);
            let max_spacing = 1 + random.below(32) as u32;
            let found = select_interior(&dem, whole(&dem), border, e, max_spacing);
            assert_eq!(found, plain_interior(&dem, border, e, max_spacing), "seed {seed}");
        }
    }

    #[test]
    fn the_widest_patch_uses_63_inner_bits() {
        let mut random = SplitMix64::new(1);
        let dem = dem(65, 65, |_| random.range(0.0, 9.0) as f32);
        let run = EdgeRun { first: Sample { column: 0, row: 64 }, length: 64, along_x: true };
        assert_eq!(select_edge(&dem, run, 0.0, 32), !1);
        let all = !1;
        let border = Border { north: all, south: all, west: all, east: all };
        assert!(select_interior(&dem, whole(&dem), border, 0.0, 32).iter().all(|row| *row == all));
    }
}
