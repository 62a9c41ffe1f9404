//! Exact places on the grid: samples, and where a triangle's sides cross the lines between quads.

use terrain_core::Sample;

/// A place at column `x / w` and row `z / w`, in lowest terms. Column or row is whole wherever sides cross lines, so that the
/// numbers stay far below 64 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Place {
    x: i64,
    z: i64,
    w: i64,
}

/// Across columns or rows.
#[derive(Clone, Copy, Debug)]
pub enum Axis {
    Column,
    Row,
}

impl From<Sample> for Place {
    fn from(sample: Sample) -> Self {
        Self { x: sample.column.into(), z: sample.row.into(), w: 1 }
    }
}

impl Place {
    /// Column and row.
    pub fn at(self) -> [f64; 2] {
        [self.x as f64 / self.w as f64, self.z as f64 / self.w as f64]
    }

    /// The sample here, or the nearest one.
    pub fn nearest(self) -> Sample {
        let [column, row] = self.at().map(|at| at.round() as u32);
        Sample { column, row }
    }

    /// The sample here, if there is one.
    pub fn sample(self) -> Option<Sample> {
        (self.w == 1).then(|| self.nearest())
    }

    /// How far it lies beyond a line between quads, times `w`.
    pub fn beyond(self, axis: Axis, line: u32) -> i64 {
        let along = match axis {
            Axis::Column => self.x,
            Axis::Row => self.z,
        };
        along - i64::from(line) * self.w
    }

    /// Where the way to another place crosses a line that parts the two.
    pub fn crossing(self, other: Self, axis: Axis, line: u32) -> Self {
        let [here, there] = [self, other].map(|place| i128::from(place.beyond(axis, line).abs()));
        let between = |a: i64, b: i64| i128::from(a) * there + i128::from(b) * here;
        let [x, z, w] = [between(self.x, other.x), between(self.z, other.z), between(self.w, other.w)];
        let divisor = greatest_divisor(greatest_divisor(x, z), w);
        let [x, z, w] = [x, z, w].map(|n| i64::try_from(n / divisor).expect("sides that cross lines between quads"));
        Self { x, z, w }
    }
}

fn greatest_divisor(mut a: i128, mut b: i128) -> i128 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a.max(1)
}

/// As [`Triangle::doubled_area`](terrain_core::Triangle::doubled_area), times all three `w`: its sign is that of the turn.
pub fn turn([a, b, c]: [Place; 3]) -> i128 {
    let [a, b, c] = [a, b, c].map(|place| [place.x, place.z, place.w].map(i128::from));
    a[0] * (b[2] * c[1] - b[1] * c[2]) + a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[1] * c[0] - b[0] * c[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(column: u32, row: u32) -> Place {
        Place::from(Sample { column, row })
    }

    #[test]
    fn crossings_are_exact_whichever_way_one_goes() {
        let [a, b] = [place(1, 2), place(8, 4)];
        let crossing = a.crossing(b, Axis::Column, 3);
        assert_eq!(crossing, Place { x: 21, z: 18, w: 7 });
        assert_eq!(b.crossing(a, Axis::Column, 3), crossing);
        assert_eq!(a.crossing(b, Axis::Row, 3), Place { x: 9, z: 6, w: 2 });
        assert_eq!(place(0, 0).crossing(place(4, 4), Axis::Row, 3).sample(), Some(Sample { column: 3, row: 3 }));
        assert_eq!((turn([a, crossing, b]), crossing.sample(), crossing.nearest().row), (0, None, 3));
        let far = place(0, 0).crossing(place(65_534, 65_533), Axis::Column, 32_768);
        assert_eq!(far.crossing(place(65_534, 0), Axis::Row, 1).beyond(Axis::Row, 1), 0);
    }

    #[test]
    fn turns_have_the_sign_of_areas() {
        let corners = [[0, 0], [0, 3], [4, 0]].map(|[column, row]| Sample { column, row });
        let area = terrain_core::Triangle { samples: corners, heights_m: [0.0; 3] }.doubled_area();
        assert_eq!((turn(corners.map(Place::from)), area), (12, 12));
    }
}
