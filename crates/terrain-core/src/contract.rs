//! The contract of [`LodMethod`] as one function that every method's tests call.

use crate::error::{ErrorDistribution, ErrorOracle};
use crate::walk::RandomWalk;
use crate::watertight::WatertightOracle;
use crate::{FramePlan, FrameStats, Heightmap, LodMethod, MeshMirror, View};

/// What the contract asks of the function that makes a method.
#[derive(Clone, Copy, Debug)]
pub struct Build {
    /// Whether the method leaves out what is not in view.
    pub culling: bool,
    /// How many threads it may plan on.
    pub threads: usize,
}

/// Walks `frames` frames over a DEM with a seeded camera and panics, naming seed and frame, where the method that
/// `build` makes breaks its contract. The points are those of [`LodMethod`].
pub fn check(heightmap: &Heightmap, build: impl Fn(Build) -> Box<dyn LodMethod>, seed: u64, frames: u32) {
    let mut whole = Subject::new(build(Build { culling: false, threads: 1 }), heightmap);
    let mut twin = build(Build { culling: false, threads: 2 });
    let mut culled = Subject::new(build(Build { culling: true, threads: 1 }), heightmap);
    let mut twin_plan = FramePlan::default();
    for (frame, view) in RandomWalk::new(seed, heightmap).take(frames as usize).enumerate() {
        let at = format!("{}, seed {seed}, frame {frame}", whole.method.name());
        whole.plan(&view, &at);
        twin.plan(&view, &mut twin_plan);
        assert!(same_bytes(&whole.plan, &twin_plan), "{at}: the plan depends on the number of threads");
        whole.assert_covers_the_dem(&at);
        culled.plan(&view, &at);
        culled.assert_covers_the_view(&view, &at);
        if frame % 8 == 0 {
            whole.assert_second_plan_uploads_nothing(&view, &at);
            twin.plan(&view, &mut twin_plan);
            culled.assert_second_plan_uploads_nothing(&view, &at);
        }
    }
}

/// Equal in all that reaches the GPU; work reports hold times.
fn same_bytes(a: &FramePlan, b: &FramePlan) -> bool {
    (&a.uploads, &a.bytes, &a.draws) == (&b.uploads, &b.bytes, &b.draws)
}

/// A method with its mirror and oracles.
struct Subject<'a> {
    heightmap: &'a Heightmap,
    method: Box<dyn LodMethod>,
    plan: FramePlan,
    mirror: MeshMirror<'a>,
    /// Whether the last plan may have changed the mesh.
    changed: bool,
    watertight: WatertightOracle,
    errors: ErrorOracle<'a>,
}

impl<'a> Subject<'a> {
    fn new(method: Box<dyn LodMethod>, heightmap: &'a Heightmap) -> Self {
        Self {
            heightmap,
            mirror: MeshMirror::new(&method.buffers(), heightmap),
            method,
            plan: FramePlan::default(),
            changed: false,
            watertight: WatertightOracle::new(heightmap.columns(), heightmap.rows()),
            errors: ErrorOracle::new(heightmap),
        }
    }

    fn plan(&mut self, view: &View, at: &str) {
        self.method.plan(view, &mut self.plan);
        self.changed = self.mirror.replay(&self.plan).unwrap_or_else(|error| panic!("{at}: {error}"));
        let drawn = (self.mirror.triangles().len() + self.mirror.degenerate().len()) as u64;
        assert_eq!(FrameStats::of(&self.plan).triangles, drawn, "{at}: plan and mirror count differently");
    }

    fn assert_covers_the_dem(&mut self, at: &str) {
        if !self.changed {
            return;
        }
        let found = self.watertight.check(self.mirror.triangles(), self.mirror.degenerate());
        assert!(found.covers(self.heightmap.columns(), self.heightmap.rows()), "{at}: {found:?}");
        for triangle in self.mirror.triangles() {
            let expected = triangle.samples.map(|sample| self.heightmap.height_m(sample));
            assert_eq!(triangle.heights_m, expected, "{at}: heights that are not the DEM's at {:?}", triangle.samples);
        }
    }

    fn assert_covers_the_view(&mut self, view: &View, at: &str) {
        if self.changed {
            let found = self.watertight.check(self.mirror.triangles(), self.mirror.degenerate());
            assert_eq!(found.cracks(), 0, "{at}, culled: {found:?}");
            self.errors.set_mesh(self.mirror.triangles());
        }
        let mut errors = ErrorDistribution::new(&[]);
        self.errors.measure(view, &mut errors);
        assert_eq!(errors.uncovered(), 0, "{at}, culled: samples in view that no triangle covers");
    }

    fn assert_second_plan_uploads_nothing(&mut self, view: &View, at: &str) {
        self.plan(view, at);
        assert!(self.plan.uploads.is_empty(), "{at}: the second plan for an unchanged view uploads bytes");
        assert!(!self.changed, "{at}: the second plan for an unchanged view draws something else");
    }
}
