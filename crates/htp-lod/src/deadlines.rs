//! When the patches of one level are to be judged again.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use terrain_core::odometer::{self, Odometer, rounded_down};

/// Bytes of [`Deadlines`] for one square; what is queued comes on top, a few entries for each patch along a border of
/// levels.
pub(crate) const BYTES_A_SQUARE: u64 = 2 * size_of::<f32>() as u64;

/// The deadline of a patch that has none.
const NEVER: f32 = odometer::NEVER as f32;

/// Fewer entries are never looked through for stale ones.
const FEW: usize = 1 << 10;

/// The deadlines of a level's patches, by place in the level ([`Grid::place_in_level`](crate::grid::Grid::place_in_level)).
pub(crate) struct Deadlines {
    /// Rounded down; without the fresh ones.
    by_place: Vec<f32>,
    /// Soonest first. An entry is stale unless its place still has that deadline.
    queue: BinaryHeap<Reverse<Entry>>,
    /// Set since a deadline was asked for, in order. They are put in place and queued when one is: all at once is less
    /// work, and none where all is set anew before.
    fresh: Vec<Entry>,
    /// So long a queue is cleared of stale entries.
    limit: usize,
}

/// The bits of a deadline, which is not negative and so sorted by its bits, and a place.
type Entry = (u32, u32);

impl Deadlines {
    /// No patch has one.
    pub fn new(places: usize) -> Self {
        Self { by_place: vec![NEVER; places], queue: BinaryHeap::new(), fresh: Vec::new(), limit: FEW }
    }

    /// As if new. Whatever has a deadline has an entry.
    pub fn clear(&mut self) {
        self.queue.drain().for_each(|Reverse((_, place))| self.by_place[place as usize] = NEVER);
        self.fresh.clear();
        self.limit = FEW;
    }

    pub fn set(&mut self, place: u32, deadline_m: f64) {
        self.fresh.push((rounded_down(deadline_m).to_bits(), place));
    }

    fn queue_fresh(&mut self) {
        let by_place = &mut self.by_place;
        let is_news = |(bits, place): &Entry| {
            let deadline_m = f32::from_bits(*bits);
            std::mem::replace(&mut by_place[*place as usize], deadline_m) != deadline_m && deadline_m != NEVER
        };
        let news: Vec<_> = self.fresh.drain(..).filter(is_news).map(Reverse).collect();
        self.queue.extend(news);
        if self.queue.len() > self.limit {
            let by_place = &self.by_place;
            self.queue.retain(|Reverse(entry)| is_current(by_place, *entry));
            self.limit = (2 * self.queue.len()).max(FEW);
        }
    }

    /// Moves the places whose deadline has passed to `due`. They have none until one is set.
    pub fn take_passed(&mut self, odometer: &Odometer, due: &mut Vec<u32>) {
        self.queue_fresh();
        while let Some(Reverse(entry)) = self.queue.peek().copied() {
            if !odometer.has_passed(f32::from_bits(entry.0).into()) {
                return;
            }
            self.queue.pop();
            if is_current(&self.by_place, entry) {
                self.by_place[entry.1 as usize] = NEVER;
                due.push(entry.1);
            }
        }
    }
}

fn is_current(by_place: &[f32], (bits, place): Entry) -> bool {
    by_place[place as usize].to_bits() == bits
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain_core::walk::RandomWalk;
    use terrain_core::{SplitMix64, View};

    /// An eye that goes 10 m a step.
    fn view(step: u32) -> View {
        let heightmap = terrain_core::Heightmap::new(2, 2, [1.0; 2], vec![0.0; 4]).unwrap();
        let mut view = RandomWalk::new(1, &heightmap).next().unwrap();
        view.eye_world = [10.0 * step as f64, 0.0, 0.0].into();
        view
    }

    #[test]
    fn what_is_due_is_what_an_array_alone_would_say() {
        for seed in 0..20 {
            let mut random = SplitMix64::new(seed);
            let (mut odometer, mut deadlines, mut expected) = (Odometer::default(), Deadlines::new(300), [NEVER; 300]);
            for step in 0..200 {
                odometer.advance(&view(step));
                let mut due = Vec::new();
                deadlines.take_passed(&odometer, &mut due);
                due.sort_unstable();
                let passed = (0..300).filter(|place| odometer.has_passed(expected[*place as usize].into()));
                assert_eq!(due, passed.collect::<Vec<u32>>(), "seed {seed}, step {step}");
                due.iter().for_each(|place| expected[*place as usize] = NEVER);
                for _ in 0..random.below(60) {
                    let (place, slack_m) = (random.below(300) as u32, random.range(0.0, 500.0));
                    let deadline_m = if random.below(9) > 0 { odometer.deadline_m(slack_m) } else { f64::INFINITY };
                    deadlines.set(place, deadline_m);
                    expected[place as usize] = rounded_down(deadline_m);
                }
                assert!(deadlines.queue.len() <= FEW, "300 places need no more, stale entries or not");
                if random.below(50) == 0 {
                    deadlines.clear();
                    expected.fill(NEVER);
                }
            }
        }
    }
}
