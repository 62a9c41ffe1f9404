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
    for mode in ["shaded", "level", "patch", "error", "difference"] {
        script += &format!("do mode {mode}\nwait converged\nscreenshot {mode}.png\n");
    }
    let methods = ["htp", "rqt", "geomipmap", "greedy", "decimated", "htp-instanced window_mib=4 layers=3"];
    for (i, method) in methods.iter().enumerate() {
        script += &format!("do right {method}\nwait converged\nnumbers {i}.toml\n");
    }
    script += "do submission multi\nwait converged\nnumbers multi.toml\ndo exaggeration 2\nwait converged\nnumbers high.toml\n";
    let Some(stage) = Stage::run(&script, &[]) else { return };
    let pictures =
        ["help", "shaded", "level", "patch", "error", "difference"].map(|name| stage.picture(&format!("{name}.png")));
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
    let calls = |name: &str| stage.numbers(name)["left"]["draw_calls"].as_integer().unwrap();
    assert!(calls("multi.toml") <= 2 || calls("multi.toml") == calls("5.toml"), "one call, or no multi-draw here");
    let error = |name: &str| stage.numbers(name)["left"]["cracks"].as_integer();
    assert_eq!(error("high.toml"), Some(0));
}

#[test]
fn a_script_that_cannot_be_read_is_refused_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let output = viewer(folder.path(), "wait 1\nfly\n", &[]);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{stderr}");
    assert!(stderr.starts_with("error: script.txt:2: 'fly': expected do COMMAND"), "{stderr}");
}
