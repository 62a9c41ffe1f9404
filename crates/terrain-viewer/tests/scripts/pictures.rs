//! What the screenshots show.

use std::collections::HashSet;

use image::RgbaImage;

use crate::stage::{SIZE, Stage, viewer};

/// Nothing over the terrain but the divider and the names.
const BARE: &str = "do panel\ndo hud\ndo map\n";

/// Rows that neither names nor messages reach.
fn terrain_rows() -> std::ops::Range<u32> {
    150..SIZE[1]
}

/// Share of the pixels of these columns, in the terrain's rows, that differ.
fn apart(a: &RgbaImage, b: &RgbaImage, columns: std::ops::Range<u32>) -> f64 {
    let pixels: Vec<_> = terrain_rows().flat_map(|y| columns.clone().map(move |x| (x, y))).collect();
    let differ = pixels.iter().filter(|(x, y)| a.get_pixel(*x, *y) != b.get_pixel(*x, *y)).count();
    differ as f64 / pixels.len() as f64
}

fn colours(picture: &RgbaImage) -> usize {
    picture.pixels().collect::<HashSet<_>>().len()
}

#[test]
fn the_divider_cuts_two_whole_pictures_where_it_stands() {
    let script = format!(
        "{BARE}do left tin tolerance_px=3 schedule=blocking\ndo right htp-instanced tolerance_px=3\ndo mode level\nwait converged\n\
         screenshot split.png\nkey Tab\nscreenshot left.png\nkey Tab\nscreenshot right.png\nkey Tab\n\
         drag 240,135 360,135\nscreenshot dragged.png\n"
    );
    let Some(stage) = Stage::run(&script, &[]) else { return };
    let [split, left, right, dragged] =
        ["split", "left", "right", "dragged"].map(|name| stage.picture(&format!("{name}.png")));
    assert!([&split, &left, &right].iter().all(|picture| colours(picture) > 300), "not blank");
    assert!(apart(&left, &right, 0..480) > 0.3, "levels of two methods differ: {}", apart(&left, &right, 0..480));
    // The handle is 26 pixels wide.
    for (picture, divider) in [(&split, 240), (&dragged, 360)] {
        assert_eq!(apart(picture, &left, 0..divider - 14), 0.0, "left of {divider}");
        assert_eq!(apart(picture, &right, divider + 14..480), 0.0, "right of {divider}");
    }
}

#[test]
fn the_error_map_has_the_legends_colours_and_an_exact_mesh_has_none() {
    let script = format!(
        "{BARE}do left full-grid\ndo right decimated step=8\ndo mode error\ndo error-scale 2\nwait converged\n\
         screenshot error.png\n"
    );
    let Some(stage) = Stage::run(&script, &[]) else { return };
    let picture = stage.picture("error.png");
    let is_cold = |x: u32, y: u32| {
        let [r, _, b, _] = picture.get_pixel(x, y).0;
        b > r
    };
    let share_cold = |columns: std::ops::Range<u32>| {
        let pixels: Vec<_> = terrain_rows().flat_map(|y| columns.clone().map(move |x| (x, y))).collect();
        pixels.iter().filter(|(x, y)| is_cold(*x, *y)).count() as f64 / pixels.len() as f64
    };
    assert_eq!(share_cold(0..225), 1.0, "the full grid has no error anywhere");
    assert!(share_cold(255..380) < 0.8, "every eighth sample has: {}", share_cold(255..380));
    // The legend's bar, from its lower end: blue, then green, yellow, red.
    let [x, bottom, top] = [SIZE[0] - 66, SIZE[1] / 2 + 88, SIZE[1] / 2 - 108];
    let legend = |share: f64| {
        let y = f64::from(bottom) - share * f64::from(bottom - top);
        let linear = terrain_renderer::heat_colour(share as f32);
        (picture.get_pixel(x, y as u32).0, linear.map(srgb))
    };
    for share in [0.05, 0.35, 0.65, 0.95] {
        let (found, expected) = legend(share);
        let close = (0..3).all(|i| found[i].abs_diff(expected[i]) <= 24);
        assert!(close, "at {share}: {found:?}, expected {expected:?}");
    }
}

fn srgb(linear: f32) -> u8 {
    let curve = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (255.0 * curve).round() as u8
}

#[test]
fn the_difference_of_a_picture_with_itself_is_dark() {
    let script = format!(
        "{BARE}do left full-grid\ndo right full-grid\ndo mode difference\nwait converged\nscreenshot same.png\n\
         do right decimated step=8\nwait converged\nscreenshot other.png\n"
    );
    let Some(stage) = Stage::run(&script, &[]) else { return };
    let hot = |name: &str| {
        let is_hot = |pixel: &&image::Rgba<u8>| pixel.0[0] > pixel.0[2] + 60;
        let picture = stage.picture(name);
        let rows = terrain_rows();
        let below = picture.enumerate_pixels().filter(|(_, y, _)| rows.contains(y)).map(|(_, _, pixel)| pixel);
        below.filter(is_hot).count()
    };
    assert_eq!(hot("same.png"), 0);
    assert!(hot("other.png") > 300, "{}", hot("other.png"));
}

#[test]
fn a_frozen_mesh_stays_while_the_camera_flies() {
    let script = format!(
        "{BARE}do left tin schedule=blocking\nwait converged\nnumbers before.toml\nkey F\nhold W 30\nhold ArrowLeft 20\n\
         numbers frozen.toml\nscreenshot frozen.png\nkey F\nwait converged\nnumbers after.toml\n"
    );
    let Some(stage) = Stage::run(&script, &[]) else { return };
    let [before, frozen, after] = ["before", "frozen", "after"].map(|name| stage.numbers(&format!("{name}.toml")));
    let triangles = |said: &toml::Table| said["left"]["triangles"].as_integer().unwrap();
    assert_ne!(before["camera"], frozen["camera"]);
    assert_eq!(triangles(&before), triangles(&frozen));
    assert_ne!(triangles(&before), triangles(&after));
    let frustum = stage.picture("frozen.png").pixels().filter(|pixel| pixel.0[0] > 220 && pixel.0[2] < 160).count();
    assert!(frustum > 20, "its frustum is drawn: {frustum}");
}

#[test]
fn a_lost_device_is_replaced_and_draws_the_same() {
    let script = format!(
        "{BARE}do left tin schedule=blocking\nkey Tab\nwait converged\nscreenshot before.png\ndo lose-device\nwait converged\n\
         numbers lost.toml\nscreenshot after.png\n"
    );
    let Some(stage) = Stage::run(&script, &[]) else { return };
    assert!(stage.numbers("lost.toml")["message"].as_str().unwrap().starts_with("the device was lost and replaced"));
    assert_eq!(apart(&stage.picture("before.png"), &stage.picture("after.png"), 0..480), 0.0);
}

#[test]
fn what_the_user_gets_wrong_is_said_in_the_window() {
    let script = "do dem no-such.tif\nwait converged\nnumbers dem.toml\ndo flight no-such.toml\nnumbers flight.toml\n\
                  do camera 1,2\nnumbers camera.toml\nscreenshot said.png\n";
    let Some(stage) = Stage::run(script, &[]) else { return };
    let message = |name| stage.numbers(name)["message"].as_str().unwrap().to_owned();
    assert!(message("dem.toml").contains("no-such.tif"), "{}", message("dem.toml"));
    assert!(message("flight.toml").contains("no-such.toml"), "{}", message("flight.toml"));
    assert!(message("camera.toml").contains("expected X,Y,Z,HEADING,PITCH,FOV"));
}

#[test]
fn every_mode_every_panel_and_every_method_is_drawn() {
    let mut script = String::from("do help\nscreenshot help.png\ndo help\nkey X\nkey N\n");
    let modes = ["shaded", "level", "patch", "cell", "draw", "error", "difference"];
    for mode in modes {
        script += &format!("do mode {mode}\nwait converged\nscreenshot {mode}.png\n");
    }
    let methods = ["htp", "rqt", "geomipmap", "greedy", "decimated", "htp-instanced window_mib=4 layers=3"];
    for (i, method) in methods.iter().enumerate() {
        script += &format!("do right {method}\nwait converged\nnumbers {i}.toml\n");
    }
    script += "do submission multi\nwait converged\nnumbers multi.toml\ndo exaggeration 2\nwait converged\nnumbers high.toml\n";
    let Some(stage) = Stage::run(&script, &[]) else { return };
    let names = ["help"].into_iter().chain(modes);
    let pictures: Vec<_> = names.map(|name| stage.picture(&format!("{name}.png"))).collect();
    for (i, picture) in pictures.iter().enumerate() {
        assert!(colours(picture) > 300, "picture {i} is blank");
        assert!(pictures[..i].iter().all(|other| other != picture), "picture {i} is like another");
    }
    for (i, method) in methods.iter().enumerate() {
        let numbers = stage.numbers(&format!("{i}.toml"));
        let right = numbers["right"].as_table().unwrap();
        assert_eq!(right["method"].as_str().unwrap(), method.split(' ').next().unwrap());
        assert!(right["triangles"].as_integer().unwrap() > 100 && right["cracks"].as_integer() == Some(0), "{method}");
    }
    let count = |name: &str, of: &str| stage.numbers(name)["left"][of].as_integer().unwrap();
    let calls = |name: &str| count(name, "draw_calls");
    assert_eq!(calls("5.toml"), 2 * count("5.toml", "draws"), "the wireframe's are calls too");
    assert!(calls("multi.toml") <= 2 || calls("multi.toml") == calls("5.toml"), "one call, or no multi-draw here");
    let error = |name: &str| stage.numbers(name)["left"]["cracks"].as_integer();
    assert_eq!(error("high.toml"), Some(0));
}

/// Pixels of a window's part that are of a method's accent: boxes and cells are drawn in it.
fn accented(picture: &RgbaImage, [r, g, b]: [u8; 3], columns: std::ops::Range<u32>) -> usize {
    let is_near = |pixel: &image::Rgba<u8>| (0..3).all(|i| pixel.0[i].abs_diff([r, g, b][i]) < 40);
    let pixels = picture.enumerate_pixels().filter(|(x, y, _)| columns.contains(x) && *y > 150);
    pixels.filter(|(_, _, pixel)| is_near(pixel)).count()
}

#[test]
fn each_methods_boxes_are_in_its_part_of_the_window() {
    let script = format!(
        "{BARE}do left tin schedule=blocking tolerance_px=4\ndo right htp-instanced tolerance_px=4\nwait converged\n\
         screenshot none.png\nkey B\nwait 1\nscreenshot boxes.png\n"
    );
    let Some(stage) = Stage::run(&script, &[]) else { return };
    let [none, boxes] = ["none", "boxes"].map(|name| stage.picture(&format!("{name}.png")));
    for (accent, own, other) in [([255, 176, 84], 0..226, 254..480), ([110, 196, 255], 254..480, 0..226)] {
        let grown = |columns: std::ops::Range<u32>| {
            accented(&boxes, accent, columns.clone()).saturating_sub(accented(&none, accent, columns))
        };
        assert!(grown(own.clone()) > 100, "{accent:?}: {}", grown(own));
        assert_eq!(grown(other), 0, "{accent:?}");
    }
}

/// While a live method catches up after a jump, what it still draws for the view before is striped.
#[test]
fn stale_patches_are_striped_until_they_are_updated() {
    let script = "do panel\ndo hud\ndo map\ndo stale\ndo left tin schedule=live tolerance_px=0.25\nkey Tab\nwait converged\n\
                  screenshot before.png\ndo camera 3000,1500,3000,40,-30,60\nnumbers jumped.toml\nscreenshot jumped.png\n\
                  wait converged\nscreenshot after.png\nnumbers after.toml\n";
    let Some(stage) = Stage::run(script, &[]) else { return };
    let striped = |name: &str| {
        let is_magenta = |pixel: &&image::Rgba<u8>| {
            let [r, g, b] = [0, 1, 2].map(|i| i32::from(pixel.0[i]));
            r > g + 90 && b > g + 60
        };
        stage.picture(name).pixels().filter(is_magenta).count()
    };
    let stale = |name: &str| stage.numbers(name)["left"]["stale_patches"].as_integer().unwrap();
    assert_eq!((striped("before.png"), striped("after.png"), stale("after.toml")), (0, 0, 0));
    // The worker may have been faster than the frame.
    assert_eq!(stale("jumped.toml") > 0, striped("jumped.png") > 0, "{} stale", stale("jumped.toml"));
}

#[test]
fn the_map_shows_the_camera_and_the_cells_that_are_loaded() {
    let script = "do panel\ndo hud\ndo left full-grid\ndo right htp-instanced window_mib=4 layers=3 tolerance_px=4\n\
                  key Tab\nwait converged\nscreenshot none.png\nkey Tab\nwait 1\nscreenshot cells.png\n";
    let Some(stage) = Stage::run(script, &[]) else { return };
    let on_map = |name: &str, is: &dyn Fn([u8; 3]) -> bool| {
        let picture = stage.picture(name);
        let pixels = picture.enumerate_pixels().filter(|(x, y, _)| *x > SIZE[0] - 190 && *y < 170);
        pixels.filter(|(_, _, pixel)| is([pixel.0[0], pixel.0[1], pixel.0[2]])).count()
    };
    let yellow = |[r, g, b]: [u8; 3]| r > 215 && g > 195 && b < 160;
    assert!(on_map("none.png", &yellow) > 40, "what the camera sees: {}", on_map("none.png", &yellow));
    let blue = |[r, g, b]: [u8; 3]| b > 225 && g > 170 && r < 150;
    assert_eq!(on_map("none.png", &blue), 0, "the full grid has no cells");
    assert!(on_map("cells.png", &blue) > 60, "{}", on_map("cells.png", &blue));
}

#[test]
fn a_script_that_cannot_be_read_is_refused_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let output = viewer(folder.path(), "wait 1\nfly\n", &[]);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{stderr}");
    assert!(stderr.starts_with("error: script.txt:2: 'fly': expected do COMMAND"), "{stderr}");
}
