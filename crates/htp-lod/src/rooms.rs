//! Parts of one buffer for lists of changing length.
//!
//! ```text
//!  | room 0 | (left behind) | room 2 | room 1, twice as large as before |      elements
//! ```
//!
//! A list that outgrows its room gets one at the buffer's end. What it leaves behind is not used again: rooms at least
//! double, so that all that was left behind is smaller than the rooms in use.

/// The room of each list, in elements of the buffer.
pub(crate) struct Rooms {
    rooms: Vec<Room>,
    end: u32,
}

#[derive(Clone, Copy, Default)]
struct Room {
    start: u32,
    capacity: u32,
}

impl Rooms {
    /// So many lists without room.
    pub fn new(lists: usize) -> Self {
        Self { rooms: vec![Room::default(); lists], end: 0 }
    }

    /// Where a list begins.
    pub fn start(&self, list: usize) -> u32 {
        self.rooms[list].start
    }

    /// Elements up to the end of the last room.
    pub fn end(&self) -> u32 {
        self.end
    }

    /// Makes room for a list of that length. Returns whether the list has moved, so that all of it is to be written.
    pub fn reserve(&mut self, list: usize, length: u32) -> bool {
        let room = &mut self.rooms[list];
        if length <= room.capacity {
            return false;
        }
        let capacity = length.next_power_of_two().max(Self::SMALLEST);
        *room = Room { start: self.end, capacity };
        self.end = self.end.checked_add(capacity).expect("an index buffer of at most 2^32 indices");
        true
    }

    /// The first room of a list, in elements.
    const SMALLEST: u32 = 64;
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain_core::SplitMix64;

    #[test]
    fn rooms_are_apart_and_what_is_left_behind_is_less_than_what_is_used() {
        let (mut rooms, mut random, mut lengths) = (Rooms::new(5), SplitMix64::new(1), [0; 5]);
        for _ in 0..300 {
            let (list, bits) = (random.below(5) as usize, random.below(12));
            let length = 1 + random.below(1 << bits) as u32;
            let start = rooms.start(list);
            let moved = rooms.reserve(list, length);
            assert!(moved || start == rooms.start(list));
            lengths[list] = length.max(lengths[list]);
            let mut used: Vec<_> = rooms.rooms.iter().map(|room| (room.start, room.start + room.capacity)).collect();
            used.retain(|(start, end)| start < end);
            used.sort();
            assert!(used.windows(2).all(|pair| pair[0].1 <= pair[1].0), "{used:?}");
            assert!(used.last().unwrap().1 <= rooms.end());
            assert!(rooms.rooms.iter().zip(lengths).all(|(room, length)| length <= room.capacity));
            let capacity: u32 = used.iter().map(|(start, end)| end - start).sum();
            assert!(rooms.end() < 2 * capacity, "{} left behind", rooms.end() - capacity);
        }
    }
}
