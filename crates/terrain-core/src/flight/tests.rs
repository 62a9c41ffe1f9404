use glam::DVec3;

use super::*;
use crate::{Heightmap, SplitMix64};

fn dem(columns: u32, rows: u32, spacing_m: [f64; 2], relief_m: f64) -> Heightmap {
    let mut random = SplitMix64::new(9);
    let heights = (0..columns * rows).map(|_| (relief_m * random.range(-0.5, 0.5)) as f32).collect();
    Heightmap::new(columns, rows, spacing_m, heights).unwrap()
}

fn flat() -> Heightmap {
    dem(11, 6, [10.0, 20.0], 0.0)
}

/// A flight of world positions that looks at the origin, one line a key.
fn world_flight(keys: &[(f64, [f64; 3])]) -> Flight {
    let keys = keys.iter().map(|(time_s, [x, y, z])| {
        format!("[[key]]\ntime_s = {time_s}\nposition_m = [{x:?}, {y:?}, {z:?}]\nheading_deg = 0\npitch_deg = 0\n")
    });
    Flight::parse("test.toml", &format!("name = 'test'\n{}", keys.collect::<String>())).unwrap()
}

#[test]
fn shipped_flights_fit_any_dem() {
    let sizes = [
        (2, 2, [1.0, 1.0]),
        (2, 3, [1000.0, 0.5]),
        (10, 10, [1.0, 1.0]),
        (17, 9, [1.0, 1.0]),
        (403, 344, [74.0, 93.0]),
        (317, 460, [30.0, 30.0]),
        (1025, 1025, [160.0, 160.0]),
    ];
    for (columns, rows, spacing_m) in sizes {
        for relief_m in [0.0, 0.3 * spacing_m[0], 3000.0] {
            let dem = dem(columns, rows, spacing_m, relief_m);
            for (name, text) in BUILT_IN {
                let flight = Flight::parse(name, text).unwrap();
                let path = FlightPath::new(&flight, &dem, flight.default_frames()).unwrap();
                assert!((0..path.len()).all(|frame| path.view(frame, [64, 48]).is_ok()), "{name}");
            }
        }
    }
}

/// Found by a review: the end of fly-over looked past the DEM, and its empty frames counted as fast ones without error.
#[test]
fn shipped_flights_see_terrain_in_every_frame() {
    for (columns, rows, spacing_m) in [(403, 344, [74.0, 93.0]), (60, 150, [30.0, 30.0]), (150, 60, [160.0, 160.0])] {
        let dem = dem(columns, rows, spacing_m, 300.0);
        let sees = |view: &crate::View| {
            let samples = (0..rows).flat_map(|row| (0..columns).map(move |column| crate::Sample { column, row }));
            samples.filter(|sample| view.sees_point(DVec3::from(dem.world(*sample)))).count()
        };
        for (name, _) in BUILT_IN {
            let path = FlightPath::new(&Flight::built_in(name).unwrap(), &dem, 60).unwrap();
            for frame in 0..path.len() {
                let view = path.view(frame, [640, 360]).unwrap();
                assert!(sees(&view) > 20, "{name}, {columns} x {rows}, frame {frame}");
            }
        }
    }
}

#[test]
fn built_in_flights_go_by_their_names() {
    for (name, _) in BUILT_IN {
        let flight = Flight::built_in(name).unwrap();
        assert_eq!(flight.name(), name);
        assert!((10.0..=20.0).contains(&flight.duration_s()), "{name}");
    }
    assert_eq!(Flight::built_in("no-such-flight"), None);
}

#[test]
fn frames_pass_the_keys_at_their_times() {
    let keys = [(2.0, [10.0, 5.0, 20.0]), (3.0, [90.0, 50.0, 80.0]), (5.0, [15.0, 7.0, 60.0])];
    let flight = world_flight(&keys);
    assert_eq!(flight.default_frames(), 181);
    let path = FlightPath::new(&flight, &flat(), 31).unwrap();
    assert_eq!(path.step_s(), 0.1);
    for (frame, (_, place)) in [0, 10, 30].into_iter().zip(keys) {
        assert!(path.camera(frame).eye_world.distance(DVec3::from(place)) < 1e-9);
    }
}

#[test]
fn one_frame_is_the_start() {
    let path = FlightPath::new(&world_flight(&[(0.0, [10.0; 3]), (1.0, [20.0; 3])]), &flat(), 1).unwrap();
    assert_eq!((path.len(), path.camera(0).eye_world, path.step_s()), (1, DVec3::splat(10.0), 1.0));
}

#[test]
fn stop_and_go_stands_still_between_its_equal_keys() {
    let flight = Flight::built_in("stop-and-go").unwrap();
    let path = FlightPath::new(&flight, &dem(50, 40, [30.0, 30.0], 20.0), 121).unwrap();
    for (stop, frames) in [(40, 40..=70), (90, 90..=120)] {
        assert!(frames.into_iter().all(|frame| path.camera(frame) == path.camera(stop)));
    }
    assert_ne!(path.camera(39), path.camera(40));
    assert_ne!(path.camera(70), path.camera(71));
}

#[test]
fn turn_is_one_full_turn_in_place() {
    let path = FlightPath::new(&Flight::built_in("turn").unwrap(), &flat(), 5).unwrap();
    for (frame, quarter_turns) in (0..5).zip(0..) {
        let camera = path.camera(frame);
        assert_eq!(camera.eye_world, path.camera(0).eye_world);
        assert!((camera.heading - quarter_turns as f64 * std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    }
}

#[test]
fn flights_over_ground_follow_it() {
    let dem = dem(30, 30, [10.0, 10.0], 100.0);
    let path = FlightPath::new(&Flight::built_in("ground-level").unwrap(), &dem, 200).unwrap();
    for frame in 0..path.len() {
        let eye = path.camera(frame).eye_world;
        assert!((eye.y - dem.ground_m(eye.x, eye.z) - 100.0).abs() < 1e-9);
    }
}

#[test]
fn look_at_points_are_in_the_middle_of_the_picture() {
    let text = "name = 'orbit'\n\
        [[key]]\ntime_s = 0\nposition_m = [0, 90, 0]\nlook_at_m = [50, 10, 50]\n\
        [[key]]\ntime_s = 1\nposition_m = [100, 90, 100]\nlook_at_m = [50, 10, 50]\n";
    let path = FlightPath::new(&Flight::parse("orbit.toml", text).unwrap(), &flat(), 9).unwrap();
    for frame in 0..9 {
        let clip = path.view(frame, [200, 100]).unwrap().clip_from_world * DVec3::new(50.0, 10.0, 50.0).extend(1.0);
        assert!(clip.x.abs() < 1e-9 && clip.y.abs() < 1e-9 && clip.w > 0.0, "frame {frame}: {clip}");
    }
}

const KEY: &str = "[[key]]\ntime_s = 0\nat = [0.5, 0.5]\nabove_ground_m = 1\nlook_at = [0, 0]\n";

/// Refused texts, with the message after the file's name. `KEY` stands for a good key of five lines at time 0.
const UNREADABLE: &[(&str, &str)] = &[
    ("", "1:1: missing field `name`"),
    ("name = 'a'", "1:1: 0 [[key]]; expected at least 2, equal ones for a camera that stands"),
    ("name = 'a'\nKEY", "1:1: 1 [[key]]; expected at least 2, equal ones for a camera that stands"),
    ("name = 'a\n", "1:10: invalid literal string, expected `'`"),
    (
        "name = 'a'\nspeed = 3\n",
        "2:1: unknown field `speed`, expected one of `name`, `fov_y_deg`, `steps_per_second`, `allow_outside`, `allow_below_ground`, `key`",
    ),
    ("name = 'a'\nfov_y_deg = 'wide'\n", "2:13: invalid type: string \"wide\", expected f64"),
    ("name = 'a'\nKEY[[key]]\nat = [0, 0]\n", "7:1: missing field `time_s`"),
    (
        "name = 'a'\n[[key]]\ntime_s = 0\nat = [0.5, 0.5, 0.5]\nabove_ground_m = 1\n",
        "4:6: `at` is [0.5, 0.5, 0.5]; expected 2 finite numbers",
    ),
    (
        "name = 'a'\n[[key]]\ntime_s = 0\nlook = [0, 0]\n",
        "4:1: unknown field `look`, expected one of `time_s`, `position_m`, `at`, `above_ground_m`, `above_ground_share`, `look_at_m`, `look_at`, `look_at_above_ground_m`, `heading_deg`, `pitch_deg`",
    ),
    (
        "name = 'a'\n[[key]]\ntime_s = 0\nlook_at = [0, 0]\n",
        "2:1: position from nothing; expected `position_m`, or `at` with either `above_ground_m` or `above_ground_share`",
    ),
    (
        "name = 'a'\n[[key]]\ntime_s = 0\nat = [0, 0]\nlook_at = [0, 0]\n",
        "2:1: position from `at`; expected `position_m`, or `at` with either `above_ground_m` or `above_ground_share`",
    ),
    (
        "name = 'a'\n[[key]]\ntime_s = 0\nposition_m = [0, 0, 0]\nabove_ground_m = 1\n",
        "2:1: position from `position_m`, `above_ground_m`; expected `position_m`, or `at` with either `above_ground_m` or `above_ground_share`",
    ),
    (
        "name = 'a'\n[[key]]\ntime_s = 0\nposition_m = [0, 0, 0]\nheading_deg = 1\n",
        "2:1: direction from `heading_deg`; expected `look_at_m`, or `look_at`, or `heading_deg` and `pitch_deg`",
    ),
    (
        "name = 'a'\n[[key]]\ntime_s = 0\nposition_m = [0, 0, 0]\npitch_deg = 91\nheading_deg = 1\n",
        "5:13: `pitch_deg` is 91; expected -90 to 90",
    ),
    ("name = 'a'\n[[key]]\ntime_s = nan\n", "3:10: `time_s` is NaN; expected a finite number"),
    (
        "name = 'a'\n[[key]]\ntime_s = 0\nposition_m = [0, inf, 0]\n",
        "4:14: `position_m` is [0.0, inf, 0.0]; expected 3 finite numbers",
    ),
    ("name = 'a'\nKEYKEY", "8:10: `time_s` is 0 after 0 on line 3; expected times that rise"),
    ("name = 'a'\nfov_y_deg = 180\nKEYNEXT", "2:13: `fov_y_deg` is 180; expected 1 to 170"),
    ("name = 'a'\nsteps_per_second = 0\nKEYNEXT", "2:20: `steps_per_second` is 0; expected 0.001 to 1000"),
    (
        "name = 'a'\nKEY[[key]]\ntime_s = 1e9\nat = [0, 0]\nabove_ground_m = 1\nlook_at = [0, 0]\n",
        "7:1: 1000000000 s at 60 steps a second; expected at most 1000000 frames",
    ),
    (
        "name = 'a'\nKEY[[key]]\ntime_s = 1\nposition_m = [0, 0, 0]\nlook_at = [0, 0]\n",
        "7:1: position by `position_m`, but by `at` in the key on line 2; expected one kind of position in all keys",
    ),
    (
        "name = 'a'\nKEY[[key]]\ntime_s = 1\nat = [0, 0]\nabove_ground_m = 1\nlook_at_m = [0, 0, 0]\n",
        "7:1: direction by `look_at_m`, but by `look_at` in the key on line 2; expected one kind of direction in all keys",
    ),
];

#[test]
fn unreadable_flights_are_refused_where_they_are_wrong() {
    for (text, expected) in UNREADABLE {
        let text = text.replace("NEXT", &KEY.replace("time_s = 0", "time_s = 1")).replace("KEY", KEY);
        let found = Flight::parse("a.toml", &text).unwrap_err().to_string();
        assert_eq!(found, format!("a.toml:{expected}"), "{text}");
    }
}

/// Flights over a flat DEM at 0 m, 100 m wide and 100 m deep.
#[test]
fn flights_that_do_not_fit_are_refused_at_the_key_before_the_frame() {
    let cases = [
        (
            [[10.0, 5.0, 10.0], [90.0, 5.0, 10.0], [130.0, 5.0, 10.0]],
            "7:1: after this key, in frame 13 (1.30 s), the camera is 3.0 m outside of the DEM, at x = 103.0 m, \
             z = 10.0 m; expected 0 to 100.0 and 0 to 100.0, or allow_outside = true",
        ),
        (
            [[10.0, 5.0, 10.0], [10.0, -15.0, 10.0], [10.0, 5.0, 10.0]],
            "2:1: after this key, in frame 3 (0.30 s), the camera is 2.3 m below ground; \
             expected a higher camera, or allow_below_ground = true",
        ),
        (
            [[1e308, 5.0, 10.0], [-1e308, 5.0, 10.0], [0.0, 5.0, 10.0]],
            "2:1: after this key, in frame 0 (0.00 s), the camera is at (NaN, NaN, NaN); expected finite numbers",
        ),
    ];
    for ([a, b, c], expected) in cases {
        let flight = world_flight(&[(0.0, a), (1.0, b), (2.0, c)]);
        let refused = FlightPath::new(&flight, &flat(), 21).unwrap_err();
        assert_eq!(refused.to_string(), format!("test.toml:{expected}"));
    }
}

#[test]
fn a_flight_may_ask_to_leave_the_dem_and_to_go_below_ground() {
    let key = |time_s| format!("[[key]]\ntime_s = {time_s}\nat = [1.5, {time_s}]\nabove_ground_m = -3\n");
    let direction = "heading_deg = 0\npitch_deg = 0\n";
    let flight = |allowed: &str, x: &str| {
        let keys = format!("{}{direction}{}{direction}", key(0), key(1)).replace("1.5", x);
        let flight = Flight::parse("a.toml", &format!("name = 'a'\n{allowed} = true\n{keys}")).unwrap();
        FlightPath::new(&flight, &flat(), 9)
    };
    assert!(flight("allow_outside", "1.5").is_ok(), "there is no ground out there");
    assert!(flight("allow_outside", "0.5").is_err());
    assert!(flight("allow_below_ground", "0.5").is_ok());
    assert!(flight("allow_below_ground", "1.5").is_err());
}

#[test]
fn a_camera_on_the_point_that_it_looks_at_is_refused() {
    let text = format!("name = 'a'\n{KEY}{}", KEY.replace("time_s = 0", "time_s = 1"));
    let flight = Flight::parse("a.toml", &text.replace("look_at = [0, 0]", "look_at = [0.5, 0.5]")).unwrap();
    let straight_down = FlightPath::new(&flight, &flat(), 2).unwrap().camera(0);
    assert_eq!((straight_down.heading, straight_down.pitch), (0.0, -std::f64::consts::FRAC_PI_2));

    let text = text.replace("look_at = [0, 0]", "look_at = [0.5, 0.5]\nlook_at_above_ground_m = 1");
    let refused = FlightPath::new(&Flight::parse("a.toml", &text).unwrap(), &flat(), 2).unwrap_err();
    let expected = "a.toml:2:1: after this key, in frame 0 (0.00 s), the camera stands on the point that it looks at; \
        expected two different points";
    assert_eq!(refused.to_string(), expected);
}

#[test]
fn impossible_numbers_of_frames_are_refused() {
    let refuse = |frames| FlightPath::new(&Flight::built_in("turn").unwrap(), &flat(), frames).unwrap_err().to_string();
    assert_eq!(refuse(0), "turn.toml:1:1: 0 frames; expected 1 to 1000000");
    assert_eq!(refuse(1_000_001), "turn.toml:1:1: 1000001 frames; expected 1 to 1000000");
}

/// Files with random damage are refused in one line, or are flights.
#[test]
fn damaged_flights_neither_panic_nor_break_the_line() {
    let mut refused = 0;
    for (name, text) in BUILT_IN {
        for seed in 0..4000 {
            let bytes = crate::damage::damage(text.as_bytes(), &mut crate::SplitMix64::new(seed));
            let Err(error) = Flight::parse(name, &String::from_utf8_lossy(&bytes)) else { continue };
            assert!(!error.to_string().contains('\n'), "{name}: seed {seed}: {error}");
            refused += 1;
        }
    }
    assert!(refused > 1000, "{refused}");
}
