//! The crate `delaunator`.

use delaunator::Point;

use super::KeptSamples;

pub(super) fn triangulate(kept: &KeptSamples, indices: &mut Vec<u32>) {
    let positions: Vec<_> = kept.positions().collect();
    let points: Vec<_> = positions.iter().map(|(x, z)| Point { x: *x as f64, y: *z as f64 }).collect();
    // Its triangles are counter-clockwise with the second axis down, as ours are.
    let corners = delaunator::triangulate(&points).triangles;
    indices.extend(corners.into_iter().map(|corner| {
        let (column, row) = positions[corner];
        kept.index(column, row)
    }));
}
