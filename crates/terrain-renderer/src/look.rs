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
    /// One grey everywhere: what is to be seen is the light.
    Plain,
    /// The normals themselves, unlit and without haze: red grows to the east, green to the south, blue upwards.
    ByNormal,
}

/// Where the normals come from, on which the light falls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Normals {
    /// At every pixel: the shading does not change with the mesh.
    #[default]
    PerPixel,
    /// At the vertices, and interpolated over the triangles: coarse triangles lose what is between their corners
    /// (Bertilsson and Goswami 2016, Figure 4).
    PerVertex,
    /// Of the triangle as it is drawn, not of the DEM: flat shading, which shows the geometry and nothing else.
    PerTriangle,
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
    /// Fade into the sky with distance.
    pub haze: bool,
    /// Colour where there is no terrain: linear red, green, blue, alpha, each 0 to 1.
    pub background: [f32; 4],
}

impl Look {
    /// The sky: the default background, and what the terrain fades into with distance.
    pub const SKY: [f32; 4] = [0.58, 0.70, 0.82, 1.0];
}

impl Default for Look {
    fn default() -> Self {
        Self { colour: Colour::Shaded, normals: Normals::PerPixel, wireframe: false, haze: true, background: Self::SKY }
    }
}
