//! The crate `spade`.

use spade::{DelaunayTriangulation, Point2, Triangulation};

use super::{KeptSamples, Place};

pub(super) fn triangulate(kept: &KeptSamples, place: Place, indices: &mut Vec<u32>) {
    let positions: Vec<_> = kept.positions().collect();
    let point = |(column, row): &(u32, u32)| {
        let [x, y] = place([*column as f64, *row as f64]);
        Point2::new(x, y)
    };
    let points = positions.iter().map(point).collect();
    let delaunay = DelaunayTriangulation::<Point2<f64>>::bulk_load_stable(points).expect("samples are finite");
    indices.reserve(3 * delaunay.num_inner_faces());
    for face in delaunay.inner_faces() {
        // spade turns counter-clockwise with its second axis up; ours, the rows, points down (south).
        let [a, b, c] = face.vertices().map(|v| {
            let (column, row) = positions[v.fix().index()];
            kept.index(column, row)
        });
        indices.extend([a, c, b]);
    }
}
