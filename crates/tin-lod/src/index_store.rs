//! Where in the index buffer the triangles of each node are.
//!
//! ```text
//!   fixed    |p0 p0 p0 - - - - -|p1 p1 - - - - - -|p2 p2 p2 p2 - - - -|     room for a fully refined node each
//!   packed   |p0 p0 p0 -|p2 p2 p2 p2|p1 p1 -|          |p3 -|               rooms by need, free ranges between them
//! ```
//!
//! Fixed is the paper's (section 4). Packed gives a node that has outgrown its room the smallest free range that is
//! large enough, and the buffer grows by half where there is none.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use crate::nodes::NodeId;

/// Rooms are multiples of this many indices, so that most updates fit the room that their node has, and every room
/// starts at a multiple of 4 bytes.
const GRANULE: u32 = 96;

/// Rooms of all nodes, and how much of each is used. Ranges are in indices, not bytes.
pub(crate) struct Rooms {
    plan: FloorPlan,
    rooms: Vec<Room>,
}

#[derive(Clone, Copy, Default)]
struct Room {
    start: u32,
    /// A multiple of [`GRANULE`] in a packed buffer.
    size: u32,
    used: u32,
}

enum FloorPlan {
    Fixed,
    Packed(FreeRanges),
}

impl Rooms {
    /// These rooms. Nodes that are never in the mesh at once may share theirs.
    pub fn fixed(rooms: impl Iterator<Item = Range<u32>>) -> Self {
        let room = |Range { start, end }: Range<u32>| Room { start, size: end - start, used: 0 };
        Self { plan: FloorPlan::Fixed, rooms: rooms.map(room).collect() }
    }

    /// No rooms yet; nodes get theirs with their triangles.
    pub fn packed(nodes: usize) -> Self {
        Self { plan: FloorPlan::Packed(FreeRanges::default()), rooms: vec![Room::default(); nodes] }
    }

    /// Size of the index buffer.
    pub fn capacity(&self) -> u32 {
        match &self.plan {
            FloorPlan::Fixed => self.rooms.iter().map(|room| room.start + room.size).max().unwrap_or(0),
            FloorPlan::Packed(free) => free.capacity,
        }
    }

    /// The indices of a node.
    pub fn of(&self, node: NodeId) -> Range<u32> {
        let Room { start, used, .. } = self.rooms[node as usize];
        start..start + used
    }

    /// Room for new indices of a node, in place of those that it had.
    ///
    /// # Panics
    ///
    /// If a fixed room is too small.
    pub fn place(&mut self, node: NodeId, indices: u32) -> Range<u32> {
        let room = &mut self.rooms[node as usize];
        match &mut self.plan {
            FloorPlan::Fixed => assert!(indices <= room.size, "{indices} indices in a room of {}", room.size),
            FloorPlan::Packed(free) => {
                let size = indices.next_multiple_of(GRANULE);
                if size > room.size {
                    free.give(room.start..room.start + room.size);
                    room.start = free.take(size);
                } else {
                    free.give(room.start + size..room.start + room.size);
                }
                room.size = size;
            }
        }
        room.used = indices;
        self.of(node)
    }
}

/// What nobody uses of a packed buffer. Free ranges that touch are one.
#[derive(Default)]
struct FreeRanges {
    capacity: u32,
    /// Sizes by starts.
    by_start: BTreeMap<u32, u32>,
    /// Sizes and starts.
    by_size: BTreeSet<(u32, u32)>,
}

impl FreeRanges {
    /// Takes the start of the smallest range that is large enough, the first of equals. Grows where there is none.
    fn take(&mut self, size: u32) -> u32 {
        let Some(&(found, start)) = self.by_size.range((size, 0)..).next() else {
            self.grow(size);
            return self.take(size);
        };
        self.remove(start, found);
        self.give(start + size..start + found);
        start
    }

    fn give(&mut self, Range { mut start, mut end }: Range<u32>) {
        if start == end {
            return;
        }
        if let Some((&before, &size)) = self.by_start.range(..start).next_back()
            && before + size == start
        {
            self.remove(before, size);
            start = before;
        }
        if let Some(&size) = self.by_start.get(&end) {
            self.remove(end, size);
            end += size;
        }
        self.by_start.insert(start, end - start);
        self.by_size.insert((end - start, start));
    }

    fn remove(&mut self, start: u32, size: u32) {
        self.by_start.remove(&start);
        self.by_size.remove(&(size, start));
    }

    fn grow(&mut self, at_least: u32) {
        let end = self.capacity;
        let by_half = (self.capacity / 2).next_multiple_of(GRANULE);
        self.capacity = end.checked_add(by_half.max(at_least)).expect("an index buffer of at most 2^32 indices");
        self.give(end..self.capacity);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain_core::SplitMix64;

    #[test]
    fn rooms_never_overlap_and_nothing_is_lost() {
        for seed in 0..20 {
            let mut random = SplitMix64::new(seed);
            let mut rooms = Rooms::packed(50);
            for step in 0..2_000 {
                let (patch, indices) = (random.below(50) as u32, 3 * random.below(700) as u32);
                let placed = rooms.place(patch, indices);
                assert_eq!((placed.len() as u32, placed.start % GRANULE), (indices, 0), "seed {seed}, step {step}");
                let FloorPlan::Packed(free) = &rooms.plan else { unreachable!() };
                let mut all: Vec<(u32, u32)> = rooms.rooms.iter().map(|r| (r.start, r.size)).collect();
                all.extend(free.by_start.iter().map(|(start, size)| (*start, *size)));
                all.retain(|(_, size)| *size > 0);
                all.sort_unstable();
                let end = all.iter().fold(0, |end, (start, size)| {
                    assert_eq!(*start, end, "seed {seed}, step {step}: a gap or an overlap");
                    start + size
                });
                assert_eq!((end, free.by_size.len()), (rooms.capacity(), free.by_start.len()));
            }
            let used: u32 = (0..50).map(|patch| rooms.of(patch).len() as u32).sum();
            assert!(rooms.capacity() < 4 * used, "seed {seed}: {used} of {} used", rooms.capacity());
        }
    }

    #[test]
    fn a_patch_that_shrinks_and_grows_again_stays_where_it_is() {
        let mut rooms = Rooms::packed(2);
        assert_eq!(rooms.place(0, 600), 0..600);
        rooms.place(1, 600);
        assert_eq!(rooms.place(0, 30), 0..30);
        assert_eq!(rooms.place(0, 96), 0..96);
        assert_eq!(rooms.place(0, 600), 0..600, "the rest of the room touches it and is free again");
    }

    #[test]
    fn fixed_rooms_are_where_they_were() {
        let mut rooms = Rooms::fixed([0..384, 384..768, 768..1152, 0..768].into_iter());
        assert_eq!((rooms.place(1, 384), rooms.place(2, 6)), (384..768, 768..774));
        assert_eq!((rooms.of(0), rooms.of(1), rooms.capacity()), (0..0, 384..768, 1152));
        assert_eq!(rooms.place(3, 600), 0..600);
    }
}
