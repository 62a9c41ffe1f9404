//! The range of many heights, and whether all of them are numbers, as fast as memory gives them.

use std::array::from_fn;

use glam::Vec4;

/// What tells whether heights are heights. By vectors, which glam compares with one instruction: whether the compiler makes such
/// instructions of loops over lanes depends on lines far away.
pub struct Extremes {
    low: Vec4,
    high: Vec4,
    /// NaN once a height is; heights up to 1e30 make it nothing else.
    sum: Vec4,
}

impl Extremes {
    pub fn of(heights_m: &[f32]) -> Self {
        let mut extremes = Self { low: Vec4::INFINITY, high: Vec4::NEG_INFINITY, sum: Vec4::ZERO };
        let (sixteens, rest) = heights_m.as_chunks();
        sixteens.iter().for_each(|sixteen| extremes.add(sixteen));
        if let Some(last) = rest.last() {
            // One of them again changes nothing that is asked for.
            extremes.add(&from_fn(|i| *rest.get(i).unwrap_or(last)));
        }
        extremes
    }

    /// Pairs first, so that no instruction waits long for the one before.
    fn add(&mut self, heights_m: &[f32; 16]) {
        let [a, b, c, d] = from_fn(|i| Vec4::from_slice(&heights_m[4 * i..]));
        self.low = self.low.min(a.min(b).min(c.min(d)));
        self.high = self.high.max(a.max(b).max(c.max(d)));
        self.sum += (a + b) + (c + d);
    }

    /// The lowest and the highest, if none [is NaN](Self::has_nan), which would hide others.
    pub fn range_m(&self) -> [f32; 2] {
        [self.low.min_element(), self.high.max_element()]
    }

    pub fn has_nan(&self) -> bool {
        self.sum.is_nan()
    }
}

/// The lowest and the highest of heights of which some may be NaN.
pub fn range_m(heights_m: &[f32]) -> [f32; 2] {
    let extremes = Extremes::of(heights_m);
    if !extremes.has_nan() {
        return extremes.range_m();
    }
    // Whatever NaN is compared with, `min` and `max` take the other.
    let wider = |[low, high]: [f32; 2], height_m: &f32| [low.min(*height_m), high.max(*height_m)];
    heights_m.iter().fold([f32::INFINITY, f32::NEG_INFINITY], wider)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against heights one by one: any count, NaN and infinities anywhere.
    #[test]
    fn extremes_are_those_of_heights_one_by_one() {
        let seed = 7;
        println!("seed {seed}");
        let mut state: u32 = seed;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 8
        };
        for round in 0..4000 {
            let count = next() % 70;
            let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30, -0.0];
            let heights_m: Vec<f32> = (0..count)
                .map(|_| match next() % 64 {
                    pick if round % 2 == 0 && pick < 6 => odd[pick as usize],
                    _ => next() as f32 - 8e6,
                })
                .collect();
            let numbers = || heights_m.iter().copied().filter(|height_m| !height_m.is_nan());
            let expected = [numbers().fold(f32::INFINITY, f32::min), numbers().fold(f32::NEG_INFINITY, f32::max)];
            assert_eq!(range_m(&heights_m), expected, "{heights_m:?}");
            let (extremes, is_finite) =
                (Extremes::of(&heights_m), heights_m.iter().all(|height_m| height_m.is_finite()));
            if is_finite {
                assert!(!extremes.has_nan() && extremes.range_m() == expected, "{heights_m:?}");
            }
            assert!(extremes.has_nan() || numbers().count() == heights_m.len(), "{heights_m:?}");
        }
    }
}
