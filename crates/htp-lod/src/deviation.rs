//! How far a triangle is from the DEM: the largest vertical distance, over every sample that it covers.
//!
//! Which samples a triangle covers is decided in integers, its border included. The height above a sample is an
//! integer combination of the corners' heights over the doubled area, which leaves the rounding of a few f64 sums.

use terrain_core::{Heightmap, Sample};

/// In metres; 0 for a triangle without area, whichever way round its corners run.
pub(crate) fn deviation_m(heightmap: &Heightmap, corners: [Sample; 3]) -> f64 {
    let [a, b, c] = corners.map(|sample| [sample.column as i64, sample.row as i64]);
    let doubled_area = doubled_area(a, b, c);
    if doubled_area == 0 {
        return 0.0;
    }
    let turned = doubled_area.signum();
    let edges = [(b, c), (c, a), (a, b)].map(|(from, to)| Edge::new(from, to, turned));
    let heights_m = corners.map(|sample| heightmap.height_m(sample) as f64);
    let [low, high] = [[0, 1].map(|i| a[i].min(b[i]).min(c[i])), [0, 1].map(|i| a[i].max(b[i]).max(c[i]))];
    // Times the doubled area, to divide once.
    let scale = doubled_area.abs() as f64;
    let mut largest = 0.0_f64;
    for row in low[1]..=high[1] {
        let start = heightmap.index(Sample { column: low[0] as u32, row: row as u32 }) as usize;
        let samples = &heightmap.heights_m()[start..=start + (high[0] - low[0]) as usize];
        let mut weights = edges.each_ref().map(|edge| edge.weight([low[0], row]));
        for sample_m in samples {
            if weights[0] | weights[1] | weights[2] >= 0 {
                let mesh: f64 = (0..3).map(|i| weights[i] as f64 * heights_m[i]).sum();
                largest = largest.max((mesh - *sample_m as f64 * scale).abs());
            }
            (0..3).for_each(|i| weights[i] += edges[i].column_step);
        }
    }
    largest / scale
}

/// Of a triangle: the doubled area between it and a sample is that sample's weight for the corner opposite, negative
/// beyond the edge.
struct Edge {
    from: [i64; 2],
    to: [i64; 2],
    /// 1 or -1: makes weights positive inside.
    turned: i64,
    /// What a weight gains by one column.
    column_step: i64,
}

impl Edge {
    fn new(from: [i64; 2], to: [i64; 2], turned: i64) -> Self {
        Self { from, to, turned, column_step: (to[1] - from[1]) * turned }
    }

    fn weight(&self, at: [i64; 2]) -> i64 {
        doubled_area(self.from, self.to, at) * self.turned
    }
}

/// Positive where the corners run counter-clockwise seen from above.
fn doubled_area(a: [i64; 2], b: [i64; 2], c: [i64; 2]) -> i64 {
    (c[0] - a[0]) * (b[1] - a[1]) - (b[0] - a[0]) * (c[1] - a[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain_core::SplitMix64;
    use terrain_core::Triangle;
    use terrain_core::error::ErrorOracle;

    #[test]
    fn agrees_with_the_error_oracle() {
        let mut random = SplitMix64::new(4);
        let heights = (0..17 * 13).map(|_| random.range(-500.0, 4000.0) as f32).collect();
        let heightmap = Heightmap::new(17, 13, [1.0; 2], heights).unwrap();
        let mut oracle = ErrorOracle::new(&heightmap);
        let mut flat = 0;
        for _ in 0..2_000 {
            let samples = [(); 3].map(|_| Sample { column: random.below(17) as u32, row: random.below(13) as u32 });
            let triangle = Triangle { samples, heights_m: samples.map(|sample| heightmap.height_m(sample)) };
            if triangle.doubled_area() == 0 {
                assert_eq!(deviation_m(&heightmap, samples), 0.0);
                flat += 1;
                continue;
            }
            oracle.set_mesh(&[triangle]);
            let covered = oracle.deviations_m().filter(|deviation_m| !deviation_m.is_nan());
            let expected = covered.fold(0.0, f32::max) as f64;
            assert!((deviation_m(&heightmap, samples) - expected).abs() <= 1e-6 * (1.0 + expected), "{samples:?}");
        }
        assert!(flat < 200);
    }
}
