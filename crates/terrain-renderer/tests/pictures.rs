//! Pictures on a real adapter; skipped with a message where there is none.

mod hills;

use hills::shot::{is_background, shaded, shoot, terrain_pixels};
use hills::{SIZE_PX, adapter, baked_grid, coarse_grid, displaced_grid, oblique, straight_down, view};
use std::f64::consts::FRAC_PI_2;
use terrain_core::{
    Buffer, BufferSizes, Draw, FramePlan, Growth, HeightFormat, HeightTiles, IndexFormat, PatchTag, Sample,
};
use terrain_renderer::{
    Colour, Look, MethodBuffers, RenderError, Renderer, RendererSettings, Scene, Submission, Target, TerrainPass,
};

#[test]
fn both_submissions_draw_the_same_picture() {
    let Some(gpu) = adapter() else { return };
    let (dem, view) = (hills::hills(), oblique(&hills::hills()));
    for mesh in [baked_grid(&dem, 37), displaced_grid(&dem, 5)] {
        for colour in [Colour::Shaded, Colour::ByPatch, Colour::ByLevel] {
            let direct = shoot(&gpu, &dem, Submission::Direct, &mesh, &view, &shaded(colour));
            let indirect = shoot(&gpu, &dem, Submission::MultiIndirect, &mesh, &view, &shaded(colour));
            assert!(direct.picture == indirect.picture, "{colour:?}");
            assert!(direct.depth == indirect.depth);
            assert_eq!(direct.times.draw_calls as usize, mesh.plan.draws.len());
        }
    }
}

/// More draws than wgpu's validation of indirect draws puts into one of its own buffers (52,428).
#[test]
fn tens_of_thousands_of_indirect_draws_are_all_drawn() {
    let Some(gpu) = adapter() else { return };
    let dem = hills::heightmap(301, 201, |column, row| f64::from(column % 7 * 30 + row % 5 * 40));
    let (mesh, view) = (baked_grid(&dem, 1), straight_down(&dem));
    let one = shoot(&gpu, &dem, Submission::Direct, &baked_grid(&dem, 60_000), &view, &shaded(Colour::Shaded));
    let many = shoot(&gpu, &dem, Submission::MultiIndirect, &mesh, &view, &shaded(Colour::Shaded));
    assert_eq!((mesh.plan.draws.len(), many.times.primitives.unwrap_or(120_000)), (60_000, 120_000));
    assert!(one.picture == many.picture && one.depth == many.depth);
}

#[test]
fn both_vertex_kinds_draw_the_same_picture() {
    let Some(gpu) = adapter() else { return };
    let (dem, view) = (hills::hills(), oblique(&hills::hills()));
    let shot = |mesh| shoot(&gpu, &dem, Submission::Direct, &mesh, &view, &shaded(Colour::Shaded));
    let baked = shot(baked_grid(&dem, 1000));
    assert!(terrain_pixels(&baked.picture, 0..SIZE_PX[0]) > 20_000);
    for quads in [1, 8] {
        let displaced = shot(displaced_grid(&dem, quads));
        assert!(baked.depth == displaced.depth, "patches of {quads}");
        assert!(baked.picture == displaced.picture, "patches of {quads}");
    }
}

/// From tiles, and from the coarse grid.
#[test]
fn heights_of_tiles_draw_the_same_picture_as_those_of_the_scene() {
    let Some(gpu) = adapter() else { return };
    // Heights in steps of 1/8 m from -500 m on, so that all formats hold them.
    let hills = hills::hills();
    let height_m = |column, row| (8.0 * f64::from(hills.height_m(Sample { column, row }))).round() / 8.0;
    let (dem, view) = (hills::heightmap(59, 43, height_m), oblique(&hills));
    for format in [HeightFormat::F32, HeightFormat::U16 { scale_m: 0.125, offset_m: -500.0 }] {
        for (coarse, look) in [(false, Colour::Shaded), (false, Colour::ByLevel), (true, Colour::Shaded)] {
            let displaced = if coarse { coarse_grid(&dem, 2, 4) } else { displaced_grid(&dem, 8) };
            let tiled = hills::tiled(&dem, &displaced, format, coarse);
            let [expected, found] =
                [displaced, tiled].map(|mesh| shoot(&gpu, &dem, Submission::Direct, &mesh, &view, &shaded(look)));
            assert!(terrain_pixels(&found.picture, 0..SIZE_PX[0]) > 10_000);
            assert!(expected.depth == found.depth && expected.picture == found.picture, "{format:?}, coarse: {coarse}");
        }
    }
}

/// The mesh is the same; the light falls on its triangles.
#[test]
fn a_scene_without_heights_draws_tiles_and_refuses_what_needs_them() {
    let Some(gpu) = adapter() else { return };
    let (dem, view) = (hills::hills(), oblique(&hills::hills()));
    let displaced = displaced_grid(&dem, 8);
    let tiled = hills::tiled(&dem, &displaced, HeightFormat::F32, false);
    let look = shaded(Colour::Shaded);
    let with = shoot(&gpu, &dem, Submission::Direct, &tiled, &view, &look);
    let scene = Scene::without_heights(&gpu, [59, 43], dem.spacing_m(), [-310.0, 310.0]).unwrap();
    let settings = RendererSettings { size_px: SIZE_PX, ..Default::default() };
    let mut renderer = Renderer::over(gpu.clone(), scene, &settings).unwrap();
    let mut buffers = renderer.buffers(tiled.sizes).unwrap();
    renderer.frame(&view, &tiled.plan, &mut buffers, &look).unwrap();
    let without = renderer.target().read_back(&gpu).unwrap();
    let is_drawn = |picture: &image::RgbaImage| picture.pixels().map(is_background).collect::<Vec<_>>();
    assert!(is_drawn(&with.picture) == is_drawn(&without) && with.picture != without);
    let black = without.pixels().filter(|pixel| pixel.0[..3] == [0; 3]).count();
    assert_eq!(black, 0, "normals are finite");

    let mut buffers = renderer.buffers(displaced.sizes).unwrap();
    let refused = renderer.frame(&view, &displaced.plan, &mut buffers, &look).unwrap_err();
    assert!(matches!(refused, RenderError::NoHeights), "{refused}");
}

#[test]
fn narrow_indices_in_a_buffer_that_grew_draw_the_same_picture() {
    let Some(gpu) = adapter() else { return };
    let (dem, view) = (hills::hills(), oblique(&hills::hills()));
    let wide = baked_grid(&dem, 1000);
    let indices: &[u32] = bytemuck::cast_slice(wide.plan.bytes_of(&wide.plan.uploads[1]));
    let narrow: Vec<u16> = indices.iter().map(|index| *index as u16).collect();
    let (all, half) = (2 * narrow.len() as u64, narrow.len() / 4 * 2);
    let [mut first, mut second] = [FramePlan::default(), FramePlan::default()];
    first.upload(Buffer::Vertices, 0, wide.plan.bytes_of(&wide.plan.uploads[0]));
    first.upload(Buffer::Indices, 0, &narrow[..half]);
    second.growths.push(Growth { buffer: Buffer::Indices, bytes: all });
    second.upload(Buffer::Indices, 2 * half as u64, &narrow[half..]);
    second.draws.clone_from(&wide.plan.draws);

    let expected = shoot(&gpu, &dem, Submission::Direct, &wide, &view, &shaded(Colour::Shaded));
    let settings = RendererSettings { size_px: SIZE_PX, ..Default::default() };
    let mut renderer = Renderer::new(gpu.clone(), &dem, &settings).unwrap();
    let sizes = BufferSizes { index_format: IndexFormat::U16, indices: 2 * half as u64, ..wide.sizes };
    let mut buffers = renderer.buffers(sizes).unwrap();
    for plan in [&first, &second] {
        renderer.frame(&view, plan, &mut buffers, &shaded(Colour::Shaded)).unwrap();
    }
    assert!(expected.picture == renderer.target().read_back(&gpu).unwrap());
}

/// One quad a patch, so that the patches of both kinds are the same and in the same order.
#[test]
fn both_vertex_kinds_have_the_same_colours_by_patch_and_by_level() {
    let Some(gpu) = adapter() else { return };
    let (dem, view) = (hills::hills(), oblique(&hills::hills()));
    for colour in [Colour::ByPatch, Colour::ByLevel] {
        let [baked, displaced] = [baked_grid(&dem, 1), displaced_grid(&dem, 1)]
            .map(|mesh| shoot(&gpu, &dem, Submission::Direct, &mesh, &view, &shaded(colour)).picture);
        assert!(baked == displaced, "{colour:?}");
    }
}

/// One row of quads for each level that a tag has room for, and one patch number for all.
#[test]
fn all_levels_have_colours_of_their_own() {
    let Some(gpu) = adapter() else { return };
    let dem = hills::heightmap(17, 17, |_, _| 0.0);
    let mut mesh = baked_grid(&dem, 16);
    for (level, draw) in mesh.plan.draws.iter_mut().enumerate() {
        *draw = Draw::baked(draw.indices.clone(), 0, PatchTag { patch: 5, level: level as u32 });
    }
    let view = view(8.0, 8.0, 600.0, 0.0, -FRAC_PI_2);
    let colours = |colour| -> Vec<[u8; 3]> {
        let picture = shoot(&gpu, &dem, Submission::Direct, &mesh, &view, &Look { colour, ..Look::default() }).picture;
        let px_per_row = view.pixels(hills::SPACING_M, 600.0);
        let middle = |row: u32| (0.5 * f64::from(SIZE_PX[1]) + (f64::from(row) - 7.5) * px_per_row) as u32;
        (0..16).map(|row| picture.get_pixel(SIZE_PX[0] / 2, middle(row)).0).map(|[r, g, b, _]| [r, g, b]).collect()
    };
    // The haze changes a colour a little.
    let alike = |a: &[u8; 3], b: &[u8; 3]| a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) < 12);
    let (levels, patches) = (colours(Colour::ByLevel), colours(Colour::ByPatch));
    let twins = (1..16).find(|at| levels[..*at].iter().any(|other| alike(other, &levels[*at])));
    assert_eq!(twins, None, "{levels:?}");
    assert!(levels.iter().all(|level| level.iter().any(|channel| *channel > 80)), "none is black: {levels:?}");
    assert!(patches.iter().all(|patch| alike(patch, &patches[0])), "one patch: {patches:?}");
}

/// As a split screen does: everything is queued before anything is drawn.
#[test]
fn two_methods_in_two_views_share_a_submission() {
    let Some(gpu) = adapter() else { return };
    let dem = hills::hills();
    let (baked, displaced) = (baked_grid(&dem, 37), displaced_grid(&dem, 5));
    let (left, right) = (oblique(&dem), straight_down(&dem));
    let (by_patch, by_level) = (shaded(Colour::ByPatch), shaded(Colour::ByLevel));
    for submission in [Submission::Direct, Submission::MultiIndirect] {
        let pass = TerrainPass::new(&gpu, Scene::new(&gpu, &dem).unwrap(), Target::COLOUR_FORMAT, submission).unwrap();
        let mut bindings = [(); 2].map(|()| pass.view_bindings(&gpu));
        let mut buffers = [&baked, &displaced].map(|mesh| MethodBuffers::new(&gpu, mesh.sizes).unwrap());
        let targets = [(); 2].map(|()| Target::new(&gpu, SIZE_PX).unwrap());
        let ([buffers_a, buffers_b], [bindings_a, bindings_b]) = (&mut buffers, &mut bindings);
        let a = pass.prepare(&gpu, &left, &baked.plan, &by_patch, buffers_a, bindings_a).unwrap();
        let b = pass.prepare(&gpu, &right, &displaced.plan, &by_level, buffers_b, bindings_b).unwrap();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        for (frame, target) in [a, b].iter().zip(&targets) {
            let (colour, depth) = (target.colour_view(), target.depth_view());
            frame.draw(&mut TerrainPass::begin(&mut encoder, colour, depth, &by_patch, None));
        }
        gpu.queue.submit([encoder.finish()]);
        let alone = [
            shoot(&gpu, &dem, submission, &baked, &left, &by_patch),
            shoot(&gpu, &dem, submission, &displaced, &right, &by_level),
        ];
        for (target, alone) in targets.iter().zip(alone) {
            assert!(target.read_back(&gpu).unwrap() == alone.picture, "{submission:?}");
        }
    }
}

#[test]
fn the_gpu_counts_the_triangles_of_the_plan() {
    let Some(gpu) = adapter() else { return };
    let dem = hills::hills();
    for view in [oblique(&dem), straight_down(&dem)] {
        for (mesh, submission) in [
            (baked_grid(&dem, 100), Submission::Direct),
            (baked_grid(&dem, 100), Submission::MultiIndirect),
            // Reaches over the rim: triangles without area are counted too.
            (displaced_grid(&dem, 8), Submission::Direct),
        ] {
            let look = Look { wireframe: gpu.facts().wireframe, ..Look::default() };
            let counted = shoot(&gpu, &dem, submission, &mesh, &view, &look).times.primitives;
            assert_eq!(counted.is_some(), gpu.facts().pipeline_statistics);
            assert_eq!(counted.unwrap_or(mesh.triangles()), mesh.triangles());
        }
    }
}

#[test]
fn terrain_from_above_has_no_holes() {
    let Some(gpu) = adapter() else { return };
    let dem = hills::hills();
    let mesh = baked_grid(&dem, 1000);
    let shot = shoot(&gpu, &dem, Submission::Direct, &mesh, &straight_down(&dem), &shaded(Colour::Shaded));
    assert!(!shot.picture.pixels().any(is_background));
    assert!(shot.depth.iter().all(|&depth| depth > 0.0));
}

#[test]
fn terrain_from_below_is_culled() {
    let Some(gpu) = adapter() else { return };
    // Too gentle for any slope to face a camera below it.
    let dem = hills::heightmap(41, 41, |column, row| f64::from(column % 3 + row % 4));
    let up = view(20.0, 20.0, -2000.0, 0.0, FRAC_PI_2);
    let shot = shoot(&gpu, &dem, Submission::Direct, &baked_grid(&dem, 1000), &up, &shaded(Colour::Shaded));
    assert!(shot.picture.pixels().all(is_background));
}

#[test]
fn looking_north_a_peak_in_the_east_stands_on_the_right() {
    let Some(gpu) = adapter() else { return };
    let (left, right) = (0..SIZE_PX[0] / 2, SIZE_PX[0] / 2..SIZE_PX[0]);
    for (column, expected) in [(28, &right), (12, &left)] {
        let dem = hills::peak_at(41, 41, Sample { column, row: 15 });
        let north = view(20.0, 42.0, 200.0, 0.0, 0.1);
        let mesh = baked_grid(&dem, 10_000);
        let shot = shoot(&gpu, &dem, Submission::Direct, &mesh, &north, &shaded(Colour::Shaded));
        let other = if expected == &right { &left } else { &right };
        let (with, without) =
            (terrain_pixels(&shot.picture, expected.clone()), terrain_pixels(&shot.picture, other.clone()));
        assert!(with > without + 500, "peak at column {column}: {with} pixels against {without}");
    }
}

#[test]
fn depth_is_near_plane_over_distance() {
    let Some(gpu) = adapter() else { return };
    let dem = hills::heightmap(41, 41, |_, _| 100.0);
    let down = view(20.0, 20.0, 600.0, 0.0, -FRAC_PI_2);
    let shot = shoot(&gpu, &dem, Submission::Direct, &baked_grid(&dem, 10_000), &down, &Look::default());
    assert!(shot.depth.iter().all(|&depth| (depth - 1.0 / 500.0).abs() < 1e-8));
}

/// The same ground twice on one DEM, 126 km apart: the pictures agree to the last bit of depth.
#[test]
fn far_from_the_origin_nothing_is_lost() {
    let Some(gpu) = adapter() else { return };
    let dem = hills::heightmap(4096 + 65, 33, |column, row| f64::from(column % 64 * 3 + row * 2));
    let mesh = baked_grid(&dem, 1_000_000);
    let at = |column| view(column, 16.25, 350.0, 0.3, -FRAC_PI_2);
    let [near, far] = [at(32.25), at(4096.0 + 32.25)]
        .map(|view| shoot(&gpu, &dem, Submission::Direct, &mesh, &view, &Look::default()));
    assert!(near.depth.iter().all(|&depth| depth > 0.0));
    assert!(near.depth == far.depth);
}

#[test]
fn times_are_measured_where_the_adapter_can() {
    let Some(gpu) = adapter() else { return };
    let (dem, view) = (hills::hills(), oblique(&hills::hills()));
    let times = shoot(&gpu, &dem, Submission::Direct, &baked_grid(&dem, 100), &view, &Look::default()).times;
    assert_eq!(times.gpu.is_some(), gpu.facts().timestamps);
    assert!(times.gpu.is_none_or(|gpu| !gpu.is_zero()) && !times.encode.is_zero());
}

#[test]
fn what_the_adapter_cannot_hold_is_refused() {
    let Some(gpu) = adapter() else { return };
    let limits = gpu.device.limits();
    let sizes = BufferSizes { indices: limits.max_buffer_size + 4, ..baked_grid(&hills::hills(), 100).sizes };
    let refused = MethodBuffers::new(&gpu, sizes).unwrap_err();
    assert!(matches!(refused, RenderError::BufferTooLarge { buffer: "index", .. }), "{refused}");

    let tiles = HeightTiles {
        format: HeightFormat::F32,
        samples: [60_000; 2],
        k: 2,
        coarse_level: 1,
        cell_side: 2,
        windows: [30_000, 0, 0, 0, 0, 0],
    };
    let sizes = BufferSizes { heights: Some(tiles), ..displaced_grid(&hills::hills(), 8).sizes };
    let refused = MethodBuffers::new(&gpu, sizes).unwrap_err();
    assert!(matches!(refused, RenderError::BufferTooLarge { buffer: "height", .. }), "{refused}");

    let too_long = limits.max_texture_dimension_2d + 1;
    let refused = Scene::new(&gpu, &hills::heightmap(too_long, 2, |_, _| 0.0)).unwrap_err();
    assert!(matches!(refused, RenderError::TextureTooLarge { what: "DEM", .. }), "{refused}");
    let refused = Target::new(&gpu, [2, too_long]).unwrap_err();
    assert!(matches!(refused, RenderError::TextureTooLarge { what: "picture", .. }), "{refused}");
}

#[test]
fn a_draw_beyond_the_indices_is_an_error_and_the_next_picture_is_drawn() {
    let Some(gpu) = adapter() else { return };
    let (dem, view) = (hills::hills(), straight_down(&hills::hills()));
    let mesh = baked_grid(&dem, 100);
    let mut broken = mesh.plan.clone();
    broken.draws[0].indices.end = u32::MAX;
    for submission in [Submission::Direct, Submission::MultiIndirect] {
        let settings = RendererSettings { size_px: SIZE_PX, submission, ..Default::default() };
        let mut renderer = Renderer::new(gpu.clone(), &dem, &settings).unwrap();
        let mut buffers = renderer.buffers(mesh.sizes).unwrap();
        renderer.frame(&view, &broken, &mut buffers, &shaded(Colour::Shaded)).unwrap_err();
        renderer.frame(&view, &mesh.plan, &mut buffers, &shaded(Colour::Shaded)).unwrap();
        assert!(!renderer.target().read_back(&gpu).unwrap().pixels().any(is_background));
    }
}
