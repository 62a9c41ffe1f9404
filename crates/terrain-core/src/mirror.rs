//! The GPU's twin on the CPU: applies plans to copies of the method's buffers and yields triangles.

use std::borrow::Cow;
use std::ops::Range;

use crate::{
    BakedVertex, Buffer, BufferSizes, Draw, FramePlan, Growth, HeightTiles, Heightmap, IndexFormat, LocalVertex, Morph,
    PatchInstance, PatchTag, Sample, Upload, VertexKind,
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
    /// By patch, as far as draws tell: its part of the triangles.
    patches: Vec<Range<usize>>,
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
            patches: Vec::new(),
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
        self.patches.clear();
        self.morph = plan.morph;
        for draw in &plan.draws {
            self.expand(draw)?;
        }
        self.draws.clone_from(&plan.draws);
        Ok(true)
    }

    /// What the last plan draws, patch by patch as far as its draws tell: tag, and triangles with those without area.
    pub fn tagged(&self) -> impl Iterator<Item = (PatchTag, u64)> + '_ {
        self.draws.iter().flat_map(move |draw| {
            let triangles = (draw.indices.len() / 3) as u64;
            // The mirror has executed the plan, so its instances are written.
            let tag = move |instance: u32| match self.vertex_kind {
                VertexKind::Baked => instance,
                VertexKind::Displaced => {
                    let one = instance as u64..instance as u64 + 1;
                    self.instances.written::<PatchInstance>(one).map_or(0, |found| found[0].tag)
                }
            };
            draw.instances.clone().map(move |instance| (PatchTag::from_instance(tag(instance)), triangles))
        })
    }

    /// The triangles of the last plan in drawing order, those without area left out.
    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// The same patch by patch, as far as draws tell.
    pub fn patches(&self) -> impl Iterator<Item = &[Triangle]> {
        self.patches.iter().map(|patch| &self.triangles[patch.clone()])
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
            let first = self.triangles.len();
            for corners in indices.chunks_exact(3) {
                let triangle = self.triangle(draw, [corners[0], corners[1], corners[2]], instance.as_ref())?;
                let kept = if triangle.doubled_area() == 0 { &mut self.degenerate } else { &mut self.triangles };
                kept.push(triangle);
            }
            self.patches.push(first..self.triangles.len());
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
mod tests;
