use super::*;
use crate::{HeightFormat, PatchTag};

fn dem() -> Heightmap {
    Heightmap::new(3, 2, [1.0; 2], vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0]).unwrap()
}

const BAKED: BufferSizes = BufferSizes {
    vertex_kind: VertexKind::Baked,
    index_format: IndexFormat::U32,
    vertices: 48,
    indices: 24,
    instances: 0,
    heights: None,
    cell_side: None,
};

fn sample(column: u32, row: u32) -> Sample {
    Sample { column, row }
}

#[test]
fn baked_draws_become_triangles() {
    let dem = dem();
    let mut plan = FramePlan::default();
    plan.upload(Buffer::Vertices, 0, &BakedVertex::whole_dem(&dem));
    plan.upload(Buffer::Indices, 0, &[0u32, 3, 1, 0, 1, 2]);
    plan.draws.push(Draw::baked(0..6, 0, PatchTag { patch: 5, level: 1 }));
    plan.draws.push(Draw::baked(0..3, 1, PatchTag { patch: 6, level: 1 }));
    let mut mirror = MeshMirror::new(&BAKED, &dem);
    assert_eq!(mirror.replay(&plan), Ok(true));
    let first = Triangle { samples: [sample(0, 0), sample(0, 1), sample(1, 0)], heights_m: [0.0, 3.0, 1.0] };
    let shifted = Triangle { samples: [sample(1, 0), sample(1, 1), sample(2, 0)], heights_m: [1.0, 4.0, 2.0] };
    assert_eq!(mirror.triangles(), [first, shifted]);
    assert_eq!(first.doubled_area(), 1);
    assert_eq!(mirror.degenerate().len(), 1, "three samples of one row");
    plan.uploads.clear();
    assert_eq!(mirror.replay(&plan), Ok(false), "nothing uploaded, same draws");
    assert_eq!(crate::triangles_by_level(&mirror)[..3], [0, 3, 0], "the level stands in the draw");
}

#[test]
fn narrow_indices_are_read_from_any_even_byte_of_a_buffer_that_grows() {
    let dem = dem();
    let sizes = BufferSizes { index_format: IndexFormat::U16, indices: 8, ..BAKED };
    let mut plan = FramePlan::default();
    plan.upload(Buffer::Vertices, 0, &BakedVertex::whole_dem(&dem));
    plan.upload(Buffer::Indices, 0, &[9u16, 0, 3, 1]);
    plan.draws.push(Draw::baked(1..4, 0, PatchTag { patch: 0, level: 0 }));
    let mut mirror = MeshMirror::new(&sizes, &dem);
    assert_eq!(mirror.replay(&plan), Ok(true));
    let expected = [sample(0, 0), sample(0, 1), sample(1, 0)];
    assert_eq!(mirror.triangles()[0].samples, expected);

    let mut larger = FramePlan::default();
    larger.growths.push(Growth { buffer: Buffer::Indices, bytes: 16 });
    larger.upload(Buffer::Indices, 8, &[0u16, 3, 1, 7]);
    larger.draws.extend([1..4, 4..7].map(|indices| Draw { indices, ..plan.draws[0].clone() }));
    assert_eq!(mirror.replay(&larger), Ok(true));
    assert!(mirror.triangles().iter().all(|triangle| triangle.samples == expected));
    assert_eq!(mirror.triangles().len(), 2);

    larger.draws[1].indices = 6..9;
    let unwritten = mirror.replay(&larger);
    assert!(matches!(unwritten, Err(MirrorError::Unwritten { buffer: Buffer::Indices, .. })), "{unwritten:?}");
    for bytes in [12, 18] {
        larger.growths[0].bytes = bytes;
        assert!(matches!(mirror.replay(&larger), Err(MirrorError::Growth { size: 16, .. })));
    }
}

#[test]
fn displaced_instances_are_clamped_to_the_rim() {
    let dem = dem();
    let sizes = BufferSizes { vertex_kind: VertexKind::Displaced, vertices: 12, indices: 12, instances: 40, ..BAKED };
    let mut plan = FramePlan::default();
    plan.upload(Buffer::Vertices, 0, &[[0, 0], [1, 0], [0, 1]].map(|uv| LocalVertex { uv }));
    plan.upload(Buffer::Indices, 0, &[0u32, 1, 2]);
    let south_east = PatchInstance { origin: [1, 0], leg_u: [0, 5], leg_v: [5, 0], tag: 0 };
    let north_west = PatchInstance { origin: [2, 1], leg_u: [0, -1], leg_v: [-2, 0], tag: 0 };
    plan.upload(Buffer::Instances, 0, &[south_east, north_west]);
    plan.draws.push(Draw { indices: 0..3, base_vertex: 0, instances: 0..2 });
    let mut mirror = MeshMirror::new(&sizes, &dem);
    mirror.replay(&plan).unwrap();
    let corners: Vec<_> = mirror.triangles().iter().map(|t| t.samples).collect();
    assert_eq!(corners, [[sample(1, 0), sample(1, 1), sample(2, 0)], [sample(2, 1), sample(2, 0), sample(0, 1)]]);
    assert_eq!(mirror.triangles()[0].heights_m, [1.0, 4.0, 2.0]);
}

/// The same corners from a coarse grid and from two tiles, of which one is not uploaded.
#[test]
fn heights_come_from_the_tiles_that_a_method_brings_along() {
    let dem = Heightmap::new(5, 3, [1.0; 2], (0..15).map(|i| 10.0 * i as f32).collect()).unwrap();
    let format = HeightFormat::U16 { scale_m: 10.0, offset_m: -30.0 };
    let windows = [2, 0, 0, 0, 0, 0];
    let tiles = HeightTiles { format, samples: [5, 3], k: 2, coarse_level: 1, cell_side: 2, windows };
    let (vertices, indices, instances) = (12, 12, 60);
    let sizes =
        BufferSizes { vertex_kind: VertexKind::Displaced, vertices, indices, instances, heights: Some(tiles), ..BAKED };
    let code = |column: u16, row: u16| 5 * row + column + 3;
    let mut plan = FramePlan::default();
    plan.upload(Buffer::Vertices, 0, &[[0, 0], [1, 0], [0, 1]].map(|uv| LocalVertex { uv }));
    plan.upload(Buffer::Indices, 0, &[0u32, 1, 2]);
    let tag = |level: u32| PatchTag { patch: 0, level }.to_instance();
    let coarse = PatchInstance { origin: [2, 0], leg_u: [0, 2], leg_v: [2, 0], tag: tag(1) };
    let fine = PatchInstance { leg_u: [0, 1], leg_v: [1, 0], tag: tag(0), ..coarse };
    let missing = PatchInstance { origin: [0, 0], ..fine };
    plan.upload(Buffer::Instances, 0, &[coarse, fine, missing]);
    let grid: Vec<u16> = [0, 2].into_iter().flat_map(|row| [0, 2, 4].map(|column| code(column, row))).collect();
    plan.upload(Buffer::Heights, 0, &grid);
    let tile: Vec<u16> = (0..3).flat_map(|row| [2, 3, 4].map(|column| code(column, row))).chain([0]).collect();
    plan.upload(Buffer::Heights, 2 * tiles.tile(0, [1, 0]), &tile);
    plan.draws.push(Draw { indices: 0..3, base_vertex: 0, instances: 0..2 });
    let mut mirror = MeshMirror::new(&sizes, &dem);
    assert_eq!(mirror.replay(&plan), Ok(true));
    let heights: Vec<_> = mirror.triangles().iter().map(|triangle| triangle.heights_m).collect();
    assert_eq!(heights, [[20.0, 120.0, 40.0], [20.0, 70.0, 30.0]]);
    assert_eq!(crate::triangles_by_level(&mirror)[..3], [1, 1, 0], "the level stands in the instance");

    plan.draws[0].instances = 2..3;
    let unwritten = mirror.replay(&plan);
    assert!(matches!(unwritten, Err(MirrorError::Unwritten { buffer: Buffer::Heights, .. })), "{unwritten:?}");
    plan.growths.push(Growth { buffer: Buffer::Heights, bytes: 4096 });
    assert!(matches!(mirror.replay(&plan), Err(MirrorError::Growth { .. })));
}

#[test]
fn a_plan_that_moves_heights_alone_changes_the_mesh() {
    let dem = Heightmap::new(3, 2, [1.0; 2], vec![0.0, 9.0, 0.0, 0.0, 9.0, 0.0]).unwrap();
    let sizes = BufferSizes { vertex_kind: VertexKind::Displaced, vertices: 12, indices: 12, instances: 20, ..BAKED };
    let mut plan = FramePlan::default();
    plan.upload(Buffer::Vertices, 0, &[[0, 0], [1, 0], [0, 1]].map(|uv| LocalVertex { uv }));
    plan.upload(Buffer::Indices, 0, &[0u32, 1, 2]);
    plan.upload(Buffer::Instances, 0, &[PatchInstance { origin: [0, 0], leg_u: [0, 1], leg_v: [1, 0], tag: 0 }]);
    plan.draws.push(Draw { indices: 0..3, base_vertex: 0, instances: 0..1 });
    let mut mirror = MeshMirror::new(&sizes, &dem);
    let mut heights_m = |plan: &FramePlan| (mirror.replay(plan), mirror.triangles()[0].heights_m);
    assert_eq!(heights_m(&plan), (Ok(true), [0.0, 0.0, 9.0]));
    plan.uploads.clear();
    plan.morph = Some(Morph { eye_world: [0.0, 50.0, 0.0], k: 2, levels: 1, reach_m: 10.0 });
    assert_eq!(heights_m(&plan), (Ok(true), [0.0, 0.0, 0.0]));
    assert_eq!(heights_m(&plan).0, Ok(false));
    plan.morph = None;
    assert_eq!(heights_m(&plan), (Ok(true), [0.0, 0.0, 9.0]));
}

#[test]
fn unsound_plans_are_refused() {
    let dem = dem();
    let draw = Draw::baked(0..3, 0, PatchTag { patch: 0, level: 0 });
    let mut plan = FramePlan::default();
    plan.upload(Buffer::Indices, 0, &[0u32, 1, 3]);
    plan.draws.push(draw.clone());
    let unwritten = MeshMirror::new(&BAKED, &dem).replay(&plan);
    assert!(matches!(unwritten, Err(MirrorError::Unwritten { buffer: Buffer::Vertices, .. })), "{unwritten:?}");

    plan.draws[0].indices = 1..4;
    let unwritten = MeshMirror::new(&BAKED, &dem).replay(&plan);
    assert!(matches!(unwritten, Err(MirrorError::Unwritten { buffer: Buffer::Indices, .. })), "{unwritten:?}");

    plan.upload(Buffer::Vertices, 44, &[0u32, 0]);
    assert!(matches!(MeshMirror::new(&BAKED, &dem).replay(&plan), Err(MirrorError::Upload { size: 48, .. })));

    let mut plan = FramePlan::default();
    plan.upload(Buffer::Vertices, 0, &[BakedVertex { sample: [3, 0], height_m: 0.0 }]);
    plan.upload(Buffer::Indices, 0, &[0u32; 3]);
    plan.draws.push(draw);
    let outside = MeshMirror::new(&BAKED, &dem).replay(&plan);
    assert!(matches!(outside, Err(MirrorError::OutsideDem { .. })), "{outside:?}");
}
