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
    /// One colour a cell, the unit that a method loads; by patch where it has none. The normals are then per pixel.
    ByCell,
    /// One colour a draw call: all are alike where one call sends all draws ([`Submission`](crate::Submission)).
    ByDraw,
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

/// What a look asks of a pipeline: its constants, `override` in `shaders/terrain.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shading {
    /// 0 shaded, 1 by patch, 2 by level, 3 plain, 4 by normal, 5 by cell, 6 by draw, 8 by error.
    pub(crate) colour: u32,
    /// 0 per pixel, 1 per vertex, 2 per triangle.
    pub(crate) normals: u32,
    pub(crate) mark_stale: bool,
}

impl Shading {
    pub(crate) fn of(look: &Look, has_heights: bool, has_cells: bool) -> Self {
        let colour = match look.colour {
            Colour::Shaded => 0,
            Colour::ByPatch => 1,
            Colour::ByLevel => 2,
            Colour::Plain => 3,
            Colour::ByNormal => 4,
            Colour::ByCell if !has_cells => 1,
            Colour::ByCell => 5,
            Colour::ByDraw => 6,
            // Without the DEM's heights there is nothing to compare with.
            Colour::ByError if !has_heights => 0,
            Colour::ByError => 8,
        };
        let normals = match look.normals {
            _ if !has_heights && look.colour != Colour::ByCell => 2,
            // Where a fragment is on the DEM travels with the normals per pixel.
            _ if matches!(look.colour, Colour::ByError | Colour::ByCell) => 0,
            Normals::PerTriangle => 2,
            Normals::PerPixel => 0,
            Normals::PerVertex => 1,
        };
        Self { colour, normals, mark_stale: look.mark_stale }
    }
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
    /// Stripe the patches that are drawn for an older view, since their updates have not finished.
    pub mark_stale: bool,
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
            mark_stale: false,
            haze: true,
            error_scale_px: 1.0,
            to_sun: Self::NORTH_WEST,
            background: Self::SKY,
        }
    }
}
