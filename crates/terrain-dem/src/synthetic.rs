//! Seeded terrain of any size: ridges, valleys, and a flat lake. The same on every machine, bit for bit.
//!
//! Gradient noise (Perlin, "Improving noise", SIGGRAPH 2002) summed as a ridged multifractal (Musgrave, in Ebert et
//! al., "Texturing and Modeling", 3rd edition, chapter 16). Only integer hashing and `+ - * / floor sqrt` in f64, which
//! IEEE 754 rounds in one way: no sine and no power, which differ between systems.
//!
//! Beside the mountains ([`Kind::Ridged`], what `synthetic:` names) there are kinds of ground that are easy or hard for a
//! terrain method (`kinds`).
//!
//! Features are sized in samples, and a sample depends on its own place alone: a smaller terrain is the north-western
//! corner of a larger one of the same seed.

mod kinds;

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use terrain_core::{Heightmap, SplitMix64};

use crate::MAX_SAMPLES;

pub use kinds::Kind;

/// How a synthetic terrain's name starts.
pub const PREFIX: &str = "synthetic:";

/// Metres between samples, in x and in z.
pub const SPACING_M: f64 = 30.0;

/// Height of the lakes' surface in metres: all that would lie lower is flooded.
pub const LAKE_M: f64 = 60.0;

/// Height of the highest possible summit in metres.
const SUMMIT_M: f64 = 2600.0;

/// Wavelength of the mountains in samples; every octave halves it.
const MOUNTAIN_SAMPLES: f64 = 256.0;
const OCTAVES: u64 = 8;

/// Wavelength of the valleys' courses in samples.
const VALLEY_SAMPLES: f64 = 420.0;

/// Wavelength of the bays of the lake that even a small terrain has, in samples.
const SHORE_SAMPLES: f64 = 32.0;
/// Its middle, in samples.
const LAKE_CENTRE: [f64; 2] = [24.0, 18.0];
/// Wholly sunk within the first radius, untouched beyond the second, in samples.
const LAKE_RADII: [f64; 2] = [5.0, 40.0];

/// The layers of noise beside the mountains' octaves.
const VALLEY: u64 = OCTAVES;
const FLOOR: u64 = OCTAVES + 1;
const SHORE: u64 = OCTAVES + 2;

/// Makes a terrain with [`SPACING_M`] between samples. Panics if a side is not 2 to [`Heightmap::MAX_SIDE`].
pub fn generate(columns: u32, rows: u32, seed: u64) -> Heightmap {
    let mut heights_m = vec![0.0; columns as usize * rows as usize];
    for (row, row_m) in heights_m.chunks_mut(columns as usize).enumerate() {
        Kind::Ridged.fill_row(seed, row as u32, row_m);
    }
    Heightmap::new(columns, rows, [SPACING_M; 2], heights_m).expect("a size that a heightmap can have")
}

/// Columns, rows and seed of `synthetic:COLUMNSxROWS:SEED`; `None` if it is not written so, or of no possible size.
pub(crate) fn parse(spec: &str) -> Option<(u32, u32, u64)> {
    let (size, seed) = spec.strip_prefix(PREFIX)?.split_once(':')?;
    let (columns, rows) = size.split_once('x')?;
    let (columns, rows): (u32, u32) = (columns.parse().ok()?, rows.parse().ok()?);
    let side = 2..=Heightmap::MAX_SIDE;
    let possible = side.contains(&columns) && side.contains(&rows) && columns as u64 * rows as u64 <= MAX_SAMPLES;
    possible.then_some((columns, rows, seed.parse().ok()?))
}

/// Ridges, valleys and lakes.
fn height_m(seed: u64, x: f64, z: f64) -> f64 {
    let relief = 0.92 * ridges(seed, x, z) * valley(seed, x, z) + valley_floor(seed, x, z);
    (relief * basin(seed, x, z) * SUMMIT_M).max(LAKE_M)
}

/// 0 to 1: sharp crests where the noise crosses zero. Each octave is weighted by the one before, so that valleys stay
/// smooth while crests get rough.
fn ridges(seed: u64, x: f64, z: f64) -> f64 {
    let (mut sum, mut total, mut amplitude, mut weight) = (0.0, 0.0, 1.0, 1.0);
    let mut samples = MOUNTAIN_SAMPLES;
    for octave in 0..OCTAVES {
        let crest = 1.0 - noise(seed, octave, x / samples, z / samples).abs();
        let crest = crest * crest * weight;
        sum += crest * amplitude;
        total += amplitude;
        weight = (crest * 1.6).clamp(0.0, 1.0);
        amplitude *= 0.45;
        samples *= 0.5;
    }
    sum / total
}

/// 1 on the land between the winding courses of valleys, little along them: hills.
fn valley(seed: u64, x: f64, z: f64) -> f64 {
    mix(0.12, 1.0, smooth(noise(seed, VALLEY, x / VALLEY_SAMPLES, z / VALLEY_SAMPLES).abs() / 0.35))
}

/// Up and down along the valleys: their low stretches are flooded.
fn valley_floor(seed: u64, x: f64, z: f64) -> f64 {
    0.06 * noise(seed, FLOOR, x / MOUNTAIN_SAMPLES, z / MOUNTAIN_SAMPLES)
}

/// 0 in the lake that every terrain has, 1 away from it.
fn basin(seed: u64, x: f64, z: f64) -> f64 {
    let (dx, dz) = (x - LAKE_CENTRE[0], z - LAKE_CENTRE[1]);
    let distance = (dx * dx + dz * dz).sqrt() * (1.0 + 0.25 * noise(seed, SHORE, x / SHORE_SAMPLES, z / SHORE_SAMPLES));
    let [sunk, untouched] = LAKE_RADII;
    smooth((distance - sunk) / (untouched - sunk))
}

/// 0 to 1 with level ends, clamped.
fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Gradient noise, -1 to 1. Every layer has its own lattice, shifted, because noise is 0 at all points of its lattice,
/// and turned by the angle of the 3-4-5 triangle, because it favours its lattice's axes.
fn noise(seed: u64, layer: u64, x: f64, z: f64) -> f64 {
    let key = SplitMix64::mix(seed ^ SplitMix64::mix(layer + 1));
    let shift = |bits: u64| (bits & 0xffff) as f64 / 65_536.0;
    let (x, z) = (0.8 * x - 0.6 * z + shift(key), 0.6 * x + 0.8 * z + shift(key >> 16));
    let (column, row) = (x.floor(), z.floor());
    let (u, v) = (x - column, z - row);
    let corner = |c: f64, r: f64| {
        let [column, row] = [column + c, row + r].map(|line| line as i64 as u32 as u64);
        slope(SplitMix64::mix(key ^ SplitMix64::mix(column << 32 | row)), u - c, v - r)
    };
    let (fade_u, fade_v) = (fade(u), fade(v));
    let north = mix(corner(0.0, 0.0), corner(1.0, 0.0), fade_u);
    let south = mix(corner(0.0, 1.0), corner(1.0, 1.0), fade_u);
    mix(north, south, fade_v) * SQRT_2
}

/// Height at (dx, dz) on a plane through 0 that rises along one of eight directions.
fn slope(hash: u64, dx: f64, dz: f64) -> f64 {
    const D: f64 = FRAC_1_SQRT_2;
    const DIRECTIONS: [[f64; 2]; 8] =
        [[1.0, 0.0], [D, D], [0.0, 1.0], [-D, D], [-1.0, 0.0], [-D, -D], [0.0, -1.0], [D, -D]];
    let [x, z] = DIRECTIONS[(hash >> 61) as usize];
    x * dx + z * dz
}

fn fade(t: f64) -> f64 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

fn mix(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain_core::Sample;

    fn checksum(heightmap: &Heightmap) -> u64 {
        heightmap.heights_m().iter().fold(0, |sum, height_m| SplitMix64::mix(sum ^ height_m.to_bits() as u64))
    }

    #[test]
    fn heights_never_change() {
        assert_eq!(checksum(&generate(64, 48, 1)), 5_685_894_252_867_146_658);
        assert_eq!(checksum(&generate(193, 250, 7)), 11_604_691_203_497_210_257);
    }

    #[test]
    fn a_smaller_terrain_is_a_corner_of_a_larger_one() {
        let (small, large) = (generate(20, 30, 5), generate(60, 50, 5));
        for row in 0..30 {
            for column in 0..20 {
                let at = Sample { column, row };
                assert_eq!(small.height_m(at), large.height_m(at));
            }
        }
    }

    #[test]
    fn every_seed_has_a_flat_lake_and_high_ground() {
        for seed in 0..20 {
            let terrain = generate(64, 48, seed);
            let lake = terrain.heights_m().iter().filter(|height_m| **height_m == LAKE_M as f32).count();
            assert!((80..64 * 48 * 3 / 4).contains(&lake), "seed {seed}: {lake} samples of lake");
            assert!(terrain.heights_m().iter().any(|height_m| *height_m > LAKE_M as f32 + 100.0), "seed {seed}");
        }
    }

    #[test]
    fn large_terrains_use_the_whole_range_of_heights() {
        let terrain = generate(800, 800, 3);
        let range = terrain.height_range_m(Sample { column: 0, row: 0 }, Sample { column: 799, row: 799 });
        assert!(range[0] == LAKE_M as f32 && (1800.0..=2600.0).contains(&range[1]), "{range:?}");
    }

    #[test]
    fn specs() {
        assert_eq!(parse("synthetic:193x250:7"), Some((193, 250, 7)));
        for wrong in [
            "synthetic:",
            "synthetic:9:1",
            "synthetic:9x9",
            "synthetic:9x9:",
            "synthetic:1x9:1",
            "synthetic:65536x2:1",
            "synthetic:65535x65535:1",
            "synthetic:9x9:-1",
            "synthetic:9x9:1:1",
        ] {
            assert_eq!(parse(wrong), None, "{wrong}");
        }
    }
}
