//! The triangles of one view: from the root down, as long as a vertex is wanted.

use terrain_core::{Aabb, View};

use super::hierarchy::{Hierarchy, Node, Point, RightTriangle};

/// One walk through the hierarchy.
pub(crate) struct Refinement<'a> {
    pub hierarchy: &'a Hierarchy,
    pub view: &'a View,
    /// Allowed screen-space error.
    pub tolerance_px: f64,
    /// Samples of the DEM along x: sample `row * columns + column` is a vertex of the vertex buffer.
    pub columns: u32,
    /// What the walk fills.
    pub indices: &'a mut Vec<u32>,
}

/// What is known of a triangle before it is looked at.
#[derive(Clone, Copy)]
struct Inherited {
    /// Whether all of it is in view, or counts as if it were.
    in_view: bool,
    /// Lowest and highest sample around it.
    heights_m: [f32; 2],
}

impl Refinement<'_> {
    /// Appends the triangles that may be in view, or with `culling` off all of them.
    pub fn run(&mut self, culling: bool) {
        let inherited = Inherited { in_view: !culling, heights_m: self.hierarchy.heights_m() };
        self.hierarchy.roots().into_iter().for_each(|root| self.refine(root, inherited));
    }

    fn refine(&mut self, triangle: RightTriangle, mut known: Inherited) {
        if self.hierarchy.is_beyond_the_rim(&triangle) {
            return;
        }
        let half = triangle.half();
        let splittable = half > 0;
        let vertex = triangle.split_vertex();
        let node = splittable.then(|| self.hierarchy.node(vertex, half));
        known.heights_m = node.map_or(known.heights_m, |node| node.heights_m);
        if !known.in_view {
            let bounds = self.hierarchy.triangle_bounds_world(&triangle, known.heights_m);
            if !self.view.sees(&bounds) {
                return;
            }
            known.in_view = self.view.sees_whole(&bounds);
        }
        match node {
            Some(node) if self.wants(node, vertex, half) => {
                triangle.children().into_iter().for_each(|child| self.refine(child, known));
            }
            _ => self.emit(&triangle),
        }
    }

    /// Whether a vertex is part of the mesh: the test of both triangles of its diamond. With nested errors and bounds
    /// it is never true of a vertex and false of one above it, so that no crack can open (Lindstrom and Pascucci 2002).
    fn wants(&self, node: &Node, vertex: Point, half: i32) -> bool {
        let bounds: Aabb = self.hierarchy.bounds_world(vertex, half);
        let allowed_m = self.view.metres(self.tolerance_px, self.view.distance_m(&bounds));
        node.error_m as f64 > allowed_m
    }

    fn emit(&mut self, triangle: &RightTriangle) {
        let samples = triangle.corners().map(|corner| self.hierarchy.sample(corner));
        self.indices.extend(samples.map(|sample| sample.row * self.columns + sample.column));
    }
}
