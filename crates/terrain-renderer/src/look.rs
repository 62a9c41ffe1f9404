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
    /// How far the mesh is from the DEM, in pixels, from blue (none) to red ([`Look::error_scale_px`]) and purple (more);
    /// see [`heat_colour`]. Shaded over a scene without heights. The normals are then per pixel.
    ByError,
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
    /// The error in pixels that is red with [`Colour::ByError`], above 0.
    pub error_scale_px: f32,
    /// Direction to the sun along the world's axes (east, up, south), of any length but 0.
    pub to_sun: [f32; 3],
    /// Colour where there is no terrain: linear red, green, blue, alpha, each 0 to 1.
    pub background: [f32; 4],
}

impl Look {
    /// The sky: the default background, and what the terrain fades into with distance.
    pub const SKY: [f32; 4] = [0.58, 0.70, 0.82, 1.0];
    /// The north-west, as on printed maps: the default sun.
    pub const NORTH_WEST: [f32; 3] = [-0.62, 0.58, -0.53];
}

/// The colour, linear red, green and blue, of an error that is this share of [`Look::error_scale_px`]: for legends.
pub fn heat_colour(share: f32) -> [f32; 3] {
    const COLD_TO_HOT: [([f32; 3], [f32; 2]); 3] =
        [([0.02, 0.38, 0.42], [0.0, 0.33]), ([0.75, 0.62, 0.04], [0.25, 0.66]), ([0.70, 0.04, 0.02], [0.60, 1.0])];
    if share > 1.0 {
        return [0.55, 0.02, 0.40];
    }
    COLD_TO_HOT.iter().fold([0.03, 0.08, 0.25], |colour, (hotter, [from, to])| {
        let t = ((share - from) / (to - from)).clamp(0.0, 1.0);
        let weight = t * t * (3.0 - 2.0 * t);
        [0, 1, 2].map(|i| colour[i] + weight * (hotter[i] - colour[i]))
    })
}

impl Default for Look {
    fn default() -> Self {
        Self {
            colour: Colour::Shaded,
            normals: Normals::PerPixel,
            wireframe: false,
            haze: true,
            error_scale_px: 1.0,
            to_sun: Self::NORTH_WEST,
            background: Self::SKY,
        }
    }
}
