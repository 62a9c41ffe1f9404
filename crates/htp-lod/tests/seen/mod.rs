//! What a walk has tried: a contract that is kept with one level and one index list proves little.

use htp_lod::{Batching, Htp, Options};
use std::collections::BTreeSet;
use std::sync::Arc;
use terrain_core::walk::RandomWalk;
use terrain_core::{FramePlan, Heightmap, LodMethod};

/// The plain list and the six matching blocks that can be drawn.
pub const ALL_LISTS: usize = 7;

/// Without those that collapse the hypotenuse. Both halves of a square are at the same distance and are split
/// together; just one of them is split where the restriction asks for it, and it asks only where a ring of one level
/// is narrower than a patch: with more than two layers, and with legs of hundreds of pixels.
pub const LISTS_BY_DISTANCE: usize = 4;

/// How many levels and how many index lists are in sight in the walk of `contract::check` with this seed. Both
/// batchings draw the same patches; as published, the tag of each draw holds the level.
pub fn levels_and_lists(heightmap: &Arc<Heightmap>, options: Options, seed: u64, frames: u32) -> [usize; 2] {
    let mut htp = Htp::new(heightmap.clone(), Options { batching: Batching::PerPatch, ..options }).unwrap();
    let mut plan = FramePlan::default();
    let (mut levels, mut lists) = (BTreeSet::new(), BTreeSet::new());
    for view in RandomWalk::new(seed, heightmap).take(frames as usize) {
        htp.plan(&view, &mut plan);
        levels.extend(plan.draws.iter().map(|draw| draw.instances.start & 15));
        lists.extend(plan.draws.iter().map(|draw| draw.indices.start));
    }
    [levels.len(), lists.len()]
}
