//! The GPU's twin on the CPU: applies plans to copies of the method's buffers and yields triangles.

use std::borrow::Cow;
use std::ops::Range;

use crate::{
    BakedVertex, Buffer, BufferSizes, Draw, FramePlan, Growth, HeightTiles, Heightmap, IndexFormat, LocalVertex, Morph,
    PatchInstance, Sample, Upload, VertexKind,
};

/// A triangle as the GPU would draw it, its corners at samples of the DEM.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// The corners, counter-clockwise seen from above where the mesh is sound.
    pub samples: [Sample; 3],
    /// Heights of the corners in metres, as the vertices hold them.
    pub heights_m: [f32; 3],
}

impl Triangle {
    /// Twice the area in grid intervals, positive where the corners run counter-clockwise seen from above
    /// (x to the right, z towards the viewer).
    pub fn doubled_area(&self) -> i64 {
        let [a, b, c] = self.samples.map(|s| (s.column as i64, s.row as i64));
        (c.0 - a.0) * (b.1 - a.1) - (b.0 - a.0) * (c.1 - a.1)
    }
}

/// A plan that the GPU could not execute, or that would read what nobody wrote.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MirrorError {
    /// A write beyond the end of a buffer, or not aligned to 4 bytes.
    #[error("upload of {} bytes at {} of {:?}: the buffer has {size} bytes, and 4-byte steps", .upload.bytes.len(), .upload.offset, .upload.buffer)]
    Upload {
        /// The write.
        upload: Upload,
        /// Bytes of that buffer.
        size: u64,
    },
    /// A buffer that would become smaller, or whose new size is no multiple of 4; or the height tiles, which do not grow.
    #[error("growth of {:?} to {} bytes: the buffer has {size}, and sizes are multiples of 4", .growth.buffer, .growth.bytes)]
    Growth {
        /// The change.
        growth: Growth,
        /// Bytes of that buffer.
        size: u64,
    },
    /// A draw that reads elements that are not there or that no upload has written.
    #[error("draw {draw:?} reads {elements:?} of {buffer:?}, where not all is uploaded")]
    Unwritten {
        /// The draw.
        draw: Draw,
        /// The buffer it reads.
        buffer: Buffer,
        /// The elements (indices, vertices or instances) it reads.
        elements: Range<u64>,
    },
    /// The sample of a vertex lies outside of the DEM.
    #[error("draw {draw:?} has a vertex at column {}, row {}: outside of the DEM", .sample.column, .sample.row)]
    OutsideDem {
        /// The draw.
        draw: Draw,
        /// The vertex's sample.
        sample: Sample,
    },
}

/// CPU copies of a method's buffers, and the mesh of the last plan.
pub struct MeshMirror<'a> {
    heightmap: &'a Heightmap,
    vertex_kind: VertexKind,
    index_format: IndexFormat,
    vertices: Words,
    indices: Words,
    instances: Words,
    tiles: Option<HeightTiles>,
    heights: Words,
    draws: Vec<Draw>,
    morph: Option<Morph>,
    triangles: Vec<Triangle>,
    degenerate: Vec<Triangle>,
}

impl<'a> MeshMirror<'a> {
    /// Empty buffers of the given sizes over a DEM.
    pub fn new(sizes: &BufferSizes, heightmap: &'a Heightmap) -> Self {
        Self {
            heightmap,
            vertex_kind: sizes.vertex_kind,
            index_format: sizes.index_format,
            vertices: Words::new(sizes.vertices),
            indices: Words::new(sizes.indices),
            instances: Words::new(sizes.instances),
            tiles: sizes.heights,
            heights: Words::new(sizes.heights.map_or(0, |tiles| tiles.bytes())),
            draws: Vec::new(),
            morph: None,
            triangles: Vec::new(),
            degenerate: Vec::new(),
        }
    }

    /// Executes a plan. Returns whether the mesh may differ from the one before.
    pub fn replay(&mut self, plan: &FramePlan) -> Result<bool, MirrorError> {
        for growth in &plan.growths {
            let words = self.words_mut(growth.buffer);
            match growth.buffer {
                Buffer::Heights => return Err(MirrorError::Growth { growth: growth.clone(), size: words.bytes() }),
                _ => words.grow(growth)?,
            }
        }
        for upload in &plan.uploads {
            self.words_mut(upload.buffer).write(upload, plan.bytes_of(upload))?;
        }
        if plan.uploads.is_empty() && plan.draws == self.draws && plan.morph == self.morph {
            return Ok(false);
        }
        // Forgotten until all is expanded: a plan that is refused must not look unchanged the next time.
        self.draws.clear();
        self.triangles.clear();
        self.degenerate.clear();
        self.morph = plan.morph;
        for draw in &plan.draws {
            self.expand(draw)?;
        }
        self.draws.clone_from(&plan.draws);
        Ok(true)
    }

    /// The triangles of the last plan in drawing order, those without area left out.
    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// The triangles of the last plan that have no area.
    pub fn degenerate(&self) -> &[Triangle] {
        &self.degenerate
    }

    fn words_mut(&mut self, buffer: Buffer) -> &mut Words {
        match buffer {
            Buffer::Vertices => &mut self.vertices,
            Buffer::Indices => &mut self.indices,
            Buffer::Instances => &mut self.instances,
            Buffer::Heights => &mut self.heights,
        }
    }

    fn expand(&mut self, draw: &Draw) -> Result<(), MirrorError> {
        let range = draw.indices.start as u64..draw.indices.end as u64;
        let unwritten = |buffer, elements| MirrorError::Unwritten { draw: draw.clone(), buffer, elements };
        let indices = self.indices.indices(self.index_format, range.clone());
        let indices = indices.ok_or_else(|| unwritten(Buffer::Indices, range.clone()))?;
        // Baked draws carry a tag in the instance range: one instance, no buffer behind it.
        let instances = match self.vertex_kind {
            VertexKind::Baked => 0..1,
            VertexKind::Displaced => draw.instances.start as u64..draw.instances.end as u64,
        };
        for instance in instances {
            let instance: Option<PatchInstance> = match self.vertex_kind {
                VertexKind::Baked => None,
                VertexKind::Displaced => {
                    let one = instance..instance + 1;
                    Some(self.instances.written(one.clone()).ok_or_else(|| unwritten(Buffer::Instances, one))?[0])
                }
            };
            for corners in indices.chunks_exact(3) {
                let triangle = self.triangle(draw, [corners[0], corners[1], corners[2]], instance.as_ref())?;
                let kept = if triangle.doubled_area() == 0 { &mut self.degenerate } else { &mut self.triangles };
                kept.push(triangle);
            }
        }
        Ok(())
    }

    fn triangle(
        &self,
        draw: &Draw,
        corners: [u32; 3],
        instance: Option<&PatchInstance>,
    ) -> Result<Triangle, MirrorError> {
        let mut triangle = Triangle { samples: [Sample { column: 0, row: 0 }; 3], heights_m: [0.0; 3] };
        for (i, index) in corners.into_iter().enumerate() {
            let vertex = (index as i64 + draw.base_vertex as i64) as u64;
            let (sample, height_m) = self.vertex(vertex, instance).map_err(|(buffer, element)| {
                let elements = element..element.wrapping_add(1);
                MirrorError::Unwritten { draw: draw.clone(), buffer, elements }
            })?;
            if sample.column >= self.heightmap.columns() || sample.row >= self.heightmap.rows() {
                return Err(MirrorError::OutsideDem { draw: draw.clone(), sample });
            }
            triangle.samples[i] = sample;
            triangle.heights_m[i] = height_m.unwrap_or_else(|| self.scene_height_m(sample));
        }
        Ok(triangle)
    }

    /// The DEM's height, or where a plan moves it to.
    fn scene_height_m(&self, at: Sample) -> f32 {
        self.morph.map_or_else(|| self.heightmap.height_m(at), |morph| morph.height_m(self.heightmap, at))
    }

    /// Sample of a vertex and, where the method brings it along, its height; or the element that no upload has written.
    fn vertex(&self, vertex: u64, instance: Option<&PatchInstance>) -> Result<(Sample, Option<f32>), (Buffer, u64)> {
        let unwritten = (Buffer::Vertices, vertex);
        let one = vertex..vertex.checked_add(1).ok_or(unwritten)?;
        match instance {
            None => {
                let baked: &BakedVertex = &self.vertices.written(one).ok_or(unwritten)?[0];
                let [column, row] = baked.sample.map(u32::from);
                Ok((Sample { column, row }, Some(baked.height_m)))
            }
            Some(instance) => {
                let local: LocalVertex = self.vertices.written(one).ok_or(unwritten)?[0];
                let height_m = self.tiles.map(|tiles| self.tile_height_m(&tiles, instance, local)).transpose()?;
                Ok((instance.sample(local, self.heightmap.columns(), self.heightmap.rows()), height_m))
            }
        }
    }

    fn tile_height_m(
        &self,
        tiles: &HeightTiles,
        instance: &PatchInstance,
        vertex: LocalVertex,
    ) -> Result<f32, (Buffer, u64)> {
        let (code, bytes) = (tiles.code_of(instance, vertex), tiles.format.bytes());
        let written = self.heights.written(code * bytes..(code + 1) * bytes);
        written.map(|code| tiles.format.decode(code)).ok_or((Buffer::Heights, code))
    }
}

/// A buffer in 4-byte words that knows which of them were written.
struct Words {
    words: Vec<u32>,
    written: Vec<bool>,
}

impl Words {
    fn new(bytes: u64) -> Self {
        let length = bytes.div_ceil(4) as usize;
        Self { words: vec![0; length], written: vec![false; length] }
    }

    fn bytes(&self) -> u64 {
        self.words.len() as u64 * 4
    }

    fn grow(&mut self, growth: &Growth) -> Result<(), MirrorError> {
        let (size, length) = (self.bytes(), growth.bytes as usize / 4);
        if growth.bytes < size || !growth.bytes.is_multiple_of(4) {
            return Err(MirrorError::Growth { growth: growth.clone(), size });
        }
        self.words.resize(length, 0);
        self.written.resize(length, false);
        Ok(())
    }

    fn write(&mut self, upload: &Upload, bytes: &[u8]) -> Result<(), MirrorError> {
        let size = self.bytes();
        let end = upload.offset.checked_add(bytes.len() as u64);
        let aligned = upload.offset.is_multiple_of(4) && bytes.len().is_multiple_of(4);
        if !aligned || end.is_none_or(|end| end > size) {
            return Err(MirrorError::Upload { upload: upload.clone(), size });
        }
        let first = upload.offset as usize;
        bytemuck::cast_slice_mut::<u32, u8>(&mut self.words)[first..first + bytes.len()].copy_from_slice(bytes);
        self.written[first / 4..(first + bytes.len()) / 4].fill(true);
        Ok(())
    }

    /// A range of indices, if all of it exists and was written.
    fn indices(&self, format: IndexFormat, range: Range<u64>) -> Option<Cow<'_, [u32]>> {
        match format {
            IndexFormat::U32 => self.written(range).map(Cow::Borrowed),
            IndexFormat::U16 => {
                let narrow: &[u16] = self.written(range)?;
                Some(narrow.iter().copied().map(u32::from).collect())
            }
        }
    }

    /// A range of elements, if all of it exists and was written.
    fn written<T: bytemuck::AnyBitPattern>(&self, elements: Range<u64>) -> Option<&[T]> {
        let bytes_each = size_of::<T>() as u64;
        let start = usize::try_from(elements.start.checked_mul(bytes_each)?).ok()?;
        let end = usize::try_from(elements.end.checked_mul(bytes_each)?).ok()?;
        let all_written = self.written.get(start / 4..end.div_ceil(4))?.iter().all(|written| *written);
        all_written.then(|| bytemuck::cast_slice(&bytemuck::cast_slice::<u32, u8>(&self.words)[start..end]))
    }
}

#[cfg(test)]
mod tests {
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
        let sizes =
            BufferSizes { vertex_kind: VertexKind::Displaced, vertices: 12, indices: 12, instances: 40, ..BAKED };
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
        let tiles = HeightTiles { format, samples: [5, 3], coarse_level: 1, coarse_step: 2, cell_side: 2, window: 2 };
        let (vertices, indices, instances) = (12, 12, 60);
        let sizes = BufferSizes {
            vertex_kind: VertexKind::Displaced,
            vertices,
            indices,
            instances,
            heights: Some(tiles),
            ..BAKED
        };
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
        plan.upload(Buffer::Heights, 2 * tiles.tile([1, 0]), &tile);
        plan.draws.push(Draw { indices: 0..3, base_vertex: 0, instances: 0..2 });
        let mut mirror = MeshMirror::new(&sizes, &dem);
        assert_eq!(mirror.replay(&plan), Ok(true));
        let heights: Vec<_> = mirror.triangles().iter().map(|triangle| triangle.heights_m).collect();
        assert_eq!(heights, [[20.0, 120.0, 40.0], [20.0, 70.0, 30.0]]);

        plan.draws[0].instances = 2..3;
        let unwritten = mirror.replay(&plan);
        assert!(matches!(unwritten, Err(MirrorError::Unwritten { buffer: Buffer::Heights, .. })), "{unwritten:?}");
        plan.growths.push(Growth { buffer: Buffer::Heights, bytes: 4096 });
        assert!(matches!(mirror.replay(&plan), Err(MirrorError::Growth { .. })));
    }

    #[test]
    fn a_plan_that_moves_heights_alone_changes_the_mesh() {
        let dem = Heightmap::new(3, 2, [1.0; 2], vec![0.0, 9.0, 0.0, 0.0, 9.0, 0.0]).unwrap();
        let sizes =
            BufferSizes { vertex_kind: VertexKind::Displaced, vertices: 12, indices: 12, instances: 20, ..BAKED };
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
}
