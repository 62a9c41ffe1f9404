//! The thresholds of a patch's interior: greedy insertion (Garland and Heckbert, "Fast polygonal approximation of
//! terrains and height fields", CMU-CS-95-181, 1995), level by level from the coarsest tolerance to the finest.
//!
//! ```text
//!   for each code, from the largest down:                      (a sample with a code is needed below that level)
//!       insert all border samples of that code                 (`threshold_map.rs` decided them)
//!       while a triangle is too far from a sample inside:
//!           insert its worst sample; its code is this one
//! ```
//!
//! So the samples that a level keeps are those of a mesh that was finished, its border included: no sample inside is
//! farther away than the level's tolerance. The mesh at run time is the same one, because both break ties alike.
//!
//! Deviation: the next point is the worst of its triangle, but its triangle is only among the worst: of those with the
//! largest code the one that waits longest. Whole deviations in place of codes save 0.3 % of the triangles at most
//! (Puget Sound, 8 to 128 m) and need a heap.

mod mesh;
mod queue;

use terrain_core::Heightmap;

use crate::deviation::{PatchHeights, Worst};
use crate::ladder::{FLOOR_M, code_of};
use crate::lattice::Vertex;
use crate::patches::PatchArea;

use mesh::{MAX_TRIANGLES, Mesh, TriangleId};
use queue::Queue;

/// The code of samples that only the full mesh has.
pub(crate) const LEAST_CODE: u8 = 1;

/// Workspace for one patch after the other.
pub(crate) struct Greedy {
    mesh: Mesh,
    queue: Queue,
    /// The sample that each waiting triangle waits for.
    worst: Box<[Vertex; MAX_TRIANGLES]>,
    /// A copy of the patch's heights: rows of a DEM of 2^n samples would share their cache lines.
    heights_m: Vec<f32>,
}

impl Greedy {
    pub fn new() -> Self {
        let worst = Box::new([0; MAX_TRIANGLES]);
        Self { mesh: Mesh::new(), queue: Queue::new(), worst, heights_m: Vec::new() }
    }

    /// Finds the codes of the samples inside a patch and hands each over as `keep(sample, code)`; samples that are
    /// not handed over have [`LEAST_CODE`]. `border`: codes of the samples of the outline, the largest codes first.
    pub fn run(
        &mut self,
        heightmap: &Heightmap,
        area: PatchArea,
        border: &[(u8, Vertex)],
        mut keep: impl FnMut(Vertex, u8),
    ) {
        self.copy_heights(heightmap, area);
        self.mesh.start(area.width, area.depth);
        self.replace_triangles(area);
        let mut border = border.iter().copied().peekable();
        loop {
            let code = self.queue.worst().0.max(border.peek().map_or(0, |next| next.0));
            if code <= LEAST_CODE {
                break;
            }
            while let Some((_, sample)) = border.next_if(|next| next.0 == code) {
                self.mesh.insert_on_outline(sample);
                self.replace_triangles(area);
            }
            while let Some(triangle) = self.next_triangle(code) {
                let sample = self.worst[triangle as usize];
                keep(sample, code);
                self.mesh.insert_inside(sample, triangle);
                self.replace_triangles(area);
            }
        }
    }

    /// A triangle whose worst sample has at least this code.
    fn next_triangle(&mut self, code: u8) -> Option<TriangleId> {
        let (highest, triangle) = self.queue.worst();
        (highest >= code).then_some(triangle)
    }

    fn copy_heights(&mut self, heightmap: &Heightmap, area: PatchArea) {
        let heights = PatchHeights::new(heightmap, area);
        self.heights_m.clear();
        for row in heights.heights_m.chunks(heights.stride).take(area.depth as usize + 1) {
            self.heights_m.extend(&row[..=area.width as usize]);
        }
    }

    /// After an insertion: the queue forgets the old triangles and takes the new ones in that are not exact enough.
    fn replace_triangles(&mut self, area: PatchArea) {
        let PatchArea { width, depth, .. } = area;
        let heights = PatchHeights { heights_m: &self.heights_m, stride: width as usize + 1, width, depth };
        for triangle in self.mesh.removed() {
            self.queue.leave(*triangle);
        }
        for triangle in self.mesh.made() {
            let corners = self.mesh.corners(*triangle);
            if let Some(Worst { sample, deviation_m }) = heights.worst_beyond(FLOOR_M, corners) {
                self.worst[*triangle as usize] = sample;
                self.queue.enter(*triangle, code_of(deviation_m));
            }
        }
    }
}
