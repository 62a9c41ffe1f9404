use terrain_core::{Camera, FlightPath, Lens, Triangle};

use super::*;

/// A roof of two planes 100 m above the DEM's middle row, which is level; drawn flat.
fn roof() -> (Heightmap, Vec<Triangle>) {
    let heights = (0..21 * 21).map(|i| if i / 21 == 10 { 100.0 } else { 0.0 }).collect();
    let heightmap = Heightmap::new(21, 21, [50.0; 2], heights).unwrap();
    let corners = [[[0, 0], [0, 20], [20, 20]], [[0, 0], [20, 20], [20, 0]]];
    let triangle = |corners: [[u32; 2]; 3]| Triangle {
        samples: corners.map(|[column, row]| Sample { column, row }),
        heights_m: [0.0; 3],
    };
    (heightmap, corners.map(triangle).to_vec())
}

/// From 2 km above the middle, looking straight down.
fn from_above(size_px: [u32; 2]) -> View {
    let eye_world = [500.0, 2000.0, 500.0].into();
    let camera = Camera { eye_world, heading: 0.0, pitch: -std::f64::consts::FRAC_PI_2 };
    View::new(&camera, &Lens { fov_y: 0.6, size_px, near_m: FlightPath::NEAR_M }).unwrap()
}

#[test]
fn pixels_have_the_class_of_the_nearest_sample_and_the_sky_has_none() {
    let (heightmap, mesh) = roof();
    let mut oracle = ErrorOracle::new(&heightmap);
    oracle.set_mesh(&mesh);
    let view = from_above([300, 200]);
    // Level ground at all points but those of the first row, which are sky.
    let mut depths = vec![(FlightPath::NEAR_M / 2000.0) as f32; 600 * 400];
    depths[..1200].fill(0.0);
    let paint = |tolerance_px| {
        let map =
            HeatMap { heightmap: &heightmap, oracle: &oracle, view: &view, depths: &depths, factor: 2, tolerance_px };
        map.paint()
    };
    // 100 m at 1900 m are 17.0 px: 200 / (2 tan 0.3) * 100 / 1900.
    let error_px = view.pixels(100.0, 1900.0);
    assert!((error_px - 17.0).abs() < 0.1, "{error_px}");
    for (tolerance_px, expected) in [(1.0, 7), (10.0, 4), (20.0, 3), (500.0, 0)] {
        let picture = paint(tolerance_px);
        assert_eq!(picture[(150, 100)], CLASSES[expected], "the ridge at a tolerance of {tolerance_px} px");
        assert_eq!(picture[(150, 60)], CLASSES[0], "the level ground beside it");
        assert_eq!(picture[(150, 0)], NOTHING, "the sky");
        // The sample of the ridge is the nearest up to 25 m from the middle, 8.1 px in all, and a pixel is as bad as the worst
        // of its points.
        let is_ridge = |row: &u32| picture[(150, *row)] == CLASSES[expected];
        let ridge = (1..200).filter(is_ridge).count();
        assert!(expected == 0 || (8..=10).contains(&ridge), "{ridge} rows");
    }
}

#[test]
fn classes_double_and_the_tolerance_is_in_the_middle() {
    let classes = |errors: &[f32]| errors.iter().map(|px| class(*px, 2.0)).collect::<Vec<_>>();
    assert_eq!(classes(&[0.0, 0.25, 0.2501, 0.5, 1.0, 2.0]), [0, 0, 1, 1, 2, 3]);
    assert_eq!(classes(&[2.0001, 4.0, 4.01, 16.0, 16.1, f32::INFINITY]), [4, 4, 5, 6, 7, 7]);
    assert_eq!((1..8).map(|i| edge_px(i, 1.0)).collect::<Vec<_>>(), [0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0]);
}

/// Linear light of a colour as an eye without one kind of cones takes it (Vienot, Brettel and Mollon 1999): without long,
/// without middle wavelengths, or with all.
fn as_seen(colour: Rgb<u8>, red_from: [f64; 2], blue_from: f64) -> [f64; 3] {
    let [red, green, blue] = colour.0.map(|channel| crate::fine::decode(f64::from(channel) / 255.0));
    let yellow = red_from[0] * red + red_from[1] * green;
    [yellow, yellow, blue + blue_from * (red - green)]
}

fn lightness([red, green, blue]: [f64; 3]) -> f64 {
    let luminance = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    116.0 * luminance.cbrt() - 16.0
}

/// CIE 1976: lighter by 5 or more from class to class, for every eye; and the tolerance parts blue from yellow.
#[test]
fn the_scale_is_in_order_for_every_eye() {
    let normal = |colour: Rgb<u8>| colour.0.map(|channel| crate::fine::decode(f64::from(channel) / 255.0));
    let protan = |colour| as_seen(colour, [0.112_38, 0.887_62], 0.004_01);
    let deutan = |colour| as_seen(colour, [0.292_75, 0.707_25], -0.022_34);
    for (eye, seen) in [("normal", &normal as &dyn Fn(Rgb<u8>) -> [f64; 3]), ("protan", &protan), ("deutan", &deutan)] {
        let scale: Vec<f64> = CLASSES.iter().map(|colour| lightness(seen(*colour))).collect();
        assert!(scale.windows(2).all(|pair| pair[1] - pair[0] >= 5.0), "{eye}: {scale:?}");
        for (i, colour) in CLASSES.into_iter().enumerate() {
            let [red, green, blue] = seen(colour);
            assert_eq!(blue > 0.5 * (red + green), i < CLASSES.len() / 2, "{eye}: class {i}");
        }
    }
}

#[test]
fn the_legend_fits_below_pictures_of_any_width() {
    let (heightmap, mesh) = roof();
    let mut oracle = ErrorOracle::new(&heightmap);
    oracle.set_mesh(&mesh);
    for size_px in [[16, 16], [320, 180], [640, 360], [1920, 1080]] {
        let view = from_above(size_px);
        let depths = vec![0.0; (size_px[0] * size_px[1]) as usize];
        let map = HeatMap {
            heightmap: &heightmap,
            oracle: &oracle,
            view: &view,
            depths: &depths,
            factor: 1,
            tolerance_px: 0.25,
        };
        let picture = map.paint();
        assert!(picture.width() >= size_px[0] && picture.height() > size_px[1]);
        let used: std::collections::BTreeSet<[u8; 3]> = picture.pixels().map(|pixel| pixel.0).collect();
        assert!(CLASSES.iter().all(|colour| used.contains(&colour.0)), "{size_px:?}");
        // Ink is on the paper and not at its rims, where a text would be cut.
        let is_ink = |x: u32| (size_px[1]..picture.height()).any(|y| picture[(x, y)] == INK);
        assert!(!is_ink(0) && !is_ink(picture.width() - 1), "{size_px:?}");
    }
}
