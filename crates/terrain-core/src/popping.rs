//! Popping: what the change of the mesh alone does to the picture.
//!
//! The mesh of the frame before and this frame's, both seen by *this* frame's camera: at every DEM sample in view the
//! height between the two, in pixels, as the error oracle has the height between mesh and DEM
//! ([`ErrorOracle::measure_popping`](crate::error::ErrorOracle::measure_popping)). The camera's own motion is in none of
//! it, and a frame that draws the mesh of the frame before has none.
//!
//! What culling leaves out has no height: a sample that came into view, so that only one of the two meshes covers it,
//! does not count, nor does a triangle over ground that was not drawn before. Voids do not count either. A camera that
//! teleports changes the mesh as it does in any other frame, and that counts.

use crate::histogram::PixelHistogram;
use crate::{Sample, Triangle};

/// The samples that changes of the mesh have moved, in one frame or in all frames of a flight.
#[derive(Clone, Default)]
pub struct Popping {
    pixels: PixelHistogram,
    displacements: PixelHistogram,
}

impl Popping {
    /// Where the bins begin that a flight's popping is counted in, in pixels: each ends where the next begins, the last
    /// one never.
    pub const BINS_PX: [f32; 11] = [0.0, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];

    /// Adds one moved sample, by the usual formula and as a displacement on the screen.
    pub fn add(&mut self, px: f32, displacement_px: f32) {
        self.pixels.add(px);
        self.displacements.add(displacement_px);
    }

    /// Adds all samples of another.
    pub fn merge(&mut self, other: &Self) {
        self.pixels.merge(&other.pixels);
        self.displacements.merge(&other.displacements);
    }

    /// Forgets all samples and keeps the memory.
    pub fn clear(&mut self) {
        self.pixels.clear();
        self.displacements.clear();
    }

    /// Heights between the meshes by [`View::pixels`](crate::View::pixels).
    pub fn pixels(&self) -> &PixelHistogram {
        &self.pixels
    }

    /// The same by [`View::displacement_px`](crate::View::displacement_px).
    pub fn displacements(&self) -> &PixelHistogram {
        &self.displacements
    }
}

/// A triangle in exact integers: sample and bits of the height of each corner, the smallest first.
type Key = [u64; 3];

/// The triangles of a mesh, to be compared with those of the next one.
#[derive(Default)]
pub struct TriangleSet {
    keys: Vec<Key>,
    next: Vec<Key>,
}

impl TriangleSet {
    /// Takes a new mesh. Returns how many of its triangles are not in the one before, though that one drew the ground at
    /// their corners (`was_covered`). Corners are compared by sample and by all bits of the height.
    pub fn replace(&mut self, triangles: &[Triangle], was_covered: impl Fn(Sample) -> bool) -> u64 {
        self.next.clear();
        self.next.extend(triangles.iter().map(key));
        self.next.sort_unstable();
        let mut before = self.keys.iter().copied().peekable();
        let mut changed = 0;
        for key in &self.next {
            while before.next_if(|other| other < key).is_some() {}
            let is_new = before.peek() != Some(key);
            changed += (is_new && key.iter().all(|corner| was_covered(sample(*corner)))) as u64;
        }
        std::mem::swap(&mut self.keys, &mut self.next);
        changed
    }
}

/// Rotated, not sorted: a triangle that is turned over is another one.
fn key(triangle: &Triangle) -> Key {
    let corner = |i: usize| {
        let Sample { column, row } = triangle.samples[i];
        (row as u64) << 48 | (column as u64) << 32 | triangle.heights_m[i].to_bits() as u64
    };
    let corners = [0, 1, 2].map(corner);
    let first = (0..3).min_by_key(|i| corners[*i]).unwrap_or(0);
    [0, 1, 2].map(|i| corners[(first + i) % 3])
}

fn sample(corner: u64) -> Sample {
    Sample { column: (corner >> 32 & 0xffff) as u32, row: (corner >> 48) as u32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::ErrorOracle;
    use crate::error::fans::{brute_force_m, fan, is_seen, on_screen_px, rough_dem, samples, view, with_voids};
    use crate::{Heightmap, SplitMix64, View};
    use glam::DVec3;

    fn measured(dem: &Heightmap, meshes: [&[Triangle]; 2], view: &View) -> Popping {
        let (mut oracle, mut popping) = (ErrorOracle::new(dem), Popping::default());
        meshes.into_iter().for_each(|mesh| oracle.set_mesh(mesh));
        oracle.measure_popping(view, &mut popping);
        popping
    }

    /// A random fan, now and then with a hole.
    fn random_mesh(dem: &Heightmap, random: &mut SplitMix64) -> Vec<Triangle> {
        let mut mesh = fan(dem, 1 + random.below(7) as u32, 1 + random.below(5) as u32);
        if random.below(3) == 0 {
            mesh.remove(random.below(mesh.len() as u64) as usize);
        }
        mesh
    }

    #[test]
    fn agrees_with_brute_force_over_every_triangle_and_sample() {
        let mut uncovered = 0;
        for seed in 0..100 {
            let (view, mut random) = (view(seed), SplitMix64::new(seed));
            // Every other DEM has voids, which do not count.
            let (dem, is_void) = match seed % 2 {
                0 => (rough_dem(seed), vec![false; 63]),
                _ => with_voids(rough_dem(seed), seed),
            };
            let [before, now] = [(); 2].map(|()| random_mesh(&dem, &mut random));
            let popping = measured(&dem, [&before, &now], &view);
            let mut expected: Vec<[f64; 2]> = Vec::new();
            for (at, is_void) in samples().zip(is_void).filter(|(at, _)| is_seen(&view, dem.world(*at).into())) {
                let sample = DVec3::from(dem.world(at));
                let [before_m, now_m] = [&before, &now].map(|mesh| brute_force_m(&dem, mesh, at));
                let (Some(before_m), Some(now_m)) = (before_m, now_m) else {
                    uncovered += 1;
                    continue;
                };
                let [from, to] = [before_m, now_m].map(|y| DVec3 { y, ..sample });
                if (now_m - before_m).abs() > 1e-3 && !is_void {
                    let px = view.pixels((now_m - before_m).abs(), sample.distance(view.eye_world));
                    expected.push([px, on_screen_px(&view, from, to)]);
                }
            }
            let largest = |i: usize| expected.iter().fold(0.0, |largest: f64, px| largest.max(px[i]));
            let found = [popping.pixels(), popping.displacements()];
            for (i, found) in found.into_iter().enumerate() {
                assert_eq!(found.samples(), expected.len() as u64, "seed {seed}");
                assert!((found.max_px() as f64 - largest(i)).abs() < 1e-3, "seed {seed}: {} px", found.max_px());
            }
        }
        assert!(uncovered > 100, "samples that one of the meshes does not cover: {uncovered}");
    }

    #[test]
    fn one_vertex_raised_by_a_metre_moves_as_far_as_the_formula_says() {
        let (dem, mut random) = (Heightmap::new(9, 7, [10.0, 12.0], vec![5.0; 63]).unwrap(), SplitMix64::new(1));
        for seed in 0..20 {
            let (view, at) =
                (view(seed), Sample { column: 1 + random.below(7) as u32, row: 1 + random.below(5) as u32 });
            let sample = DVec3::from(dem.world(at));
            let before = fan(&dem, at.column, at.row);
            let mut now = before.clone();
            now.iter_mut().for_each(|triangle| triangle.heights_m[0] += 1.0);
            let popping = measured(&dem, [&before, &now], &view);
            if !is_seen(&view, sample) {
                continue;
            }
            // All others are moved less, and none is nearer by as much.
            let expected = view.pixels(1.0, sample.distance(view.eye_world)) as f32;
            assert_eq!(popping.pixels().max_px(), expected, "seed {seed}");
            let moved = on_screen_px(&view, sample, sample + DVec3::Y);
            assert!(popping.displacements().max_px() as f64 >= moved - 1e-6, "seed {seed}");
        }
    }

    #[test]
    fn nothing_pops_where_the_mesh_stays_or_one_is_missing() {
        let (dem, view) = (rough_dem(1), view(1));
        let mesh = fan(&dem, 3, 3);
        for [before, now] in [[&mesh[..], &mesh], [&[], &mesh], [&mesh, &[]]] {
            assert_eq!(measured(&dem, [before, now], &view).pixels().samples(), 0);
        }
        let reordered: Vec<Triangle> = mesh.iter().rev().copied().map(turned).collect();
        assert_eq!(measured(&dem, [&mesh, &reordered], &view).pixels().samples(), 0);
    }

    /// The same triangle from another corner on.
    fn turned(mut triangle: Triangle) -> Triangle {
        triangle.samples.rotate_left(1);
        triangle.heights_m.rotate_left(1);
        triangle
    }

    #[test]
    fn triangles_are_compared_by_corners_and_by_all_bits_of_the_heights() {
        let dem = rough_dem(1);
        let (mesh, other) = (fan(&dem, 3, 3), fan(&dem, 4, 3));
        let mut set = TriangleSet::default();
        assert_eq!(set.replace(&mesh, |_| false), 0, "there was no mesh before");
        let reordered: Vec<Triangle> = mesh.iter().rev().copied().map(turned).collect();
        assert_eq!(set.replace(&reordered, |_| true), 0);
        let mut raised = mesh.clone();
        raised[1].heights_m[2] = raised[1].heights_m[2].next_up();
        assert_eq!(set.replace(&raised, |_| true), 1);
        assert_eq!(set.replace(&other, |_| true), 4);
        let doubled = [&other[..], &mesh[..1]].concat();
        assert_eq!(set.replace(&doubled, |_| true), 1);
        assert_eq!(set.replace(&other[1..], |_| true), 0, "what is gone is not new");
        assert_eq!(set.replace(&mesh, |at| at != mesh[0].samples[1]), 2, "two of four stand on that corner");
    }

    #[test]
    fn the_bins_hold_all_samples_once() {
        let mut popping = Popping::default();
        let values = [0.0, 0.1249, 0.125, 0.3, 1.0, 63.9, 64.0, 1e6];
        values.iter().for_each(|px| popping.add(*px, 0.0));
        let ends = Popping::BINS_PX[1..].iter().copied().chain([f32::INFINITY]);
        let counts: Vec<u64> = Popping::BINS_PX.iter().zip(ends).map(|(a, b)| popping.pixels().count(*a, b)).collect();
        assert_eq!(counts, [2, 1, 1, 0, 1, 0, 0, 0, 0, 1, 2]);
    }
}
