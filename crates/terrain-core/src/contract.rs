//! The contract of [`LodMethod`] as one function that every method's tests call.

use crate::error::{ErrorDistribution, ErrorOracle};
use crate::walk::RandomWalk;
use crate::watertight::WatertightOracle;
use crate::{FramePlan, FrameStats, Heightmap, LodMethod, MeshMirror, Sample, View};

/// Walks `frames` frames over a DEM with a seeded camera and panics, naming seed and frame, where the method that
/// `build` makes for a number of threads breaks its contract. The points are those of [`LodMethod`].
pub fn check(heightmap: &Heightmap, build: impl Fn(usize) -> Box<dyn LodMethod>, seed: u64, frames: u32) {
    check_heights(heightmap, &build, seed, frames, Heights::OfTheDem);
}

/// As [`check`], for a method that smooths: vertices may have other heights than the DEM, but all of one sample have
/// the same, and it lies within those of the sample and its 8 neighbours.
pub fn check_smoothed(heightmap: &Heightmap, build: impl Fn(usize) -> Box<dyn LodMethod>, seed: u64, frames: u32) {
    check_heights(heightmap, &build, seed, frames, Heights::Within(1));
}

/// As [`check`], for a method that draws levels on their way into one another: vertices may have other heights than the
/// DEM, but all of one sample have the same, and it lies within those of the samples up to `side` intervals away.
pub fn check_morphed(
    heightmap: &Heightmap,
    build: impl Fn(usize) -> Box<dyn LodMethod>,
    seed: u64,
    frames: u32,
    side: u32,
) {
    check_heights(heightmap, &build, seed, frames, Heights::Within(side));
}

/// What heights vertices may have.
#[derive(Clone, Copy)]
enum Heights {
    OfTheDem,
    /// Those of the samples up to so many intervals away.
    Within(u32),
}

fn check_heights(
    heightmap: &Heightmap,
    build: &impl Fn(usize) -> Box<dyn LodMethod>,
    seed: u64,
    frames: u32,
    heights: Heights,
) {
    let mut whole = Twins::new(heightmap, build, false, heights);
    let mut culled = Twins::new(heightmap, build, true, heights);
    let walk = RandomWalk::new(seed, heightmap).take(frames as usize);
    for (frame, view) in walk.enumerate() {
        let at = format!("{}, seed {seed}, frame {frame}", whole.one.method.name());
        whole.plan(&view, &at);
        whole.one.assert_covers_the_dem(&at);
        culled.plan(&view, &format!("{at}, culled"));
        culled.one.assert_covers_the_view(&view, &format!("{at}, culled"));
        if frame % 8 == 0 {
            whole.assert_second_plan_changes_nothing(&view, &at);
            culled.assert_second_plan_changes_nothing(&view, &format!("{at}, culled"));
        }
        if frame + 1 == frames as usize {
            culled.one.method.set_culling(false);
            culled.one.plan(&view, &at);
            culled.one.assert_covers_the_dem(&format!("{at}, culling switched off"));
        }
    }
}

/// Numbers of threads that must not matter, beside one.
const THREADS: [usize; 2] = [2, 8];

/// A method on one thread, watched, and the same on more threads, which must plan the same bytes.
struct Twins<'a> {
    one: Subject<'a>,
    others: [Box<dyn LodMethod>; THREADS.len()],
    plan_of_other: FramePlan,
}

impl<'a> Twins<'a> {
    fn new(
        heightmap: &'a Heightmap,
        build: &impl Fn(usize) -> Box<dyn LodMethod>,
        culling: bool,
        heights: Heights,
    ) -> Self {
        let build = |threads| {
            let mut method = build(threads);
            method.set_culling(culling);
            method
        };
        let one = Subject::new(build(1), heightmap, heights);
        Self { one, others: THREADS.map(build), plan_of_other: FramePlan::default() }
    }

    fn plan(&mut self, view: &View, at: &str) {
        self.one.plan(view, at);
        for (other, threads) in self.others.iter_mut().zip(THREADS) {
            other.plan(view, &mut self.plan_of_other);
            let is_same = same_bytes(&self.one.plan, &self.plan_of_other);
            assert!(is_same, "{at}: the plan depends on the number of threads, {threads} or 1");
        }
    }

    fn assert_second_plan_changes_nothing(&mut self, view: &View, at: &str) {
        self.plan(view, at);
        assert!(self.one.plan.uploads.is_empty(), "{at}: the second plan for an unchanged view uploads bytes");
        assert!(!self.one.changed, "{at}: the second plan for an unchanged view draws something else");
    }
}

/// The part of the contract that also holds while updates race the camera (point 3 and those it rests on): walks
/// `frames` frames and panics where one is not whole.
pub fn check_live(heightmap: &Heightmap, mut method: Box<dyn LodMethod>, seed: u64, frames: u32) {
    method.set_culling(false);
    let mut whole = Subject::new(method, heightmap, Heights::OfTheDem);
    for (frame, view) in RandomWalk::new(seed, heightmap).take(frames as usize).enumerate() {
        let at = format!("{}, live, seed {seed}, frame {frame}", whole.method.name());
        whole.plan(&view, &at);
        whole.assert_covers_the_dem(&at);
    }
}

/// Equal in all that reaches the GPU; work reports hold times.
fn same_bytes(a: &FramePlan, b: &FramePlan) -> bool {
    (&a.growths, &a.uploads, &a.bytes, &a.draws, &a.morph) == (&b.growths, &b.uploads, &b.bytes, &b.draws, &b.morph)
}

/// A method with its mirror and oracles.
struct Subject<'a> {
    heightmap: &'a Heightmap,
    heights: Heights,
    method: Box<dyn LodMethod>,
    plan: FramePlan,
    mirror: MeshMirror<'a>,
    /// Whether the last plan may have changed the mesh.
    changed: bool,
    watertight: WatertightOracle,
    errors: ErrorOracle<'a>,
}

impl<'a> Subject<'a> {
    fn new(method: Box<dyn LodMethod>, heightmap: &'a Heightmap, heights: Heights) -> Self {
        Self {
            heightmap,
            heights,
            mirror: MeshMirror::new(&method.buffers(), heightmap),
            method,
            plan: FramePlan::default(),
            changed: false,
            watertight: WatertightOracle::new(heightmap.columns(), heightmap.rows()),
            errors: ErrorOracle::new(heightmap),
        }
    }

    fn plan(&mut self, view: &View, at: &str) {
        let mut sizes = self.method.buffers();
        self.method.plan(view, &mut self.plan);
        self.plan.growths.iter().for_each(|growth| sizes.grow(growth));
        assert_eq!(self.method.buffers(), sizes, "{at}: a buffer that grows behind the plan's back");
        self.changed = self.mirror.replay(&self.plan).unwrap_or_else(|error| panic!("{at}: {error}"));
        let drawn = (self.mirror.triangles().len() + self.mirror.degenerate().len()) as u64;
        assert_eq!(FrameStats::of(&self.plan).triangles, drawn, "{at}: plan and mirror count differently");
    }

    fn assert_covers_the_dem(&mut self, at: &str) {
        if self.changed {
            let found = self.watertight.check(self.mirror.triangles(), self.mirror.degenerate());
            assert!(found.covers(self.heightmap.columns(), self.heightmap.rows()), "{at}: {found:?}");
            self.assert_heights(at);
        }
    }

    fn assert_covers_the_view(&mut self, view: &View, at: &str) {
        if self.changed {
            let found = self.watertight.check(self.mirror.triangles(), self.mirror.degenerate());
            assert_eq!(found.cracks(), 0, "{at}: {found:?}");
            self.assert_heights(at);
            self.errors.set_mesh(self.mirror.triangles());
        }
        let holes = self.watertight.open_edges_in_view(self.heightmap, view);
        assert_eq!(holes, 0, "{at}: open edges in view");
        let mut errors = ErrorDistribution::new(&[]);
        self.errors.measure(view, &mut errors);
        assert_eq!(errors.uncovered(), 0, "{at}: samples in view that no triangle covers");
    }

    fn assert_heights(&self, at: &str) {
        match self.heights {
            Heights::OfTheDem => self.assert_heights_of_the_dem(at),
            Heights::Within(side) => self.assert_heights_of_samples_around(side, at),
        }
    }

    fn assert_heights_of_the_dem(&self, at: &str) {
        for triangle in self.mirror.triangles() {
            let expected = triangle.samples.map(|sample| self.heightmap.height_m(sample));
            assert_eq!(triangle.heights_m, expected, "{at}: heights that are not the DEM's at {:?}", triangle.samples);
        }
    }

    fn assert_heights_of_samples_around(&self, side: u32, at: &str) {
        let mut seen_m = vec![f32::NAN; self.heightmap.heights_m().len()];
        for triangle in self.mirror.triangles() {
            for (sample, height_m) in triangle.samples.into_iter().zip(triangle.heights_m) {
                let seen_m = &mut seen_m[self.heightmap.index(sample) as usize];
                assert!(seen_m.is_nan() || *seen_m == height_m, "{at}: two heights at {sample:?}");
                *seen_m = height_m;
                let [low_m, high_m] = self.heights_around(sample, side);
                // Means of equal heights may be rounded away from them.
                let slack_m = 4.0 * f32::EPSILON * low_m.abs().max(high_m.abs());
                assert!(
                    (low_m - slack_m..=high_m + slack_m).contains(&height_m),
                    "{at}: a height out of its neighbours' at {sample:?}"
                );
            }
        }
    }

    /// The lowest and the highest of a sample and those up to `side` intervals away.
    fn heights_around(&self, Sample { column, row }: Sample, side: u32) -> [f32; 2] {
        let first = Sample { column: column.saturating_sub(side), row: row.saturating_sub(side) };
        self.heightmap.height_range_m(first, Sample { column: column + side, row: row + side })
    }
}

/// Methods that break the contract in one way each: it must notice.
#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BakedVertex, Buffer, BufferSizes, Draw, IndexFormat, PatchTag, VertexKind};

    /// Two triangles a quad, one draw a row; with something wrong.
    struct Faulty {
        heightmap: Heightmap,
        threads: usize,
        frame: u32,
        culling: bool,
        wrong: Wrong,
    }

    #[derive(Clone, Copy, PartialEq)]
    enum Wrong {
        Nothing,
        MissingTriangle,
        MissingTriangleWhenCulled,
        Height,
        HeightOutOfRange,
        TwoHeights,
        UploadsAlways,
        Threads,
        CulledThreads,
        Clockwise,
        NotUploaded,
    }

    impl LodMethod for Faulty {
        fn name(&self) -> &'static str {
            "faulty"
        }

        fn buffers(&self) -> BufferSizes {
            let samples = self.heightmap.heights_m().len() as u64;
            BufferSizes {
                vertex_kind: VertexKind::Baked,
                index_format: IndexFormat::U32,
                vertices: 8 * (samples + 1),
                indices: 24 * samples,
                instances: 0,
                heights: None,
                cell_side: None,
            }
        }

        fn set_culling(&mut self, culling: bool) {
            self.culling = culling;
        }

        fn plan(&mut self, _view: &View, plan: &mut FramePlan) {
            plan.clear();
            self.frame += 1;
            let (columns, rows) = (self.heightmap.columns(), self.heightmap.rows());
            if self.frame == 1 || self.wrong == Wrong::UploadsAlways {
                let mut vertices = BakedVertex::whole_dem(&self.heightmap);
                vertices.push(vertices[7]);
                vertices[7].height_m += match self.wrong {
                    Wrong::Height | Wrong::TwoHeights => 1.0,
                    Wrong::HeightOutOfRange => 2.0,
                    _ => 0.0,
                };
                vertices.truncate(if self.wrong == Wrong::NotUploaded { 9 } else { vertices.len() });
                plan.upload(Buffer::Vertices, 0, &vertices);
                let quad = |at: u32| [at, at + columns, at + 1, at + 1, at + columns, at + columns + 1];
                let quads = (0..rows - 1).flat_map(|r| (0..columns - 1).map(move |c| r * columns + c));
                let mut indices: Vec<u32> = quads.flat_map(quad).collect();
                if self.wrong == Wrong::Clockwise {
                    indices.swap(0, 1);
                }
                if self.wrong == Wrong::TwoHeights {
                    *indices.iter_mut().find(|index| **index == 7).unwrap() = columns * rows;
                }
                plan.upload(Buffer::Indices, 0, &indices);
            }
            let row = |r: u32| {
                Draw::baked(6 * (columns - 1) * r..6 * (columns - 1) * (r + 1), 0, PatchTag { patch: r, level: 0 })
            };
            plan.draws.extend((0..rows - 1).map(row));
            let threads_matter = match self.wrong {
                Wrong::Threads => !self.culling,
                Wrong::CulledThreads => self.culling,
                _ => false,
            };
            if threads_matter && self.threads > 2 {
                plan.draws.reverse();
            }
            let missing = match self.wrong {
                Wrong::MissingTriangle => true,
                Wrong::MissingTriangleWhenCulled => self.culling,
                _ => false,
            };
            plan.draws[3].indices.start += 3 * missing as u32;
        }
    }

    fn check_faulty(wrong: Wrong) {
        check_faulty_heights(wrong, Heights::OfTheDem);
    }

    fn check_faulty_heights(wrong: Wrong, heights: Heights) {
        let heightmap = Heightmap::new(9, 8, [10.0; 2], (0..72).map(|i| (i % 5) as f32).collect()).unwrap();
        let build = |threads| -> Box<dyn LodMethod> {
            Box::new(Faulty { heightmap: heightmap.clone(), threads, frame: 0, culling: true, wrong })
        };
        check_heights(&heightmap, &build, 3, 200, heights);
    }

    #[test]
    fn nothing_wrong() {
        check_faulty(Wrong::Nothing);
    }

    #[test]
    fn a_height_between_its_neighbours_is_wrong_but_where_heights_are_smoothed() {
        check_faulty_heights(Wrong::Height, Heights::Within(1));
    }

    #[test]
    #[should_panic(expected = "a height out of its neighbours'")]
    fn a_smoothed_height_that_no_mean_can_have() {
        check_faulty_heights(Wrong::HeightOutOfRange, Heights::Within(1));
    }

    #[test]
    #[should_panic(expected = "two heights at")]
    fn two_smoothed_heights_of_one_sample() {
        check_faulty_heights(Wrong::TwoHeights, Heights::Within(1));
    }

    macro_rules! notices {
        ($($name:ident: $wrong:ident, $message:literal;)*) => {$(
            #[test]
            #[should_panic(expected = $message)]
            fn $name() {
                check_faulty(Wrong::$wrong);
            }
        )*};
    }

    notices! {
        a_missing_triangle: MissingTriangle, "open_edges: 2";
        a_triangle_that_is_missing_when_culled: MissingTriangleWhenCulled, "open edges in view";
        a_wrong_height: Height, "heights that are not the DEM's";
        uploads_for_an_unchanged_view: UploadsAlways, "uploads bytes";
        threads_that_matter: Threads, "number of threads";
        threads_that_matter_when_culled: CulledThreads, "culled: the plan depends on the number of threads";
        a_triangle_turned_over: Clockwise, "inverted: 1";
        vertices_that_were_never_uploaded: NotUploaded, "where not all is uploaded";
    }
}
