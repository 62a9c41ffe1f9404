//! Voids left open, on a real adapter; skipped with a message where there is none.

mod hills;

use std::f64::consts::FRAC_PI_2;

use hills::shot::{Shot, is_background, shaded, shoot};
use hills::{Mesh, SIZE_PX, SPACING_M, adapter, baked_grid, coarse_grid, displaced_grid, oblique, straight_down, view};
use image::RgbaImage;
use terrain_core::{HeightFormat, Heightmap, SplitMix64, View, VoidMask};
use terrain_renderer::{Colour, Gpu, Look, Normals, Renderer, RendererSettings, Scene, Submission};

/// The DEM with one of `one_in` samples a void, and a hole of 7 x 5 around the middle.
fn with_voids(dem: Heightmap, one_in: u64) -> Heightmap {
    let mut random = SplitMix64::new(5);
    let (columns, rows) = (dem.columns(), dem.rows());
    let is_hole = |i: u32| (i % columns).abs_diff(columns / 2) <= 3 && (i / columns).abs_diff(rows / 2) <= 2;
    let flags: Vec<bool> = (0..columns * rows).map(|i| random.below(one_in) == 0 || is_hole(i)).collect();
    dem.with_voids(VoidMask::of_flags(columns, &flags).into()).unwrap()
}

/// The same heights, all of them measured.
fn filled(dem: &Heightmap) -> Heightmap {
    Heightmap::new(dem.columns(), dem.rows(), dem.spacing_m(), dem.heights_m().to_vec()).unwrap()
}

/// Looking straight down on the plain at height 0: which pixels show ground (`Some(true)`), which show a void quad or what is
/// beyond the rim, and which are within `margin_px` of another quad, so that nothing is said about them.
fn expected_on_a_plain(
    dem: &Heightmap,
    eye: [f64; 2],
    eye_height_m: f64,
    view: &View,
    margin_px: f64,
) -> Vec<Option<bool>> {
    let px_per_quad = view.pixels(SPACING_M, eye_height_m);
    let voids = dem.voids().unwrap();
    let is_ground = |[x, z]: [f64; 2]| {
        let (column, row) = (x.floor(), z.floor());
        let is_inside =
            column >= 0.0 && row >= 0.0 && column < (dem.columns() - 1) as f64 && row < (dem.rows() - 1) as f64;
        let is_void = |dx, dz| voids.is_void(column as u32 + dx, row as u32 + dz);
        is_inside && !is_void(0, 0) && !is_void(1, 0) && !is_void(0, 1) && !is_void(1, 1)
    };
    let pixels = (0..SIZE_PX[1]).flat_map(|y| (0..SIZE_PX[0]).map(move |x| [x, y]));
    pixels
        .map(|pixel| {
            let at = |dx: f64, dy: f64| {
                let offset_px = [pixel[0] as f64 + 0.5 + dx, pixel[1] as f64 + 0.5 + dy];
                is_ground([0, 1].map(|i| eye[i] + (offset_px[i] - 0.5 * SIZE_PX[i] as f64) / px_per_quad))
            };
            let m = margin_px;
            let near = [at(0.0, 0.0), at(m, m), at(m, -m), at(-m, m), at(-m, -m)];
            near.iter().all(|ground| *ground == near[0]).then_some(near[0])
        })
        .collect()
}

/// How many pixels show ground, and how many do not; all are as expected.
fn assert_shows(picture: &RgbaImage, expected: &[Option<bool>], what: &str) -> [usize; 2] {
    for ((x, y, pixel), expected) in picture.enumerate_pixels().zip(expected) {
        assert!(expected.is_none_or(|ground| ground != is_background(pixel)), "{what}: pixel {x}, {y} is {pixel:?}");
    }
    [true, false].map(|ground| expected.iter().filter(|expected| **expected == Some(ground)).count())
}

/// Each source of heights, and triangles larger than quads.
fn meshes(dem: &Heightmap) -> Vec<(&'static str, Mesh)> {
    let tiled = hills::tiled(dem, &displaced_grid(dem, 8), HeightFormat::F32, false);
    vec![
        ("baked", baked_grid(dem, 1000)),
        ("displaced", displaced_grid(dem, 8)),
        ("of 5 quads a side", coarse_grid(dem, 2, 5)),
        ("tiled", tiled),
    ]
}

#[test]
fn the_quads_at_voids_are_left_undrawn_and_no_others_are() {
    let Some(gpu) = adapter() else { return };
    let dem = with_voids(hills::heightmap(59, 43, |_, _| 0.0), 40);
    let (eye, height_m) = ([29.3, 21.7], 900.0);
    let view = view(eye[0], eye[1], height_m, 0.0, -FRAC_PI_2);
    let expected = expected_on_a_plain(&dem, eye, height_m, &view, 0.02);
    for (name, mesh) in meshes(&dem) {
        for (submission, look) in [
            (Submission::Direct, shaded(Colour::Shaded)),
            (Submission::MultiIndirect, shaded(Colour::ByPatch)),
            (Submission::Direct, Look { normals: Normals::PerVertex, ..shaded(Colour::Shaded) }),
        ] {
            let shot = shoot(&gpu, &dem, submission, &mesh, &view, &look);
            let [ground, open] = assert_shows(&shot.picture, &expected, name);
            assert!(ground > 30_000 && open > 4_000, "{name}: {ground} pixels of ground, {open} open");
        }
    }
}

/// Where sample numbers no longer fit into half of a float, and the mask's texture has several rows.
#[test]
fn quads_far_from_the_origin_are_told_apart() {
    let Some(gpu) = adapter() else { return };
    let dem = with_voids(hills::heightmap(6000, 40, |_, _| 0.0), 30);
    for column in [40.6, 5970.4] {
        let (eye, height_m) = ([column, 20.1], 300.0);
        let view = view(eye[0], eye[1], height_m, 0.0, -FRAC_PI_2);
        let shot = shoot(&gpu, &dem, Submission::Direct, &baked_grid(&dem, 300_000), &view, &shaded(Colour::Shaded));
        let expected = expected_on_a_plain(&dem, eye, height_m, &view, 0.05);
        let [ground, open] = assert_shows(&shot.picture, &expected, "far away");
        assert!(ground > 30_000 && open > 4_000, "{ground} pixels of ground, {open} open");
    }
}

/// Lines reach half a pixel beyond their quad.
#[test]
fn lines_end_at_voids() {
    let Some(gpu) = adapter() else { return };
    if !gpu.facts().wireframe {
        return;
    }
    let dem = with_voids(hills::heightmap(59, 43, |_, _| 0.0), 40);
    let (eye, height_m) = ([29.3, 21.7], 600.0);
    let view = view(eye[0], eye[1], height_m, 0.0, -FRAC_PI_2);
    let look = Look { wireframe: true, ..shaded(Colour::Shaded) };
    let expected = expected_on_a_plain(&dem, eye, height_m, &view, 1.0);
    let shoot = |dem: &Heightmap| shoot(&gpu, dem, Submission::Direct, &baked_grid(dem, 1000), &view, &look).picture;
    let (open, whole) = (shoot(&dem), shoot(&filled(&dem)));
    assert_shows(&open, &expected, "lines");
    let same = open.pixels().zip(whole.pixels()).zip(&expected);
    assert!(same.filter(|(_, expected)| **expected == Some(true)).all(|((open, whole), _)| open == whole));
}

/// What a pixel shows, as a point in samples; `None` of the background.
fn ground_at(shot: &Shot, view: &View, [x, y]: [u32; 2]) -> Option<[f64; 2]> {
    let depth = shot.depth[(y * SIZE_PX[0] + x) as usize];
    let ndc = [x, y].map(|at| f64::from(at) + 0.5);
    let clip = [2.0 * ndc[0] / SIZE_PX[0] as f64 - 1.0, 1.0 - 2.0 * ndc[1] / SIZE_PX[1] as f64, depth.into()];
    let world = view.clip_from_world.inverse().project_point3(clip.into());
    (depth > 0.0).then(|| [world.x / SPACING_M, world.z / SPACING_M])
}

/// Hills: a pixel that shows a void quad in the filled picture shows something farther away, or the background; all others
/// are as they were.
#[test]
fn what_is_behind_a_hole_is_seen_through_it() {
    let Some(gpu) = adapter() else { return };
    if gpu.facts().backend == "gl" {
        return;
    }
    let dem = with_voids(hills::hills(), 60);
    let voids = dem.voids().unwrap();
    for (view, farther) in [(oblique(&dem), true), (straight_down(&dem), false)] {
        let look = shaded(Colour::Shaded);
        let shot = |dem: &Heightmap| shoot(&gpu, dem, Submission::Direct, &displaced_grid(dem, 8), &view, &look);
        let (open, whole) = (shot(&dem), shot(&filled(&dem)));
        let (mut kept, mut sky, mut ground_behind) = (0, 0, 0);
        for (i, [x, y]) in (0..SIZE_PX[1]).flat_map(|y| (0..SIZE_PX[0]).map(move |x| [x, y])).enumerate() {
            let pixel = |shot: &Shot| *shot.picture.get_pixel(x, y);
            let Some(at) = ground_at(&whole, &view, [x, y]) else {
                assert!(is_background(&pixel(&open)));
                continue;
            };
            if at.iter().any(|at| (at - at.round()).abs() < 0.01) {
                continue; // too near a quad's border to tell
            }
            let [column, row] = at.map(|at| at as u32);
            let is_void = [(0, 0), (1, 0), (0, 1), (1, 1)].iter().any(|(c, r)| voids.is_void(column + c, row + r));
            if is_void {
                assert!(open.depth[i] < whole.depth[i], "pixel {x}, {y}");
                sky += is_background(&pixel(&open)) as u32;
                ground_behind += !is_background(&pixel(&open)) as u32;
            } else {
                assert!(pixel(&open) == pixel(&whole) && open.depth[i] == whole.depth[i], "pixel {x}, {y}");
                kept += 1;
            }
        }
        assert!(kept > 10_000 && sky > 1_000, "{kept} pixels kept, {sky} see the background");
        assert_eq!(ground_behind > 50, farther, "{ground_behind} pixels see other ground");
    }
}

/// Heights of a method's own, and none of the DEM's on the GPU.
#[test]
fn a_scene_without_heights_leaves_voids_open_too() {
    let Some(gpu) = adapter() else { return };
    let dem = with_voids(hills::hills(), 60);
    let tiled = hills::tiled(&dem, &displaced_grid(&dem, 8), HeightFormat::F32, false);
    let (view, look) = (oblique(&dem), shaded(Colour::Shaded));
    let with = shoot(&gpu, &dem, Submission::Direct, &tiled, &view, &look).picture;
    let scene = Scene::without_heights(&gpu, [59, 43], dem.spacing_m(), [-310.0, 310.0]).unwrap();
    let without = picture(&gpu, scene.with_voids(&gpu, dem.voids().unwrap()).unwrap(), &tiled, &view, &look);
    let shown = |picture: &RgbaImage| picture.pixels().map(is_background).collect::<Vec<_>>();
    assert!(shown(&with) == shown(&without) && with != without);
}

fn picture(gpu: &Gpu, scene: Scene, mesh: &Mesh, view: &View, look: &Look) -> RgbaImage {
    let settings = RendererSettings { size_px: SIZE_PX, ..Default::default() };
    let mut renderer = Renderer::over(gpu.clone(), scene, &settings).unwrap();
    let mut buffers = renderer.buffers(mesh.sizes).unwrap();
    renderer.frame(view, &mesh.plan, &mut buffers, look).unwrap();
    renderer.target().read_back(gpu).unwrap()
}
