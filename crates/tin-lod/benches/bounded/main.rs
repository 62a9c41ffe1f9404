//! Figures of the bounded mesh: the maps' build, triangles and draws, the largest error, and the times of a whole DEM, of
//! a flight and of a teleport.
//!
//! `cargo bench -p tin-lod --bench bounded [-- path/to/dem.png spacing scale]`; without arguments the Puget Sound DEM
//! that lies beside the project on some machines, or else synthetic terrain of the same size.

#[path = "../common/mod.rs"]
mod common;
mod flight;
mod sizes;
#[path = "../../tests/bounded/whole_dem.rs"]
mod whole_dem;

use std::sync::{Arc, LazyLock};
use std::time::Instant;

use common::cpu_ms;
use terrain_core::Heightmap;
use tin_lod::ladder;
use tin_lod::{KeptSamples, NodeId, NodeMaps, Nodes, Options, Selection, Triangulator};
use whole_dem::{Leveled, Mesh, WholeDem};

const PATCH: u32 = 32;
const BUILDS: usize = 9;
const FRAMES: usize = 51;

fn main() {
    let (name, dem) = common::open();
    println!("{name}: {} x {} samples, patch {PATCH} where nothing else is said", dem.columns(), dem.rows());
    time_build(&dem);
    let whole = WholeDem::new(dem.clone(), PATCH, 1);
    for tolerance_m in [8.0, 16.0, 32.0, 64.0, 128.0] {
        uniform(&whole, tolerance_m);
    }
    for tolerance_px in [0.5, 1.0, 2.0] {
        view_dependent(&whole, tolerance_px);
    }
    sizes::compare(&dem, &[(32, 1), (32, 2), (16, 4)]);
    let of = |patch, group, blocks| Options { patch, group: Some(group), blocks, ..Default::default() };
    let settings = [
        ("patch 32", of(32, 1, false)),
        ("patch 32 blocks", of(32, 1, true)),
        ("patch 32 group 2", of(32, 2, false)),
        ("patch 32 group 2 blocks", of(32, 2, true)),
        ("patch 16 group 4 blocks", of(16, 4, true)),
    ];
    let dem = Arc::new(dem);
    flight::teleport(&dem, &settings);
    flight::compare(&dem, &settings);
}

fn time_build(dem: &Heightmap) {
    let pools = [1, 2].map(|threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap());
    for group in [1, 2] {
        let nodes = Nodes::new(dem, PATCH, group);
        let build = |pool: usize| drop(pools[pool].install(|| NodeMaps::build(dem, nodes.clone())));
        let [one, two] = medians_ms(BUILDS, wall_ms, build);
        println!("threshold maps, groups up to {group}: {one:.0} ms on 1 thread, {two:.0} ms on 2");
        let [one] = medians_ms(BUILDS, cpu_ms, |_| build(0));
        println!("threshold maps, groups up to {group}: {one:.0} ms of CPU time");
    }
}

fn wall_ms() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed().as_secs_f64() * 1e3
}

/// Runs the ways `0..N` in turn, again and again; the median time of each.
fn medians_ms<const N: usize>(rounds: usize, now_ms: fn() -> f64, mut run: impl FnMut(usize)) -> [f64; N] {
    let mut times = [(); N].map(|_| Vec::with_capacity(rounds));
    for _ in 0..rounds {
        for (way, times) in times.iter_mut().enumerate() {
            let start_ms = now_ms();
            run(way);
            times.push(now_ms() - start_ms);
        }
    }
    times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[rounds / 2]
    })
}

fn uniform(whole: &WholeDem, tolerance_m: f64) {
    let level = ladder::level_of(tolerance_m);
    let (leveled, mut mesh) = (whole.uniform(level), Mesh::default());
    whole.triangulate(&leveled, &mut mesh);
    let bound = whole.bound(&leveled, &whole.triangles(&mesh), None);
    let (triangles, rung_m) = (mesh.indices.len() / 3, ladder::tolerance_m(level));
    println!("uniform {tolerance_m} m (rung {rung_m:.3} m): {triangles} triangles, error/tolerance {:.7}", bound.worst);
}

/// The whole DEM without culling, on one thread.
fn view_dependent(whole: &WholeDem, tolerance_px: f64) {
    let view = common::above_the_middle(&whole.dem);
    let (leveled, mut mesh) = (whole.of_view(&view, tolerance_px, false), Mesh::default());
    let mut indices = Vec::new();
    let [select_ms, unchecked_ms, whole_ms] = medians_ms(FRAMES, cpu_ms, |way| match way {
        0 => select(whole, &leveled, |_, _| {}),
        1 => {
            indices.clear();
            select(whole, &leveled, |node, selection| triangulate(whole, node, selection, &mut indices));
        }
        _ => whole.triangulate(&leveled, &mut mesh),
    });
    let bound = whole.bound(&leveled, &whole.triangles(&mesh), Some(&view));
    let (triangles, repair) = (mesh.indices.len() / 3, mesh.repair);
    println!(
        "{tolerance_px} px: {triangles} triangles, error_px {:.4}, error/tolerance {:.7}, {} above",
        bound.worst_px, bound.worst, bound.above
    );
    println!(
        "  CPU: select {select_ms:.2}, + triangulate {unchecked_ms:.2}, + check, repair {whole_ms:.2} ms ({:.0} %)",
        100.0 * (1.0 - unchecked_ms / whole_ms)
    );
    println!(
        "  {:.2} % of the patches repaired, {} samples ({:.2} per 1000 triangles), at most {} rounds",
        100.0 * mesh.nodes_repaired as f64 / mesh.nodes as f64,
        repair.samples,
        1e3 * repair.samples as f64 / triangles as f64,
        repair.rounds
    );
}

fn select(whole: &WholeDem, leveled: &Leveled, mut then: impl FnMut(NodeId, &Selection)) {
    let (cut, mut selection) = (whole.cut(leveled), Selection::default());
    for node in whole.nodes_of(leveled) {
        selection.select(&cut, node);
        then(node, &selection);
    }
}

fn triangulate(whole: &WholeDem, node: NodeId, selection: &Selection, indices: &mut Vec<u32>) {
    let area = whole.maps.nodes().area(node);
    let kept = KeptSamples {
        width: area.width,
        depth: area.depth,
        border: selection.border(),
        interior: selection.interior(),
        first_index: whole.dem.index(area.first),
        row_stride: whole.dem.columns(),
    };
    Triangulator::Grid.triangulate(&kept, indices);
}
