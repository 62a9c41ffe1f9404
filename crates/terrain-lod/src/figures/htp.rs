//! Figures 1 to 3 of the HTP paper, drawn from the crate's own hierarchy and index lists: no shape stands at a place of its
//! own making.

use htp_lod::{cell_patches, index_list, local_vertices};
use terrain_core::PatchInstance;

use super::spec::Figure;
use super::svg::{Drawing, Paint, Point};

const INK: &str = "#1b2733";
const FAINT: &str = "#8a97a5";
const COARSE: &str = "#e3e7ec";
/// Blue and orange: apart for every eye.
const BLUE: &str = "#9cc3e6";
const ORANGE: &str = "#f2a65a";
const THICK: &str = "#c2410c";

/// A triangle by its samples: column and row.
type Corners = [[i64; 2]; 3];

/// A patch in samples.
struct Patch {
    /// By local index.
    vertices: Vec<[i64; 2]>,
    /// Apex, left end, right end.
    corners: Corners,
}

impl Patch {
    fn of(instance: &PatchInstance, k: u32) -> Self {
        let at = |uv: [u16; 2]| {
            let [u, v] = uv.map(i64::from);
            [0, 1].map(|axis| {
                i64::from(instance.origin[axis])
                    + u * i64::from(instance.leg_u[axis])
                    + v * i64::from(instance.leg_v[axis])
            })
        };
        let k16 = k as u16;
        Self {
            vertices: local_vertices(k).iter().map(|vertex| at(vertex.uv)).collect(),
            corners: [[0, 0], [k16, 0], [0, k16]].map(at),
        }
    }

    fn triangles(&self, k: u32, mask: u8) -> Vec<Corners> {
        index_list(k, mask).iter().map(|triangle| triangle.map(|i| self.vertices[i as usize])).collect()
    }

    /// The ends of the hypotenuse, the left and the right side, in the order of the mask's bits.
    fn sides(&self) -> [[[i64; 2]; 2]; 3] {
        let [apex, left, right] = self.corners;
        [[left, right], [apex, left], [right, apex]]
    }

    fn has_corner(&self, at: &[i64; 2]) -> bool {
        self.corners.contains(at)
    }
}

/// Patches of all layers, the finest first. The suite is checked for what a hierarchy can be.
fn layers(k: u32, layers: u32) -> Vec<Vec<Patch>> {
    let all = cell_patches(k, layers).expect("Figure::validate made the same");
    all.iter().map(|layer| layer.iter().map(|instance| Patch::of(instance, k)).collect()).collect()
}

/// From samples to the drawing.
#[derive(Clone, Copy)]
struct Map {
    origin: Point,
    /// The sample at the origin.
    first: [i64; 2],
    scale: f64,
}

impl Map {
    fn at(&self, sample: [i64; 2]) -> Point {
        [0, 1].map(|axis| self.origin[axis] + (sample[axis] - self.first[axis]) as f64 * self.scale)
    }

    fn all<const N: usize>(&self, samples: [[i64; 2]; N]) -> [Point; N] {
        samples.map(|sample| self.at(sample))
    }
}

fn sorted(mut corners: Corners) -> Corners {
    corners.sort_unstable();
    corners
}

/// Three times the middle, so that it is whole.
fn middle3(corners: Corners) -> [i64; 2] {
    [0, 1].map(|axis| corners.iter().map(|corner| corner[axis]).sum())
}

/// The triangle nearest to its patch's middle.
fn central(patch: &Patch, k: u32) -> Corners {
    let middle = middle3(patch.corners);
    let distance = |corners: &Corners| (0..2).map(|axis| (middle3(*corners)[axis] - middle[axis]).pow(2)).sum::<i64>();
    patch.triangles(k, 0).into_iter().min_by_key(distance).expect("a patch has triangles")
}

/// Figure 1: half a cell, layer by layer. The coloured triangle of one layer is the coloured patch of the next.
pub fn layers_figure(figure: &Figure) -> String {
    let (k, count) = (figure.k(), figure.layers());
    let layers = layers(k, count);
    let (side, gap) = (330.0, 26.0);
    let mut drawing = Drawing::new(f64::from(count) * (side + gap) + gap, side + 82.0);
    let whole = &layers[count as usize - 1][0];
    let scale = side / k.pow(count) as f64;
    let mut chosen = whole.corners;
    for (i, layer) in layers.iter().rev().enumerate() {
        let map = Map { origin: [gap + i as f64 * (side + gap), 30.0], first: whole.corners[0], scale };
        let inside: Vec<&Patch> =
            layer.iter().filter(|patch| patch.corners.iter().all(|at| is_in_half(*at, whole))).collect();
        let patch = inside.iter().find(|patch| sorted(patch.corners) == sorted(chosen));
        let patch = patch.expect("a triangle of a layer is a patch of the next finer one");
        let next = central(patch, k);
        let fills = [(i > 0, patch.corners, BLUE), (i + 1 < layers.len(), next, ORANGE)];
        for (_, corners, fill) in fills.into_iter().filter(|(is_drawn, ..)| *is_drawn) {
            drawing.polygon(&map.all(corners), Paint { fill, stroke: "none", width: 0.0 });
        }
        let thin = Paint { fill: "none", stroke: FAINT, width: 0.8 };
        inside.iter().flat_map(|patch| patch.triangles(k, 0)).for_each(|t| drawing.polygon(&map.all(t), thin));
        let outline = Paint { fill: "none", stroke: INK, width: 2.0 };
        inside.iter().for_each(|patch| drawing.polygon(&map.all(patch.corners), outline));
        chosen = next;
        let level = count as usize - 1 - i;
        let centre = map.origin[0] + 0.5 * side;
        let legs = k.pow(level as u32);
        let (patches, triangles) = (inside.len(), inside.len() as u32 * k * k);
        let plural = if patches == 1 { "" } else { "es" };
        drawing.text([centre, 14.0], 16.0, INK, &format!("Layer {level}"));
        drawing.text(
            [centre, side + 48.0],
            14.0,
            INK,
            &format!("{patches} patch{plural} of {k} x {k}, {triangles} triangles"),
        );
        let intervals = if legs == 1 { "interval" } else { "intervals" };
        drawing.text([centre, side + 68.0], 14.0, INK, &format!("legs of {legs} sample {intervals}"));
    }
    drawing.finish(&format!("Hierarchical layers of triangular patches, k = {k}"))
}

/// Whether a sample lies in the north-west half of the cell.
fn is_in_half(at: [i64; 2], whole: &Patch) -> bool {
    let [apex, left, _] = whole.corners;
    at[0] - apex[0] + at[1] - apex[1] <= left[1] - apex[1]
}

/// A patch with its apex in the north-west and neighbours of its own layer on all sides, and these: beyond the hypotenuse,
/// the left and the right side.
fn surrounded(layer: &[Patch]) -> (&Patch, [&Patch; 3]) {
    let beyond = |patch: &Patch, [a, b]: [[i64; 2]; 2]| {
        layer.iter().find(|other| other.corners != patch.corners && other.has_corner(&a) && other.has_corner(&b))
    };
    let found = layer.iter().find_map(|patch| {
        let [hypotenuse, left, right] = patch.sides().map(|side| beyond(patch, side));
        let is_north_west = patch.corners[0] < patch.corners[1].min(patch.corners[2]);
        is_north_west.then_some((patch, [hypotenuse?, left?, right?]))
    });
    found.expect("a hierarchy of two layers has patches inside")
}

/// Figure 2: the plain patch and the seven matching blocks, each between the neighbours that it is for. A coarser neighbour
/// shows one triangle of its patch.
pub fn blocks_figure(figure: &Figure) -> String {
    let k = figure.k();
    let layers = layers(k, figure.layers());
    let (patch, neighbours) = surrounded(&layers[0]);
    // Neighbours reach as far to all sides as the patch itself.
    let (side, gap) = (124.0, 30.0);
    let (cell, scale) = (2.0 * side + gap, side / f64::from(k));
    let mut drawing = Drawing::new(4.0 * cell + gap, 2.0 * (cell + 30.0) + 10.0);
    for mask in 0..8_u8 {
        let corner = [f64::from(mask % 4) * cell + gap + side, f64::from(mask / 4) * (cell + 30.0) + 32.0 + side];
        let map = Map { origin: corner, first: patch.corners[0], scale };
        let is_coarse = |side: usize| mask >> side & 1 == 1;
        for (side, neighbour) in neighbours.iter().enumerate() {
            let paint = Paint { fill: if is_coarse(side) { COARSE } else { "white" }, stroke: FAINT, width: 1.0 };
            let triangles = if is_coarse(side) { vec![neighbour.corners] } else { neighbour.triangles(k, 0) };
            triangles.into_iter().for_each(|corners| drawing.polygon(&map.all(corners), paint));
        }
        let paint = Paint { fill: BLUE, stroke: INK, width: 1.4 };
        let triangles = patch.triangles(k, mask);
        triangles.iter().for_each(|corners| drawing.polygon(&map.all(*corners), paint));
        for side in (0..3).filter(|side| is_coarse(*side)) {
            drawing.line(map.all(patch.sides()[side]), THICK, 4.0);
        }
        for (name, (side, neighbour)) in ["ph", "pl", "pr"].iter().zip(neighbours.iter().enumerate()) {
            let at = middle3(neighbour.corners).map(|sum| sum as f64 / 3.0);
            let at = [0, 1].map(|axis| map.origin[axis] + (at[axis] - map.first[axis] as f64) * scale);
            let level = if is_coarse(side) { "level i + 1" } else { "level i" };
            drawing.text_on_lines([at[0], at[1] - 7.0], 14.0, INK, name);
            drawing.text_on_lines([at[0], at[1] + 9.0], 11.0, INK, level);
        }
        dots(&mut drawing, patch, &map, &index_list(k, mask));
        let name = block_name(mask);
        let title_at = [corner[0], corner[1] - side - 16.0];
        drawing.text(title_at, 15.0, INK, &format!("mask {mask}: {name}, {} triangles", triangles.len()));
    }
    drawing.finish(&format!("The plain patch and the seven matching blocks, k = {k}"))
}

fn block_name(mask: u8) -> &'static str {
    ["plain", "ph", "pl", "ph and pl", "pr", "ph and pr", "pl and pr", "all three"][mask as usize]
}

/// The patch's vertices with their numbers; those that the block does not use are hollow.
fn dots(drawing: &mut Drawing, patch: &Patch, map: &Map, triangles: &[[u32; 3]]) {
    let used = triangles.as_flattened();
    for (i, sample) in patch.vertices.iter().enumerate() {
        let is_used = used.contains(&(i as u32));
        let fill = if is_used { INK } else { "white" };
        drawing.circle(map.at(*sample), 9.0, Paint { fill, stroke: INK, width: 1.0 });
        drawing.text(map.at(*sample), 11.0, if is_used { "white" } else { FAINT }, &i.to_string());
    }
}

/// Figure 3: patches of both orientations with the numbers of their vertices. One index list fits them all.
pub fn orientations_figure(figure: &Figure) -> String {
    let k = figure.k();
    let layers = layers(k, figure.layers());
    let squares = 2;
    let scale = 270.0 / f64::from(k);
    let side = f64::from(squares * k) * scale;
    let list: Vec<String> = index_list(k, 0).iter().map(|[a, b, c]| format!("({a}, {b}, {c})")).collect();
    let mut drawing = Drawing::new(side + 60.0, side + 60.0 + 24.0 * list.len().div_ceil(6) as f64 + 30.0);
    let map = Map { origin: [30.0, 30.0], first: [0, 0], scale };
    let end = i64::from(squares * k);
    let shown = layers[0].iter().filter(|patch| patch.corners.iter().flatten().all(|at| *at <= end));
    for patch in shown {
        let is_north_west = patch.corners[0] < patch.corners[1].min(patch.corners[2]);
        let fill = if is_north_west { "#dcebf7" } else { "#fdebd8" };
        patch
            .triangles(k, 0)
            .iter()
            .for_each(|t| drawing.polygon(&map.all(*t), Paint { fill, stroke: FAINT, width: 1.0 }));
        drawing.polygon(&map.all(patch.corners), Paint { fill: "none", stroke: INK, width: 2.2 });
        let centre = middle3(patch.corners).map(|sum| sum as f64 / 3.0);
        for (i, vertex) in patch.vertices.iter().enumerate() {
            // Drawn in towards the middle, so that the numbers of neighbours stand beside each other.
            let [x, y] = [0, 1].map(|axis| vertex[axis] as f64 + 0.17 * (centre[axis] - vertex[axis] as f64));
            drawing.text([map.origin[0] + x * scale, map.origin[1] + y * scale], 15.0, INK, &i.to_string());
        }
    }
    drawing.text([30.0 + 0.5 * side, side + 60.0], 15.0, INK, "Index list of every patch:");
    for (i, row) in list.chunks(6).enumerate() {
        drawing.text([30.0 + 0.5 * side, side + 84.0 + 24.0 * i as f64], 15.0, INK, &row.join(" "));
    }
    drawing.finish(&format!("One index list in patches of both orientations, k = {k}"))
}
