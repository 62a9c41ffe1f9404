//! The crate `spade`.

use spade::{DelaunayTriangulation, Point2, Triangulation};

use super::KeptSamples;

pub(super) fn triangulate(kept: &KeptSamples, indices: &mut Vec<u32>) {
    let positions: Vec<_> = kept.positions().collect();
    let points = positions.iter().map(|(column, row)| Point2::new(*column as f64, *row as f64)).collect();
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
