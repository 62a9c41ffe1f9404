//! From kept samples to triangles: a Delaunay triangulation in the plane, lifted back by the samples' own heights
//! (section 3.3 of the paper).
//!
//! Deviation: the paper moves the points at random, so that four points on a square do not confuse its
//! triangulation. `spade` decides with exact predicates, so nothing is moved and straight borders stay straight. The
//! jitter as an option for fidelity is still to come.

use spade::{DelaunayTriangulation, Point2, Triangulation};
use terrain_core::{Heightmap, Sample};

use crate::patches::PatchArea;
use crate::select::{Border, Mask};

/// Indices of the patch's triangles into a vertex buffer that holds the whole DEM, counter-clockwise seen from above.
pub(crate) fn triangulate(heightmap: &Heightmap, area: PatchArea, border: Border, interior: &[Mask]) -> Vec<u32> {
    let kept = kept_samples(area, border, interior);
    let vertex = |(column, row): (u32, u32)| {
        heightmap.index(Sample { column: area.first.column + column, row: area.first.row + row })
    };
    let points = kept.iter().map(|(column, row)| Point2::new(*column as f64, *row as f64)).collect();
    let delaunay = DelaunayTriangulation::<Point2<f64>>::bulk_load_stable(points).expect("samples are finite");
    let mut indices = Vec::with_capacity(3 * delaunay.num_inner_faces());
    for face in delaunay.inner_faces() {
        // spade turns counter-clockwise with its second axis up; ours, the rows, points down (south).
        let [a, b, c] = face.vertices().map(|v| vertex(kept[v.fix().index()]));
        indices.extend([a, c, b]);
    }
    indices
}

/// Column and row within the patch of all kept samples, row by row.
fn kept_samples(area: PatchArea, border: Border, interior: &[Mask]) -> Vec<(u32, u32)> {
    let mut kept = Vec::with_capacity(256);
    for row in 0..=area.depth {
        let corners = row == 0 || row == area.depth;
        let inner = match row {
            0 => border.north,
            _ if corners => border.south,
            _ => interior[row as usize - 1],
        };
        if corners || border.west >> row & 1 == 1 {
            kept.push((0, row));
        }
        kept.extend(bits(inner).map(|column| (column, row)));
        if corners || border.east >> row & 1 == 1 {
            kept.push((area.width, row));
        }
    }
    kept
}

/// Positions of the set bits, lowest first.
fn bits(mut mask: Mask) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let next = (mask != 0).then(|| mask.trailing_zeros());
        mask &= mask.wrapping_sub(1);
        next
    })
}
