//! Levels that glide into one another, on a real adapter; skipped with a message where there is none.

mod hills;

use hills::shot::{Shot, shaded, shoot};
use hills::{Mesh, adapter, coarse_grid, oblique};
use terrain_core::{
    BakedVertex, Buffer, BufferSizes, Draw, FramePlan, IndexFormat, MeshMirror, Morph, PatchTag, VertexKind, View,
};
use terrain_renderer::{Colour, Submission};

/// Every sample of [`hills::hills`], on its way: of the level of each, some have left and some have arrived.
fn gliding(view: &View, reach_m: f64) -> Mesh {
    let mut mesh = coarse_grid(&hills::hills(), 8, 1);
    mesh.plan.morph = Some(Morph { eye_world: view.eye_world.into(), k: 3, levels: 3, reach_m });
    mesh
}

/// The triangles that the mirror finds in a mesh, each with vertices of its own.
fn baked(mesh: &Mesh) -> Mesh {
    let dem = hills::hills();
    let mut mirror = MeshMirror::new(&mesh.sizes, &dem);
    mirror.replay(&mesh.plan).unwrap();
    let corners = mirror.triangles().iter().flat_map(|t| t.samples.into_iter().zip(t.heights_m));
    let vertex = |(at, height_m)| BakedVertex { height_m, ..BakedVertex::of(&dem, at) };
    let vertices: Vec<BakedVertex> = corners.map(vertex).collect();
    let indices: Vec<u32> = (0..vertices.len() as u32).collect();
    let mut plan = FramePlan::default();
    plan.upload(Buffer::Vertices, 0, &vertices);
    plan.upload(Buffer::Indices, 0, &indices);
    plan.draws.push(Draw::baked(0..indices.len() as u32, 0, PatchTag { patch: 0, level: 0 }));
    let sizes = BufferSizes {
        vertex_kind: VertexKind::Baked,
        index_format: IndexFormat::U32,
        vertices: size_of_val(&vertices[..]) as u64,
        indices: size_of_val(&indices[..]) as u64,
        instances: 0,
        heights: None,
        cell_side: None,
    };
    Mesh { sizes, plan }
}

/// Pixels whose depth differs by more than a share of it.
fn differing(a: &Shot, b: &Shot, share: f32) -> usize {
    a.depth.iter().zip(&b.depth).filter(|(a, b)| (*a - *b).abs() > share * a.max(**b)).count()
}

/// The shader's distances are f32 and the mirror's f64: a height differs by a few millionths of its way. Where that
/// moves a silhouette across the middle of a pixel, the pixel shows what is behind.
#[test]
fn gliding_vertices_are_where_the_mirror_says() {
    let Some(gpu) = adapter() else { return };
    let (dem, view) = (hills::hills(), oblique(&hills::hills()));
    let shot = |mesh: &Mesh| shoot(&gpu, &dem, Submission::Direct, mesh, &view, &shaded(Colour::Shaded));
    let still = shot(&coarse_grid(&dem, 8, 1));
    for reach_m in [150.0, 400.0, 900.0] {
        let mesh = gliding(&view, reach_m);
        let (glided, expected) = (shot(&mesh), shot(&baked(&mesh)));
        if glided.depth.is_empty() {
            continue; // GL cannot copy depth
        }
        let moved = differing(&glided, &still, 1e-3);
        assert!(moved > 5_000, "reach {reach_m} m: {moved} pixels have moved at all");
        let wrong = differing(&glided, &expected, 1e-5);
        assert!(wrong <= 10, "reach {reach_m} m: {wrong} pixels are not where the mirror has them");
    }
}

/// With nothing on its way, the entry point draws what `vertex_displaced` does.
#[test]
fn vertices_that_have_not_left_are_drawn_as_without_a_morph() {
    let Some(gpu) = adapter() else { return };
    let (dem, view) = (hills::hills(), oblique(&hills::hills()));
    let shot = |mesh: &Mesh| shoot(&gpu, &dem, Submission::Direct, mesh, &view, &shaded(Colour::Shaded));
    let (still, near) = (shot(&coarse_grid(&dem, 8, 1)), shot(&gliding(&view, 1e6)));
    assert!(still.picture == near.picture && still.depth == near.depth);
}
