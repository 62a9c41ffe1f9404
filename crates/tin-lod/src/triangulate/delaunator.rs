//! The crate `delaunator`.

use delaunator::Point;

use super::{KeptSamples, Place};

pub(super) fn triangulate(kept: &KeptSamples, place: Place, indices: &mut Vec<u32>) {
    let positions: Vec<_> = kept.positions().collect();
    let point = |(column, row): &(u32, u32)| {
        let [x, y] = place([*column as f64, *row as f64]);
        Point { x, y }
    };
    let points: Vec<_> = positions.iter().map(point).collect();
    // Its triangles are counter-clockwise with the second axis down, as ours are.
    let corners = delaunator::triangulate(&points).triangles;
    indices.extend(corners.into_iter().map(|corner| {
        let (column, row) = positions[corner];
        kept.index(column, row)
    }));
}
