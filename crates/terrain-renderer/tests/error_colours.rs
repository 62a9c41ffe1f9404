//! Colours by error, on a real adapter; skipped with a message where there is none.

mod hills;

use hills::shot::{shaded, shoot};
use hills::{adapter, baked_grid, heightmap, view};
use std::f64::consts::FRAC_PI_2;
use terrain_renderer::{Colour, Look, Submission, heat_colour};

fn srgb(linear: f32) -> u8 {
    let curve = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (255.0 * curve).round() as u8
}

/// A mesh that lies a known height above a plain, seen from straight above.
#[test]
fn a_mesh_has_the_colour_of_its_error_in_pixels() {
    let Some(gpu) = adapter() else { return };
    let plain = heightmap(33, 33, |_, _| 100.0);
    let view = view(16.0, 16.0, 600.0, 0.0, -FRAC_PI_2);
    for above_m in [0.0, 0.5, 1.0, 2.5, 4.0, 6.0] {
        let raised = heightmap(33, 33, |_, _| 100.0 + above_m);
        let look = Look { error_scale_px: 2.0, to_sun: [0.0, 1.0, 0.0], ..shaded(Colour::ByError) };
        let picture = shoot(&gpu, &plain, Submission::Direct, &baked_grid(&raised, 1_000_000), &view, &look).picture;
        let error_px = view.pixels(above_m, 500.0 - above_m);
        let expected = heat_colour((error_px / 2.0) as f32).map(srgb);
        let found = picture.get_pixel(picture.width() / 2, picture.height() / 2).0;
        let close = (0..3).all(|i| found[i].abs_diff(expected[i]) <= 2);
        assert!(close, "{above_m} m, {error_px:.2} px: {found:?}, expected {expected:?}");
    }
}

/// The other diagonal of a quad is no error: both ways to cut it are meshes of all samples.
#[test]
fn all_samples_have_no_error_whichever_way_their_quads_are_cut() {
    let Some(gpu) = adapter() else { return };
    let dem = hills::hills();
    let mut mesh = baked_grid(&dem, 1_000_000);
    let view = hills::straight_down(&dem);
    let look = Look { error_scale_px: 1.0, ..shaded(Colour::ByError) };
    let columns = dem.columns();
    let other: Vec<u32> = (0..dem.rows() - 1)
        .flat_map(|row| (0..columns - 1).map(move |column| row * columns + column))
        .flat_map(|a| {
            let (b, c, d) = (a + 1, a + columns, a + columns + 1);
            [a, c, d, a, d, b]
        })
        .collect();
    for cut in ["one way", "the other way"] {
        let picture = shoot(&gpu, &dem, Submission::Direct, &mesh, &view, &look).picture;
        let cold = heat_colour(0.0);
        // Brightness is the relief's: what is left is the hue.
        let is_cold = |[r, g, b, _]: [u8; 4]| {
            let [dark, _, blue] = [r, g, b].map(|channel| f64::from(channel) / 255.0).map(|c| c.powf(2.2));
            dark / blue < 1.4 * f64::from(cold[0] / cold[2])
        };
        assert!(picture.pixels().all(|pixel| is_cold(pixel.0)), "{cut}");
        mesh.plan.upload(terrain_core::Buffer::Indices, 0, &other);
    }
}
