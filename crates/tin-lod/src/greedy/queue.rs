//! Triangles that wait for a point, by the code of their worst sample: lists through fixed arrays, so that to enter, to
//! leave and to find the worst takes a few stores and no memory.

use super::mesh::{MAX_TRIANGLES, TriangleId};

/// Triangles, then the heads of the lists: one a code.
const NODES: usize = MAX_TRIANGLES + 256;

/// See the module.
pub(super) struct Queue {
    /// Rings: a node alone is its own neighbour.
    next: Box<[u16; NODES]>,
    previous: Box<[u16; NODES]>,
    /// No list of a larger code holds a triangle.
    highest: u8,
}

fn head(code: u8) -> u16 {
    MAX_TRIANGLES as u16 + code as u16
}

impl Queue {
    pub fn new() -> Self {
        let nodes = || Box::new(std::array::from_fn(|i| i as u16));
        Self { next: nodes(), previous: nodes(), highest: 0 }
    }

    /// Puts a triangle that is in no list at the end of a code's list.
    pub fn enter(&mut self, triangle: TriangleId, code: u8) {
        let (before, after) = (self.previous[head(code) as usize], head(code));
        (self.previous[triangle as usize], self.next[triangle as usize]) = (before, after);
        (self.next[before as usize], self.previous[after as usize]) = (triangle, triangle);
        self.highest = self.highest.max(code);
    }

    /// Takes a triangle out of its list, if it is in one.
    pub fn leave(&mut self, triangle: TriangleId) {
        let t = triangle as usize;
        let (before, after) = (self.previous[t], self.next[t]);
        (self.next[before as usize], self.previous[after as usize]) = (after, before);
        (self.next[t], self.previous[t]) = (triangle, triangle);
    }

    /// The largest code that a triangle waits with, and the first one to enter with it; `(0, _)` if none waits.
    pub fn worst(&mut self) -> (u8, TriangleId) {
        while self.highest > 0 && self.next[head(self.highest) as usize] == head(self.highest) {
            self.highest -= 1;
        }
        (self.highest, self.next[head(self.highest) as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_code_comes_first_and_of_equals_the_first_to_enter() {
        let mut queue = Queue::new();
        for (triangle, code) in [(7, 3), (0, 255), (8191, 3), (5, 255), (6, 9)] {
            queue.enter(triangle, code);
        }
        queue.leave(6);
        queue.leave(6);
        for expected in [(255, 0), (255, 5), (3, 7), (3, 8191)] {
            assert_eq!(queue.worst(), expected);
            queue.leave(expected.1);
        }
        assert_eq!(queue.worst().0, 0);
        queue.enter(0, 4);
        assert_eq!(queue.worst(), (4, 0));
    }
}
