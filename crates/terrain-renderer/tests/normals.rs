//! Normals at pixels and at vertices, on a real adapter; skipped with a message where there is none.

mod hills;

use hills::shot::{is_background, shaded, shoot};
use hills::{Mesh, adapter, baked_grid, coarse_grid, view};
use image::RgbaImage;
use std::f64::consts::FRAC_PI_2;
use terrain_core::Heightmap;
use terrain_renderer::{Colour, Gpu, Look, Normals, Submission};

/// Ripples that are steep enough for the light and too low to show from above where a triangle cuts them off.
fn ripples() -> Heightmap {
    hills::heightmap(129, 129, |column, row| 60.0 * (0.5 * f64::from(column)).sin() * (0.4 * f64::from(row)).cos())
}

/// From high above, where geometry changes little and light much.
fn from_above(gpu: &Gpu, dem: &Heightmap, mesh: &Mesh, normals: Normals) -> RgbaImage {
    let look = Look { normals, ..shaded(Colour::ByLevel) };
    shoot(gpu, dem, Submission::Direct, mesh, &view(64.0, 64.0, 3500.0, 0.0, -FRAC_PI_2), &look).picture
}

/// Mean difference of the colour channels, of 255.
fn difference(a: &RgbaImage, b: &RgbaImage) -> f64 {
    let sum: u64 = a.as_raw().iter().zip(b.as_raw()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / a.as_raw().len() as f64
}

#[test]
fn normals_at_the_vertices_change_with_the_mesh_and_normals_at_the_pixels_do_not() {
    let Some(gpu) = adapter() else { return };
    let dem = ripples();
    let (fine, coarse) = (baked_grid(&dem, 1_000_000), coarse_grid(&dem, 16, 8));
    let pictures = |normals| [&fine, &coarse].map(|mesh| from_above(&gpu, &dem, mesh, normals));
    let [fine_pixels, coarse_pixels] = pictures(Normals::PerPixel);
    let [fine_vertices, coarse_vertices] = pictures(Normals::PerVertex);
    let alike = difference(&fine_pixels, &fine_vertices);
    let apart = difference(&coarse_pixels, &coarse_vertices);
    assert!(alike < 0.5 && apart > 4.0, "{alike} on all samples, {apart} on every eighth");
    let (pixels, vertices) = (difference(&fine_pixels, &coarse_pixels), difference(&fine_vertices, &coarse_vertices));
    assert!(4.0 * pixels < vertices, "from mesh to mesh {pixels} at pixels, {vertices} at vertices");
}

#[test]
fn both_vertex_kinds_have_the_same_normals_at_the_vertices() {
    let Some(gpu) = adapter() else { return };
    let dem = ripples();
    let [baked, displaced] = [&baked_grid(&dem, 1_000_000), &coarse_grid(&dem, 128, 1)]
        .map(|mesh| from_above(&gpu, &dem, mesh, Normals::PerVertex));
    assert!(baked == displaced);
}

/// Eight triangles: with normals of their own each has one shade, with those of the DEM the ripples are seen.
#[test]
fn a_triangle_of_one_grey_has_one_shade() {
    let Some(gpu) = adapter() else { return };
    let (dem, eye) = (ripples(), view(64.0, 64.0, 3500.0, 0.0, -FRAC_PI_2));
    let unlike_neighbours = |normals| {
        let look = Look { normals, haze: false, ..shaded(Colour::Plain) };
        let picture = shoot(&gpu, &dem, Submission::Direct, &coarse_grid(&dem, 2, 64), &eye, &look).picture;
        let is_unlike = |x: u32, y: u32| picture[(x, y)].0[0].abs_diff(picture[(x + 1, y)].0[0]) > 1;
        let places = (0..picture.height()).flat_map(|y| (0..picture.width() - 1).map(move |x| (x, y)));
        places.filter(|(x, y)| is_unlike(*x, *y)).count()
    };
    let (flat, smooth) = (unlike_neighbours(Normals::PerTriangle), unlike_neighbours(Normals::PerPixel));
    assert!(flat < 2000 && smooth > 10_000, "{flat} and {smooth} of 57,420 pairs");
}

/// A level plain is of one grey to the horizon, unless there is haze; its normals point up.
#[test]
fn a_level_plain_shows_haze_and_normals_alone() {
    let Some(gpu) = adapter() else { return };
    let dem = hills::heightmap(65, 65, |_, _| 0.0);
    let eye = view(32.0, 62.0, 100.0, 0.0, -0.2);
    let shades = |look: &Look| {
        let picture = shoot(&gpu, &dem, Submission::Direct, &baked_grid(&dem, 1_000_000), &eye, look).picture;
        picture.pixels().filter(|pixel| !is_background(pixel)).copied().collect::<std::collections::HashSet<_>>()
    };
    let look = |colour, haze| Look { haze, ..shaded(colour) };
    assert_eq!(shades(&look(Colour::Plain, false)).len(), 1);
    assert!(shades(&look(Colour::Plain, true)).len() > 10);
    // 0.5, 0.5 and 1, squared: 137 of 255 in sRGB.
    let up = image::Rgba([137, 137, 255, 255]);
    assert_eq!(shades(&look(Colour::ByNormal, true)), [up].into());
}
