//! The wireframe on a real adapter; skipped with a message where there is none.

mod hills;

use hills::shot::{is_background, shaded, shoot};
use hills::{Mesh, SIZE_PX, SPACING_M, adapter, baked_grid, coarse_grid, displaced_grid, oblique, skip, view};
use image::RgbaImage;
use terrain_core::{Heightmap, View};
use terrain_renderer::{Colour, Gpu, Look, Submission};

/// The machine's adapter, if it can draw lines over triangles. (wgpu gives a depth bias to triangles alone on GL.)
fn line_adapter() -> Option<Gpu> {
    let gpu = adapter()?;
    let facts = gpu.facts();
    if facts.wireframe && facts.backend != "gl" { Some(gpu) } else { skip("no lines, or no depth bias for them") }
}

fn picture(gpu: &Gpu, dem: &Heightmap, mesh: &Mesh, view: &View, colour: Colour, wireframe: bool) -> RgbaImage {
    let look = Look { wireframe, ..shaded(colour) };
    shoot(gpu, dem, Submission::Direct, mesh, view, &look).picture
}

/// Where a point of flat ground, given in samples, is in the picture, in pixels from its top left corner; nowhere if it
/// is behind the eye.
fn project(view: &View, [column, row]: [f64; 2]) -> Option<[f64; 2]> {
    let ndc = view.clip_from_world.project_point3([column * SPACING_M, 0.0, row * SPACING_M].into());
    let [width, height] = SIZE_PX.map(f64::from);
    (ndc.z > 0.0).then_some([(0.5 + 0.5 * ndc.x) * width, (0.5 - 0.5 * ndc.y) * height])
}

/// The edges of the triangles of flat ground, in pixels, for squares of `step` samples from one row to the last.
fn edges(view: &View, rows: std::ops::Range<u32>, columns: u32, step: u32) -> Vec<[[f64; 2]; 2]> {
    let squares =
        rows.step_by(step as usize).flat_map(|row| (0..columns).step_by(step as usize).map(move |c| [c, row]));
    let corners = [[[0, 0], [step, 0]], [[0, 0], [0, step]], [[step, 0], [0, step]]];
    let at = |square: [u32; 2], corner: [u32; 2]| project(view, [0, 1].map(|i| f64::from(square[i] + corner[i])));
    let edges = squares.flat_map(|square| corners.map(|[from, to]| Some([at(square, from)?, at(square, to)?])));
    edges.flatten().collect()
}

/// The pixels that a line between two points of the picture must cover: one in each column where it is shallow, one in
/// each row where it is steep; with the neighbour on the other side of the line's middle.
fn covered([a, b]: [[f64; 2]; 2]) -> Vec<[[i64; 2]; 2]> {
    let along = usize::from((b[1] - a[1]).abs() > (b[0] - a[0]).abs());
    let (from, to) = if a[along] < b[along] { (a, b) } else { (b, a) };
    let centres = (from[along].ceil() as i64 + 1)..(to[along].floor() as i64 - 1);
    let pixels = centres.map(|at| {
        let share = (at as f64 + 0.5 - from[along]) / (to[along] - from[along]);
        let across = from[1 - along] + share * (to[1 - along] - from[1 - along]);
        [-0.5, 0.5].map(|aside| {
            let across = (across + aside).floor() as i64;
            if along == 0 { [at, across] } else { [across, at] }
        })
    });
    pixels.collect()
}

#[test]
fn lines_on_flat_ground_have_no_gaps() {
    let Some(gpu) = line_adapter() else { return };
    let dem = hills::heightmap(65, 65, |_, _| 0.0);
    let mesh = coarse_grid(&dem, 4, 8);
    let inside = |[x, y]: [i64; 2]| (0..i64::from(SIZE_PX[0])).contains(&x) && (0..i64::from(SIZE_PX[1])).contains(&y);
    for (height_m, heading) in [(40.0, 0.1), (70.0, 0.35), (150.0, -0.5), (400.0, 0.02)] {
        let view = view(30.0, 66.0, height_m, heading, -0.15);
        let [plain, lines] = [false, true].map(|on| picture(&gpu, &dem, &mesh, &view, Colour::ByLevel, on));
        let changed = |[x, y]: [i64; 2]| plain.get_pixel(x as u32, y as u32) != lines.get_pixel(x as u32, y as u32);
        let pixels = edges(&view, 24..64, 64, 8).into_iter().flat_map(covered);
        let pixels: Vec<_> = pixels.filter(|either| either.iter().all(|pixel| inside(*pixel))).collect();
        let gaps: Vec<_> = pixels.iter().filter(|either| !either.iter().any(|pixel| changed(*pixel))).collect();
        assert!(
            gaps.is_empty() && pixels.len() > 1000,
            "{} gaps of {} pixels, the first at {:?}",
            gaps.len(),
            pixels.len(),
            gaps.first()
        );
    }
}

#[test]
fn the_wireframe_does_not_depend_on_vertex_kind_or_order() {
    let Some(gpu) = line_adapter() else { return };
    let (dem, view) = (hills::hills(), oblique(&hills::hills()));
    for colour in [Colour::Shaded, Colour::ByPatch] {
        let mut backwards = baked_grid(&dem, 1);
        backwards.plan.draws.reverse();
        let [baked, backwards, displaced] = [&baked_grid(&dem, 1), &backwards, &displaced_grid(&dem, 1)]
            .map(|mesh| picture(&gpu, &dem, mesh, &view, colour, true));
        assert!(baked == backwards, "{colour:?}");
        assert!(baked == displaced, "{colour:?}");
    }
}

#[test]
fn a_wireframe_darkens_the_terrain_and_leaves_the_background_alone() {
    let Some(gpu) = line_adapter() else { return };
    let (dem, view) = (hills::hills(), oblique(&hills::hills()));
    let mesh = baked_grid(&dem, 1000);
    let [plain, lines] = [false, true].map(|on| picture(&gpu, &dem, &mesh, &view, Colour::ByLevel, on));
    let near = |at: u32, last: u32| at.saturating_sub(1)..=(at + 1).min(last - 1);
    let (mut terrain, mut dark) = (0, 0);
    for (x, y, pixel) in plain.enumerate_pixels() {
        let line = lines.get_pixel(x, y);
        let mut around = near(x, SIZE_PX[0]).flat_map(|x| near(y, SIZE_PX[1]).map(move |y| [x, y]));
        if around.all(|[x, y]| is_background(plain.get_pixel(x, y))) {
            assert_eq!(line, pixel, "background at {x}, {y}");
        }
        assert!(line.0.iter().zip(pixel.0).all(|(line, plain)| *line <= plain), "brighter at {x}, {y}");
        terrain += u32::from(!is_background(pixel));
        dark += u32::from(line != pixel);
    }
    assert!(dark > terrain / 10 && dark < terrain, "{dark} of {terrain} pixels changed");
}

/// Where triangles are smaller than pixels, lines at full strength would paint the ground black.
#[test]
fn lines_fade_where_they_would_merge() {
    let Some(gpu) = line_adapter() else { return };
    let dem = hills::heightmap(801, 801, |column, row| f64::from((column / 3 + row / 5) % 3));
    let (mesh, view) = (baked_grid(&dem, 1_000_000), view(400.0, 795.0, 300.0, 0.0, -0.25));
    let [plain, lines] = [false, true].map(|on| picture(&gpu, &dem, &mesh, &view, Colour::ByLevel, on));
    let brightness = |picture: &RgbaImage, rows: std::ops::Range<u32>| -> f64 {
        let pixels = picture.enumerate_pixels().filter(|(_, y, pixel)| rows.contains(y) && !is_background(pixel));
        pixels.map(|(_, _, pixel)| f64::from(pixel.0[0]) + f64::from(pixel.0[1])).sum()
    };
    let kept = |rows: std::ops::Range<u32>| brightness(&lines, rows.clone()) / brightness(&plain, rows);
    let (far, near) = (kept(0..60), kept(SIZE_PX[1] - 20..SIZE_PX[1]));
    assert!(far > 0.95 && near < 0.9, "the lines leave {far} of the light in the distance and {near} nearby");
}
