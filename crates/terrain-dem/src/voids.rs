//! Voids: samples without a height. What stands in for them.

pub(crate) use terrain_core::VoidMask;

/// Sweeps of relaxation over the filled heights: enough for the eye, since the first guess is good.
const SWEEPS: usize = 16;

/// Gives the voids heights from their rim: smooth, always the same, in time and memory linear in the grid.
///
/// A pyramid of the rims' means is the first guess (push-pull; Gortler et al., "The Lumigraph", SIGGRAPH 1996, section
/// 3.4, with rims alone as the samples). Relaxation then brings it closer to the membrane over the rim. Each fill lies
/// between the lowest and the highest sample at its own hole's rim.
///
/// At least one sample must have a height.
pub(crate) fn fill(mask: &VoidMask, rows: u32, heights_m: &mut [f32]) {
    let holes = Holes { mask, columns: mask.columns() as usize, rows: rows as usize };
    let first = holes.push(heights_m);
    holes.pull(&first, heights_m);
    holes.clamp(heights_m);
    for sweep in 0..SWEEPS {
        // There and back, so that neither direction is favoured.
        match sweep % 2 {
            0 => mask.indices().for_each(|index| holes.relax(index, heights_m)),
            _ => mask.indices().rev().for_each(|index| holes.relax(index, heights_m)),
        }
    }
}

struct Holes<'a> {
    mask: &'a VoidMask,
    columns: usize,
    rows: usize,
}

impl Holes<'_> {
    /// The up to four neighbours of a sample.
    fn neighbours(&self, index: usize) -> impl Iterator<Item = usize> + use<> {
        let (column, row, columns) = (index % self.columns, index / self.columns, self.columns);
        [
            (row > 0).then(|| index - columns),
            (column > 0).then(|| index - 1),
            (column + 1 < columns).then(|| index + 1),
            (row + 1 < self.rows).then(|| index + columns),
        ]
        .into_iter()
        .flatten()
    }

    fn is_rim(&self, index: usize) -> bool {
        !self.mask.has(index) && self.neighbours(index).any(|neighbour| self.mask.has(neighbour))
    }

    /// The first level over the samples: means of the rim samples among each 2 x 2.
    fn push(&self, heights_m: &[f32]) -> Level {
        Level::over(self.columns, self.rows, |column, row| {
            let index = row * self.columns + column;
            self.is_rim(index).then(|| [heights_m[index], 1.0])
        })
    }

    fn pull(&self, first: &Level, heights_m: &mut [f32]) {
        let first = first.completed();
        for index in self.mask.indices() {
            heights_m[index] = first.between(index % self.columns, index / self.columns);
        }
    }

    /// Brings each hole's fill into the range of its own rim: the pyramid's means reach over to other holes.
    fn clamp(&self, heights_m: &mut [f32]) {
        let mut left = Left::all(self.mask);
        for start in self.mask.indices() {
            if left.has(start) {
                let (hole, [low, high]) = self.hole(start, &mut left, heights_m);
                hole.into_iter().for_each(|index| {
                    let height_m = &mut heights_m[index as usize];
                    *height_m = height_m.clamp(low, high);
                });
            }
        }
    }

    /// The samples of one hole, taken from `left`, and the range of its rim.
    fn hole(&self, start: usize, left: &mut Left, heights_m: &[f32]) -> (Vec<u32>, [f32; 2]) {
        let (mut hole, mut next, mut range) = (vec![start as u32], 0, [f32::INFINITY, f32::NEG_INFINITY]);
        left.clear(start);
        while let Some(&index) = hole.get(next) {
            next += 1;
            for neighbour in self.neighbours(index as usize) {
                if left.has(neighbour) {
                    left.clear(neighbour);
                    hole.push(neighbour as u32);
                } else if !self.mask.has(neighbour) {
                    range = [range[0].min(heights_m[neighbour]), range[1].max(heights_m[neighbour])];
                }
            }
        }
        (hole, range)
    }

    /// One step towards the membrane: the mean of the neighbours, never out of their range.
    fn relax(&self, index: usize, heights_m: &mut [f32]) {
        let (mut sum, mut count) = (0.0, 0.0);
        for neighbour in self.neighbours(index) {
            sum += heights_m[neighbour] as f64;
            count += 1.0;
        }
        heights_m[index] = (sum / count) as f32;
    }
}

/// The voids that belong to no hole yet.
struct Left(Vec<u64>);

impl Left {
    fn all(mask: &VoidMask) -> Self {
        Self(mask.words().to_vec())
    }

    fn has(&self, index: usize) -> bool {
        self.0[index / 64] >> (index % 64) & 1 == 1
    }

    fn clear(&mut self, index: usize) {
        self.0[index / 64] &= !(1 << (index % 64));
    }
}

/// One level of the pyramid: for each 2 x 2 of the level below a mean, and how much is known of it, 0 to 1.
struct Level {
    columns: usize,
    rows: usize,
    cells: Vec<[f32; 2]>,
}

impl Level {
    /// Over a grid of `columns` x `rows` means and weights.
    fn over(columns: usize, rows: usize, below: impl Fn(usize, usize) -> Option<[f32; 2]>) -> Self {
        let mut level = Self { columns: columns.div_ceil(2), rows: rows.div_ceil(2), cells: Vec::new() };
        level.cells.reserve_exact(level.columns * level.rows);
        for row in 0..level.rows {
            for column in 0..level.columns {
                let (mut sum, mut weight) = (0.0, 0.0);
                for (dx, dz) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let (c, r) = (2 * column + dx, 2 * row + dz);
                    if c < columns
                        && r < rows
                        && let Some([mean, w]) = below(c, r)
                    {
                        sum += mean as f64 * w as f64;
                        weight += w as f64;
                    }
                }
                let mean = if weight > 0.0 { sum / weight } else { 0.0 };
                level.cells.push([mean as f32, weight.min(1.0) as f32]);
            }
        }
        level
    }

    /// The means, with what a cell does not know itself taken from the level above.
    fn completed(&self) -> Means {
        let own = |[mean, _]: &[f32; 2]| *mean;
        if self.cells.len() == 1 {
            return Means { columns: 1, rows: 1, cells: self.cells.iter().map(own).collect() };
        }
        let above = Self::over(self.columns, self.rows, |column, row| {
            Some(self.cells[row * self.columns + column]).filter(|[_, weight]| *weight > 0.0)
        });
        let above = above.completed();
        let complete = |(index, [mean, weight]): (usize, &[f32; 2])| {
            let guess = above.between(index % self.columns, index / self.columns) as f64;
            (*weight as f64 * *mean as f64 + (1.0 - *weight as f64) * guess) as f32
        };
        Means { columns: self.columns, rows: self.rows, cells: self.cells.iter().enumerate().map(complete).collect() }
    }
}

/// A level without gaps.
struct Means {
    columns: usize,
    rows: usize,
    cells: Vec<f32>,
}

impl Means {
    /// Bilinear at the middle of a cell of the level below, which lies a quarter off its parent's middle.
    fn between(&self, column: usize, row: usize) -> f32 {
        let (near, far) = (Self::pair(column, self.columns), Self::pair(row, self.rows));
        let at = |c: usize, r: usize| self.cells[r * self.columns + c] as f64;
        let along = |r: usize| 0.75 * at(near[0], r) + 0.25 * at(near[1], r);
        (0.75 * along(far[0]) + 0.25 * along(far[1])) as f32
    }

    /// The parent, and its neighbour on the child's side.
    fn pair(child: usize, count: usize) -> [usize; 2] {
        let parent = child / 2;
        let neighbour = if child.is_multiple_of(2) { parent.saturating_sub(1) } else { (parent + 1).min(count - 1) };
        [parent, neighbour]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain_core::SplitMix64;

    const NAN: f32 = f32::NAN;

    fn filled(columns: u32, mut heights_m: Vec<f32>) -> Vec<f32> {
        let mask = VoidMask::of(columns, &heights_m);
        let rows = heights_m.len() as u32 / columns;
        fill(&mask, rows, &mut heights_m);
        heights_m
    }

    #[test]
    fn one_void_is_the_mean_of_its_neighbours() {
        #[rustfmt::skip]
        let heights_m = vec![
            0.0, 1.0, 0.0,
            2.0, NAN, 3.0,
            9.0, 4.0, 9.0,
        ];
        assert_eq!(filled(3, heights_m)[4], 2.5);
    }

    #[test]
    fn only_voids_are_marked_and_filled() {
        assert_eq!(VoidMask::of(2, &[1.0, -0.0, 3.0, 4.0]).count(), 0);
        let mask = VoidMask::of(2, &[1.0, NAN, 3.0, 4.0]);
        assert!(mask.count() == 1 && mask.is_void(1, 0) && !mask.is_void(0, 1));
        assert_eq!(filled(2, vec![1.0, NAN, 3.0, 3.0]), [1.0, 2.0, 3.0, 3.0]);
    }

    /// A single sample fills all: there is no other rim.
    #[test]
    fn all_but_one() {
        let mut heights_m = vec![NAN; 37 * 21];
        heights_m[400] = 7.5;
        assert!(filled(37, heights_m).iter().all(|height_m| *height_m == 7.5));
    }

    #[test]
    fn a_hole_in_a_slope_is_filled_with_the_slope() {
        let (columns, rows) = (90, 70);
        let slope = |column: usize, row: usize| 10.0 * column as f32 + 3.0 * row as f32;
        let in_hole = |column: usize, row: usize| column.abs_diff(45).pow(2) + row.abs_diff(35).pow(2) < 25 * 25;
        let at = |i: usize| (i % columns, i / columns);
        let value = |i| if in_hole(at(i).0, at(i).1) { NAN } else { slope(at(i).0, at(i).1) };
        let heights_m = filled(columns as u32, (0..columns * rows).map(value).collect());
        // The slope rises by about 500 m across the hole.
        let worst = heights_m.iter().enumerate().map(|(i, h)| (h - slope(at(i).0, at(i).1)).abs()).fold(0.0, f32::max);
        assert!(worst < 60.0, "{worst}");
    }

    /// The range of each void's rim, passed on from neighbour to neighbour until nothing changes.
    fn rim_ranges(heights_m: &[f32], columns: usize) -> Vec<[f32; 2]> {
        let mut ranges = vec![[f32::INFINITY, f32::NEG_INFINITY]; heights_m.len()];
        loop {
            let before = ranges.clone();
            for index in (0..heights_m.len()).filter(|index| heights_m[*index].is_nan()) {
                let beside = |other: usize| other / columns == index / columns;
                let around = [index.wrapping_sub(columns), index + columns];
                let around =
                    around.into_iter().chain([index.wrapping_sub(1), index + 1].into_iter().filter(|i| beside(*i)));
                for other in around.filter(|other| *other < heights_m.len()) {
                    let height_m = heights_m[other];
                    let [low, high] = if height_m.is_nan() { ranges[other] } else { [height_m; 2] };
                    ranges[index] = [ranges[index][0].min(low), ranges[index][1].max(high)];
                }
            }
            if ranges == before {
                return ranges;
            }
        }
    }

    /// Random holes of all sizes: fills stay within their own hole's rim, and samples stay what they were.
    #[test]
    fn fills_keep_to_the_range_of_their_own_rim() {
        for seed in 0..60 {
            let mut random = SplitMix64::new(seed);
            let (columns, rows) = (2 + random.next_u64() as usize % 60, 2 + random.next_u64() as usize % 60);
            let share = random.next_u64() % 100;
            let mut heights_m: Vec<f32> =
                (0..columns * rows).map(|_| (random.next_u64() % 4000) as f32 - 400.0).collect();
            // The first stays, so that not all are voids.
            for height_m in &mut heights_m[1..] {
                if random.next_u64() % 100 < share {
                    *height_m = NAN;
                }
            }
            let mask = VoidMask::of(columns as u32, &heights_m);
            let full = filled(columns as u32, heights_m.clone());
            assert_eq!(full, filled(columns as u32, heights_m.clone()), "seed {seed}");
            let ranges = rim_ranges(&heights_m, columns);
            for (index, (height_m, [low, high])) in full.iter().zip(ranges).enumerate() {
                let expected = if mask.has(index) { low..=high } else { heights_m[index]..=heights_m[index] };
                assert!(expected.contains(height_m), "seed {seed}: {height_m} at {index}, {expected:?}");
            }
        }
    }
}
