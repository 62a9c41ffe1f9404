//! Stable slots: every drawn patch keeps its place among the instances, so that little is to be sent.
//!
//! One array of instances for each index list, which the visible patches enter and leave. A patch that enters takes
//! the place of one that left in the same frame, or the next at the end; places that stay empty take the array's last
//! patches. So a frame writes at most as many instances as patches enter or leave, and none where nothing changes.
//! Where most of an array is written, all of it is sent, in one upload instead of thousands.
//!
//! ```text
//!  before        a  b  c  d  e  f           b and d leave, x enters:
//!                a  x  c  .  e  f           x takes the place of b,
//!  after         a  x  c  f  e              the last one that of d: 2 instances to send
//! ```

use crate::blocks::{Blocks, MASKS};
use crate::rooms::Rooms;
use std::ops::Range;
use terrain_core::{Buffer, Draw, FramePlan, Growth, PatchInstance};

/// The instances of all drawn patches, and their places in the instance buffer.
pub(crate) struct Slots {
    /// By the patch's place ([`Grid::place_at`](crate::grid::Grid::place_at)): mask and slot, see [`place`]. It counts where
    /// that slot holds the patch, so that whatever leaves need not be looked up here: a sparse set (Briggs and Torczon 1993).
    places: Vec<u32>,
    /// Whether places are out of date. They are found anew when one is asked for: all at once, and not at all where all is
    /// drawn anew before.
    unplaced: bool,
    /// By mask.
    arrays: [Array; MASKS],
    rooms: Rooms,
    /// Bytes of the instance buffer.
    bytes: u64,
    /// Whether this frame draws all anew.
    anew: bool,
}

/// The patches that one index list draws.
#[derive(Default)]
struct Array {
    /// What the instance buffer holds once the plan is carried out.
    instances: Vec<PatchInstance>,
    /// The patch numbers of the same; [`NOWHERE`] in a hole.
    patches: Vec<u32>,
    /// Slots whose patch left in this frame.
    holes: Vec<u32>,
    /// Slots that were written in this frame, a bit each.
    written: Vec<u64>,
}

/// The patch is not drawn.
const NOWHERE: u32 = u32::MAX;
const SLOT_BITS: u32 = 29;

fn place(mask: u8, slot: usize) -> u32 {
    (mask as u32) << SLOT_BITS | slot as u32
}

impl Slots {
    /// For patches with numbers below `patches`; none is drawn.
    pub fn new(patches: u32) -> Self {
        Self {
            places: vec![NOWHERE; patches as usize],
            unplaced: false,
            arrays: Default::default(),
            rooms: Rooms::new(MASKS),
            bytes: size_of::<PatchInstance>() as u64,
            anew: false,
        }
    }

    /// Patches that are drawn.
    pub fn drawn(&self) -> usize {
        self.arrays.iter().map(|array| array.patches.len()).sum()
    }

    /// Draws nothing. What [enters](Self::enter) from now on is sent as a whole: less work where nearly all changes.
    pub fn clear(&mut self) {
        for array in &mut self.arrays {
            array.patches.clear();
            array.instances.clear();
            array.holes.clear();
        }
        self.anew = true;
    }

    /// Draws a patch that was not drawn since all was cleared in this frame.
    #[inline]
    pub fn enter(&mut self, patch: u32, mask: u8, instance: PatchInstance) {
        debug_assert!(self.anew);
        self.unplaced = true;
        let array = &mut self.arrays[mask as usize];
        array.patches.push(patch);
        array.instances.push(instance);
    }

    /// Brings the places up to date.
    fn find_places(&mut self) {
        let Self { places, arrays, .. } = self;
        let drawn = || {
            let slots = (0..)
                .zip(arrays.iter())
                .flat_map(|(mask, array)| (0..).zip(&array.patches).map(move |slot| (mask, slot)));
            slots.filter(|(_, (_, patch))| **patch != NOWHERE)
        };
        drawn().for_each(|(mask, (slot, patch))| places[*patch as usize] = place(mask, slot));
        let is_there = |(mask, (slot, patch)): (u8, (usize, &u32))| places[*patch as usize] == place(mask, slot);
        debug_assert!(drawn().all(is_there), "a patch is drawn twice");
    }

    /// Mask and slot of a patch that is drawn.
    fn find(&mut self, patch: u32) -> Option<(u8, u32)> {
        if std::mem::take(&mut self.unplaced) {
            self.find_places();
        }
        let place = self.places[patch as usize];
        let (mask, slot) = ((place >> SLOT_BITS) as u8, place & ((1 << SLOT_BITS) - 1));
        let is_there = self.arrays.get(mask as usize)?.patches.get(slot as usize) == Some(&patch);
        is_there.then_some((mask, slot))
    }

    /// Bytes of the instance buffer.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Draws a patch by the index list of a mask, or not at all.
    pub fn set(&mut self, patch: u32, mask: Option<u8>, instance: impl FnOnce() -> PatchInstance) {
        let before = self.find(patch);
        if before.map(|(mask, _)| mask) == mask {
            return;
        }
        if let Some((before, slot)) = before {
            self.arrays[before as usize].leave(slot);
        }
        if let Some(mask) = mask {
            let slot = self.arrays[mask as usize].enter(patch, instance());
            self.places[patch as usize] = place(mask, slot);
        }
    }

    /// Ends the frame: closes the holes and sends what was written. The buffer grows with the arrays.
    pub fn upload(&mut self, plan: &mut FramePlan) {
        for mask in 0..MASKS {
            while let Some((patch, slot)) = self.arrays[mask].close_hole() {
                self.places[patch as usize] = place(mask as u8, slot);
            }
        }
        let moved: [bool; MASKS] =
            std::array::from_fn(|mask| self.rooms.reserve(mask, self.arrays[mask].patches.len() as u32));
        self.grow(plan);
        for (mask, moved) in moved.into_iter().enumerate() {
            self.arrays[mask].upload(moved || self.anew, self.rooms.start(mask), plan);
        }
        self.anew = false;
    }

    fn grow(&mut self, plan: &mut FramePlan) {
        let needed = self.rooms.end() as u64 * size_of::<PatchInstance>() as u64;
        if needed > self.bytes {
            self.bytes = needed;
            plan.growths.push(Growth { buffer: Buffer::Instances, bytes: needed });
        }
    }

    /// One draw for the plain list and for each matching block in use.
    pub fn draw(&self, blocks: &Blocks, plan: &mut FramePlan) {
        for (mask, array) in self.arrays.iter().enumerate().filter(|(_, array)| !array.patches.is_empty()) {
            let (indices, start) = (blocks.ranges[mask].clone(), self.rooms.start(mask));
            let instances = start..start + array.patches.len() as u32;
            plan.draws.push(Draw { indices, base_vertex: 0, instances });
        }
    }
}

impl Array {
    fn leave(&mut self, slot: u32) {
        self.patches[slot as usize] = NOWHERE;
        self.holes.push(slot);
    }

    /// The slot of a patch that enters.
    fn enter(&mut self, patch: u32, instance: PatchInstance) -> usize {
        let slot = match self.holes.pop() {
            Some(hole) => hole as usize,
            None => {
                self.patches.push(patch);
                self.instances.push(instance);
                self.patches.len() - 1
            }
        };
        self.patches[slot] = patch;
        self.instances[slot] = instance;
        self.mark(slot);
        slot
    }

    /// Fills a hole with the last patch. Returns the patch and its new slot; none when there is no hole left.
    fn close_hole(&mut self) -> Option<(u32, usize)> {
        while let Some(hole) = self.holes.pop() {
            while self.patches.last() == Some(&NOWHERE) {
                self.patches.pop();
                self.instances.pop();
            }
            let slot = hole as usize;
            if slot < self.patches.len() {
                self.patches.swap_remove(slot);
                self.instances.swap_remove(slot);
                self.mark(slot);
                return Some((self.patches[slot], slot));
            }
        }
        None
    }

    fn mark(&mut self, slot: usize) {
        if self.written.len() <= slot / 64 {
            self.written.resize(slot / 64 + 1, 0);
        }
        self.written[slot / 64] |= 1 << (slot % 64);
    }

    /// Sends each run of written slots, or all where that is asked for or most are written.
    fn upload(&mut self, all: bool, start: u32, plan: &mut FramePlan) {
        let mut send = |slots: Range<usize>| {
            if slots.is_empty() {
                return;
            }
            let offset = (start as usize + slots.start) * size_of::<PatchInstance>();
            plan.upload(Buffer::Instances, offset as u64, &self.instances[slots]);
        };
        let written: u32 = self.written.iter().map(|bits| bits.count_ones()).sum();
        if all || 2 * written as usize > self.instances.len() {
            send(0..self.instances.len());
        } else {
            // What was written and then dropped from the end is not sent.
            runs(&self.written, self.instances.len()).for_each(&mut send);
        }
        self.written.fill(0);
    }
}

/// The runs of set bits below `end`, in order.
fn runs(bits: &[u64], end: usize) -> impl Iterator<Item = Range<usize>> {
    let mut from = 0;
    std::iter::from_fn(move || {
        let first = next(bits, from, true).filter(|first| *first < end)?;
        from = next(bits, first, false).unwrap_or(end).min(end);
        Some(first..from)
    })
}

/// The first bit at `from` or after it that is set, or that is not.
fn next(bits: &[u64], from: usize, set: bool) -> Option<usize> {
    let wanted = |word: usize| if set { bits[word] } else { !bits[word] };
    if from / 64 < bits.len() && wanted(from / 64) >> (from % 64) != 0 {
        return Some(from + (wanted(from / 64) >> (from % 64)).trailing_zeros() as usize);
    }
    let word = (from / 64 + 1..bits.len()).find(|word| wanted(*word) != 0)?;
    Some(64 * word + wanted(word).trailing_zeros() as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;
    use terrain_core::SplitMix64;

    /// A patch number as an instance.
    fn numbered(patch: u32) -> PatchInstance {
        PatchInstance { origin: [0; 2], leg_u: [0; 2], leg_v: [0; 2], tag: patch }
    }

    /// What the GPU's instance buffer would hold.
    fn carry_out(plan: &FramePlan, buffer: &mut Vec<u8>) {
        plan.growths.iter().for_each(|growth| buffer.resize(growth.bytes as usize, 0));
        for upload in &plan.uploads {
            buffer[upload.offset as usize..][..upload.bytes.len()].copy_from_slice(plan.bytes_of(upload));
        }
    }

    /// The patches that a plan draws, by mask.
    fn drawn(plan: &FramePlan, blocks: &Blocks, buffer: &[u8]) -> BTreeMap<u32, u8> {
        let mut drawn = BTreeMap::new();
        for draw in &plan.draws {
            let mask = blocks.ranges.iter().position(|range| *range == draw.indices).unwrap() as u8;
            for instance in draw.instances.clone() {
                let bytes = &buffer[20 * instance as usize..][..20];
                let instance: PatchInstance = bytemuck::pod_read_unaligned(bytes);
                assert_eq!(drawn.insert(instance.tag, mask), None, "a patch that is drawn twice");
            }
        }
        drawn
    }

    #[test]
    fn slots_hold_what_is_drawn_and_each_frame_sends_little_more_than_what_enters_or_leaves() {
        for seed in 0..40 {
            let mut random = SplitMix64::new(seed);
            let (mut slots, mut buffer, blocks) = (Slots::new(500), vec![0; 20], Blocks::new(3));
            let (mut expected, mut writes_saved) = (BTreeMap::new(), 0);
            for _ in 0..60 {
                let (mut plan, mut changes, busy) = (FramePlan::default(), 0, random.below(4) == 0);
                for _ in 0..random.below(if busy { 600 } else { 20 }) {
                    let patch = random.below(500) as u32;
                    let mask = (random.below(3) > 0).then(|| random.below(7) as u8);
                    let before = match mask {
                        Some(mask) => expected.insert(patch, mask),
                        None => expected.remove(&patch),
                    };
                    changes += (before != mask) as usize * (before.is_some() as usize + mask.is_some() as usize);
                    slots.set(patch, mask, || numbered(patch));
                }
                let anew = random.below(8) == 0;
                if anew {
                    slots.clear();
                    expected.retain(|patch, _| patch % 5 > 0);
                    expected.iter().for_each(|(patch, mask)| slots.enter(*patch, *mask, numbered(*patch)));
                }
                slots.upload(&mut plan);
                assert_eq!(slots.drawn(), expected.len());
                slots.draw(&blocks, &mut plan);
                carry_out(&plan, &mut buffer);
                assert_eq!(buffer.len() as u64, slots.bytes());
                assert_eq!(drawn(&plan, &blocks, &buffer), expected, "seed {seed}");
                let writes = plan.bytes.len() / 20;
                // Twice: where most slots are written, all are sent.
                let is_little = writes <= if anew { expected.len() } else { 2 * changes };
                assert!(is_little || !plan.growths.is_empty(), "seed {seed}: {writes} for {changes}");
                writes_saved += changes.saturating_sub(writes);
            }
            assert!(writes_saved > 0);
        }
    }

    /// A streamed plan looks twice at what is in sight: once for cells that leave, once for those that have entered.
    #[test]
    fn all_is_cleared_in_a_frame_in_which_patches_have_left() {
        let (mut slots, blocks, mut buffer) = (Slots::new(9), Blocks::new(3), vec![0; 20]);
        let mut plan = FramePlan::default();
        (0..6).for_each(|patch| slots.set(patch, Some(0), || numbered(patch)));
        slots.upload(&mut plan);
        carry_out(&plan, &mut buffer);
        plan.clear();
        slots.set(2, None, || numbered(2));
        slots.clear();
        slots.enter(4, 0, numbered(4));
        slots.set(5, Some(3), || numbered(5));
        slots.set(4, None, || numbered(4));
        slots.upload(&mut plan);
        slots.draw(&blocks, &mut plan);
        carry_out(&plan, &mut buffer);
        assert_eq!(drawn(&plan, &blocks, &buffer), BTreeMap::from([(5, 3)]));
    }

    #[test]
    fn runs_are_those_of_bit_by_bit() {
        let mut random = SplitMix64::new(2);
        for _ in 0..200 {
            let words = random.below(5) as usize;
            let bits: Vec<u64> =
                (0..words).map(|_| random.next_u64() & random.next_u64() | random.next_u64()).collect();
            let end = random.below(64 * words as u64 + 1) as usize;
            let expected = (0..end).filter(|bit| bits[bit / 64] >> (bit % 64) & 1 == 1).collect::<Vec<_>>();
            assert_eq!(runs(&bits, end).flatten().collect::<Vec<_>>(), expected, "{bits:x?}, {end}");
            let found: Vec<_> = runs(&bits, end).collect();
            assert!(found.windows(2).all(|pair| pair[0].end < pair[1].start), "runs that touch: {found:?}");
        }
    }

    #[test]
    fn a_patch_that_leaves_and_comes_back_in_one_frame_stays_drawn() {
        let (mut slots, blocks, mut buffer) = (Slots::new(9), Blocks::new(3), vec![0; 20]);
        for (frame, masks) in [[Some(0), Some(0)], [None, Some(0)], [Some(0), Some(5)]].into_iter().enumerate() {
            let mut plan = FramePlan::default();
            slots.set(3, None, || numbered(3));
            slots.set(3, masks[0], || numbered(3));
            slots.set(4, masks[1], || numbered(4));
            slots.upload(&mut plan);
            slots.draw(&blocks, &mut plan);
            carry_out(&plan, &mut buffer);
            let expected = [3, 4].into_iter().zip(masks).filter_map(|(patch, mask)| Some((patch, mask?)));
            assert_eq!(drawn(&plan, &blocks, &buffer), expected.collect(), "frame {frame}");
        }
    }
}
