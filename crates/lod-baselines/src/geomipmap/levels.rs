//! The level of each block in one view.

use terrain_core::View;

use super::blocks::Blocks;
use super::lists::{LEVELS, Side};

/// Levels of all blocks.
#[derive(Default)]
pub(crate) struct Levels {
    levels: Vec<usize>,
    /// What the tolerance allows at each block's nearest point, in metres.
    allowed_m: Vec<f64>,
    /// Blocks whose neighbours are to be looked at, kept for its memory.
    unsettled: Vec<usize>,
}

impl Levels {
    /// The coarsest levels whose errors are allowed, then finer ones where neighbours need them.
    pub fn choose(&mut self, blocks: &Blocks, view: &View, tolerance_px: f64) {
        let allowed_m = |bounds| view.metres(tolerance_px, view.distance_m(bounds));
        self.allowed_m.clear();
        self.allowed_m.extend(blocks.blocks.iter().map(|block| allowed_m(&block.bounds_world)));
        let coarsest = |errors_m: &[f32; LEVELS], allowed_m: f64| {
            (1..LEVELS).take_while(|level| errors_m[*level] as f64 <= allowed_m).last().unwrap_or(0)
        };
        self.levels.clear();
        let wishes = blocks.blocks.iter().zip(&self.allowed_m);
        self.levels.extend(wishes.map(|(block, allowed_m)| coarsest(&block.errors_m, *allowed_m)));
        self.settle(blocks);
    }

    /// Makes blocks finer until each has neighbours that it may meet. Levels only fall, and the finer a block, the
    /// finer its neighbours must be; so the result is the coarsest that there is, in whatever order blocks are visited.
    fn settle(&mut self, blocks: &Blocks) {
        self.unsettled.clear();
        self.unsettled.extend(0..blocks.blocks.len());
        while let Some(block) = self.unsettled.pop() {
            for side in Side::ALL {
                let Some(neighbour) = blocks.neighbour(block, side) else { continue };
                let coarsest = self.coarsest_neighbour(blocks, block, side);
                if self.levels[neighbour] > coarsest {
                    self.levels[neighbour] = coarsest;
                    self.unsettled.push(neighbour);
                }
            }
        }
    }

    /// One level coarser where the joined strip's error is allowed, else the same.
    fn coarsest_neighbour(&self, blocks: &Blocks, block: usize, side: Side) -> usize {
        let level = self.levels[block];
        let joined_m = blocks.blocks[block].joined_m[level][side as usize];
        level + (joined_m as f64 <= self.allowed_m[block]) as usize
    }

    /// The level of a block, and the set of its sides beyond which the neighbour is coarser.
    pub fn of(&self, blocks: &Blocks, block: usize) -> (usize, usize) {
        let level = self.levels[block];
        let is_joined = |side: &&Side| blocks.neighbour(block, **side).is_some_and(|other| self.levels[other] > level);
        (level, Side::ALL.iter().filter(is_joined).map(|side| side.bit()).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain_core::{Heightmap, SplitMix64, walk::RandomWalk};

    /// Smooth in the west, rough in the east.
    fn dem() -> Heightmap {
        let mut random = SplitMix64::new(4);
        let heights = (0..300 * 200).map(|i| random.range(0.0, 40.0).powi(2) as f32 * (i % 300) as f32 / 9e3).collect();
        Heightmap::new(300, 200, [10.0, 10.0], heights).unwrap()
    }

    #[test]
    fn no_block_could_be_coarser_and_none_breaks_a_rule() {
        let dem = dem();
        let blocks = Blocks::new(&dem);
        let mut levels = Levels::default();
        let (mut forced, mut joined) = (0, 0);
        for (frame, view) in RandomWalk::new(3, &dem).take(200).enumerate() {
            levels.choose(&blocks, &view, 2.0);
            let breaks = |levels: &Levels, block: usize, level: usize| {
                let too_far = blocks.blocks[block].errors_m[level] as f64 > levels.allowed_m[block];
                let mut near = Side::ALL.iter().filter_map(|side| Some((*side, blocks.neighbour(block, *side)?)));
                let opposite = |side: Side| Side::ALL[(side as usize + 2) % 4];
                too_far || near.any(|(side, other)| level > levels.coarsest_neighbour(&blocks, other, opposite(side)))
            };
            for block in 0..blocks.blocks.len() {
                let (level, sides) = levels.of(&blocks, block);
                assert!(!breaks(&levels, block, level), "frame {frame}, block {block}");
                joined += sides.count_ones();
                if level + 1 < LEVELS && blocks.blocks[block].errors_m[level + 1] as f64 <= levels.allowed_m[block] {
                    assert!(breaks(&levels, block, level + 1), "frame {frame}, block {block} could be coarser");
                    forced += 1;
                }
            }
        }
        assert!(forced > 100 && joined > 1_000, "{forced} forced, {joined} joined");
    }
}
