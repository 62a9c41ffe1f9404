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

mod closest;

use closest::KeptBefore;
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
///
/// - `run`: an edge of a [`PatchGrid`](crate::PatchGrid) over this DEM.
/// - `tolerance_m`: the height difference in metres above which a sample is kept, 0 or more; with infinity those alone
///   that are always kept. It is no bound of the error.
/// - `max_spacing`: largest distance between kept samples in grid intervals, 1 to the side of a whole patch.
pub fn select_edge(heightmap: &Heightmap, run: EdgeRun, tolerance_m: f64, max_spacing: u32) -> Mask {
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

/// Selects the interior samples of a patch: fills `rows` with a mask for each of its interior rows.
///
/// - `area`: a patch of a [`PatchGrid`](crate::PatchGrid) over this DEM.
/// - `border`: what its four edges keep.
/// - `tolerance_m`, `max_spacing`: as for [`select_edge`].
///
/// What depends on no other decision of the same row is compared for all of the row at once. What is left is the last
/// kept sample on the row, from west to east.
pub fn select_interior(
    heightmap: &Heightmap,
    area: PatchArea,
    border: Border,
    tolerance_m: f64,
    max_spacing: u32,
    rows: &mut Vec<Mask>,
) {
    rows.clear();
    let inner = 1..area.width as usize;
    let all = inner_bits(area.width);
    let lattice = lattice_bits(max_spacing);
    let mut above = row_heights(heightmap, area, 0);
    let mut before = KeptBefore::new(area.width, border.north, above);
    for row in 1..area.depth {
        let heights = row_heights(heightmap, area, row);
        let of_row = &heights[inner.clone()];
        let mut kept = if row.is_multiple_of(max_spacing) { lattice & all } else { 0 };
        kept |= differing(of_row, [heights, &above[inner.clone()]], tolerance_m) << 1;
        if kept != all {
            kept |= differing(of_row, [&before.closest_heights_m(row)[1..]], tolerance_m) << 1;
        }
        let [west, east] = [border.west, border.east].map(|side| side >> row & 1);
        let kept = with_last_kept(heights, west == 1, kept, tolerance_m);
        before.add_row(row, (kept | west) as u128 | (east as u128) << area.width, heights);
        rows.push(kept);
        above = heights;
    }
}

fn differs(a_m: f32, b_m: f32, tolerance_m: f64) -> bool {
    (a_m as f64 - b_m as f64).abs() > tolerance_m
}

/// Bit `i` where the `i`-th height differs from any of the `i`-th heights of the others, which are no shorter.
fn differing<const N: usize>(heights_m: &[f32], others_m: [&[f32]; N], tolerance_m: f64) -> Mask {
    let others_m = others_m.map(|other_m| &other_m[..heights_m.len()]);
    let mut found = [0u8; 64];
    // A byte a comparison, which the compiler does many of at once; then the lowest bit of each byte.
    for (i, (found, height_m)) in found.iter_mut().zip(heights_m).enumerate() {
        *found = others_m.iter().fold(0, |any, other_m| any | differs(*height_m, other_m[i], tolerance_m) as u8);
    }
    let eight_bits = |bytes: &[u8; 8]| u64::from_le_bytes(*bytes).wrapping_mul(0x0102_0408_1020_4080) >> 56;
    found.as_chunks().0.iter().rev().fold(0, |mask, bytes| mask << 8 | eight_bits(bytes))
}

/// Adds the samples of a row that differ from the last kept one to their west.
fn with_last_kept(heights_m: &[f32], west: bool, mut kept: Mask, tolerance_m: f64) -> Mask {
    // Nothing differs from a NaN.
    let mut last_m = if west { heights_m[0] } else { f32::NAN };
    for (column, height_m) in (1..).zip(heights_m[1..heights_m.len() - 1].iter().copied()) {
        if kept >> column & 1 == 1 || differs(last_m, height_m, tolerance_m) {
            kept |= 1 << column;
            last_m = height_m;
        }
    }
    kept
}

/// The multiples of the maximum spacing.
fn lattice_bits(max_spacing: u32) -> Mask {
    (0..64).step_by(max_spacing as usize).fold(0, |mask, column| mask | 1 << column)
}

/// Heights of one row of a patch, both ends included.
fn row_heights(heightmap: &Heightmap, area: PatchArea, row: u32) -> &[f32] {
    let start = heightmap.index(Sample { column: area.first.column, row: area.first.row + row }) as usize;
    &heightmap.heights_m()[start..=start + area.width as usize]
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain_core::SplitMix64;

    fn dem(columns: u32, rows: u32, height: impl FnMut(u32) -> f32) -> Heightmap {
        Heightmap::new(columns, rows, [1.0; 2], (0..columns * rows).map(height).collect()).unwrap()
    }

    /// The interior of a patch that is the whole DEM.
    fn interior(dem: &Heightmap, border: Border, tolerance_m: f64, max_spacing: u32) -> Vec<Mask> {
        let first = Sample { column: 0, row: 0 };
        let area = PatchArea { first, width: dem.columns() - 1, depth: dem.rows() - 1 };
        let mut rows = vec![1; 7];
        select_interior(dem, area, border, tolerance_m, max_spacing, &mut rows);
        rows
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
        let rows = interior(&flat, border, 1.0, 8);
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

    /// Rough, sloping, with a few spikes, or in terraces: kept samples from nearly none to all.
    fn random_dem(random: &mut SplitMix64) -> Heightmap {
        let largest = [9, 17, 33, 65][random.below(4) as usize];
        let mut side = || 2 + random.below(largest - 1) as u32;
        let (columns, rows) = (side(), side());
        let (kind, roughness) = (random.below(4), random.range(0.1, 3.0));
        let [along_x, along_z] = [random.range(-0.3, 0.3), random.range(-0.3, 0.3)];
        dem(columns, rows, |i| {
            let slope = (i % columns) as f64 * along_x + (i / columns) as f64 * along_z;
            let height_m = match kind {
                0 => slope + random.range(0.0, roughness),
                1 => slope,
                2 => slope + (random.below(40) == 0) as u32 as f64 * random.range(-9.0, 9.0),
                _ => (slope * 2.0).floor(),
            };
            height_m as f32
        })
    }

    /// From no kept inner sample to a quarter of them.
    fn random_border(random: &mut SplitMix64, dem: &Heightmap) -> Border {
        let sparse = random.below(4);
        let mut side = |samples: u32| (0..=sparse).fold(inner_bits(samples - 1), |bits, _| bits & random.next_u64());
        let [columns, rows] = [dem.columns(), dem.rows()];
        Border { north: side(columns), south: side(columns), west: side(rows), east: side(rows) }
    }

    #[test]
    fn equals_algorithm_1_word_by_word() {
        let seeds = 0..3_000;
        println!("seeds {seeds:?}");
        for seed in seeds {
            let mut random = SplitMix64::new(seed);
            let dem = random_dem(&mut random);
            let border = random_border(&mut random, &dem);
            let e = random.range(0.1, 4.0);
            let max_spacing = 1 + random.below(64) as u32;
            let found = interior(&dem, border, e, max_spacing);
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
        assert!(interior(&dem, border, 0.0, 32).iter().all(|row| *row == all));
    }
}
