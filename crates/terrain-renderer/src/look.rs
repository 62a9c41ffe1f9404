//! How a frame looks; nothing here changes what is drawn.

/// What the triangles are coloured by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Colour {
    /// Height and slope, under one sun.
    #[default]
    Shaded,
    /// One colour a patch.
    ByPatch,
    /// One colour a level: warm for the finest, colder with every coarser one.
    ByLevel,
}

/// Where the DEM's normals, on which the light falls, are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Normals {
    /// At every pixel: the shading does not change with the mesh.
    #[default]
    PerPixel,
    /// At the vertices, and interpolated over the triangles: coarse triangles lose what is between their corners
    /// (Bertilsson and Goswami 2016, Figure 4).
    PerVertex,
}

/// How a frame looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// What the triangles are coloured by.
    pub colour: Colour,
    /// Where the normals are read.
    pub normals: Normals,
    /// Draw the triangles' edges over the terrain: the plan is then drawn twice. Edges fade where triangles are only
    /// a few pixels high. On GL they have gaps: wgpu's depth bias is for filled triangles alone there.
    pub wireframe: bool,
    /// Colour where there is no terrain: linear red, green, blue, alpha, each 0 to 1.
    pub background: [f32; 4],
}

impl Look {
    /// The sky: the default background, and what the terrain fades into with distance.
    pub const SKY: [f32; 4] = [0.58, 0.70, 0.82, 1.0];
}

impl Default for Look {
    fn default() -> Self {
        Self { colour: Colour::Shaded, normals: Normals::PerPixel, wireframe: false, background: Self::SKY }
    }
}
