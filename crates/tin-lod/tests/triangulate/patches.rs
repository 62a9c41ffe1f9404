//! Patches to triangulate: random and structured masks of any size.

use terrain_core::SplitMix64;
use tin_lod::{Border, KeptSamples, Mask};

/// Owned kept samples. The patch lies somewhere inside a larger vertex buffer.
#[derive(Clone, Debug)]
pub struct Patch {
    pub width: u32,
    pub depth: u32,
    pub border: Border,
    pub interior: Vec<Mask>,
}

impl Patch {
    pub const FIRST_INDEX: u32 = 1_000_003;
    pub const ROW_STRIDE: u32 = 1009;

    /// Keeps the corners, and every other sample for which `keep` says so.
    pub fn new(width: u32, depth: u32, mut keep: impl FnMut(u32, u32) -> bool) -> Self {
        let mut row = |z| (1..width).fold(0, |mask: Mask, x| mask | (keep(x, z) as Mask) << x);
        let (north, south) = (row(0), row(depth));
        let interior = (1..depth).map(&mut row).collect();
        let mut side = |x| (1..depth).fold(0, |mask: Mask, z| mask | (keep(x, z) as Mask) << z);
        Self { width, depth, border: Border { north, south, west: side(0), east: side(width) }, interior }
    }

    pub fn kept(&self) -> KeptSamples<'_> {
        KeptSamples {
            width: self.width,
            depth: self.depth,
            border: self.border,
            interior: &self.interior,
            first_index: Self::FIRST_INDEX,
            row_stride: Self::ROW_STRIDE,
        }
    }

    /// One of many kinds of patches, as the seed has it.
    pub fn random(seed: u64, largest: u32) -> Self {
        let mut random = SplitMix64::new(seed);
        let mut side = || 1 + random.below(largest as u64) as u32;
        let (width, depth) = (side(), side());
        let density = [0.0, 0.01, 0.05, 0.2, 0.5, 0.8, 0.97, 1.0][random.below(8) as usize];
        let (step, shift) = (1 + random.below(9) as u32, random.below(9) as u32);
        let (centre, scale) = (random.below(width as u64 + 1) as i32, random.range(0.5, 40.0));
        let outline = |x, z| x == 0 || x == width || z == 0 || z == depth;
        let kind = random.below(10);
        let mut chance = |density: f64| random.range(0.0, 1.0) < density;
        Self::new(width, depth, |x, z| match kind {
            // Even density: from corners alone to all samples.
            0..=2 => chance(density),
            // A dense and an empty half, across or along.
            3 => chance(if x * 2 < width { density } else { 0.01 }),
            4 => chance(if z * 2 < depth { density } else { 0.01 }),
            // The outline alone, or with a dense inside.
            5 => outline(x, z) && chance(density),
            6 => outline(x, z) != chance(density),
            // A lattice, a checkerboard, stripes: many points on circles and lines.
            7 => x % step == 0 && (z + shift) % step == 0,
            8 => (x + z) % 2 == shift % 2 || chance(density * 0.1),
            // A bow: valleys and hills for the front.
            _ => (x as i32 - centre).pow(2) as f64 / scale - z as f64 * [1.0, -1.0][shift as usize % 2] < density,
        })
    }
}
