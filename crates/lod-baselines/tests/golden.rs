//! How many triangles each baseline draws of one terrain in one view. A change that moves a count says so in its commit.

use std::sync::Arc;

use lod_baselines::{Decimated, FullGrid, Geomipmap, Greedy, Rqt};
use terrain_core::{Camera, FramePlan, FrameStats, Lens, LodMethod, View};
use terrain_dem::synthetic;

#[test]
fn triangles_of_the_whole_dem_and_in_view() {
    let dem = synthetic::generate(300, 200, 7);
    let [width_m, depth_m] = dem.extent_m().map(|metres| 0.4 * metres);
    let eye_world = [width_m, dem.ground_m(width_m, depth_m) + 50.0, depth_m].into();
    let camera = Camera { eye_world, heading: 1.0, pitch: -0.1 };
    let view = View::new(&camera, &Lens { fov_y: 1.0, size_px: [640, 360], near_m: 1.0 }).unwrap();
    let counts = |mut method: Box<dyn LodMethod>| {
        let mut plan = FramePlan::default();
        [false, true].map(|culling| {
            method.set_culling(culling);
            method.plan(&view, &mut plan);
            FrameStats::of(&plan).triangles
        })
    };
    assert_eq!(counts(Box::new(FullGrid::new(&dem))), [119_002; 2]);
    assert_eq!(counts(Box::new(Decimated::new(&dem, 2).unwrap())), [30_000; 2]);
    let rqt = [1.0, 4.0].map(|tolerance_px| counts(Box::new(Rqt::new(&dem, tolerance_px).unwrap())));
    assert_eq!(rqt, [[12_459, 3_455], [2_315, 599]]);
    let geomipmap = [1.0, 4.0].map(|tolerance_px| counts(Box::new(Geomipmap::new(&dem, tolerance_px).unwrap())));
    let greedy =
        |tolerance_px| Greedy::new(Arc::new(dem.clone()), tolerance_px, Greedy::usual_distance_m(&dem)).unwrap();
    assert_eq!([1.0, 4.0].map(|tolerance_px| counts(Box::new(greedy(tolerance_px)))), [[3_259; 2], [539; 2]]);
    assert_eq!(geomipmap, [[98_481, 41_622], [22_358, 9_209]]);
}
