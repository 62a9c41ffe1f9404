//! The plain patch and its matching blocks, as index lists for any `k` (sections 2.2 and 4.1, Figures 2 and 3).
//!
//! A patch is a right triangle of `k * k` small triangles. Its vertices are numbered row by row from the apex, where
//! the right angle is, and in each row from the left to the right side. A side that meets a coarser neighbour is
//! *collapsed*: it drops its inner vertices and becomes one edge. All 8 lists for k = 3, with the apex (0) in the
//! north-west, the left end (6) in the south and the right end (9) in the east:
//!
//! ```text
//! mask 0: plain               mask 1: hypotenuse          mask 2: left                mask 3: hypotenuse, left
//! 0-------2-------5-------9   0-------2-------5-----..9   0-------2-------5-------9   0-------2-------5-----..9
//! |     / |     / |     /     |     / |     /    .../     | \     |     / |     /     |      /|     /    .../
//! |   /   |   /   |   /       |   /   |   / ..... /       |   \   |   /   |   /       |      /|   / ..... /
//! | /     | /     | /         | /     | /...    /         |     \ | /     | /         |     / | /...    /
//! 1-------4-------8           1-------4..     /           |       4-------8           |    /  4..     /
//! |     / |     /             |     //      /             |      /|     /             |    / /      /
//! |   /   |   /               |   / /     /               |     / |   /               |   / /     /
//! | /     | /                 | /  /    /                 |    /  | /                 |  / /    /
//! 3-------7                   3   /   /                   |   /   7                   |  //   /
//! |     /                     |  /  /                     |  /  /                     | //  /
//! |   /                       | / /                       | / /                       |// /
//! | /                         |//                         |//                         |//
//! 6                           6                           6                           6
//!
//! mask 4: right               mask 5: hypotenuse, right   mask 6: left, right         mask 7: all (never drawn)
//! 0-----------------------9   0-----------------------9   0..---------------------9   0-----------------------9
//! | \                .../     | \                ....     | \...                /     | \                .../
//! |   \         ..... /       |   \         ....../       |   \ .....         /       |   \         ..... /
//! |     \    ...    /         |     \    ...... /         |     \    ...    /         |     \    ...    /
//! 1-------4-------8           1-------4.....  /           |       4-----..8           |       4..     /
//! |     / |     /             |     / ...   /             |      /|     /             |      /      /
//! |   /   |   /               |   /...    /               |     / |   /               |     /     /
//! | /     | /                 | /..     /                 |    /  | /                 |    /    /
//! 3-------7                   3.      /                   |   /   7                   |   /   /
//! |     /                     |     /                     |  /  /                     |  /  /
//! |   /                       |   /                       | / /                       | / /
//! | /                         | /                         |//                         |//
//! 6                           6                           6                           6
//! ```
//!
//! A block is built in three steps. One strip is cut off along each of its `c` collapsed sides; the inner triangle of
//! `k - c` segments a side that is left stays plain; each strip is one triangle on the collapsed edge, with its third
//! corner in the middle of the strip's inner row, and two fans that join the row's halves to the edge's ends. That
//! makes `k * k - c * (k - 1)` triangles. The middle is the best choice, or within 1.6 per cent of the best, of all
//! triangulations of a k = 3 block, by the deviation from the DEM.
//!
//! All sides are treated alike by counting a vertex's steps in three directions: `towards[APEX]`, `towards[LEFT]` and
//! `towards[RIGHT]`, of sum `k` (barycentric coordinates). A side is where one of them is 0.

use std::ops::Range;
use terrain_core::LocalVertex;

/// A side of a patch. Its bit in a mask says "collapsed: the neighbour is one level coarser".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Hypotenuse = 0,
    /// From the apex to the left end.
    Left = 1,
    /// From the apex to the right end.
    Right = 2,
}

impl Side {
    pub const ALL: [Side; 3] = [Side::Hypotenuse, Side::Left, Side::Right];

    /// 1, 2 and 4.
    pub fn bit(self) -> u8 {
        1 << self as u8
    }

    /// The directions in which the side runs, counter-clockwise: from its first corner to its second.
    fn corners(self) -> [usize; 2] {
        match self {
            Side::Hypotenuse => [LEFT, RIGHT],
            Side::Left => [APEX, LEFT],
            Side::Right => [RIGHT, APEX],
        }
    }

    /// The direction that leads away from the side: the corner opposite.
    fn opposite(self) -> usize {
        match self {
            Side::Hypotenuse => APEX,
            Side::Left => RIGHT,
            Side::Right => LEFT,
        }
    }
}

const APEX: usize = 0;
const LEFT: usize = 1;
const RIGHT: usize = 2;

/// The number of masks: each of three sides plain or collapsed.
pub(crate) const MASKS: usize = 8;

/// All three sides collapsed: it has its index list, as in Figure 2, but every patch of a split patch has a sibling on
/// at least one side, so it is never drawn (`leaves` asserts it).
pub(crate) const ALL_COLLAPSED: u8 = 7;

/// Vertices of a patch: 10 for k = 3.
pub(crate) fn vertices_per_patch(k: u32) -> u32 {
    (k + 1) * (k + 2) / 2
}

/// The vertices of a patch in their order, row by row from the apex: steps towards the left and towards the right end
/// (section 2.1).
pub fn local_vertices(k: u32) -> Vec<LocalVertex> {
    let row = |row: u32| (0..=row).map(move |j| LocalVertex { uv: [(row - j) as u16, j as u16] });
    (0..=k).flat_map(row).collect()
}

/// The 8 index lists of one `k`, one after the other: one static index buffer.
///
/// Deviation: the paper has 7 index buffers, the plain patch's among them (section 3, phase 1), and draws 7 matching
/// blocks beside it (Figure 2), which makes 8 lists. All 8 are here, by mask; 7 can be drawn.
pub(crate) struct Blocks {
    pub indices: Vec<u32>,
    /// Where the list of each mask stands in `indices`.
    pub ranges: [Range<u32>; MASKS],
}

impl Blocks {
    pub fn new(k: u32) -> Self {
        let mut indices = Vec::new();
        let ranges = std::array::from_fn(|mask| {
            let start = indices.len() as u32;
            indices.extend(index_list(k, mask as u8).as_flattened());
            start..indices.len() as u32
        });
        Self { indices, ranges }
    }
}

/// The triangles of the plain patch (mask 0) or of a matching block, counter-clockwise seen from above, as indices into
/// [`local_vertices`]. The mask says which sides are collapsed: 1 the hypotenuse, 2 the left one, 4 the right one
/// (sections 2.2 and 4.1). `k` is 2 or more, the mask below 8.
pub fn index_list(k: u32, mask: u8) -> Vec<[u32; 3]> {
    let collapsed = Side::ALL.map(|side| (mask & side.bit() != 0) as u32);
    let strips: u32 = collapsed.iter().sum();
    let Some(segments) = k.checked_sub(strips) else {
        // k = 2 with three strips: they overlap, and the whole patch is one triangle.
        return vec![[APEX, LEFT, RIGHT].map(|corner| vertex(corner_of_patch(k, corner)))];
    };
    // The inner triangle keeps one step away from each collapsed side.
    let mut margin = [0; 3];
    for side in Side::ALL {
        margin[side.opposite()] = collapsed[side as usize];
    }
    let mut triangles = Vec::new();
    plain(segments, margin, &mut triangles);
    for side in Side::ALL.into_iter().filter(|side| mask & side.bit() != 0) {
        strip(k, segments, margin, side, &mut triangles);
    }
    triangles
}

/// The number of a vertex from its steps towards the three corners: rows from the apex, from left to right.
fn vertex(towards: [u32; 3]) -> u32 {
    let row = towards[LEFT] + towards[RIGHT];
    row * (row + 1) / 2 + towards[RIGHT]
}

fn corner_of_patch(k: u32, corner: usize) -> [u32; 3] {
    let mut towards = [0; 3];
    towards[corner] = k;
    towards
}

/// A plain triangle of `segments` segments a side whose vertices all lie `margin` steps or more from the sides.
fn plain(segments: u32, margin: [u32; 3], triangles: &mut Vec<[u32; 3]>) {
    let at = |row: u32, j: u32| {
        let towards = [segments - row, row - j, j];
        vertex([APEX, LEFT, RIGHT].map(|corner| towards[corner] + margin[corner]))
    };
    for row in 0..segments {
        for j in 0..=row {
            triangles.push([at(row, j), at(row + 1, j), at(row + 1, j + 1)]);
            if j < row {
                triangles.push([at(row, j), at(row + 1, j + 1), at(row, j + 1)]);
            }
        }
    }
}

/// The strip between a collapsed side and the inner triangle: the edge's own triangle and the two fans beside it.
///
/// ```text
///     r0--r1--r2--r3      inner row of `segments` + 1 vertices
///    / / / /  \   \ \     edge triangle (first, second, r1): the middle, rounded down
///   first--------second
/// ```
fn strip(k: u32, segments: u32, margin: [u32; 3], side: Side, triangles: &mut Vec<[u32; 3]>) {
    let [from, to] = side.corners();
    let inner = |step: u32| {
        let mut towards = margin;
        towards[from] += segments - step;
        towards[to] += step;
        vertex(towards)
    };
    let [first, second] = [from, to].map(|corner| vertex(corner_of_patch(k, corner)));
    let middle = segments / 2;
    triangles.push([first, second, inner(middle)]);
    for step in 0..segments {
        let end = if step < middle { first } else { second };
        triangles.push([end, inner(step + 1), inner(step)]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::{BTreeMap, BTreeSet};

    #[test]
    fn plain_patch_of_k_3_is_the_papers_list() {
        let paper = [[0, 1, 2], [1, 3, 4], [1, 4, 2], [2, 4, 5], [3, 6, 7], [3, 7, 4], [4, 7, 8], [4, 8, 5], [5, 8, 9]];
        assert_eq!(index_list(3, 0), paper);
    }

    #[test]
    fn matching_blocks_of_k_3() {
        let triangles = [0, 1, 2, 3, 4, 5, 6, 7].map(|mask| index_list(3, mask).len());
        assert_eq!(triangles, [9, 7, 7, 5, 7, 5, 5, 3]);
        let hypotenuse = [[0, 1, 2], [1, 3, 4], [1, 4, 2], [2, 4, 5], [6, 9, 4], [6, 4, 3], [9, 5, 4]];
        assert_eq!(index_list(3, Side::Hypotenuse.bit()), hypotenuse);
        assert_eq!(index_list(3, ALL_COLLAPSED), [[6, 9, 4], [0, 6, 4], [9, 0, 4]]);
        assert_eq!(index_list(2, ALL_COLLAPSED), [[0, 3, 5]]);
    }

    /// Twice the signed area, positive counter-clockwise seen from above, for a patch with its apex in the north-west:
    /// u counts rows to the south, v columns to the east.
    fn area2(triangle: [u32; 3], vertices: &[LocalVertex]) -> i32 {
        let [a, b, c] = triangle.map(|i| vertices[i as usize].uv.map(i32::from));
        (c[1] - a[1]) * (b[0] - a[0]) - (b[1] - a[1]) * (c[0] - a[0])
    }

    /// The border edges that a mask asks for, counter-clockwise.
    fn border(k: u32, mask: u8) -> BTreeSet<(u32, u32)> {
        let mut edges = BTreeSet::new();
        for side in Side::ALL {
            let [from, to] = side.corners();
            let at = |step: u32| {
                let mut towards = [0; 3];
                towards[from] = k - step;
                towards[to] = step;
                vertex(towards)
            };
            if mask & side.bit() != 0 {
                edges.insert((at(0), at(k)));
            } else {
                edges.extend((0..k).map(|step| (at(step), at(step + 1))));
            }
        }
        edges
    }

    #[test]
    fn every_block_of_every_k_is_a_triangulation() {
        for k in 2..=16 {
            let vertices = local_vertices(k);
            assert_eq!(vertices.len() as u32, vertices_per_patch(k));
            for mask in 0..MASKS as u8 {
                check_block(k, mask, &vertices);
            }
        }
    }

    fn check_block(k: u32, mask: u8, vertices: &[LocalVertex]) {
        let triangles = index_list(k, mask);
        let strips = mask.count_ones();
        assert_eq!(triangles.len() as u32, k * k - strips * (k - 1), "k {k} mask {mask}");
        assert!(triangles.iter().all(|t| area2(*t, vertices) > 0), "k {k} mask {mask}");
        let area: i32 = triangles.iter().map(|t| area2(*t, vertices)).sum();
        assert_eq!(area, (k * k) as i32, "k {k} mask {mask}");

        let mut edges = BTreeMap::new();
        for [a, b, c] in &triangles {
            for edge in [(*a, *b), (*b, *c), (*c, *a)] {
                *edges.entry(edge).or_insert(0) += 1;
            }
        }
        assert!(edges.values().all(|count| *count == 1), "k {k} mask {mask}");
        let open: BTreeSet<_> = edges.keys().copied().filter(|(a, b)| !edges.contains_key(&(*b, *a))).collect();
        assert_eq!(open, border(k, mask), "k {k} mask {mask}");

        let used: BTreeSet<u32> = triangles.as_flattened().iter().copied().collect();
        assert_eq!(used.len() as u32, vertices_per_patch(k) - strips * (k - 1), "k {k} mask {mask}");
        let on_border = |edges: &BTreeSet<(u32, u32)>| edges.iter().map(|(a, _)| *a).collect::<BTreeSet<u32>>();
        let dropped = &on_border(&border(k, 0)) - &on_border(&border(k, mask));
        assert!(used.is_disjoint(&dropped), "k {k} mask {mask}");
    }

    #[test]
    fn the_lists_stand_one_after_the_other() {
        let blocks = Blocks::new(4);
        for mask in 0..MASKS {
            let range = blocks.ranges[mask].start as usize..blocks.ranges[mask].end as usize;
            assert_eq!(blocks.indices[range], *index_list(4, mask as u8).as_flattened());
        }
        assert_eq!(blocks.ranges[7].end as usize, blocks.indices.len());
    }
}
